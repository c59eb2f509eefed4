#pragma once

// The samples of one part that may be near the surface of another, by its distance field. For the files of
// this room only.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

#include "assets/base/pose.h"
#include "haptics/scene/contact_samples.h"
#include "haptics/scene/distance_field.h"

namespace tandem::haptics {

static_assert(ContactSamples::kMaxInLeaf <= DistanceField::kMaxAtOnce);

/// A rigid transform of many points in float, relative to the origin of the field that is read.
struct FloatMotion {
  FloatMotion(const Pose& toFromSamples, const glm::dvec3& origin)
      : rotation(glm::mat3_cast(toFromSamples.orientation)), shift(toFromSamples.position - origin) {}
  glm::vec3 operator()(const glm::vec3& p) const { return rotation * p + shift; }
  glm::mat3 rotation;
  glm::vec3 shift;
};

/// Calls visit(sample, place in the field, reading there) for the samples that may be within `reach` m of a
/// field's surface or behind it. `allInside` becomes false if a sample may be outside. `passedBy` rises to
/// an upper bound of the depth (m) of all samples that are not visited, below 0 outside.
template <typename Visit>
void forEachNear(const ContactSamples& samples, const DistanceField& field, const FloatMotion& motion,
                 float reach, bool& allInside, float& passedBy, Visit&& visit) {
  const auto nodes = samples.nodes();
  if (nodes.empty()) return;
  // A patch may be deeper than its sample.
  const float patched = samples.patches().empty() ? 0.0f : 1.0f;
  constexpr std::uint32_t kAtOnce = DistanceField::kMaxAtOnce;
  std::array<glm::vec3, kAtOnce> at;
  std::array<DistanceField::Reading, kAtOnce> readings;
  // Several nodes are read at a time, so that their memory latencies overlap. A tree of 2^32 samples is 28
  // levels deep, and each level leaves at most kAtOnce nodes behind.
  std::array<std::uint32_t, 40 * kAtOnce> stack;
  std::array<std::uint32_t, kAtOnce> leaves;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const auto batchSize = static_cast<std::uint32_t>(std::min<std::size_t>(top, kAtOnce));
    top -= batchSize;
    std::array<std::uint32_t, kAtOnce> batch;
    for (std::uint32_t k = 0; k < batchSize; ++k) {
      batch[k] = stack[top + k];
      const ContactSamples::Node& node = nodes[batch[k]];
      at[k] = motion({node.centre[0], node.centre[1], node.centre[2]});
    }
    field.read(at.data(), batchSize, readings.data());
    std::uint32_t leafCount = 0;
    for (std::uint32_t k = 0; k < batchSize; ++k) {
      const ContactSamples::Node& node = nodes[batch[k]];
      const float least = readings[k].distance - readings[k].error - node.radius;
      if (least > reach) {
        allInside = allInside && readings[k].distance + readings[k].error + node.radius < 0.0f;
        passedBy = std::max(passedBy, -least);
      } else if (node.second != 0) {
        stack[top++] = node.second;
        stack[top++] = batch[k] + 1;
      } else {
        leaves[leafCount++] = batch[k];
      }
    }
    for (std::uint32_t l = 0; l < leafCount; ++l) {
      const ContactSamples::Node& node = nodes[leaves[l]];
      const std::uint32_t count = node.end - node.begin;
      const glm::vec4* const points = samples.points().data() + node.begin;
      for (std::uint32_t k = 0; k < count; ++k) at[k] = motion(glm::vec3(points[k]));
      field.read(at.data(), count, readings.data());
      for (std::uint32_t k = 0; k < count; ++k) {
        if (readings[k].distance + readings[k].error >= 0.0f) allInside = false;
        if (readings[k].distance - readings[k].error - points[k].w <= reach)
          visit(node.begin + k, at[k], readings[k]);
        else
          passedBy = std::max(passedBy, readings[k].error - readings[k].distance + patched * points[k].w);
      }
    }
  }
}

}  // namespace tandem::haptics
