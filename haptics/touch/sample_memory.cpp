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
    const std::size_t count = model != nullptr ? kTargets * model->samples.samples().size() : 0;
    targets_.emplace_back(count, kNoPart);
    answers_.emplace_back(count);
  }
  ASSERT(!world.has(static_cast<PartId>(answers_.size())));
}

SampleAnswer& SampleMemory::slot(PartId part, std::uint32_t sample, PartId target) {
  const std::size_t first = std::size_t{kTargets} * sample;
  std::size_t oldest = first;
  for (std::size_t k = first; k < first + kTargets; ++k) {
    if (targets_[part][k] == target) return answers_[part][k];
    if (age(answers_[part][k]) > age(answers_[part][oldest])) oldest = k;
  }
  targets_[part][oldest] = target;
  return answers_[part][oldest];
}

}  // namespace tandem::haptics
