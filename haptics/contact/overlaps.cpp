#include "haptics/contact/overlaps.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/finite.h"
#include "haptics/contact/near_samples.h"
#include "haptics/geometry/segment.h"

namespace tandem::haptics {
namespace {

// Of a share that is computed in float.
constexpr float kShareRounding = 1e-4f;
// Tolerances that parts may be deeper in each other than a fit explains.
constexpr double kExplained = 2.0;
// Tolerances of a depth that counts as 0, and rounds of making a fit as deep as it has to be.
constexpr double kExact = 0.1;
constexpr int kMaxPasses = 4, kMaxFitQueries = 2000;  // queries of one round
// Tolerances by which a seat is made roomier than it was measured, and depths of an overlap above which a fit
// would let the parts in further than they were.
constexpr double kRoom = 1.0, kMuchDeeper = 1.1;

void include(assets::Bounds& bounds, const glm::dvec3& p) {
  bounds.min = glm::min(bounds.min, p);
  bounds.max = glm::max(bounds.max, p);
}

double sizeOf(const assets::Bounds& bounds) { return glm::length(bounds.max - bounds.min); }

/// A share of 1 within the bounds that falls to 0 at `margin` (m) beside them, because a jump would be
/// felt.
double shareBeside(const assets::Bounds& bounds, double margin, const glm::dvec3& p) {
  const double off = glm::length(p - glm::clamp(p, bounds.min, bounds.max));
  return off < margin ? 1.0 - off / margin : 0.0;
}

/// A lower bound of that share for all places at most `radius` from p.
float leastShare(const glm::vec3& middle, const glm::vec3& half, float margin, const glm::vec3& p,
                 float radius) {
  const glm::vec3 off = glm::max(glm::abs(p - middle) + radius - half, glm::vec3(0.0f));
  return 1.0f - glm::length(off) / margin;
}

/// Whether p is behind the surface at the surface's nearest point. On an edge or in a corner p must be
/// behind every face that meets there, because before a sharp edge one face alone may be wrong.
bool isBehind(const MeshEdges& edges, const MeshPoint& nearest, const glm::dvec3& p) {
  const glm::dvec3 off = p - nearest.point;
  if (glm::dot(edges.normal(nearest.triangle), off) >= 0.0) return false;
  if (nearest.onFace) return true;
  const double near = 1e-6 * nearest.distance;
  for (const std::uint32_t i : edges.around(nearest.triangle)) {
    const MeshEdge edge = edges.edge(i);
    if (glm::length(nearest.point - closestPointOnSegment(nearest.point, edge.a, edge.b)) > near) continue;
    for (const glm::dvec3& normal : edge.normals)
      if (glm::dot(normal, off) >= 0.0) return false;
  }
  return true;
}

}  // namespace

float AllowedDepth::least(const glm::vec3& inSampled, const glm::vec3& inTarget, float radius) const {
  if (!(depth > 0.0f)) return 0.0f;
  const float share = std::max(leastShare(sampledMiddle, sampledHalf, margin, inSampled, radius),
                               leastShare(targetMiddle, targetHalf, margin, inTarget, radius));
  return depth * std::max(share - kShareRounding, 0.0f);
}

const Overlaps::Overlap& Overlaps::overlapOf(int pair) const {
  return overlaps_[static_cast<std::size_t>(of_[static_cast<std::size_t>(pair)])];
}

const InterferenceFit* Overlaps::fit(int pair, bool& firstIsHollow) const {
  if (!has(pair) || !TICK_ASSERT(fault_, pair < island_.pairCount())) return nullptr;
  const Overlap& overlap = overlapOf(pair);
  if (overlap.fit == kNoFit) return nullptr;
  firstIsHollow = overlap.aIsHollow == (overlap.a == island_.first(island_.pair(pair)).part);
  return &*fits_[static_cast<std::size_t>(overlap.fit)];
}

bool Overlaps::contained(int pair) const { return has(pair) && overlapOf(pair).contained; }

double Overlaps::allowedAt(int pair, const glm::dvec3& inFirst, const glm::dvec3& inOther) const {
  if (!has(pair) || !TICK_ASSERT(fault_, pair < island_.pairCount())) return 0.0;
  const Overlap& overlap = overlapOf(pair);
  if (overlap.fit != kNoFit) return 0.0;
  const bool firstIsA = overlap.a == island_.first(island_.pair(pair)).part;
  const double share = std::max(shareBeside(overlap.inA, overlap.margin, firstIsA ? inFirst : inOther),
                                shareBeside(overlap.inB, overlap.margin, firstIsA ? inOther : inFirst));
  return share * overlap.allowed;
}

bool AllowedDepth::sameBoxes(const AllowedDepth& other) const {
  return margin == other.margin && sampledMiddle == other.sampledMiddle && sampledHalf == other.sampledHalf &&
         targetMiddle == other.targetMiddle && targetHalf == other.targetHalf;
}

AllowedDepth Overlaps::allowed(int pair, bool ofFirst, const glm::dvec3& fieldOrigin) const {
  AllowedDepth depth;
  if (!has(pair)) return depth;
  const Overlap& overlap = overlapOf(pair);
  const bool sampledIsA = ofFirst == (overlap.a == island_.first(island_.pair(pair)).part);
  const assets::Bounds &inSampled = sampledIsA ? overlap.inA : overlap.inB,
                       &inTarget = sampledIsA ? overlap.inB : overlap.inA;
  if (overlap.contained || overlap.fit != kNoFit || !(overlap.margin > 0.0)) return depth;
  depth.depth = static_cast<float>(overlap.allowed);
  depth.margin = static_cast<float>(overlap.margin);
  depth.sampledMiddle = glm::vec3(0.5 * (inSampled.min + inSampled.max));
  depth.sampledHalf = glm::vec3(0.5 * (inSampled.max - inSampled.min));
  depth.targetMiddle = glm::vec3(0.5 * (inTarget.min + inTarget.max) - fieldOrigin);
  depth.targetHalf = glm::vec3(0.5 * (inTarget.max - inTarget.min));
  return depth;
}

double Overlaps::longestExit(double dt) const {
  double longest = 0.0;
  for (const Overlap& overlap : overlaps_) {
    const int body = island_.bodyOf(overlap.a);
    if (overlap.contained && body >= 0) longest = std::max(longest, island_.body(body).escapeDistance(dt));
  }
  return longest;
}

ExactRow Overlaps::exitRow(int index, double dt) const {
  ExactRow row;
  if (!TICK_ASSERT(fault_, contained(index))) return row;
  const ContactPair& pair = island_.pair(index);
  const Overlap& overlap = overlapOf(index);
  const ContactBody& first = island_.first(pair);
  const bool firstInside = overlap.a == first.part;
  const Pose& container = firstInside ? island_.otherPose(pair) : first.pose;
  row.normal = container.orientation * overlap.exit * (firstInside ? 1.0 : -1.0);
  row.gap = glm::dot(row.normal, island_.relativeApplied(index).linear) - first.escapeDistance(dt);
  row.source = {static_cast<std::uint16_t>(index), 0, assets::kNone};
  return row;
}

void Overlaps::beginStep() {
  for (int i = 0; i < island_.pairCount(); ++i) {
    const ContactPair& pair = island_.pair(i);
    int& of = of_[static_cast<std::size_t>(i)];
    of = -1;
    deepest_[static_cast<std::size_t>(i)] = 0.0;
    if (!pair.mayTouch()) continue;
    const PartId part = island_.first(pair).part;
    for (std::size_t k = 0; k < overlaps_.size(); ++k) {
      const Overlap& overlap = overlaps_[k];
      if (isOf(overlap, part, pair.other)) of = static_cast<int>(k);
    }
  }
}

void Overlaps::noteDepth(int pair, double depth) {
  if (!TICK_ASSERT(fault_, pair >= 0 && pair < island_.pairCount())) return;
  double& deepest = deepest_[static_cast<std::size_t>(pair)];
  deepest = std::max(deepest, depth);
}

void Overlaps::endStep() {
  if (overlaps_.empty()) return;
  std::array<int, kMaxOverlaps> now;
  std::size_t remaining = 0;
  for (std::size_t k = 0; k < overlaps_.size(); ++k) {
    Overlap overlap = overlaps_[k];
    if (overlap.fit != kNoFit) {
      now[k] = static_cast<int>(remaining);
      overlaps_[remaining++] = overlap;
      continue;
    }
    // Where neither part moves here, nothing has changed.
    bool near = island_.bodyOf(overlap.a) < 0 && island_.bodyOf(overlap.b) < 0;
    for (int i = 0; i < island_.pairCount(); ++i) {
      if (of_[static_cast<std::size_t>(i)] != static_cast<int>(k)) continue;
      const double deepest = deepest_[static_cast<std::size_t>(i)];
      near = deepest > 0.0;
      overlap.allowed = std::min(overlap.allowed, deepest);
    }
    now[k] = near ? static_cast<int>(remaining) : -1;
    if (near) overlaps_[remaining++] = overlap;
  }
  while (overlaps_.size() > remaining) overlaps_.pop_back();
  for (int i = 0; i < island_.pairCount(); ++i) {
    int& index = of_[static_cast<std::size_t>(i)];
    if (index >= 0) index = now[static_cast<std::size_t>(index)];
  }
}

void Overlaps::forget(PartId part) {
  const auto end = std::remove_if(overlaps_.begin(), overlaps_.end(), [&](const Overlap& o) {
    return o.fit == kNoFit && (o.a == part || o.b == part);
  });
  for (auto left = overlaps_.end() - end; left > 0; --left) overlaps_.pop_back();
}

void Overlaps::measure(bool exits) {
  queries_ = 0;
  for (const ContactPair& pair : island_.pairs()) {
    if (!TICK_ASSERT(fault_, pair.model != nullptr && island_.first(pair).model != nullptr)) return;
    if (!keepFit(pair)) measurePair(pair, exits);
  }
}

void Overlaps::measurePair(const ContactPair& pair, bool exits) {
  const ContactBody& body = island_.first(pair);
  Side ofFirst, ofOther;
  // The other part's samples come first; those of the first part extend the bounds that they leave.
  measureSide({pair.model, body.model, inverse(pair.otherFromFirst)}, ofOther);
  ofFirst.inSampled = ofOther.inTarget;
  ofFirst.inTarget = ofOther.inSampled;
  measureSide({body.model, pair.model, pair.otherFromFirst}, ofFirst);
  const double depth = std::max(ofFirst.depth, ofOther.depth);
  if (!(depth > 0.0)) return;
  if (overlaps_.full()) {
    std::copy(overlaps_.begin() + 1, overlaps_.end(), overlaps_.begin());
    overlaps_.pop_back();
  }
  Overlap& overlap = overlaps_.push_back({});
  overlap = {body.part, pair.other, depth, ofFirst.inSampled, ofFirst.inTarget};
  // The overlap may reach further than its samples by as much as they stand apart.
  const glm::dvec3 grow(body.model->samples.smoothSpacing() + pair.model->samples.smoothSpacing());
  for (assets::Bounds* bounds : {&overlap.inA, &overlap.inB}) {
    bounds->min -= grow;
    bounds->max += grow;
  }
  overlap.margin = 0.25 * sizeOf(overlap.inA);
  overlap.contained = exits && ofFirst.allInside;
  if (overlap.contained)
    overlap.exit = exitDirection(pair, body.part);
  else
    findFit(pair, overlap);
  TICK_ASSERT(fault_, overlap.allowed > 0.0 && isFinite(overlap.exit));
}

bool Overlaps::keepFit(const ContactPair& pair) {
  const PartId part = island_.first(pair).part;
  const auto known = std::find_if(overlaps_.begin(), overlaps_.end(), [&](const Overlap& overlap) {
    return overlap.fit != kNoFit && isOf(overlap, part, pair.other);
  });
  if (known == overlaps_.end()) return false;
  const InterferenceFit& fit = *fits_[static_cast<std::size_t>(known->fit)];
  const double most = kExplained * pair.model->field.tolerance();
  if (unexplained(fit, pair, known->aIsHollow == (known->a == part)) <= most) return true;
  overlaps_.erase(known);
  return false;
}

int Overlaps::freeFit() const {
  for (std::size_t i = 0; i < kMaxFits; ++i) {
    const auto uses = [&](const Overlap& overlap) { return overlap.fit == static_cast<int>(i); };
    if (std::none_of(overlaps_.begin(), overlaps_.end(), uses)) return static_cast<int>(i);
  }
  return kNoFit;
}

void Overlaps::findFit(const ContactPair& pair, Overlap& overlap) {
  const PartModel &first = *island_.first(pair).model, &other = *pair.model;
  if (first.byFormula() || other.byFormula() || !first.field.solid() || !other.field.solid()) return;
  if (overlap.allowed < std::max(first.field.tolerance(), other.field.tolerance())) return;
  const int free = freeFit();
  if (free == kNoFit) return;
  InterferenceFit& fit = fits_[static_cast<std::size_t>(free)].emplace();
  for (const bool firstIsHollow : {false, true}) {
    if (!measureFit(fit, pair, firstIsHollow, overlap)) continue;
    overlap.fit = free;
    overlap.aIsHollow = firstIsHollow;
    return;
  }
}

bool Overlaps::measureFit(InterferenceFit& fit, const ContactPair& pair, bool firstIsHollow,
                          const Overlap& overlap) const {
  const double deepest = 1.5 * overlap.allowed;
  const PartModel &first = *island_.first(pair).model, &other = *pair.model;
  const bool found = firstIsHollow
                         ? fit.measure(first, other, pair.otherFromFirst, overlap.inA, deepest)
                         : fit.measure(other, first, inverse(pair.otherFromFirst), overlap.inB, deepest);
  if (!found) return false;
  const double tolerance = other.field.tolerance();
  double left = 1e300;
  for (int pass = 0; pass < kMaxPasses && left > kExact * tolerance; ++pass) {
    left = unexplained(fit, pair, firstIsHollow);
    if (left > kMuchDeeper * overlap.allowed) return false;
    fit.setDepth(fit.depth() + left);
  }
  fit.setDepth(fit.depth() + kRoom * tolerance);
  return left <= kExact * tolerance && fit.depth() < kMuchDeeper * overlap.allowed;
}

double Overlaps::unexplained(const InterferenceFit& fit, const ContactPair& pair, bool firstIsHollow) const {
  const PartModel &first = *island_.first(pair).model, &other = *pair.model;
  double deepest = 0.0;
  int queries = 0;
  const auto see = [&](const SampledModels& models, bool ofHollow) {
    const DistanceField& field = models.to->field;
    float passedBy = -1.0f;
    bool allInside = false;
    forEachNear(models.from->samples, field, FloatMotion(models.toFromSamples, field.origin()), 0.0f,
                allInside, passedBy, [&](std::uint32_t i, const glm::vec3&, const DistanceField::Reading&) {
                  const ContactSample& sample = models.from->samples.samples()[i];
                  const glm::dvec3 at = transformPoint(models.toFromSamples, sample.point);
                  deepest = deeperIn(*models.to, at + fit.shift(models, sample, ofHollow), deepest, queries);
                });
  };
  see({&first, &other, pair.otherFromFirst}, firstIsHollow);
  see({&other, &first, inverse(pair.otherFromFirst)}, !firstIsHollow);
  return deepest;
}

double Overlaps::deeperIn(const PartModel& part, const glm::dvec3& p, double known, int& queries) {
  const DistanceField::Reading read = part.field.read(glm::vec3(p - part.field.origin()));
  const auto distance = static_cast<double>(read.distance), error = static_cast<double>(read.error);
  if (error - distance <= known) return known;
  if (error < kExact * part.field.tolerance()) return error - distance;
  // Nothing is known of what there is no time to look at.
  if (++queries > kMaxFitQueries) return 1e300;
  MeshPoint nearest;
  if (!part.tree->closestPoint(p, 1.001 * (error - distance), nearest)) return known;
  const bool inside = distance < -error || isBehind(part.edges, nearest, p);
  return inside ? std::max(known, nearest.distance) : known;
}

glm::dvec3 Overlaps::exitDirection(const ContactPair& pair, PartId part) const {
  const glm::dvec3 centre = transformPoint(pair.otherFromFirst, world_.collider(part).centre);
  MeshPoint nearest;
  pair.model->tree->closestPoint(centre, 1e300, nearest);
  const glm::dvec3 path = nearest.point - centre;
  const double length = glm::length(path);
  if (length > 0.0) return path / length;
  return pair.model->byFormula() ? pair.model->field.shapes().front().at(centre).gradient
                                 : pair.model->edges.normal(nearest.triangle);
}

void Overlaps::measureSide(const SampledModels& models, Side& side) {
  const PartModel &from = *models.from, &to = *models.to;
  side.allInside = !from.samples.samples().empty() && to.field.solid();
  float passedBy = -1.0f;
  forEachNear(from.samples, to.field, FloatMotion(models.toFromSamples, to.field.origin()), 0.0f,
              side.allInside, passedBy,
              [&](std::uint32_t i, const glm::vec3&, const DistanceField::Reading& read) {
                measureSample(models, from.samples.samples()[i], read, side);
              });
}

void Overlaps::measureSample(const SampledModels& models, const ContactSample& sample,
                             const DistanceField::Reading& read, Side& side) {
  const PartModel& to = *models.to;
  const glm::dvec3 &point = sample.point, inTarget = transformPoint(models.toFromSamples, point);
  const auto note = [&](double depth) {
    side.depth = std::max(side.depth, depth);
    include(side.inSampled, point);
    include(side.inTarget, inTarget);
  };
  glm::dvec3 p = inTarget;
  if (to.byFormula()) {
    const double depth = depthOf(models, sample, p);
    if (depth > 0.0) note(depth);
    return;
  }
  const bool round = models.from->samples.isRound(sample);
  const double maxDepth = static_cast<double>(read.error) - static_cast<double>(read.distance) +
                          (round ? static_cast<double>(sample.along) : 0.0);
  if (maxDepth <= side.depth && point == glm::clamp(point, side.inSampled.min, side.inSampled.max)) return;
  if (round) depthOf(models, sample, p);
  const bool surelyInside = read.distance < -read.error;
  double depth = surelyInside ? maxDepth : 0.0;
  bool inside = surelyInside;
  if (maxDepth > side.depth || !surelyInside) {
    if (++queries_ > kMaxQueries) {
      inside = true;
    } else {
      // An inner sample has the surface within maxDepth, so a sample without a surface there is outside.
      MeshPoint nearest;
      if (!to.tree->closestPoint(p, 1.001 * maxDepth, nearest)) return;
      inside = surelyInside || isBehind(to.edges, nearest, p);
      depth = nearest.distance;
    }
  }
  if (inside) note(depth);
}

}  // namespace tandem::haptics
