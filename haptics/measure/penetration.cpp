#include "haptics/measure/penetration.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/measure/face_depth.h"
#include "haptics/measure/ridge_depth.h"

namespace tandem::haptics {
namespace {

/// Fraction of the smaller part beyond which faces may be deeper than edges and are searched everywhere.
constexpr double kDeep = 5e-3;

}  // namespace

struct PenetrationMeter::Data {
  Data(std::shared_ptr<const DepthModel> first, std::shared_ptr<const DepthModel> second)
      : a(std::move(first)), b(std::move(second)), aInB(*a, *b), bInA(*b, *a) {}

  bool areApart(const Pose& bFromA) const {
    const glm::dvec3 centreA = 0.5 * (a->bounds().min + a->bounds().max);
    const glm::dvec3 centreB = 0.5 * (b->bounds().min + b->bounds().max);
    return a->facetCount() == 0 || b->facetCount() == 0 ||
           glm::length(transformPoint(bFromA, centreA) - centreB) > 0.5 * (a->size() + b->size());
  }

  std::shared_ptr<const DepthModel> a, b;
  RidgeDepth aInB, bInA;
  std::vector<CrossedFacet> facetsOfA, facetsOfB;
};

PenetrationMeter::PenetrationMeter(std::shared_ptr<const DepthModel> a, std::shared_ptr<const DepthModel> b) {
  ASSERT(a != nullptr && b != nullptr);
  data_ = std::make_unique<Data>(std::move(a), std::move(b));
}
PenetrationMeter::~PenetrationMeter() = default;
PenetrationMeter::PenetrationMeter(PenetrationMeter&&) noexcept = default;
PenetrationMeter& PenetrationMeter::operator=(PenetrationMeter&&) noexcept = default;

PenetrationDepth PenetrationMeter::measure(const Pose& worldFromA, const Pose& worldFromB) {
  Data& d = *data_;
  const Pose bFromA = inverse(worldFromB) * worldFromA, aFromB = inverse(bFromA);
  PenetrationDepth result;
  if (d.areApart(bFromA)) return result;
  d.facetsOfA.clear();
  d.facetsOfB.clear();
  DeepestPoint ofA, ofB;
  d.aInB.measure(bFromA, ofA, d.facetsOfB);
  ofB.depth = ofA.depth;  // only a deeper point matters
  d.bInA.measure(aFromB, ofB, d.facetsOfA);
  // From here on each search finds only points deeper than all before.
  const auto better = [](DeepestPoint& mine, DeepestPoint& other, auto&& search) {
    mine.depth = std::max(mine.depth, other.depth);
    const double before = mine.depth;
    search(mine);
    if (mine.depth > before) other.found = false;
  };
  const FaceDepth facesOfA(*d.a, *d.b, bFromA), facesOfB(*d.b, *d.a, aFromB);
  if (ofB.found) ofA.found = false;
  better(ofA, ofB, [&](DeepestPoint& deepest) { facesOfA.searchBetween(d.facetsOfA, deepest); });
  better(ofB, ofA, [&](DeepestPoint& deepest) { facesOfB.searchBetween(d.facetsOfB, deepest); });
  if (std::max(ofA.depth, ofB.depth) > kDeep * std::min(d.a->size(), d.b->size())) {
    better(ofA, ofB, [&](DeepestPoint& deepest) { facesOfA.search(deepest); });
    better(ofB, ofA, [&](DeepestPoint& deepest) { facesOfB.search(deepest); });
  }
  if (!ofA.found && !ofB.found) return result;
  result.ofA = ofA.found;
  const DeepestPoint& place = result.ofA ? ofA : ofB;
  const Pose& worldFromBody = result.ofA ? worldFromB : worldFromA;
  result.depth = place.depth;
  result.point = transformPoint(worldFromBody, place.point);
  const glm::dvec3 out = transformVector(worldFromBody, place.surface - place.point);
  ASSERT(result.depth > 0.0);
  result.normal = (result.ofA ? out : -out) / result.depth;
  return result;
}

PenetrationDepth deepestPenetration(const DepthModel& a, const Pose& worldFromA, const DepthModel& b,
                                    const Pose& worldFromB) {
  const auto borrowed = [](const DepthModel& m) {
    return std::shared_ptr<const DepthModel>(std::shared_ptr<const DepthModel>(), &m);
  };
  return PenetrationMeter(borrowed(a), borrowed(b)).measure(worldFromA, worldFromB);
}

}  // namespace tandem::haptics
