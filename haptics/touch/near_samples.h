#pragma once

// The samples of one part that may be near the surface of another, by its distance field.

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

/// The samples that may be within `reach` m of a field's surface or behind it, found a few at a time by the
/// tree of balls. The samples and the field must outlive it unchanged.
class NearSamples {
 public:
  static constexpr std::uint32_t kAtOnce = DistanceField::kMaxAtOnce;

  /// `besides`: samples of smooth surfaces are near, too, while their part may touch beside them
  /// (ContactSamples::touchAbout()).
  NearSamples(const ContactSamples& samples, const DistanceField& field, const FloatMotion& motion,
              float reach, bool besides = false)
      : samples_(&samples), field_(&field), motion_(motion), reach_(reach), besides_(besides) {
    if (!samples.nodes().empty()) stack_[top_++] = 0;
  }

  bool done() const { return top_ == 0 && leaf_ == leafCount_; }
  /// Reads either balls or the samples of one leaf, at most kAtOnce, and calls visit(sample, place in the
  /// field, reading there) for each sample that may be that near.
  template <typename Visit>
  void advance(Visit&& visit) {
    leaf_ < leafCount_ ? readLeaf(visit) : readBalls();
  }

  /// Whether no sample may be outside, of those that have been read.
  bool allInside() const { return allInside_; }
  /// m, an upper bound of the depth of the samples that have been read and not visited; below 0 outside.
  float passedBy() const { return passedBy_; }

 private:
  void readBalls() {
    // Several balls are read at a time, so that their memory latencies overlap.
    const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(top_, kAtOnce));
    top_ -= count;
    std::array<std::uint32_t, kAtOnce> batch;
    for (std::uint32_t k = 0; k < count; ++k) {
      batch[k] = stack_[top_ + k];
      const ContactSamples::Node& node = samples_->nodes()[batch[k]];
      at_[k] = motion_({node.centre[0], node.centre[1], node.centre[2]});
    }
    field_->read(at_.data(), count, readings_.data());
    leaf_ = leafCount_ = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      const ContactSamples::Node& node = samples_->nodes()[batch[k]];
      const float least = readings_[k].distance - readings_[k].error - node.radius;
      if (least > reach_) {
        allInside_ = allInside_ && readings_[k].distance + readings_[k].error + node.radius < 0.0f;
        passedBy_ = std::max(passedBy_, -least);
      } else if (node.second != 0) {
        stack_[top_++] = node.second;
        stack_[top_++] = batch[k] + 1;
      } else {
        leaves_[leafCount_++] = batch[k];
      }
    }
  }

  template <typename Visit>
  void readLeaf(Visit&& visit) {
    const ContactSamples::Node& node = samples_->nodes()[leaves_[leaf_++]];
    const std::uint32_t count = node.end - node.begin;
    const glm::vec4* const points = samples_->points().data() + node.begin;
    // A patch may be deeper than its sample.
    const float patched = samples_->patches().empty() ? 0.0f : 1.0f;
    const auto about = [&](std::uint32_t k) {
      return besides_ ? ContactSamples::touchAbout(points[k]) : ContactSamples::pieceAbout(points[k]);
    };
    for (std::uint32_t k = 0; k < count; ++k) at_[k] = motion_(glm::vec3(points[k]));
    field_->read(at_.data(), count, readings_.data());
    for (std::uint32_t k = 0; k < count; ++k) {
      if (readings_[k].distance + readings_[k].error >= 0.0f) allInside_ = false;
      if (readings_[k].distance - readings_[k].error - about(k) <= reach_)
        visit(node.begin + k, at_[k], readings_[k]);
      else
        passedBy_ = std::max(passedBy_, readings_[k].error - readings_[k].distance +
                                            patched * ContactSamples::pieceAbout(points[k]));
    }
  }

  const ContactSamples* samples_;
  const DistanceField* field_;
  FloatMotion motion_;
  float reach_, passedBy_ = -1.0f;  // m
  bool besides_ = false, allInside_ = true;
  // A tree of 2^32 samples is 28 levels deep, and each level leaves at most kAtOnce balls behind.
  std::array<std::uint32_t, 40 * kAtOnce> stack_;
  std::array<std::uint32_t, kAtOnce> leaves_;
  std::size_t top_ = 0;
  std::uint32_t leaf_ = 0, leafCount_ = 0;  // into leaves_
  // Of what is being read.
  std::array<glm::vec3, kAtOnce> at_;
  std::array<DistanceField::Reading, kAtOnce> readings_;
};

}  // namespace tandem::haptics
