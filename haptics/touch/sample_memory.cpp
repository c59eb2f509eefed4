#include "haptics/touch/sample_memory.h"

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {

float SampleAnswer::movedSince(const glm::vec3& now, const glm::quat& turn, float extent) const {
  const float path = glm::length(now - place);
  if (!(extent > 0.0f)) return path;
  // A rotation by t moves a point at a distance of 1 by 2 sin(t/2) <= 4 sin(t/4) = 2 |a - b|.
  const glm::quat near = glm::dot(orientation, turn) < 0.0f ? -turn : turn;
  return path + 2.0f * extent * glm::length(near - orientation);
}

SampleMemory::SampleMemory(const ContactWorld& world) {
  for (PartId part = 0; world.has(part); ++part) {
    const PartModel* model = world.model(part);
    answers_.emplace_back(model != nullptr ? kTargets * model->samples.samples().size() : 0);
  }
  ASSERT(!world.has(static_cast<PartId>(answers_.size())));
}

const SampleAnswer* SampleMemory::find(PartId part, std::uint32_t sample, PartId target) const {
  const SampleAnswer* const first = &answers_[part][kTargets * sample];
  for (std::uint32_t k = 0; k < kTargets; ++k) {
    if (first[k].target == target) return first + k;
  }
  return nullptr;
}

SampleAnswer& SampleMemory::slot(PartId part, std::uint32_t sample, PartId target) {
  SampleAnswer* const first = &answers_[part][kTargets * sample];
  SampleAnswer* oldest = first;
  for (std::uint32_t k = 0; k < kTargets; ++k) {
    if (first[k].target == target) return first[k];
    if (age(first[k]) > age(*oldest)) oldest = first + k;
  }
  return *oldest;
}

}  // namespace tandem::haptics
