#pragma once

// Cache of the last exact query of each sample, so that a resting contact costs no query in the next step.
//
// 1. It has room for kTargets other parts a sample, because an edge often stands on two. The oldest answer
//    is replaced.
// 2. Only the constructor allocates.

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// The answer of one exact query.
struct SampleAnswer {
  glm::vec3 place{0.0f, 0.0f, 0.0f};  // m, where the sample was, relative to the origin of the target's field
  float room = 0.0f;                  // m that it can move from there without touching; below 0 inside
  std::array<glm::vec3, 2> normals{};  // of the planes of its contact, frame of the target
  std::array<float, 2> gaps{};         // m, over those planes
  int planes = 0;
  std::uint32_t triangle = kNoTriangle;  // of the target, the nearest one
  PartId target = kNoPart;
  std::uint32_t step = 0;  // in which it was found
};

class SampleMemory {
 public:
  static constexpr std::uint32_t kTargets = 2;

  explicit SampleMemory(const ContactWorld& world);

  void beginStep() { ++step_; }
  std::uint32_t step() const { return step_; }
  /// Steps since the answer was found.
  std::uint32_t age(const SampleAnswer& answer) const { return step_ - answer.step; }

  /// The last answer of a sample before a target; null if there is none.
  const SampleAnswer* find(PartId part, std::uint32_t sample, PartId target) const;
  /// The entry for the next answer of the sample before this target.
  SampleAnswer& slot(PartId part, std::uint32_t sample, PartId target);

 private:
  std::vector<std::vector<SampleAnswer>> answers_;  // one list a part: kTargets for each of its samples
  std::uint32_t step_ = 0;
};

}  // namespace tandem::haptics
