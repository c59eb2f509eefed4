#pragma once

// How deep one part is in the others of a scene, exactly. For tests and measurements, never within a tick: it
// allocates, takes milliseconds, and makes the models of neighbours when they first come near.

#include <memory>
#include <vector>

#include "haptics/measure/penetration.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::haptics {

class TickState;

/// The deepest place, and in which part.
struct HeldPartDepth : PenetrationDepth {
  PartId other = kNoPart;  // kNoPart: it is in none
};

/// Follows one part against all that its collision filter lets it touch. Keeps a reference to the scene.
class HeldPartDepthMeter {
 public:
  HeldPartDepthMeter(const ContactScene& scene, PartId held);
  ~HeldPartDepthMeter();
  HeldPartDepthMeter(HeldPartDepthMeter&&) noexcept;

  /// With all parts where the state's last tick left them.
  HeldPartDepth measure(const TickState& state);
  /// `worldFromPart`: one pose a part.
  HeldPartDepth measure(const std::vector<Pose>& worldFromPart);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace tandem::haptics
