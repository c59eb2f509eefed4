#pragma once

// Exact depth of one part in the other parts of a scene. For tests and measurements, never within a tick:
// it allocates, takes milliseconds, and builds the models of neighbours when they first come near.

#include <memory>
#include <vector>

#include "haptics/measure/penetration.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::haptics {

class TickState;

/// The deepest point and the part that contains it.
struct HeldPartDepth : PenetrationDepth {
  PartId other = kNoPart;  // kNoPart: in none
};

/// Tracks one part against all parts that its collision filter lets it touch. Keeps a reference to the scene.
class HeldPartDepthMeter {
 public:
  HeldPartDepthMeter(const ContactScene& scene, PartId held);
  ~HeldPartDepthMeter();
  HeldPartDepthMeter(HeldPartDepthMeter&&) noexcept;

  /// Depth with all parts in their poses after the state's last tick.
  HeldPartDepth measure(const TickState& state);
  /// `worldFromPart` holds one pose per part.
  HeldPartDepth measure(const std::vector<Pose>& worldFromPart);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace tandem::haptics
