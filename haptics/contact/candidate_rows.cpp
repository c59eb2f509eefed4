#include "haptics/contact/candidate_rows.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/contact/near_samples.h"
#include "haptics/contact/patch_touch.h"

namespace tandem::haptics {
namespace {

constexpr std::uint32_t kFreshSteps = 8;  // steps for which the planes of an answer are trusted at least
constexpr float kLevel = 0.25f;           // share of the trusted error up to which a dip is none
constexpr float kBlade = 0.7f;            // rad (some 40 degrees) between the faces of a blade at least

}  // namespace

double CandidateRows::gather() {
  const PartModel &from = *query_.from, &to = *query_.to;
  const bool byFormula = to.byFormula();
  float passedBy = -1.0f;
  bool inside = false;
  forEachNear(from.samples, to.field, FloatMotion(query_.toFromSamples, to.field.origin()), query_.limit,
              inside, passedBy, [&](std::uint32_t i, const glm::vec3& place, const Reading& read) {
                const ContactSample& sample = sampleAt(i);
                allowed_ = static_cast<float>(query_.allowed(sample));
                if (byFormula) return addShapeRows(i);
                if (from.samples.isRound(sample)) return addPatchRow(i, place, read);
                addSampleRow(i, place, read);
              });
  deepen(passedBy);
  return static_cast<double>(deepest_);
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
    if (query_.contained || read.distance + allowed > limit) continue;
    if (!shape.solid()) orientAgainst(outward, query_.to->field.tolerance(), read.gradient, read.distance);
    rows_.addPlane(query_.world(glm::vec3(read.gradient)), query_.arm(point),
                   static_cast<float>(read.distance + allowed), query_.source(i));
  }
}

void CandidateRows::addPatchRow(std::uint32_t i, const glm::vec3& place, const Reading& read) {
  const ContactSample& sample = sampleAt(i);
  const float least = read.distance - read.error - sample.along;
  if (query_.contained) return deepen(-least);
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
  rows_.addPlane(query_.world(glm::vec3(touch.read.gradient)), query_.arm(touch.point), gap + allowed_,
                 query_.source(i));
}

void CandidateRows::addSampleRow(std::uint32_t i, const glm::vec3& place, const Reading& read) {
  deepen(read.error - read.distance);
  if (query_.contained) return;
  const ContactSample& sample = sampleAt(i);
  const float least = read.distance - read.error + allowed_;
  if (read.error > query_.rough)
    return addAnsweredRows(i, place, nullptr, least - query_.from->samples.spread(i));
  Dip dip;
  if (sample.along > 0.0f) dip = edgeDip(sample, place, read);
  if (dip.ofBlade) return addAnsweredRows(i, place, nullptr, least - sample.along);
  if (ContactSamples::isSmooth(sample)) dip.depth = smoothDip(sample, read);
  if (allowed_ > 0.0f) dip.depth = 0.0f;
  if (least - dip.depth > query_.limit) return;
  if (dip.depth > kLevel * query_.smooth) {
    if (const SampleAnswer* const answer = trustedAnswer(i, place))
      return addPlanes(i, place, *answer, nullptr);
  }
  glm::vec3 normal = read.gradient;
  // A reading is taken to be too low, so that a contact at rest is not queried in every step, but by no more
  // than leaves the sample a tolerance deep.
  float gap = read.distance + std::min(read.error, query_.tolerance - read.error);
  if (read.error > query_.smooth) {
    gap = read.distance - read.error;
    alignToFace(i, read, normal, gap);
  }
  rows_.addPlane(query_.world(normal), query_.armOf(place), gap - dip.depth + allowed_, query_.source(i));
}

const SampleAnswer* CandidateRows::trustedAnswer(std::uint32_t sample, const glm::vec3& place) const {
  const SampleAnswer* const answer = memory_.find(query_.sampled, sample, query_.target);
  if (answer == nullptr || glm::length(place - answer->place) > query_.trusted) return nullptr;
  // The age differs from sample to sample, so that they are not all queried in the same step.
  return memory_.age(*answer) <= kFreshSteps + sample % kFreshSteps ? answer : nullptr;
}

void CandidateRows::addPlanes(std::uint32_t i, const glm::vec3& place, const SampleAnswer& answer,
                              const ContactPatch* patch) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(answer.planes); ++k) {
    const AnsweredPlane& plane = answer.plane[k];
    const glm::vec3 &normal = plane.normal, seat = place + rotation_ * plane.aside;
    glm::vec3 arm = query_.armOf(seat);
    float gap = plane.gap + glm::dot(normal, seat - plane.seat) + allowed_;
    if (patch != nullptr) {
      // The gap is that of the place of the patch that is lowest over the plane now.
      const glm::dvec3 up(normal), lowest = patch->pointAt(patch->lowest(up, evenness(*query_.to)));
      arm = query_.arm(lowest);
      gap += static_cast<float>(glm::dot(up, lowest - patch->sample()));
    }
    rows_.addPlane(query_.world(normal), arm, gap, query_.source(i));
  }
}

void CandidateRows::addAnsweredRows(std::uint32_t i, const glm::vec3& place, const ContactPatch* patch,
                                    float room) {
  if (const SampleAnswer* const trusted = trustedAnswer(i, place))
    return addPlanes(i, place, *trusted, patch);
  if (const SampleAnswer* const answer = memory_.find(query_.sampled, i, query_.target)) {
    const float length = glm::length(place - answer->place);
    room = std::max(room, answer->room + allowed_ - (patch != nullptr ? 2.0f : 1.0f) * length);
  }
  if (room <= query_.limit) rows_.addBall(query_.armOf(place), room, query_.source(i));
}

CandidateRows::Dip CandidateRows::edgeDip(const ContactSample& sample, const glm::vec3& place,
                                          const Reading& read) const {
  ContactPatch edge;
  if (!query_.from->patchOf(sample, edge)) return {};
  const glm::vec3 along = sample.along * (rotation_ * glm::vec3(edge.axis));
  const Dip ahead = dipTowards(along, place, read), behind = dipTowards(-along, place, read);
  return ahead.depth > behind.depth ? ahead : behind;
}

CandidateRows::Dip CandidateRows::dipTowards(const glm::vec3& along, const glm::vec3& place,
                                             const Reading& read) const {
  // Two errors over a cell are what a model's slope may be off by.
  const float length = glm::length(along),
              offPerError = 2.0f * length / static_cast<float>(query_.to->field.smallestCell());
  const float seen = -glm::dot(read.gradient, along), down = seen + offPerError * read.error;
  if (down <= kLevel * query_.smooth) return {};
  const Reading next = query_.to->field.read(place + along);
  if (next.error > query_.rough) return {down, false};
  const float seenNext = glm::dot(next.gradient, along), up = seenNext + offPerError * next.error;
  if (up <= 0.0f) return {};
  const float depth = std::max(0.0f, down * (read.distance - next.distance + up) / (down + up));
  const bool ofBlade = seen + seenNext >= kBlade * length &&
                       std::min(depth, depth + next.distance - read.distance) > query_.smooth;
  return {depth + next.error, ofBlade};
}

float CandidateRows::smoothDip(const ContactSample& sample, const Reading& read) const {
  const glm::vec3 down = -(glm::transpose(rotation_) * read.gradient);
  float sine = 1.0f;
  for (const glm::dvec3& normal : query_.from->samples.normals(sample)) {
    const float cosine = std::clamp(glm::dot(down, glm::vec3(normal)), 0.0f, 1.0f);
    sine = std::min(sine, std::sqrt(1.0f - cosine * cosine));
  }
  const auto& samples = query_.from->samples;
  return static_cast<float>(
      std::min(static_cast<double>(sine) * samples.smoothSpacing(), samples.smoothDip(sample)));
}

void CandidateRows::alignToFace(std::uint32_t i, const Reading& read, glm::vec3& normal, float& gap) const {
  const SampleAnswer* const answer = memory_.find(query_.sampled, i, query_.target);
  if (answer == nullptr) return;
  const Triangle face = query_.to->tree->triangle(answer->triangle);
  const glm::dvec3 p = transformPoint(query_.toFromSamples, sampleAt(i).point),
                   &up = query_.to->edges.normal(answer->triangle);
  if (!closestPointOnTriangle(p, face).onFace) return;
  const double height = glm::dot(up, p - face.a);
  if (std::abs(height - static_cast<double>(read.distance)) > static_cast<double>(read.error)) return;
  normal = glm::vec3(up);
  gap = static_cast<float>(height);
}

}  // namespace tandem::haptics
