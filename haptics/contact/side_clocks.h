#pragma once

// When the samples of a part must be read again before another part. A side, that is the samples of one part
// before another one, has a clock that runs with their relative motion: it advances by at least as much (m)
// as any sample comes nearer to the target. A sample that is read at the time s and found to be free for m
// metres cannot touch before the time s + m, whatever the path; until then it costs nothing.
//
// 1. A bound holds until the clock reaches it, so that nothing is passed unseen: steps are cut to their
//    reach.
// 2. Sides are known by their parts. Where there is no room for all, they are forgotten and read anew.
// 3. Only the constructor allocates.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "haptics/base/fixed_vector.h"
#include "haptics/contact/overlaps.h"
#include "haptics/scene/contact_world.h"
#include "haptics/scene/part_model.h"

namespace tandem::haptics {

/// Times until which the samples of a side, and the balls of their tree, need not be read; m, by its clock.
struct DueTimes {
  /// Of what has not been read yet.
  static constexpr float kNever = -1e30f;

  /// The time, rounded down, until which what is free for `clear` m now need not be read.
  float until(float clear) const { return now + clear - kRounding * (now + std::abs(clear)); }

  std::span<float> nodes, samples;
  std::span<std::uint32_t> visited;  // room for the indices of all nodes
  float now = 0.0f;

 private:
  static constexpr float kRounding = 0x1p-20f;
};

/// An upper bound of how far the move from one pose to another takes any point of a ball, m; the ball in the
/// frame that moves.
double farthestMotion(const Pose& from, const Pose& to, const glm::dvec3& centre, double radius);

class SideClocks {
 public:
  explicit SideClocks(const ContactWorld& world);

  /// The times of a side whose samples are at a pose (part frames) and may be deep in the target by
  /// `allowed`; its clock has advanced since the last call. Empty where there is no room for so many samples.
  DueTimes at(PartId sampled, PartId target, const SampledModels& models, const AllowedDepth& allowed);
  /// Whether at() would forget the other sides, because there is no room for one more.
  bool forgetsFor(PartId sampled, PartId target, const SampledModels& models) const;
  /// Most nodes of a tree: the room that DueTimes::visited needs.
  std::size_t mostNodes() const { return mostNodes_; }

 private:
  static constexpr std::size_t kMaxSides = 2 * kMaxPairs, kMaxTimes = std::size_t{1} << 20;

  struct Side {
    PartId sampled = kNoPart, target = kNoPart;
    const PartFeatures* features = nullptr;  // of the part that is sampled
    const TriangleBvh* tree = nullptr;       // of the target
    std::size_t first = 0;                   // into times_
    double clock = 0.0;                      // m
    Pose pose;
    AllowedDepth allowed;
  };

  static bool isOf(const Side& side, PartId sampled, PartId target, const SampledModels& models);
  bool hasRoomFor(const SampledModels& models) const;
  Side& sideOf(PartId sampled, PartId target, const SampledModels& models);
  void restart(Side& side, const SampledModels& models);

  FixedVector<Side, kMaxSides> sides_;
  std::size_t used_ = 0, largest_ = 0;        // of times_; the most that a side takes
  std::unique_ptr<float[]> times_;            // kMaxTimes or, for one large part alone, largest_
  std::unique_ptr<std::uint32_t[]> visited_;  // as many as the largest tree has nodes
  std::size_t mostNodes_ = 0, room_ = 0;
};

}  // namespace tandem::haptics
