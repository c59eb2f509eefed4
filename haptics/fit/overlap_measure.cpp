#include "haptics/fit/overlap_measure.h"

#include <algorithm>
#include <utility>

#include <glm/geometric.hpp>

#include "haptics/geometry/mesh_edges.h"

namespace tandem::haptics {

void OverlapMeasure::begin(const PartPair& pair, const glm::dvec3& centre, bool exits,
                           const KnownFit& known) {
  pair_ = pair;
  centre_ = centre;
  exits_ = exits;
  known_ = known;
  queries_ = 0;
  measured_ = {};
  if (known.fit == nullptr) return beginSide(Phase::ofOther);
  phase_ = Phase::knownFit;
  unexplained_.begin(pair, known.firstIsHollow, kExplained * pair.other->field.tolerance());
}

void OverlapMeasure::beginSide(Phase ofWhich) {
  phase_ = ofWhich;
  models_ = pair_.side(ofWhich == Phase::ofFirst);
  side_.allInside = !models_.from->samples.samples().empty() && models_.to->field.solid();
  side_.depth = 0.0;
  if (ofWhich == Phase::ofOther)
    side_.inSampled = side_.inTarget = {};
  else
    std::swap(side_.inSampled, side_.inTarget);
  const DistanceField& field = models_.to->field;
  near_.emplace(models_.from->samples, field, FloatMotion(models_.toFromSamples, field.origin()), 0.0f);
}

bool OverlapMeasure::advance(CountedWork& work) {
  if (phase_ == Phase::knownFit) {
    if (!unexplained_.advance(*known_.fit, work)) return false;
    measured_.keepsFit = unexplained_.depth() <= kExplained * pair_.other->field.tolerance() ||
                         (work.hurried() && unexplained_.isUnknown());
    if (measured_.keepsFit) return true;
    beginSide(Phase::ofOther);
  }
  if (phase_ == Phase::ofOther) {
    if (!advanceSide(work)) return false;
    depthOfOther_ = side_.depth;
    beginSide(Phase::ofFirst);
  }
  if (phase_ == Phase::ofFirst) {
    if (!advanceSide(work)) return false;
    if (!endSides()) return true;
  }
  if (phase_ == Phase::exit) {
    if (work.pauses(CountedWork::kQuery)) return false;
    work.spend(CountedWork::kQuery);
    measured_.exit = exitDirection();
    return true;
  }
  if (!search_.advance(work)) return false;
  measured_.firstIsHollow = search_.firstIsHollow();
  return true;
}

bool OverlapMeasure::advanceSide(CountedWork& work) {
  constexpr int kAtOnce = static_cast<int>(NearSamples::kAtOnce);
  while (!near_->done()) {
    if (work.pauses(kAtOnce * (CountedWork::kReading + CountedWork::kQuery))) return false;
    work.spend(kAtOnce * CountedWork::kReading);
    near_->advance([&](std::uint32_t i, const glm::vec3&, const DistanceField::Reading& read) {
      measureSample(models_.from->samples.samples()[i], read, work);
    });
  }
  side_.allInside = side_.allInside && near_->allInside();
  return true;
}

bool OverlapMeasure::endSides() {
  measured_.depth = std::max(side_.depth, depthOfOther_);
  if (!(measured_.depth > 0.0)) return false;
  measured_.inFirst = side_.inSampled;
  measured_.inOther = side_.inTarget;
  // The overlap may reach further than its samples by as much as they stand apart.
  const glm::dvec3 grow(pair_.first->samples.smoothSpacing() + pair_.other->samples.smoothSpacing());
  for (assets::Bounds* bounds : {&measured_.inFirst, &measured_.inOther}) {
    bounds->min -= grow;
    bounds->max += grow;
  }
  measured_.contained = exits_ && side_.allInside;
  if (!measured_.contained && !mayFit()) return false;
  phase_ = measured_.contained ? Phase::exit : Phase::fit;
  if (!measured_.contained) search_.begin(pair_, measured_.depth, measured_.inFirst, measured_.inOther);
  return true;
}

bool OverlapMeasure::mayFit() const {
  const PartModel &first = *pair_.first, &other = *pair_.other;
  return !first.byFormula() && !other.byFormula() && first.field.solid() && other.field.solid() &&
         measured_.depth >= std::max(first.field.tolerance(), other.field.tolerance());
}

void OverlapMeasure::note(double depth, const glm::dvec3& point, const glm::dvec3& inTarget) {
  side_.depth = std::max(side_.depth, depth);
  side_.inSampled.include(point);
  side_.inTarget.include(inTarget);
}

void OverlapMeasure::measureSample(const ContactSample& sample, const DistanceField::Reading& read,
                                   CountedWork& work) {
  const PartModel& to = *models_.to;
  const glm::dvec3 &point = sample.point, inTarget = transformPoint(models_.toFromSamples, point);
  glm::dvec3 p = inTarget;
  if (to.byFormula()) {
    work.spend(CountedWork::kShift);
    const double depth = depthOf(models_, sample, p);
    if (depth > 0.0) note(depth, point, inTarget);
    return;
  }
  const bool round = models_.from->samples.isRound(sample);
  const double maxDepth = static_cast<double>(read.error) - static_cast<double>(read.distance) +
                          (round ? static_cast<double>(sample.along) : 0.0);
  if (maxDepth <= side_.depth && point == glm::clamp(point, side_.inSampled.min, side_.inSampled.max)) return;
  if (round) depthOf(models_, sample, p);
  const bool surelyInside = read.distance < -read.error;
  double depth = surelyInside ? maxDepth : 0.0;
  bool inside = surelyInside;
  if (maxDepth > side_.depth || !surelyInside) {
    if (++queries_ > kMaxQueries || (work.hurried() && !work.affords(CountedWork::kQuery))) {
      inside = true;
    } else {
      work.spend(CountedWork::kQuery);
      // An inner sample has the surface within maxDepth, so a sample without a surface there is outside.
      MeshPoint nearest;
      if (!to.tree->closestPoint(p, 1.001 * maxDepth, nearest)) return;
      inside = surelyInside || isBehind(to.edges, nearest, p);
      depth = nearest.distance;
    }
  }
  if (inside) note(depth, point, inTarget);
}

glm::dvec3 OverlapMeasure::exitDirection() const {
  const PartModel& other = *pair_.other;
  const glm::dvec3 centre = transformPoint(pair_.otherFromFirst, centre_);
  MeshPoint nearest;
  other.tree->closestPoint(centre, 1e300, nearest);
  const glm::dvec3 path = nearest.point - centre;
  const double length = glm::length(path);
  if (length > 0.0) return path / length;
  return other.byFormula() ? other.field.shapes().front().at(centre).gradient
                           : other.edges.normal(nearest.triangle);
}

}  // namespace tandem::haptics
