#include <algorithm>

#include <glm/geometric.hpp>

#include "haptics/contact/near_samples.h"
#include "haptics/contact/part_contact.h"
#include "haptics/geometry/segment.h"

// Overlaps of the parts that move here: those that the file has at rest are remembered and never ejected.

namespace tandem::haptics {
namespace {

void include(assets::Bounds& bounds, const glm::dvec3& p) {
  bounds.min = glm::min(bounds.min, p);
  bounds.max = glm::max(bounds.max, p);
}

double sizeOf(const assets::Bounds& bounds) { return glm::length(bounds.max - bounds.min); }

/// 1 within the bounds, falling to 0 at `margin` (m) beside them: a step there would be felt.
double shareBeside(const assets::Bounds& bounds, double margin, const glm::dvec3& p) {
  const double off = glm::length(p - glm::clamp(p, bounds.min, bounds.max));
  return off < margin ? 1.0 - off / margin : 0.0;
}

/// Whether p is behind the surface at the point of it that is nearest. On an edge or in a corner every face that meets
/// there has to say so: before a sharp one, a face alone may be wrong.
bool isBehind(const MeshEdges& edges, const MeshPoint& nearest, const glm::dvec3& p) {
  const glm::dvec3 off = p - nearest.point;
  if (glm::dot(edges.normal(nearest.triangle), off) >= 0.0) return false;
  if (nearest.onFace) return true;
  const double near = 1e-6 * nearest.distance;
  for (const std::uint32_t i : edges.around(nearest.triangle)) {
    const MeshEdge& edge = edges.edges()[i];
    if (glm::length(nearest.point - closestPointOnSegment(nearest.point, edge.a, edge.b)) > near) continue;
    for (const glm::dvec3& normal : edge.normals)
      if (glm::dot(normal, off) >= 0.0) return false;
  }
  return true;
}

}  // namespace

bool PartContact::isContained(const Pair& pair) const {
  return pair.overlap >= 0 && overlaps_[static_cast<std::size_t>(pair.overlap)].contained;
}

double PartContact::allowedDepth(const Pair& pair) const {
  return pair.overlap >= 0 ? overlaps_[static_cast<std::size_t>(pair.overlap)].allowed : 0.0;
}

double PartContact::allowedAt(const Pair& pair, const glm::dvec3& inFirst, const glm::dvec3& inOther) const {
  if (pair.overlap < 0) return 0.0;
  const Overlap& overlap = overlaps_[static_cast<std::size_t>(pair.overlap)];
  const bool firstIsA = overlap.a == bodies_[static_cast<std::size_t>(pair.first)].part;
  const double share = std::max(shareBeside(overlap.inA, overlap.margin, firstIsA ? inFirst : inOther),
                                shareBeside(overlap.inB, overlap.margin, firstIsA ? inOther : inFirst));
  return share * overlap.allowed;
}

void PartContact::take(PartId part, const glm::dvec3& centreOfMass) {
  const auto end = std::remove_if(overlaps_.begin(), overlaps_.begin() + overlapCount_,
                                  [&](const Overlap& o) { return o.a == part || o.b == part; });
  overlapCount_ = static_cast<int>(end - overlaps_.begin());
  const auto last = std::remove_if(kept_.begin(), kept_.begin() + keptCount_,
                                   [&](const Kept& k) { return k.first == part || k.other == part; });
  keptCount_ = static_cast<int>(last - kept_.begin());
  looksAtTaking_ = 0;
  lastFrictionCount_ = lastPaceCount_ = 0;
  for (HeldJoint& held : joints_) {
    // A joint that moved meanwhile elsewhere goes on from where it is, but for whole turns.
    if (held.joint->partA == part || held.joint->partB == part)
      held.started = held.started && held.joint->pitch != 0.0;
  }
  if (world_.model(part) == nullptr) return;
  bodyCount_ = 0;
  addBody(part, centreOfMass, world_.pose(part));
  findPairs(0.0);
  place();
  for (int i = 0; i < pairCount_; ++i) noteOverlap(pairs_[static_cast<std::size_t>(i)]);
}

void PartContact::noteOverlap(Pair& pair) {
  bool firstInside = true, otherInside = true;
  assets::Bounds inFirst, inOther;
  const double depth = std::max(depthOfSide(pair, true, firstInside, inFirst, inOther),
                                depthOfSide(pair, false, otherInside, inFirst, inOther));
  if (!(depth > 0.0)) return;
  if (overlapCount_ == kMostOverlaps) {  // the oldest goes
    std::copy(overlaps_.begin() + 1, overlaps_.end(), overlaps_.begin());
    --overlapCount_;
  }
  const PartId part = bodies_[static_cast<std::size_t>(pair.first)].part;
  Overlap& overlap = overlaps_[static_cast<std::size_t>(overlapCount_++)];
  overlap = {part, pair.other, depth, inFirst, inOther};
  // Samples stand this far apart: the overlap reaches further than they say.
  const PartModel& first = *bodies_[static_cast<std::size_t>(pair.first)].model;
  const glm::dvec3 grow(first.samples.smoothSpacing() + pair.model->samples.smoothSpacing());
  for (assets::Bounds* bounds : {&overlap.inA, &overlap.inB}) {
    bounds->min -= grow;
    bounds->max += grow;
  }
  overlap.margin = 0.25 * sizeOf(overlap.inA);
  overlap.contained = firstInside;
  if (!firstInside) return;
  const glm::dvec3 centre = transformPoint(pair.otherFromFirst, world_.collider(part).centre);
  MeshPoint nearest;
  pair.model->tree->closestPoint(centre, 1e300, nearest);
  const glm::dvec3 way = nearest.point - centre;
  const double length = glm::length(way);
  overlap.wayOut = length > 0.0              ? way / length
                   : pair.model->byFormula() ? pair.model->field.shapes().front().at(centre).gradient
                                             : pair.model->edges.normal(nearest.triangle);
}

double PartContact::depthOfSide(const Pair& pair, bool ofFirst, bool& allInside, assets::Bounds& inFirst,
                                assets::Bounds& inOther) {
  const PartModel* const first = bodies_[static_cast<std::size_t>(pair.first)].model;
  const PartModel &from = ofFirst ? *first : *pair.model, &to = ofFirst ? *pair.model : *first;
  const Pose toFromSamples = ofFirst ? pair.otherFromFirst : inverse(pair.otherFromFirst);
  const FloatMotion motion(toFromSamples, to.field.origin());
  double deepest = 0.0;
  allInside = !from.samples.samples().empty() && to.field.solid();
  float passedBy = -1.0f;
  forEachNear(from.samples, to.field, motion, 0.0f, allInside, passedBy,
              [&](std::uint32_t i, const glm::vec3&, const DistanceField::Reading& read) {
                const ContactSample& sample = from.samples.samples()[i];
                const glm::dvec3 &point = sample.point, inAsked = transformPoint(toFromSamples, point);
                assets::Bounds& bounds = ofFirst ? inFirst : inOther;
                glm::dvec3 p = inAsked;
                if (to.byFormula()) {
                  const double depth = depthOf(from, to, toFromSamples, sample, p);
                  if (!(depth > 0.0)) return;
                  deepest = std::max(deepest, depth);
                  include(bounds, point);
                  include(ofFirst ? inOther : inFirst, inAsked);
                  return;
                }
                const bool round = from.samples.isRound(sample);
                const double most = static_cast<double>(read.error) - static_cast<double>(read.distance) +
                                    (round ? static_cast<double>(sample.along) : 0.0);
                if (most <= deepest && point == glm::clamp(point, bounds.min, bounds.max)) return;
                if (round) depthOf(from, to, toFromSamples, sample, p);
                const bool surelyInside = read.distance < -read.error;
                double depth = surelyInside ? most : 0.0;
                bool inside = surelyInside;
                if (most > deepest || !surelyInside) {
                  if (++looksAtTaking_ > kMostLooks) {
                    inside = true;
                  } else {
                    // With no surface within `most` it is outside: inside none can be further away.
                    MeshPoint nearest;
                    if (!to.tree->closestPoint(p, 1.001 * most, nearest)) return;
                    inside = surelyInside || isBehind(to.edges, nearest, p);
                    depth = nearest.distance;
                  }
                }
                if (!inside) return;
                deepest = std::max(deepest, depth);
                include(bounds, point);
                include(ofFirst ? inOther : inFirst, inAsked);
              });
  return deepest;
}

void PartContact::updateOverlaps() {
  std::array<int, kMostOverlaps> now;
  int kept = 0;
  for (int k = 0; k < overlapCount_; ++k) {
    Overlap overlap = overlaps_[static_cast<std::size_t>(k)];
    // Where neither moves here, nothing has changed.
    bool near = bodyOf(overlap.a) < 0 && bodyOf(overlap.b) < 0;
    for (int i = 0; i < pairCount_; ++i) {
      const Pair& pair = pairs_[static_cast<std::size_t>(i)];
      if (pair.overlap != k || pair.joint >= 0) continue;
      near = pair.deepest > 0.0;
      overlap.allowed = std::min(overlap.allowed, pair.deepest);
    }
    now[static_cast<std::size_t>(k)] = near ? kept : -1;
    if (near) overlaps_[static_cast<std::size_t>(kept++)] = overlap;
  }
  overlapCount_ = kept;
  for (int i = 0; i < pairCount_; ++i) {
    int& index = pairs_[static_cast<std::size_t>(i)].overlap;
    if (index >= 0) index = now[static_cast<std::size_t>(index)];
  }
}

void PartContact::bringOut(const Pair& pair, std::uint16_t index) {
  const Overlap& overlap = overlaps_[static_cast<std::size_t>(pair.overlap)];
  const Body& first = bodies_[static_cast<std::size_t>(pair.first)];
  const bool firstInside = overlap.a == first.part;
  const Pose& container = firstInside ? poseOf(pair) : first.pose;
  Displacement gone = goals_[static_cast<std::size_t>(pair.first)].before;
  if (pair.second >= 0)
    gone = seenFrom(gone, goals_[static_cast<std::size_t>(pair.second)].before, rowPairs_[index].apart);
  ExactRow row;
  row.normal = container.orientation * overlap.wayOut * (firstInside ? 1.0 : -1.0);
  row.gap = glm::dot(row.normal, gone.linear) - wayOutATick(first);
  row.source = {index, 0, assets::kNone};
  rows_.addExact(row);
}

}  // namespace tandem::haptics
