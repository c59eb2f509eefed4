#pragma once

// Where the last descents of samples ended (sample_descent.h). While the target touches a sample from the
// same side, the place beside it that is deepest stays where it was, and the sample need not descend again.
//
// 1. A table of kEntries places; a descent that falls on a taken one replaces it.
// 2. Only the constructor allocates.

#include <cstddef>
#include <cstdint>
#include <memory>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "haptics/scene/contact_world.h"
#include "haptics/scene/part_model.h"

namespace tandem::haptics {

/// Where a descent ended, frame of the sampled part.
struct KnownSeat {
  PartId sampled = kNoPart, target = kNoPart;
  std::uint32_t sample = 0;
  const PartFeatures* features = nullptr;         // of the part that is sampled
  std::uint32_t edge = assets::kNone;             // kNone: the sample itself was deepest
  bool level = false;                             // no place near the sample was deeper, by the field alone
  float along = 0.0f;                             // m that the edge goes on at least on both sides
  glm::dvec3 point{0.0, 0.0, 0.0};                // m, on that edge
  glm::vec3 up{0.0f, 0.0f, 0.0f};                 // unit, from the target to the sample
  glm::quat orientation{1.0f, 0.0f, 0.0f, 0.0f};  // of its part then, frame of the target
  glm::vec3 place{0.0f, 0.0f, 0.0f};  // m, where the sample was, relative to the origin of the target's field
};

class SeatMemory {
 public:
  SeatMemory() : seats_(new KnownSeat[kEntries]) {}

  /// The last seat of a sample before a target; null if it is not known.
  const KnownSeat* find(PartId sampled, std::uint32_t sample, PartId target,
                        const PartFeatures* features) const {
    const KnownSeat& seat = seats_[indexOf(sampled, sample, target)];
    const bool same = seat.sampled == sampled && seat.sample == sample && seat.target == target &&
                      seat.features == features;
    return same ? &seat : nullptr;
  }
  void remember(const KnownSeat& seat) { seats_[indexOf(seat.sampled, seat.sample, seat.target)] = seat; }

 private:
  static constexpr std::size_t kEntries = 8192;

  static std::size_t indexOf(PartId sampled, std::uint32_t sample, PartId target) {
    // Samples that touch lie side by side in their list.
    return (sample + 2654435761u * (static_cast<std::uint32_t>(sampled) * 97u + target)) % kEntries;
  }

  std::unique_ptr<KnownSeat[]> seats_;
};

}  // namespace tandem::haptics
