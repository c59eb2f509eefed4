#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "haptics/contact/near_samples.h"
#include "haptics/contact/part_contact.h"

// The samples of one part of a pair before the other: which of them could touch in a step, and what holds one off.

namespace tandem::haptics {
namespace {

// What a close look told is believed while its sample has not gone further than this share of the spacing.
constexpr double kBelieved = 0x1p-4;
constexpr std::size_t kMostNormals = 16;  // of one sample

}  // namespace

PartContact::AskedSide PartContact::askedSide(std::uint16_t pair, std::uint16_t side, double reach) const {
  const Pair& of = pairs_[pair];
  const Body& first = bodies_[static_cast<std::size_t>(of.first)];
  const bool ofFirst = side == 0;
  AskedSide asked;
  asked.from = ofFirst ? first.model : of.model;
  asked.to = ofFirst ? of.model : first.model;
  asked.toFromSamples = ofFirst ? of.otherFromFirst : inverse(of.otherFromFirst);
  asked.worldFromTo = ofFirst ? poseOf(of) : first.pose;
  asked.turn = glm::mat3(glm::mat3_cast(asked.worldFromTo.orientation));
  asked.shift = glm::vec3(transformPoint(asked.worldFromTo, asked.to->field.origin()) - first.centre);
  asked.sign = ofFirst ? 1.0f : -1.0f;
  asked.limit = static_cast<float>(reach);
  asked.smooth = 2.0f * static_cast<float>(asked.to->field.tolerance());
  asked.rough = std::max(asked.smooth, 0.12f * static_cast<float>(asked.to->field.smallestCell()));
  asked.believed = static_cast<float>(kBelieved * asked.from->samples.spacing());
  asked.contained = isContained(of);
  asked.pair = pair;
  asked.side = side;
  asked.sampled = ofFirst ? first.part : of.other;
  asked.asked = ofFirst ? of.other : first.part;
  return asked;
}

double PartContact::allowedOf(const AskedSide& side, const ContactSample& sample) const {
  const Pair& pair = pairs_[side.pair];
  if (allowedDepth(pair) == 0.0) return 0.0;
  const glm::dvec3 at = transformPoint(side.toFromSamples, sample.point);
  return side.ofFirst() ? allowedAt(pair, sample.point, at) : allowedAt(pair, at, sample.point);
}

PartContact::Look& PartContact::lookAt(PartId part, std::uint32_t sample, PartId other) {
  Look* const first = &looks_[part][kLooks * sample];
  Look* oldest = first;
  for (std::uint32_t k = 0; k < kLooks; ++k) {
    if (first[k].other == other) return first[k];
    if (stepNumber_ - first[k].step > stepNumber_ - oldest->step) oldest = first + k;
  }
  return *oldest;
}

// --- the samples that could touch

void PartContact::gatherSide(std::uint16_t pair, std::uint16_t side, double reach) {
  AskedSide asking = askedSide(pair, side, reach);
  const PartModel &from = *asking.from, &to = *asking.to;
  const bool byFormula = to.byFormula();
  float deepest = 0.0f, passedBy = -1.0f;
  bool inside = false;
  forEachNear(from.samples, to.field, FloatMotion(asking.toFromSamples, to.field.origin()), asking.limit,
              inside, passedBy,
              [&](std::uint32_t i, const glm::vec3& place, const DistanceField::Reading& read) {
                const ContactSample& sample = from.samples.samples()[i];
                asking.allowed = static_cast<float>(allowedOf(asking, sample));
                if (byFormula) return addShapeRows(asking, i, deepest);
                if (from.samples.isRound(sample)) return addPatchRow(asking, i, place, read, deepest);
                addSampleRow(asking, i, place, read, deepest);
              });
  deepest = std::max(deepest, passedBy);
  pairs_[pair].deepest = std::max(pairs_[pair].deepest, static_cast<double>(deepest));
}

void PartContact::addSampleRow(const AskedSide& side, std::uint32_t i, const glm::vec3& place,
                               const DistanceField::Reading& read, float& deepest) {
  deepest = std::max(deepest, read.error - read.distance);
  if (side.contained) return;
  const ContactSample& sample = side.from->samples.samples()[i];
  const float least = read.distance - read.error + side.allowed;
  if (read.error > side.rough || (sample.along > 0.0f && crossesBlade(side, sample, place, read)))
    return addLookRows(side, i, place, nullptr, least - sample.along);
  // Along the rest of a piece of edge before a smooth surface the least gap is that of an end: the next sample's.
  if (least > side.limit) return;
  glm::vec3 normal = read.gradient;
  float gap = read.distance + read.error;
  if (read.error > side.smooth) {
    gap = read.distance - read.error;
    turnToFace(side, i, read, normal, gap);
  }
  rows_.addPlane(side.sign * (side.turn * normal), side.turn * place + side.shift, gap + side.allowed,
                 {side.pair, side.side, i});
}

void PartContact::addLookRows(const AskedSide& side, std::uint32_t i, const glm::vec3& place,
                              const ContactPatch* patch, float room) {
  const Look& look = lookAt(side.sampled, i, side.asked);
  const RowSource source{side.pair, side.side, i};
  const glm::vec3 arm = side.turn * place + side.shift;
  if (look.other == side.asked) {
    const glm::vec3 way = place - look.place;
    const float length = glm::length(way);
    // Not all in the same step.
    if (stepNumber_ - look.step <= kFresh + i % kFresh && length <= side.believed) {
      for (std::size_t k = 0; k < static_cast<std::size_t>(look.planes); ++k) {
        const glm::vec3& normal = look.normals[k];
        glm::vec3 at = arm;
        float gap = look.gaps[k] + glm::dot(normal, way) + side.allowed;
        if (patch != nullptr) {
          // The place of the patch that is lowest over the plane now.
          const glm::dvec3 up(normal), lowest = patch->pointAt(patch->lowest(up, evenness(*side.to)));
          at = side.arm(lowest);
          gap += static_cast<float>(glm::dot(up, lowest - patch->sample()));
        }
        rows_.addPlane(side.sign * (side.turn * normal), at, gap, source);
      }
      return;
    }
    room = std::max(room, look.room + side.allowed - (patch != nullptr ? 2.0f : 1.0f) * length);
  }
  if (room <= side.limit) rows_.addBall(arm, room, source);
}

bool PartContact::crossesBlade(const AskedSide& side, const ContactSample& sample, const glm::vec3& place,
                               const DistanceField::Reading& read) {
  ContactPatch edge;
  if (!side.from->patchOf(sample, edge)) return false;
  const glm::vec3 along = sample.along * glm::vec3(side.toFromSamples.orientation * edge.axis);
  const float slope = glm::dot(read.gradient, along);
  if (std::abs(slope) <= side.smooth) return false;
  const float towards = slope > 0.0f ? -1.0f : 1.0f;
  const DistanceField::Reading next = side.to->field.read(place + towards * along);
  const float down = std::abs(slope), up = towards * glm::dot(next.gradient, along);
  // Where the surface turns by less than some 40 degrees between them, it is round rather than a blade.
  if (up <= 0.0f || down + up < 0.7f * sample.along) return false;
  const float least = read.distance - down * (read.distance - next.distance + up) / (down + up);
  return least - read.error <= side.limit && std::min(read.distance, next.distance) - least > side.smooth;
}

void PartContact::turnToFace(const AskedSide& side, std::uint32_t i, const DistanceField::Reading& read,
                             glm::vec3& normal, float& gap) {
  const Look& look = lookAt(side.sampled, i, side.asked);
  if (look.other != side.asked) return;
  const Triangle face = side.to->tree->triangle(look.triangle);
  const glm::dvec3 p = transformPoint(side.toFromSamples, side.from->samples.samples()[i].point),
                   &up = side.to->edges.normal(look.triangle);
  if (!closestPointOnTriangle(p, face).onFace) return;
  const double height = glm::dot(up, p - face.a);
  if (std::abs(height - static_cast<double>(read.distance)) > static_cast<double>(read.error)) return;
  normal = glm::vec3(up);
  gap = static_cast<float>(height);
}

// --- a close look at one of them

void PartContact::refine(RowSource source, const Displacement& u, ContactRows& rows) {
  ++work_.exact;
  const AskedSide side = askedSide(source.pair, source.side, reach_);
  const ContactSample& sample = side.from->samples.samples()[source.sample];
  std::array<glm::dvec3, kMostNormals> normals;
  std::size_t count = 0;
  for (const glm::dvec3& normal : side.from->samples.normals(sample)) {
    if (count < normals.size()) normals[count++] = side.toFromSamples.orientation * normal;
  }
  SampleAtMesh asked = askedSample(side, sample, u);
  asked.normals = {normals.data(), count};
  Look& look = lookAt(side.sampled, source.sample, side.asked);
  const Look* const last = look.other == side.asked ? &look : nullptr;
  TouchingFeature found;
  if (!holdsOff(side, sample, asked, last != nullptr ? last->triangle : kNoTriangle, found)) return;
  if (!side.to->byFormula() && !side.to->field.solid()) turnToSample(found, last, side.to->field.tolerance());
  keepLook(side, sample, asked, found, look);
  addFoundRows(side, sample, found, source, rows);
}

SampleAtMesh PartContact::askedSample(const AskedSide& side, const ContactSample& sample,
                                      const Displacement& u) const {
  const Pair& pair = pairs_[side.pair];
  const Body& first = bodies_[static_cast<std::size_t>(pair.first)];
  const double way = motionOf(first, u), share = way > reach_ ? reach_ / way : 1.0;
  SampleAtMesh asked;
  asked.point = transformPoint(side.toFromSamples, sample.point);
  const glm::dvec3 motion = share * u.at(transformPoint(side.worldFromTo, asked.point) - first.centre);
  asked.motion = glm::conjugate(side.worldFromTo.orientation) * (side.ofFirst() ? motion : -motion);
  asked.slack = 0.5 * side.to->field.tolerance();
  asked.range = kBelieved * side.from->samples.spacing() + (pair.second >= 0 ? 2.0 : 1.0) * reach_;
  if (side.to->byFormula() || side.from->samples.isRound(sample)) return asked;
  const DistanceField::Reading around = side.to->field.read(glm::vec3(asked.point - side.to->field.origin()));
  // Where the field cannot tell the side, it is that on which the sample came.
  asked.outside = around.distance > around.error || (pair.overlap < 0 && around.distance >= -around.error);
  if (ContactPatch edge; side.from->patchOf(sample, edge)) {
    asked.edge = side.toFromSamples.orientation * edge.axis;
    asked.along = edge.along;
  }
  return asked;
}

bool PartContact::holdsOff(const AskedSide& side, const ContactSample& sample, const SampleAtMesh& asked,
                           std::uint32_t hint, TouchingFeature& found) const {
  const PartModel &from = *side.from, &to = *side.to;
  if (to.byFormula()) return touchShapes(from, to, side.toFromSamples, sample, asked, found);
  if (from.samples.isRound(sample))
    return touchPatch(from, to, side.toFromSamples, sample, asked, hint, found);
  return effort_.exact ? touchingFeature(*to.tree, to.edges, asked, 1e300, hint, found)
                       : fieldFeature(to, asked, found);
}

bool PartContact::fieldFeature(const PartModel& to, const SampleAtMesh& asked, TouchingFeature& found) {
  const DistanceField::Reading read = to.field.read(glm::vec3(asked.point - to.field.origin()));
  const glm::dvec3 up(read.gradient);
  const double slope = glm::length(up), distance = static_cast<double>(read.distance);
  if (!(slope > 0.1)) return false;
  found.planes[0] = {asked.point, up / slope, distance};
  found.distance = std::abs(distance);
  found.triangle = 0;
  found.count = 1;
  return true;
}

void PartContact::turnToSample(TouchingFeature& found, const Look* last, double tolerance) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) {
    TouchingPlane& plane = found.planes[k];
    bool behind = plane.gap < 0.0;
    // A hair across it is still on the side on which it was.
    if (last != nullptr && last->planes > 0 && std::abs(plane.gap) < 8.0 * tolerance)
      behind = glm::dot(glm::dvec3(last->normals[0]), plane.normal) < 0.0;
    if (!behind) continue;
    plane.normal = -plane.normal;
    plane.gap = -plane.gap;
  }
}

void PartContact::keepLook(const AskedSide& side, const ContactSample& sample, const SampleAtMesh& asked,
                           const TouchingFeature& found, Look& look) const {
  look.place = glm::vec3(asked.point - side.to->field.origin());
  look.room = static_cast<float>(std::min(found.distance, found.planes[0].gap));
  look.planes = found.count;
  const bool round = side.from->samples.isRound(sample);
  for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) {
    const TouchingPlane& plane = found.planes[k];
    look.normals[k] = glm::vec3(plane.normal);
    // Of a patch that of its sample, from which any of its places follows.
    const double above = round ? glm::dot(plane.normal, asked.point - plane.point) : 0.0;
    look.gaps[k] = static_cast<float>(plane.gap + above);
  }
  look.triangle = found.triangle;
  look.other = side.asked;
  look.step = stepNumber_;
}

void PartContact::addFoundRows(const AskedSide& side, const ContactSample& sample,
                               const TouchingFeature& found, RowSource source, ContactRows& rows) {
  const Pair& pair = pairs_[side.pair];
  const Body& first = bodies_[static_cast<std::size_t>(pair.first)];
  const assets::Material &mine = world_.material(side.sampled, sample.triangle),
                         &its = world_.material(side.asked, found.triangle);
  const double tolerance = side.to->field.tolerance();
  const double allowed = allowedOf(side, sample);
  for (int i = 0; i < found.count; ++i) {
    const TouchingPlane& plane = found.planes[static_cast<std::size_t>(i)];
    ExactRow row;
    row.normal = side.worldFromTo.orientation * plane.normal * (side.ofFirst() ? 1.0 : -1.0);
    row.arm = transformPoint(side.worldFromTo, plane.point) - first.centre;
    // A way out is no longer than the way to the surface. It is taken at the speed of what pushes the part in,
    // and beyond that a few tolerances a step; the last tolerance gently.
    const double gap = std::max(plane.gap, -found.distance) + allowed;
    row.gap = std::max(gap + std::clamp(-0.8 * gap, 0.0, tolerance), -push_ - 8.0 * tolerance);
    row.staticFriction = 0.5 * (mine.staticFriction + its.staticFriction);
    row.dynamicFriction = 0.5 * (mine.dynamicFriction + its.dynamicFriction);
    row.source = source;
    row.source.side = static_cast<std::uint16_t>(source.side + 2 * i);
    if (rows.addExact(row) < 0) work_.overflow = true;
  }
}

}  // namespace tandem::haptics
