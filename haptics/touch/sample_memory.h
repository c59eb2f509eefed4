#pragma once

// Cache of the last exact query of each sample, so that a resting contact costs no query in the next step.
//
// 1. It has room for kTargets other parts a sample, because an edge often stands on two. The oldest answer
//    is replaced.
// 2. Only the constructor allocates.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// One plane of an exact query's answer, frame of the target.
struct AnsweredPlane {
  glm::vec3 normal{0.0f, 0.0f, 0.0f};  // unit
  float height = 0.0f;                 // m, of the plane over the origin of the target's field
  glm::vec3 aside{0.0f, 0.0f, 0.0f};   // m, from the sample to the place that touches, frame of its part
};

/// The answer of one exact query.
struct SampleAnswer {
  /// m, an upper bound of how far any place within `extent` m of the sample has moved, now that the sample is
  /// at `now` and its part turned by `turn`.
  float movedSince(const glm::vec3& now, const glm::quat& turn, float extent) const;

  glm::vec3 place{0.0f, 0.0f, 0.0f};  // m, where the sample was, relative to the origin of the target's field
  // m that it can move from there, with all that it stands for as far as that was seen, without touching;
  // below 0 inside.
  float room = 0.0f;
  glm::quat orientation{1.0f, 0.0f, 0.0f, 0.0f};  // of its part then, frame of the target
  int planes = 0;
  std::uint32_t triangle = kNoTriangle;  // of the target, the nearest one
  std::uint32_t step = 0;                // in which it was found
  std::array<AnsweredPlane, 4> plane;    // of its contact
};

class SampleMemory {
 public:
  static constexpr std::uint32_t kTargets = 2;

  explicit SampleMemory(const ContactWorld& world);

  void beginStep() { ++step_; }
  std::uint32_t step() const { return step_; }
  /// Steps since the answer was found.
  std::uint32_t age(const SampleAnswer& answer) const { return step_ - answer.step; }
  /// Whether the planes of an answer of this sample are recent enough to be trusted. The age differs from
  /// sample to sample, so that they are not all queried in the same step.
  bool isFresh(const SampleAnswer& answer, std::uint32_t sample) const {
    return age(answer) <= kFreshSteps + sample % kFreshSteps;
  }

  /// The last answer of a sample before a target; null if there is none.
  const SampleAnswer* find(PartId part, std::uint32_t sample, PartId target) const {
    const std::size_t first = std::size_t{kTargets} * sample;
    for (std::size_t k = first; k < first + kTargets; ++k) {
      if (targets_[part][k] == target) return &answers_[part][k];
    }
    return nullptr;
  }
  /// The entry for the next answer of the sample before this target.
  SampleAnswer& slot(PartId part, std::uint32_t sample, PartId target);

 private:
  static constexpr std::uint32_t kFreshSteps = 8;

  // For each part, kTargets entries a sample. Most samples have no answer: the targets, in a table of their
  // own, tell so without a load of the far larger answers.
  std::vector<std::vector<PartId>> targets_;
  std::vector<std::vector<SampleAnswer>> answers_;
  std::uint32_t step_ = 0;
};

}  // namespace tandem::haptics
