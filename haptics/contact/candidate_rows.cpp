#include "haptics/contact/candidate_rows.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/touch/patch_touch.h"
#include "haptics/touch/piece_clearance.h"

namespace tandem::haptics {
namespace {

constexpr std::uint32_t kWorthDividing = 1024;  // samples
constexpr float kShallow = 0.25f;   // trusted errors up to which no answer is worth more than a dip
constexpr double kSpacings = 1.25;  // of samples at which a part that passed through another has left it
constexpr float kBlade = 0.7f;      // rad (some 40 degrees) between the faces of a blade at least

}  // namespace

SideTimes::SideTimes(const SideQuery& query, SideClocks& clocks) {
  if (query.rowless) return;
  allowed = query.overlaps->allowed(query.pair, query.ofFirst(), query.to->field.origin());
  due = clocks.at(query.sampled, query.target, query, allowed);
  if (!due.nodes.empty()) divide(query.from->samples);
}

void SideTimes::divide(const ContactSamples& samples) {
  const auto count = [&](std::uint32_t n) { return samples.nodes()[n].end - samples.nodes()[n].begin; };
  roots.push_back(0);
  while (!roots.full()) {
    const auto largest = std::max_element(
        roots.begin(), roots.end(), [&](std::uint32_t a, std::uint32_t b) { return count(a) < count(b); });
    const std::uint32_t n = *largest, second = samples.nodes()[n].second;
    if (count(n) < kWorthDividing || second == 0 || !isOpen(samples, due, n)) return;
    opened.push_back(n);
    *largest = n + 1;
    roots.push_back(second);
  }
}

void SideTimes::close(const ContactSamples& samples) const {
  for (std::size_t k = opened.size(); k > 0; --k)
    due.nodes[opened[k - 1]] = leastOfChildren(samples, due, opened[k - 1]);
}

double CandidateRows::gather(std::size_t part) {
  const PartModel &from = *query_.from, &to = *query_.to;
  const FloatMotion motion(query_.toFromSamples, to.field.origin());
  if (query_.passing) return leaves(motion) ? 0.0 : kSpacings * from.samples.spacing();
  const auto visit = [&](std::uint32_t i, const glm::vec3& place, const Reading& read) {
    addAnyRows(i, place, read);
    return clear_;
  };
  if (!times_.due.nodes.empty()) {
    // What is not visited is further than the reach from as deep as it may be.
    deepen(times_.allowed.depth - query_.limit);
    DueSamples(from.samples, to.field, motion, times_.allowed, query_.limit, times_.due, visit)
        .read(times_.roots[part]);
    return static_cast<double>(deepest_);
  }
  NearSamples near(from.samples, to.field, motion, query_.limit, true);
  while (!near.done()) near.advance(visit);
  deepen(near.passedBy());
  return static_cast<double>(deepest_);
}

bool CandidateRows::leaves(const FloatMotion& motion) const {
  const ContactSamples& samples = query_.from->samples;
  const auto reach = static_cast<float>(kSpacings * samples.spacing());
  NearSamples near(samples, query_.to->field, motion, std::max(query_.limit, reach), true);
  bool any = false;
  while (!any && !near.done())
    near.advance([&](std::uint32_t, const glm::vec3&, const Reading&) { any = true; });
  return !any;
}

void CandidateRows::addRows(std::uint32_t i, const glm::vec3& place, const Reading& read) {
  const ContactSample& sample = sampleAt(i);
  allowed_ = static_cast<float>(query_.allowed(sample));
  clear_ =
      read.distance - read.error - ContactSamples::touchAbout(query_.from->samples.points()[i]) + allowed_;
  if (query_.to->byFormula()) return addShapeRows(i);
  if (query_.from->samples.isRound(sample)) return addPatchRow(i, place, read);
  addSampleRow(i, place, read);
}

void CandidateRows::addFittedRows(std::uint32_t i, const glm::vec3& place, const Reading& read) {
  // What is outside is out of reach, wherever it is shifted within its own part.
  shift_ = query_.fitShift(sampleAt(i), hint_);
  if (shift_ == glm::dvec3(0.0)) {
    addRows(i, place, read);
  } else {
    const glm::vec3 shifted = place + glm::vec3(shift_);
    addRows(i, shifted, query_.to->field.read(shifted));
  }
  clear_ /= 1.0f + static_cast<float>(query_.fit->slope());
}

void CandidateRows::addPlane(const glm::vec3& normal, const glm::vec3& arm, float gap, RowSource source,
                             float beside) {
  if (query_.isCut(arm)) return;
  rows_.addPlane(normal, arm, gap, source, beside);
  lowest_ = std::min(lowest_, gap);
}

void CandidateRows::addShapeRows(std::uint32_t i) {
  const ContactSample& sample = sampleAt(i);
  const double slack = evenness(*query_.to), allowed = static_cast<double>(allowed_),
               limit = static_cast<double>(query_.limit);
  ContactPatch patch;
  const bool patched = patchBefore(query_, sample, patch);
  const glm::dvec3 at = transformPoint(query_.toFromSamples, sample.point),
                   outward = outwardBefore(query_, sample);
  for (const Primitive& shape : query_.to->field.shapes()) {
    glm::dvec3 point = at;
    SurfaceDistance read = shape.against(at, outward);
    if (patched) {
      // The shape is convex: its distance lies above the plane that touches it in one place.
      const double drop = glm::dot(read.gradient, patch.pointAt(patch.lowest(read.gradient, 0.0)) - at);
      if (read.distance + drop + allowed > limit) {
        deepen(static_cast<float>(-read.distance - drop));
        continue;
      }
      if (drop < -slack) {
        const PatchTouch touch = deepestIn(shape, patch, slack, outward);
        point = touch.point;
        read = touch.read;
      }
    }
    deepen(static_cast<float>(-read.distance));
    if (query_.rowless || read.distance + allowed > limit) continue;
    if (!shape.solid()) orientAgainst(outward, query_.to->field.tolerance(), read.gradient, read.distance);
    addPlane(query_.world(glm::vec3(read.gradient)), query_.arm(point),
             static_cast<float>(read.distance + allowed), query_.source(i));
  }
}

void CandidateRows::addPatchRow(std::uint32_t i, const glm::vec3& place, const Reading& read) {
  const ContactSample& sample = sampleAt(i);
  const float least = read.distance - read.error - sample.along;
  if (query_.rowless) return deepen(-least);
  const double slack = evenness(*query_.to);
  const ContactPatch patch = query_.from->samples.patches()[sample.patch].moved(query_.toFromSamples);
  PatchTouch touch;
  float error = read.error;
  if (error <= query_.rough) touch = deepestIn(query_.to->field, patch, slack, error);
  if (error > query_.rough) {
    deepen(-least);
    return addAnsweredRows(i, place, &patch, least + allowed_);
  }
  const float distance = static_cast<float>(touch.read.distance);
  deepen(error - distance);
  if (distance - error + allowed_ > query_.limit) return;
  const float gap = error <= query_.smooth ? distance + error : distance - error;
  addPlane(query_.world(glm::vec3(touch.read.gradient)), query_.arm(touch.point), gap + allowed_,
           query_.source(i));
}

void CandidateRows::addSampleRow(std::uint32_t i, const glm::vec3& place, const Reading& read) {
  deepen(read.error - read.distance);
  if (query_.rowless) return;
  const ContactSample& sample = sampleAt(i);
  const float least = read.distance - read.error + allowed_;
  const bool smooth = ContactSamples::isSmooth(sample);
  // Between samples of a smooth surface the part may touch first.
  float beside = smooth && asItLies() ? query_.from->samples.sag(sample) : 0.0f;
  if (read.error > query_.rough) return addAnsweredRows(i, place, nullptr, least - sample.along - beside);
  if (smooth && least - beside > query_.limit) return;
  Dip dip;
  if (sample.along > 0.0f) dip = edgeDip(sample, place, read, least - query_.limit);
  if (dip.ofBlade) return addAnsweredRows(i, place, nullptr, least - sample.along);
  if (!asItLies()) dip.depth = 0.0f;
  if (!smooth && least - dip.depth > query_.limit) {
    clearAlong(sample, place, read);
    if (clear_ > query_.limit) return;
    // Elsewhere along the piece it may touch another place of the target, as it did when last queried.
    if (const SampleAnswer* const answer = trustedAnswer(i, place)) addPlanes(i, place, *answer, nullptr);
    return;
  }
  if (dip.depth > kShallow * query_.smooth) {
    if (const SampleAnswer* const answer = trustedAnswer(i, place))
      return addPlanes(i, place, *answer, nullptr);
  }
  glm::vec3 normal = read.gradient;
  // A reading is taken to be too low, so that a contact at rest is not queried in every step.
  float gap = read.distance + read.error;
  // By what that leaves the sample deep beyond a tolerance, it may touch before its plane does.
  if (read.error <= query_.smooth && asItLies())
    beside = std::max(beside, 2.0f * read.error - 0.5f * query_.smooth);
  if (read.error > query_.smooth) {
    if (isAnswered(i, place)) return addAnsweredRows(i, place, nullptr, least - sample.along);
    gap = read.distance - read.error;
    // Near an edge of the target the field's gradient is not the face's normal, along which the piece may dip
    // more.
    if (alignToFace(i, read, normal, gap) && sample.along > 0.0f && asItLies())
      dip.depth = std::max(dip.depth, edgeDip(sample, place, {gap, 0.0f, normal}, gap - query_.limit).depth);
  }
  addPlane(query_.world(normal), query_.armOf(place), gap - dip.depth + allowed_, query_.source(i), beside);
}

const SampleAnswer* CandidateRows::trustedAnswer(std::uint32_t sample, const glm::vec3& place) const {
  const SampleAnswer* const answer = memory_.find(query_.sampled, sample, query_.target);
  return answer != nullptr && isTrusted(sample, place, *answer) ? answer : nullptr;
}

bool CandidateRows::isTrusted(std::uint32_t sample, const glm::vec3& place,
                              const SampleAnswer& answer) const {
  return memory_.isFresh(answer, sample) && glm::length(place - answer.place) <= query_.trusted;
}

void CandidateRows::addPlanes(std::uint32_t i, const glm::vec3& place, const SampleAnswer& answer,
                              const ContactPatch* patch) {
  const ContactSample& sample = sampleAt(i);
  // The planes hold for the whole piece of edge only until it has moved by its distance from the target then.
  // From then on, the rest of the piece may be deeper than the sample.
  const bool isOpen = patch == nullptr && sample.along > 0.0f && asItLies() && answer.planes == 1 &&
                      answer.plane[0].aside == glm::vec3(0.0f) && roomLeft(i, place, answer, nullptr) < 0.0f;
  for (std::size_t k = 0; k < static_cast<std::size_t>(answer.planes); ++k) {
    const AnsweredPlane& plane = answer.plane[k];
    const glm::vec3 &normal = plane.normal, seat = place + rotation_ * plane.aside;
    glm::vec3 arm = query_.armOf(seat);
    float gap = glm::dot(normal, seat) - plane.height + allowed_;
    if (patch != nullptr) {
      // The gap is that of the place of the patch that is lowest over the plane now.
      const glm::dvec3 up(normal), lowest = patch->pointAt(patch->lowest(up, evenness(*query_.to)));
      arm = query_.arm(lowest);
      gap += static_cast<float>(glm::dot(up, lowest - patch->sample()));
    }
    if (isOpen) gap -= edgeDip(sample, place, {gap, 0.0f, normal}, gap - query_.limit).depth;
    // What rests on the plane obeys it as it will obey the exact row, so that it is not queried in vain.
    const auto demanded = static_cast<float>(query_.corrected(static_cast<double>(gap)));
    addPlane(query_.world(normal), arm, demanded, query_.source(i));
  }
}

float CandidateRows::roomLeft(std::uint32_t i, const glm::vec3& place, const SampleAnswer& answer,
                              const ContactPatch* patch) const {
  const auto extent = static_cast<float>(query_.from->samples.extent(sampleAt(i)));
  const float path =
      patch != nullptr ? 2.0f * glm::length(place - answer.place) : answer.movedSince(place, turn_, extent);
  return answer.room + allowed_ - path;
}

bool CandidateRows::isAnswered(std::uint32_t i, const glm::vec3& place) const {
  if (trustedAnswer(i, place) != nullptr) return true;
  const SampleAnswer* const answer = memory_.find(query_.sampled, i, query_.target);
  return answer != nullptr && roomLeft(i, place, *answer, nullptr) > query_.limit;
}

void CandidateRows::addAnsweredRows(std::uint32_t i, const glm::vec3& place, const ContactPatch* patch,
                                    float room) {
  if (const SampleAnswer* const answer = memory_.find(query_.sampled, i, query_.target)) {
    const float left = roomLeft(i, place, *answer, patch);
    const bool point = patch == nullptr && !(sampleAt(i).along > 0.0f);
    if (point) clear_ = std::max(clear_, left);
    const bool outOfReach = patch == nullptr && left > query_.limit;
    if (!outOfReach && isTrusted(i, place, *answer)) return addPlanes(i, place, *answer, patch);
    room = std::max(room, left);
    // What is said of places that were seen says little of the rest of a sharp edge or of a patch: of an edge
    // it holds as far as an answer is trusted, then the field is read again.
    if (outOfReach) clear_ = std::max(clear_, std::min(left, query_.trusted));
  }
  if (room <= query_.limit) rows_.addBall(query_.armOf(place), room, query_.source(i));
}

void CandidateRows::clearAlong(const ContactSample& sample, const glm::vec3& place, const Reading& read) {
  if (clear_ > query_.limit || !(sample.along > 0.0f)) return;
  const glm::vec3 along = alongOf(sample);
  clear_ = std::max(clear_, leastAlong(query_.to->field, place, read, along, query_.rough) + allowed_);
}

CandidateRows::Dip CandidateRows::edgeDip(const ContactSample& sample, const glm::vec3& place,
                                          const Reading& read, float above) const {
  const glm::vec3 along = alongOf(sample);
  const float slope = glm::dot(read.gradient, along), worth = std::max(query_.smooth, above);
  // Most edges run along the target or do not dip.
  if (std::abs(slope) <= worth) return {};
  return dipTowards(slope > 0.0f ? -along : along, place, read);
}

CandidateRows::Dip CandidateRows::dipTowards(const glm::vec3& along, const glm::vec3& place,
                                             const Reading& read) const {
  const float down = -glm::dot(read.gradient, along);
  const Reading next = query_.to->field.read(place + along);
  // Where the other end is near an edge of the target, it is known only how deep that end may be.
  const float end =
      next.error > query_.smooth ? std::clamp(read.distance - next.distance + next.error, 0.0f, down) : 0.0f;
  const float up = glm::dot(next.gradient, along);
  if (next.error > query_.rough || up <= 0.0f) return {end, false};
  const float depth = std::max(0.0f, down * (read.distance - next.distance + up) / (down + up));
  const bool ofBlade = down + up >= kBlade * glm::length(along) &&
                       std::min(depth, depth + next.distance - read.distance) > query_.smooth;
  return {std::max(end, depth + next.error), ofBlade};
}

bool CandidateRows::alignToFace(std::uint32_t i, const Reading& read, glm::vec3& normal, float& gap) const {
  const SampleAnswer* const answer = memory_.find(query_.sampled, i, query_.target);
  if (answer == nullptr) return false;
  const Triangle face = query_.to->tree->triangle(answer->triangle);
  const glm::dvec3 p = transformPoint(query_.toFromSamples, sampleAt(i).point) + shift_,
                   up = query_.to->edges.normal(answer->triangle);
  if (!closestPointOnTriangle(p, face).onFace) return false;
  const double height = glm::dot(up, p - face.a);
  if (std::abs(height - static_cast<double>(read.distance)) > static_cast<double>(read.error)) return false;
  normal = glm::vec3(up);
  gap = static_cast<float>(height);
  return true;
}

}  // namespace tandem::haptics
