#include "haptics/contact/sample_refiner.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/base/fixed_vector.h"
#include "haptics/contact/sample_descent.h"

namespace tandem::haptics {
namespace {

constexpr double kEven = 0.1;            // tolerances by which a deeper place near a sample is deeper
constexpr double kLong = 10.0;           // tolerances that a sample goes in a long step
constexpr std::size_t kMaxNormals = 16;  // of one sample
constexpr double kToleranceAcross =
    8.0;  // tolerances that a sample may be across a sheet and still on its old side
constexpr double kTolerancesOut =
    8.0;  // by which a step moves out what is inside, beyond the speed of what pushes it in

/// Orients the planes of a sheet, which has no inside, to the side on which the sample is, or was in its
/// last answer.
void orientToSample(TouchingFeature& found, const SampleAnswer* last, double tolerance) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) {
    TouchingPlane& plane = found.planes[k];
    bool behind = plane.gap < 0.0;
    if (last != nullptr && last->planes > 0 && std::abs(plane.gap) < kToleranceAcross * tolerance)
      behind = glm::dot(glm::dvec3(last->plane[0].normal), plane.normal) < 0.0;
    if (!behind) continue;
    plane.normal = -plane.normal;
    plane.gap = -plane.gap;
  }
}

}  // namespace

void SampleRefiner::beginStep(double dt, double reach, const ContactEffort& effort) {
  TICK_ASSERT(fault_, dt > 0.0 && reach >= 0.0);
  dt_ = dt;
  reach_ = reach;
  exact_ = effort.exact;
  descend_ = effort.descend;
  queries_ = 0;
  memory_.beginStep();
}

void SampleRefiner::refine(RowSource source, const Displacement& u, ContactRows& rows) {
  ++queries_;
  if (!TICK_ASSERT(fault_, source.pair < island_.pairCount() && island_.pair(source.pair).mayTouch())) return;
  const SideQuery query(island_, overlaps_, source.pair, source.side, reach_);
  if (!TICK_ASSERT(fault_, source.sample < query.from->samples.samples().size())) return;
  const ContactSample& sample = query.from->samples.samples()[source.sample];
  FixedVector<glm::dvec3, kMaxNormals> normals;
  for (const glm::dvec3& normal : query.from->samples.normals(sample)) {
    if (!normals.full()) normals.push_back(query.toFromSamples.orientation * normal);
  }
  SampleQuery sampleQuery = sampleQueryFor(query, sample, u);
  sampleQuery.normals = {normals.data(), normals.size()};
  const SampleAnswer* const last = memory_.find(query.sampled, source.sample, query.target);
  TouchingFeature found;
  if (!touch(query, sample, sampleQuery, last, found)) return;
  if (!query.to->byFormula() && !query.to->field.solid())
    orientToSample(found, last, query.to->field.tolerance());
  remember(query, source.sample, sampleQuery, found);
  addRows(query, sample, found, source, rows);
}

glm::dvec3 SampleRefiner::surfaceMotion(const ExactRow& row) const {
  const ContactPair& pair = island_.pair(row.source.pair);
  if (!TICK_ASSERT(fault_, pair.second < 0 && world_.has(pair.other))) return glm::dvec3(0.0);
  const glm::dvec3 point = island_.first(pair).centre + row.arm;
  return dt_ * velocityAt(world_.pose(pair.other), world_.twist(pair.other), point);
}

SampleQuery SampleRefiner::sampleQueryFor(const SideQuery& query, const ContactSample& sample,
                                          const Displacement& u) const {
  const ContactBody& first = query.first();
  const double length = first.motion(u), share = length > reach_ ? reach_ / length : 1.0;
  const PartModel &from = *query.from, &to = *query.to;
  SampleQuery sampleQuery;
  sampleQuery.point = transformPoint(query.toFromSamples, sample.point);
  const glm::dvec3 motion = share * u.at(transformPoint(query.worldFromTo, sampleQuery.point) - first.centre);
  sampleQuery.motion = glm::conjugate(query.worldFromTo.orientation) * (query.ofFirst() ? motion : -motion);
  sampleQuery.slack = 0.5 * to.field.tolerance();
  sampleQuery.range = SideQuery::kTrustedShare * from.samples.spacing() +
                      (query.contactPair().second >= 0 ? 2.0 : 1.0) * reach_;
  if (to.byFormula() || from.samples.isRound(sample)) return sampleQuery;
  const DistanceField::Reading around = to.field.read(glm::vec3(sampleQuery.point - to.field.origin()));
  // Where the field's error leaves the side open, the sample is outside, for it came from there.
  sampleQuery.outside =
      around.distance > around.error || (!overlaps_.has(query.pair) && around.distance >= -around.error);
  if (ContactPatch edge; from.patchOf(sample, edge)) {
    sampleQuery.edge = query.toFromSamples.orientation * edge.axis;
    sampleQuery.along = edge.along;
  }
  return sampleQuery;
}

bool SampleRefiner::touch(const SideQuery& query, const ContactSample& sample, const SampleQuery& sampleQuery,
                          const SampleAnswer* last, TouchingFeature& found) const {
  const PartModel& to = *query.to;
  const std::uint32_t hint = last != nullptr ? last->triangle : kNoTriangle;
  if (to.byFormula()) return touchShapes(query, sample, sampleQuery, found);
  if (query.from->samples.isRound(sample)) return touchPatch(query, sample, sampleQuery, hint, exact_, found);
  return exact_ ? touchMesh(query, sample, sampleQuery, hint, found) : fieldFeature(to, sampleQuery, found);
}

bool SampleRefiner::touchMesh(const SideQuery& query, const ContactSample& sample,
                              const SampleQuery& sampleQuery, std::uint32_t hint,
                              TouchingFeature& found) const {
  const PartModel &from = *query.from, &to = *query.to;
  const auto touchAt = [&](const SampleQuery& at, TouchingFeature& feature) {
    return touchingFeature(*to.tree, to.edges, at, 1e300, hint, feature);
  };
  // The depth that an overlap at rest allows was measured at the samples alone.
  const bool descends = descend_ && sample.edge != assets::kNone && !(query.allowed(sample) > 0.0);
  if (!descends) return touchAt(sampleQuery, found);
  const DescentBounds bounds{kEven * to.field.tolerance(), sampleQuery.range};
  Seat seat = deepestNear(query, sample, bounds, hint);
  hint = seat.triangle;
  found.least = seat.least;
  // In a long step the deepest place may be another one at its end.
  if (seat.edge == assets::kNone && glm::length(sampleQuery.motion) > kLong * to.field.tolerance()) {
    SampledModels ahead = query;
    ahead.toFromSamples.position += sampleQuery.motion;
    seat = deepestNear(ahead, sample, bounds, hint);
    seat.point -= sampleQuery.motion;
  }
  // Beside a flush face the planes of a place over it are those of the face's border, in any direction: the
  // place counts only where it may be inside.
  const bool counts = ContactSamples::isSmooth(sample) || seat.least < glm::length(sampleQuery.motion);
  if (seat.edge == assets::kNone || !counts) return touchAt(sampleQuery, found);
  const MeshEdge& edge = from.edges.edges()[seat.edge];
  const glm::dquat& rotation = query.toFromSamples.orientation;
  const std::array<glm::dvec3, 2> normals{rotation * edge.normals[0], rotation * edge.normals[1]};
  SampleQuery seated = sampleQuery;
  seated.point = seat.point;
  seated.normals = normals;
  seated.edge = rotation * glm::normalize(edge.b - edge.a);
  seated.along = seat.along;
  if (!touchAt(seated, found)) return false;
  // A piece of sharp edge may lie over a hollow, and touch at both places.
  TouchingFeature beside;
  if (!ContactSamples::isSmooth(sample) && touchAt(sampleQuery, beside)) found.add(beside);
  return true;
}

void SampleRefiner::remember(const SideQuery& query, std::uint32_t sample, const SampleQuery& sampleQuery,
                             const TouchingFeature& found) {
  SampleAnswer& answer = memory_.slot(query.sampled, sample, query.target);
  const glm::dvec3& origin = query.to->field.origin();
  answer.place = glm::vec3(sampleQuery.point - origin);
  answer.room = static_cast<float>(std::min(found.distance, found.least));
  answer.planes = 0;
  const bool round = query.from->samples.isRound(query.from->samples.samples()[sample]);
  const auto predicted = [&](const TouchingPlane& plane) {
    return plane.gap + glm::dot(plane.normal, sampleQuery.motion);
  };
  // The lowest planes, as many as there is room for.
  std::array<const TouchingPlane*, TouchingFeature::kMaxPlanes> lowest;
  const auto end = lowest.begin() + found.count;
  for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) lowest[k] = &found.planes[k];
  std::sort(lowest.begin(), end,
            [&](const TouchingPlane* a, const TouchingPlane* b) { return predicted(*a) < predicted(*b); });
  for (auto at = lowest.begin(); at != end; ++at) {
    const TouchingPlane& plane = **at;
    answer.room = std::min(answer.room, static_cast<float>(plane.gap));
    if (answer.planes == static_cast<int>(answer.plane.size())) continue;
    // The gap of a patch is stored at its sample, from which that of any of its places follows.
    const glm::dvec3 seat = round ? sampleQuery.point : plane.point;
    answer.plane[static_cast<std::size_t>(answer.planes++)] = {
        glm::vec3(plane.normal), static_cast<float>(plane.gap + glm::dot(plane.normal, seat - plane.point)),
        glm::vec3(seat - origin),
        glm::vec3(glm::conjugate(query.toFromSamples.orientation) * (seat - sampleQuery.point))};
  }
  answer.triangle = found.triangle;
  answer.target = query.target;
  answer.step = memory_.step();
}

void SampleRefiner::addRows(const SideQuery& query, const ContactSample& sample, const TouchingFeature& found,
                            RowSource source, ContactRows& rows) const {
  if (!TICK_ASSERT(fault_, found.count >= 0 && found.count <= TouchingFeature::kMaxPlanes)) return;
  const assets::Material &mine = world_.material(query.sampled, sample.triangle),
                         &its = world_.material(query.target, found.triangle);
  const double tolerance = query.to->field.tolerance(), allowed = query.allowed(sample);
  for (int i = 0; i < found.count; ++i) {
    const TouchingPlane& plane = found.planes[static_cast<std::size_t>(i)];
    ExactRow row;
    row.normal = query.worldFromTo.orientation * plane.normal * (query.ofFirst() ? 1.0 : -1.0);
    row.arm = transformPoint(query.worldFromTo, plane.point) - query.first().centre;
    // Position correction: the part moves out at most by the distance to the surface, at the speed of what
    // pushes it in and beyond that by a few tolerances a step. Of a penetration all but one tolerance is
    // corrected in a step, of a small one a fifth a step (a Baumgarte stabilisation).
    const double gap = std::max(plane.gap, -found.distance) + allowed;
    row.gap =
        std::max(gap + std::clamp(-0.8 * gap, 0.0, tolerance), -island_.push() - kTolerancesOut * tolerance);
    row.staticFriction = 0.5 * (mine.staticFriction + its.staticFriction);
    row.dynamicFriction = 0.5 * (mine.dynamicFriction + its.dynamicFriction);
    row.source = source;
    row.source.side = static_cast<std::uint16_t>(source.side + 2 * i);
    rows.addExact(row);
  }
}

}  // namespace tandem::haptics
