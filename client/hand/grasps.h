#pragma once

// The grasps of a person's two hands: what their buttons ask of the server and of the tick, and which hand a
// granted part is for.
//
// 1. A part that this site simulates is held at once, whichever hand brought it here.
// 2. A part is asked for once: the second hand waits for the answer to the first one.
// 3. A grant that no hand waits for is taken all the same; the part rests here and is released.
//
// Haptic thread; allocates nothing.

#include <array>
#include <cstddef>

#include "client/hand/control_hand.h"
#include "client/hand/grasp.h"
#include "client/hand/hand_intents.h"
#include "client/hand/hand_parts.h"

namespace tandem::client {

class Grasps {
 public:
  /// What is referred to must outlive this.
  Grasps(const assets::Scene& scene, HandParts& parts, ControlHand& controls, HandIntents& intents)
      : scene_(scene), parts_(parts), controls_(controls), intents_(intents) {}

  /// Once a tick and hand. `target` is what the hand grasps if the button goes down now.
  void setButton(std::size_t hand, bool down, PartId target);
  /// Once a tick and hand, before setButton(): holds what has arrived.
  void advance(std::size_t hand, sync::Micros sessionNow);
  /// After the loop has stood still: couples a held part anew, where part and device are now.
  void restart(std::size_t hand);
  /// The tick has refused the grasp.
  void onRefused(std::size_t hand) { hands_[hand].end(); }

  /// This site owns a part from now on that it did not simulate.
  void onGrant(const sync::PartRecord& grant, sync::Micros sessionNow);
  /// A part that hands may have asked for is simulated here now.
  void onSimulated(PartId part);
  void onDenial(PartId part) { endAll(Grasp::Stage::asking, part); }
  void onLostPart(PartId part) { endAll(Grasp::Stage::holding, part); }
  /// Another site owns the part now.
  void onOtherOwner(PartId part) { endAll(Grasp::Stage::taking, part); }
  void onConnectionLost();

  bool holds(PartId part) const;
  bool isHolding(std::size_t hand) const { return hands_[hand].stage() == Grasp::Stage::holding; }
  /// Whether a hand asks for the part with its button still down.
  bool wants(PartId part) const;
  bool isPending() const { return hands_[0].isPending() || hands_[1].isPending(); }

  static constexpr sync::Micros kBlend = 100 * sync::kMillisecond;

 private:
  void reach(std::size_t hand, PartId part);
  void hold(std::size_t hand, PartId part);
  void endAll(Grasp::Stage stage, PartId part);

  const assets::Scene& scene_;
  HandParts& parts_;
  ControlHand& controls_;
  HandIntents& intents_;
  std::array<Grasp, haptics::kHands> hands_;
};

}  // namespace tandem::client
