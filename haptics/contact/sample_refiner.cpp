#include "haptics/contact/sample_refiner.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/base/fixed_vector.h"

namespace tandem::haptics {
namespace {

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
      behind = glm::dot(glm::dvec3(last->normals[0]), plane.normal) < 0.0;
    if (!behind) continue;
    plane.normal = -plane.normal;
    plane.gap = -plane.gap;
  }
}

}  // namespace

void SampleRefiner::beginStep(double dt, double reach, bool exact) {
  TICK_ASSERT(fault_, dt > 0.0 && reach >= 0.0);
  dt_ = dt;
  reach_ = reach;
  exact_ = exact;
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
  sampleQuery.nearest = static_cast<double>(1.001f * (std::abs(around.distance) + around.error));
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
  if (!exact_) return fieldFeature(to, sampleQuery, found);
  // Beyond its grid a field knows only how far the mesh is at least.
  return touchingFeature(*to.tree, to.edges, sampleQuery, sampleQuery.nearest, hint, found) ||
         touchingFeature(*to.tree, to.edges, sampleQuery, 1e300, hint, found);
}

void SampleRefiner::remember(const SideQuery& query, std::uint32_t sample, const SampleQuery& sampleQuery,
                             const TouchingFeature& found) {
  SampleAnswer& answer = memory_.slot(query.sampled, sample, query.target);
  answer.place = glm::vec3(sampleQuery.point - query.to->field.origin());
  answer.room = static_cast<float>(std::min(found.distance, found.planes[0].gap));
  answer.planes = found.count;
  const bool round = query.from->samples.isRound(query.from->samples.samples()[sample]);
  for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) {
    const TouchingPlane& plane = found.planes[k];
    answer.normals[k] = glm::vec3(plane.normal);
    // The gap of a patch is stored at its sample, from which that of any of its places follows.
    const double above = round ? glm::dot(plane.normal, sampleQuery.point - plane.point) : 0.0;
    answer.gaps[k] = static_cast<float>(plane.gap + above);
  }
  answer.triangle = found.triangle;
  answer.target = query.target;
  answer.step = memory_.step();
}

void SampleRefiner::addRows(const SideQuery& query, const ContactSample& sample, const TouchingFeature& found,
                            RowSource source, ContactRows& rows) const {
  if (!TICK_ASSERT(fault_, found.count >= 0 && found.count <= 2)) return;
  const assets::Material &mine = world_.material(query.sampled, sample.triangle),
                         &its = world_.material(query.target, found.triangle);
  const double tolerance = query.to->field.tolerance(), allowed = query.allowed(sample);
  for (int i = 0; i < found.count; ++i) {
    const TouchingPlane& plane = found.planes[static_cast<std::size_t>(i)];
    ExactRow row;
    row.normal = query.worldFromTo.orientation * plane.normal * (query.ofFirst() ? 1.0 : -1.0);
    row.arm = transformPoint(query.worldFromTo, plane.point) - query.first().centre;
    if (query.isCut(glm::vec3(row.arm))) continue;
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
