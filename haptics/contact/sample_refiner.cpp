#include "haptics/contact/sample_refiner.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/base/fixed_vector.h"
#include "haptics/scene/haptic_texture.h"
#include "haptics/touch/sample_descent.h"

namespace tandem::haptics {
namespace {

constexpr double kDeeperBy = 0.1;    // tolerances by which a deeper place near a sample is deeper
constexpr double kAllowance = 0.5;   // tolerances that a place near a sample may be deeper
constexpr double kTurned = 0.25;     // tolerances by which the seat of a sample may be off
constexpr int kMaxDescents = 8;      // in a step; samples beyond it are measured where they are
constexpr int kMaxBeside = 8;        // in a step; samples queried because of what may be beside them
constexpr float kEnters = 0.25f;     // tolerances that a sample may be beyond a plane of its last answer
constexpr float kSameSeat = 0.06f;   // extents that a sample goes while its last seat holds
constexpr double kNearSeat = 0.03;   // extents that a sample goes until its last seat is looked for anew
constexpr double kTurnedNear = 1.0;  // tolerances by which that extent may turn meanwhile
constexpr double kLong = 10.0;       // tolerances that a sample goes in a long step
constexpr double kToleranceAcross =
    8.0;  // tolerances that a sample may be across a sheet and still on its old side
constexpr double kTolerancesOut =
    8.0;  // by which a step moves out what is inside, beyond the speed of what pushes it in

std::uint32_t indexOf(const PartModel& part, const ContactSample& sample) {
  return static_cast<std::uint32_t>(&sample - part.samples.samples().data());
}

Seat seatAt(const SampledModels& models, const KnownSeat& known) {
  Seat seat;
  seat.edge = known.edge;
  seat.point = transformPoint(models.toFromSamples, known.point);
  seat.along = static_cast<double>(known.along);
  seat.least = 1e300;
  return seat;
}

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
  beginAhead(dt, reach, effort);
  memory_.beginStep();
}

void SampleRefiner::beginAhead(double dt, double reach, const ContactEffort& effort) {
  TICK_ASSERT(fault_, dt > 0.0 && reach >= 0.0);
  dt_ = dt;
  reach_ = reach;
  exact_ = effort.exact;
  descend_ = effort.descend;
  queries_ = descents_ = besideQueries_ = 0;
  prepared_.clear();
}

void SampleRefiner::prepare(std::span<const RowSource> sources, PairMotions u) {
  prepared_.clear();
  for (const RowSource& source : sources) {
    Prepared& prepared = prepared_.push_back({});
    prepared.source = source;
    prepared.u = u[source.pair];
  }
  constexpr int kAtOnce = 4;  // samples, so that a task is worth it
  const int count = static_cast<int>(prepared_.size());
  helpers_->run((count + kAtOnce - 1) / kAtOnce, [&](int task, int) {
    for (int k = kAtOnce * task; k < std::min(count, kAtOnce * (task + 1)); ++k)
      prepareOne(prepared_[static_cast<std::size_t>(k)]);
  });
}

void SampleRefiner::prepareOne(Prepared& prepared) const {
  const RowSource& source = prepared.source;
  const SideQuery query(island_, overlaps_, source.pair, source.side, reach_);
  const ContactSample& sample = query.from->samples.samples()[source.sample];
  if (query.to->byFormula() || query.from->samples.isRound(sample)) return;
  Normals normals;
  const SampleQuery sampleQuery = sampleQueryFor(query, sample, prepared.u, normals);
  const SampleAnswer* const last = memory_.find(query.sampled, source.sample, query.target);
  prepared.hint = last != nullptr ? last->triangle : kNoTriangle;
  prepared.touches = touchAt(query, sampleQuery, prepared.hint, prepared.found);
  prepared.known = true;
}

const SampleRefiner::Prepared* SampleRefiner::preparedFor(RowSource source, const Displacement& u) const {
  for (const Prepared& prepared : prepared_) {
    if (prepared.source == source && prepared.known && prepared.u.linear == u.linear &&
        prepared.u.angular == u.angular)
      return &prepared;
  }
  return nullptr;
}

void SampleRefiner::refine(RowSource source, const Displacement& u, ContactRows& rows) {
  ++queries_;
  if (!TICK_ASSERT(fault_, source.pair < island_.pairCount() && island_.pair(source.pair).mayTouch())) return;
  const SideQuery query(island_, overlaps_, source.pair, source.side, reach_);
  if (!TICK_ASSERT(fault_, source.sample < query.from->samples.samples().size())) return;
  const ContactSample& sample = query.from->samples.samples()[source.sample];
  Normals normals;
  const SampleQuery sampleQuery = sampleQueryFor(query, sample, u, normals);
  const SampleAnswer* const last = memory_.find(query.sampled, source.sample, query.target);
  TouchingFeature found;
  if (!touch(query, sample, sampleQuery, last, preparedFor(source, u), found)) return;
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

glm::dvec3 SampleRefiner::motionAt(const SideQuery& query, const glm::dvec3& point,
                                   const Displacement& u) const {
  const ContactBody& first = query.first();
  const double length = first.motion(u), share = length > reach_ ? reach_ / length : 1.0;
  const glm::dvec3 motion = share * u.at(transformPoint(query.worldFromTo, point) - first.centre);
  return glm::conjugate(query.worldFromTo.orientation) * (query.ofFirst() ? motion : -motion);
}

bool SampleRefiner::mayTouchBeside(RowSource source, const glm::vec3& normal, float room,
                                   const Displacement& u) {
  if (!exact_ || !TICK_ASSERT(fault_, source.pair < island_.pairCount())) return false;
  const SideQuery query(island_, overlaps_, source.pair, source.side, reach_);
  const ContactSample& sample = query.from->samples.samples()[source.sample];
  const DistanceField& field = query.to->field;
  const glm::dvec3 point = transformPoint(query.toFromSamples, sample.point);
  const glm::vec3 place(point - field.origin());
  const SampleAnswer* const answer = memory_.find(query.sampled, source.sample, query.target);
  if (answer != nullptr && memory_.isFresh(*answer, source.sample) &&
      glm::length(place - answer->place) <= query.trusted)
    return entersPlanes(query, *answer, place, glm::vec3(motionAt(query, point, u)));
  const DistanceField::Reading here = field.read(place);
  if (room < 2.0f * here.error - static_cast<float>(field.tolerance())) return besideQueries_++ < kMaxBeside;
  if (!descend_ || !ContactSamples::isSmooth(sample)) return false;
  if (const KnownSeat* const known = recallNear(query, sample)) return entersAt(query, *known, u);
  const glm::dvec3 up = glm::conjugate(query.worldFromTo.orientation) * glm::dvec3(query.sign * normal),
                   ownUp = glm::conjugate(query.toFromSamples.orientation) * up;
  if (static_cast<double>(room) > smoothDip(query.from->samples, sample, ownUp)) return false;
  return besideQueries_++ < kMaxBeside;
}

bool SampleRefiner::entersPlanes(const SideQuery& query, const SampleAnswer& answer, const glm::vec3& place,
                                 const glm::vec3& motion) {
  const glm::quat turn(query.toFromSamples.orientation);
  const float allowed = kEnters * static_cast<float>(query.to->field.tolerance());
  for (std::size_t k = 0; k < static_cast<std::size_t>(answer.planes); ++k) {
    const AnsweredPlane& plane = answer.plane[k];
    if (glm::dot(plane.normal, place + turn * plane.aside + motion) - plane.height < -allowed) return true;
  }
  return false;
}

bool SampleRefiner::entersAt(const SideQuery& query, const KnownSeat& known, const Displacement& u) const {
  if (known.edge == assets::kNone) return false;
  const DistanceField& field = query.to->field;
  const glm::dvec3 seat = transformPoint(query.toFromSamples, known.point);
  const DistanceField::Reading read = field.read(glm::vec3(seat + motionAt(query, seat, u) - field.origin()));
  return read.distance + std::min(read.error, static_cast<float>(field.tolerance()) - read.error) < 0.0f;
}

SampleQuery SampleRefiner::sampleQueryFor(const SideQuery& query, const ContactSample& sample,
                                          const Displacement& u, Normals& normals) const {
  const PartModel &from = *query.from, &to = *query.to;
  for (const glm::dvec3& normal : from.samples.normals(sample)) {
    if (!normals.full()) normals.push_back(query.toFromSamples.orientation * normal);
  }
  SampleQuery sampleQuery;
  sampleQuery.normals = {normals.data(), normals.size()};
  const glm::dvec3 shift = query.fitShift(sample);
  sampleQuery.shifted = shift != glm::dvec3(0.0);
  sampleQuery.point = transformPoint(query.toFromSamples, sample.point) + shift;
  sampleQuery.motion = motionAt(query, sampleQuery.point, u);
  sampleQuery.slack = 0.5 * to.field.tolerance();
  sampleQuery.range = SideQuery::kTrustedShare * from.samples.spacing() + query.contactPair().closing(reach_);
  if (to.byFormula() || from.samples.isRound(sample)) return sampleQuery;
  readField(query, sampleQuery);
  if (ContactPatch edge; from.patchOf(sample, edge)) {
    sampleQuery.edge = query.toFromSamples.orientation * edge.axis;
    sampleQuery.along = edge.along;
  }
  return sampleQuery;
}

void SampleRefiner::readField(const SideQuery& query, SampleQuery& sampleQuery) const {
  const DistanceField& field = query.to->field;
  const DistanceField::Reading around =
      field.read(glm::vec3(sampleQuery.point - field.origin()), sampleQuery.near);
  sampleQuery.nearest = static_cast<double>(1.001f * (std::abs(around.distance) + around.error));
  // Where the field's error leaves the side open, the sample is outside, for it came from there.
  sampleQuery.outside =
      around.distance > around.error ||
      ((query.fit != nullptr || !overlaps_.has(query.pair)) && around.distance >= -around.error);
}

bool SampleRefiner::touch(const SideQuery& query, const ContactSample& sample, const SampleQuery& sampleQuery,
                          const SampleAnswer* last, const Prepared* prepared, TouchingFeature& found) {
  const PartModel& to = *query.to;
  const std::uint32_t hint = last != nullptr ? last->triangle : kNoTriangle;
  if (to.byFormula()) return touchShapes(query, sample, sampleQuery, found);
  if (query.from->samples.isRound(sample)) return touchPatch(query, sample, sampleQuery, hint, exact_, found);
  if (!exact_) return fieldFeature(to, sampleQuery, found);
  return touchMesh(query, sample, sampleQuery, last, prepared, found);
}

bool SampleRefiner::touchAt(const SideQuery& query, const SampleQuery& at, std::uint32_t& hint,
                            TouchingFeature& found) {
  const PartModel& to = *query.to;
  // Beyond its grid a field knows only how far the mesh is at least.
  if (!touchingFeature(*to.tree, to.edges, at, at.nearest, hint, found) &&
      !touchingFeature(*to.tree, to.edges, at, 1e300, hint, found))
    return false;
  hint = found.triangle;
  return true;
}

bool SampleRefiner::touchMesh(const SideQuery& query, const ContactSample& sample,
                              const SampleQuery& sampleQuery, const SampleAnswer* last,
                              const Prepared* prepared, TouchingFeature& found) {
  std::uint32_t hint = last != nullptr ? last->triangle : kNoTriangle;
  if (prepared != nullptr) {
    if (!prepared->touches) return false;
    hint = prepared->hint;
    found = prepared->found;
  } else if (!touchAt(query, sampleQuery, hint, found)) {
    return false;
  }
  // The depth that an overlap at rest allows was measured at the samples alone.
  if (!descend_ || sample.edge == assets::kNone || sampleQuery.shifted || query.allowed(sample) > 0.0)
    return true;
  const TouchingFeature beside = found;
  const Seat seat = seatOf(query, sample, sampleQuery, hint, found);
  const double least = std::min(found.distance - kAllowance * query.to->field.tolerance(), seat.least);
  found.least = least;
  // Beside a flush face the planes of a place over it are those of the face's border, in any direction: the
  // place counts only where it may be inside.
  const bool counts = ContactSamples::isSmooth(sample) || seat.least < glm::length(sampleQuery.motion);
  if (seat.edge == assets::kNone || !counts) return true;
  const EdgeLine edge = query.from->edges.line(seat.edge);
  const glm::dquat& rotation = query.toFromSamples.orientation;
  std::array<glm::dvec3, 2> normals = query.from->edges.normals(seat.edge);
  for (glm::dvec3& normal : normals) normal = rotation * normal;
  SampleQuery seated = sampleQuery;
  seated.point = seat.point;
  readField(query, seated);
  seated.normals = normals;
  seated.edge = rotation * glm::normalize(edge.b - edge.a);
  seated.along = seat.along;
  if (!touchAt(query, seated, hint, found)) return false;
  found.least = least;
  // A piece of sharp edge may lie over a hollow, and touch at both places.
  if (!ContactSamples::isSmooth(sample)) found.add(beside);
  return true;
}

Seat SampleRefiner::seatOf(const SideQuery& query, const ContactSample& sample,
                           const SampleQuery& sampleQuery, std::uint32_t hint, const TouchingFeature& found) {
  const PartModel &from = *query.from, &to = *query.to;
  const double tolerance = to.field.tolerance(), motion = glm::length(sampleQuery.motion);
  const LevelBounds level{sampleQuery.outside ? found.distance : -found.distance, kAllowance * tolerance,
                          static_cast<double>(query.smooth)};
  const glm::dvec3& up = found.planes[0].normal;
  if (isLevel(query, sample, level, up, found.count == 1)) {
    if (ContactSamples::isSmooth(sample)) note(query, sample, sampleQuery, up, {}, true);
    return {};
  }
  if (const KnownSeat* const known = recall(query, sample, sampleQuery, up)) return seatAt(query, *known);
  if (descents_ >= kMaxDescents) {
    Seat unseen;
    unseen.least = found.distance - from.samples.dip(sample);
    return unseen;
  }
  ++descents_;
  const DescentBounds bounds{kDeeperBy * tolerance, sampleQuery.range};
  const KnownSeat* const last = ContactSamples::isSmooth(sample) ? lastSeat(query, sample) : nullptr;
  Seat seat = deepestNear(query, sample, bounds, hint,
                          last != nullptr ? EdgePlace{last->edge, last->point} : EdgePlace{});
  const bool looked = seat.least <= bounds.range;
  if (looked && (seat.edge == assets::kNone || ContactSamples::isSmooth(sample)))
    note(query, sample, sampleQuery, up, seat, false);
  // In a long step the deepest place may be another one at its end.
  if (seat.edge == assets::kNone && motion > kLong * tolerance) {
    SampledModels ahead = query;
    ahead.toFromSamples.position += sampleQuery.motion;
    const double least = seat.least;
    seat = deepestNear(ahead, sample, bounds, hint);
    seat.point -= sampleQuery.motion;
    seat.least = std::min(least, seat.least);
  }
  return seat;
}

const KnownSeat* SampleRefiner::lastSeat(const SideQuery& query, const ContactSample& sample) const {
  const PartModel& from = *query.from;
  return seats_.find(query.sampled, indexOf(from, sample), query.target, from.features.get());
}

const KnownSeat* SampleRefiner::recallNear(const SideQuery& query, const ContactSample& sample) const {
  const PartModel& from = *query.from;
  const KnownSeat* const known = lastSeat(query, sample);
  if (known == nullptr) return nullptr;
  const double extent = from.samples.extent(sample);
  const glm::vec3 place(transformPoint(query.toFromSamples, sample.point) - query.to->field.origin());
  const glm::quat now(query.toFromSamples.orientation),
      near = glm::dot(known->orientation, now) < 0.0f ? -now : now;
  const double turned = 2.0 * extent * static_cast<double>(glm::length(near - known->orientation));
  const bool same = static_cast<double>(glm::length(place - known->place)) <= kNearSeat * extent &&
                    turned <= kTurnedNear * query.to->field.tolerance();
  return same ? known : nullptr;
}

const KnownSeat* SampleRefiner::recall(const SideQuery& query, const ContactSample& sample,
                                       const SampleQuery& sampleQuery, const glm::dvec3& up) const {
  const PartModel& from = *query.from;
  const KnownSeat* const known = lastSeat(query, sample);
  if (known == nullptr || known->level) return nullptr;
  const glm::vec3 place(sampleQuery.point - query.to->field.origin()),
      ownUp(glm::conjugate(query.toFromSamples.orientation) * up);
  const auto extent = static_cast<float>(from.samples.extent(sample)),
             turned = static_cast<float>(kTurned * query.to->field.tolerance());
  const bool same = glm::length(place - known->place) <= kSameSeat * extent &&
                    extent * glm::length(ownUp - known->up) <= turned;
  return same ? known : nullptr;
}

void SampleRefiner::note(const SideQuery& query, const ContactSample& sample, const SampleQuery& sampleQuery,
                         const glm::dvec3& up, const Seat& seat, bool level) {
  const Pose& pose = query.toFromSamples;
  KnownSeat known;
  known.sampled = query.sampled;
  known.target = query.target;
  known.sample = indexOf(*query.from, sample);
  known.features = query.from->features.get();
  known.edge = seat.edge;
  known.level = level;
  known.orientation = glm::quat(pose.orientation);
  known.along = static_cast<float>(seat.along);
  known.point = transformPoint(inverse(pose), seat.point);
  known.up = glm::vec3(glm::conjugate(pose.orientation) * up);
  known.place = glm::vec3(sampleQuery.point - query.to->field.origin());
  seats_.remember(known);
}

void SampleRefiner::remember(const SideQuery& query, std::uint32_t sample, const SampleQuery& sampleQuery,
                             const TouchingFeature& found) {
  SampleAnswer& answer = memory_.slot(query.sampled, sample, query.target);
  const glm::dvec3& origin = query.to->field.origin();
  answer.place = glm::vec3(sampleQuery.point - origin);
  answer.room = static_cast<float>(std::min(found.distance, found.least));
  answer.orientation = glm::quat(query.toFromSamples.orientation);
  answer.planes = 0;
  const bool round = query.from->samples.isRound(query.from->samples.samples()[sample]);
  static_assert(TouchingFeature::kMaxPlanes <= std::tuple_size_v<decltype(answer.plane)>);
  double lowest = 1e300;
  for (std::size_t k = 0; k < static_cast<std::size_t>(found.count); ++k) {
    const TouchingPlane& plane = found.planes[k];
    answer.room = std::min(answer.room, static_cast<float>(plane.gap));
    // The gap of a patch is stored at its sample, from which that of any of its places follows.
    const glm::dvec3 seat = round ? sampleQuery.point : plane.point;
    answer.plane[static_cast<std::size_t>(answer.planes++)] = {
        glm::vec3(plane.normal), static_cast<float>(glm::dot(plane.normal, plane.point - origin) - plane.gap),
        glm::vec3(glm::conjugate(query.toFromSamples.orientation) * (seat - sampleQuery.point))};
    // The plane that is predicted to be violated most is the first one.
    const double predicted = plane.gap + glm::dot(plane.normal, sampleQuery.motion);
    if (predicted < lowest) {
      lowest = predicted;
      std::swap(answer.plane[0], answer.plane[k]);
    }
  }
  answer.triangle = found.triangle;
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
    if (query.isCut(glm::vec3(row.arm))) continue;
    // Position correction: the part moves out at most by the distance to the surface, at the speed of what
    // pushes it in and beyond that by a few tolerances a step.
    const double gap = query.corrected(std::max(plane.gap, -found.distance) + allowed);
    row.gap = std::max(gap, -island_.push() - kTolerancesOut * tolerance);
    double myShare = 0.5, itsShare = 0.5;
    if (world_.surfaces() != nullptr) {
      const glm::dvec3 ownPlace = transformPoint(inverse(query.toFromSamples), plane.point);
      myShare *= textureFriction(world_, query.sampled, sample.triangle, ownPlace);
      itsShare *= textureFriction(world_, query.target, found.triangle, plane.point);
    }
    row.staticFriction = myShare * mine.staticFriction + itsShare * its.staticFriction;
    row.dynamicFriction = myShare * mine.dynamicFriction + itsShare * its.dynamicFriction;
    row.source = source;
    row.source.side = static_cast<std::uint16_t>(source.side + 2 * i);
    rows.addExact(row);
  }
}

}  // namespace tandem::haptics
