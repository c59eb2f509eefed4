#include "haptics/contact/candidate_rows.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/contact/due_samples.h"
#include "haptics/contact/patch_touch.h"

namespace tandem::haptics {
namespace {

constexpr std::uint32_t kFreshSteps = 8;  // steps for which the planes of an answer are trusted at least

}  // namespace

double CandidateRows::gather() {
  const PartModel &from = *query_.from, &to = *query_.to;
  const FloatMotion motion(query_.toFromSamples, to.field.origin());
  const auto visit = [&](std::uint32_t i, const glm::vec3& place, const Reading& read) {
    addRows(i, place, read);
    return clear_;
  };
  if (!query_.contained) {
    const AllowedDepth allowed = query_.overlaps->allowed(query_.pair, query_.ofFirst(), to.field.origin());
    const DueTimes due = clocks_.at(query_.sampled, query_.target, query_, allowed);
    if (!due.nodes.empty()) {
      // What is not visited is further than the reach from as deep as it may be.
      deepen(allowed.depth - query_.limit);
      DueSamples(from.samples, to.field, motion, allowed, query_.limit, due, visit).read();
      return static_cast<double>(deepest_);
    }
  }
  float passedBy = -1.0f;
  bool inside = false;
  forEachNear(from.samples, to.field, motion, query_.limit, inside, passedBy, visit);
  deepen(passedBy);
  return static_cast<double>(deepest_);
}

void CandidateRows::addRows(std::uint32_t i, const glm::vec3& place, const Reading& read) {
  const ContactSample& sample = sampleAt(i);
  allowed_ = static_cast<float>(query_.allowed(sample));
  clear_ = read.distance - read.error - sample.along + allowed_;
  if (query_.to->byFormula()) return addShapeRows(i);
  if (query_.from->samples.isRound(sample)) return addPatchRow(i, place, read);
  addSampleRow(i, place, read);
}

void CandidateRows::addPlane(const glm::vec3& normal, const glm::vec3& arm, float gap, RowSource source) {
  if (!query_.isCut(arm)) rows_.addPlane(normal, arm, gap, source);
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
    addPlane(query_.world(glm::vec3(read.gradient)), query_.arm(point),
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
  addPlane(query_.world(glm::vec3(touch.read.gradient)), query_.arm(touch.point), gap + allowed_,
           query_.source(i));
}

void CandidateRows::addSampleRow(std::uint32_t i, const glm::vec3& place, const Reading& read) {
  deepen(read.error - read.distance);
  if (query_.contained) return;
  const ContactSample& sample = sampleAt(i);
  const float least = read.distance - read.error + allowed_;
  if (read.error > query_.rough || (sample.along > 0.0f && crossesBlade(sample, place, read)))
    return addAnsweredRows(i, place, nullptr, least - sample.along);
  // Before a smooth surface the least gap along the rest of a piece of edge is at its end, where the next
  // sample stands.
  if (least > query_.limit) return;
  glm::vec3 normal = read.gradient;
  float gap = read.distance + read.error;
  if (read.error > query_.smooth) {
    if (isAnswered(i, place)) return addAnsweredRows(i, place, nullptr, least - sample.along);
    gap = read.distance - read.error;
    alignToFace(i, read, normal, gap);
  }
  addPlane(query_.world(normal), query_.armOf(place), gap + allowed_, query_.source(i));
}

bool CandidateRows::trusts(const SampleAnswer& answer, std::uint32_t sample, float length) const {
  // The age differs from sample to sample, so that they are not all queried in the same step.
  return memory_.age(answer) <= kFreshSteps + sample % kFreshSteps && length <= query_.trusted;
}

bool CandidateRows::isAnswered(std::uint32_t i, const glm::vec3& place) const {
  const SampleAnswer* const answer = memory_.find(query_.sampled, i, query_.target);
  if (answer == nullptr) return false;
  const float length = glm::length(place - answer->place);
  return trusts(*answer, i, length) || answer->room + allowed_ - length > query_.limit;
}

void CandidateRows::addAnsweredRows(std::uint32_t i, const glm::vec3& place, const ContactPatch* patch,
                                    float room) {
  const glm::vec3 arm = query_.armOf(place);
  if (const SampleAnswer* const answer = memory_.find(query_.sampled, i, query_.target)) {
    const glm::vec3 path = place - answer->place;
    const float length = glm::length(path);
    // What is said of a point says little of a piece of edge or of a patch around it.
    if (patch == nullptr && !(sampleAt(i).along > 0.0f))
      clear_ = std::max(clear_, answer->room + allowed_ - length);
    if (trusts(*answer, i, length)) {
      for (std::size_t k = 0; k < static_cast<std::size_t>(answer->planes); ++k) {
        const glm::vec3& normal = answer->normals[k];
        glm::vec3 at = arm;
        float gap = answer->gaps[k] + glm::dot(normal, path) + allowed_;
        if (patch != nullptr) {
          // The gap is that of the place of the patch that is lowest over the plane now.
          const glm::dvec3 up(normal), lowest = patch->pointAt(patch->lowest(up, evenness(*query_.to)));
          at = query_.arm(lowest);
          gap += static_cast<float>(glm::dot(up, lowest - patch->sample()));
        }
        addPlane(query_.world(normal), at, gap, query_.source(i));
      }
      return;
    }
    room = std::max(room, answer->room + allowed_ - (patch != nullptr ? 2.0f : 1.0f) * length);
  }
  if (room <= query_.limit) rows_.addBall(arm, room, query_.source(i));
}

bool CandidateRows::crossesBlade(const ContactSample& sample, const glm::vec3& place,
                                 const Reading& read) const {
  ContactPatch edge;
  if (!query_.from->patchOf(sample, edge)) return false;
  const glm::vec3 along = sample.along * glm::vec3(query_.toFromSamples.orientation * edge.axis);
  const float slope = glm::dot(read.gradient, along);
  if (std::abs(slope) <= query_.smooth) return false;
  const float towards = slope > 0.0f ? -1.0f : 1.0f;
  const Reading next = query_.to->field.read(place + towards * along);
  const float down = std::abs(slope), up = towards * glm::dot(next.gradient, along);
  // A surface whose normal changes by less than some 40 degrees between them is round rather than a blade.
  if (up <= 0.0f || down + up < 0.7f * sample.along) return false;
  const float least = read.distance - down * (read.distance - next.distance + up) / (down + up);
  return least - read.error <= query_.limit && std::min(read.distance, next.distance) - least > query_.smooth;
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
