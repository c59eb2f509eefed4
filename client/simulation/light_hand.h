#pragma once

// A hand without haptics, for simulations of the protocol alone: it takes parts, moves them and lets go by a
// script, and answers the network's events as HandLoop does (client/hand/hand_loop.h), but feels nothing and
// its parts have no dynamics.

#include <array>
#include <cstdint>
#include <vector>

#include "assets/scene/scene.h"
#include "client/hand/hand_script.h"
#include "client/session/exchange.h"
#include "sync/wire/wire_frame.h"

namespace tandem::client {

class LightHand {
 public:
  /// `script` and `exchange` outlive this. Of the script it plays grasp, release and move_relative.
  LightHand(const assets::Scene& scene, const std::vector<ScriptStep>& script, Exchange& exchange);

  /// Reads the events of the network, does what the script says up to scenario time `t`, in s, and publishes
  /// the hand at local time `now`.
  void step(double t, sync::Micros now);
  /// When the script or a motion goes on, in s; < 0: never.
  double nextDue() const;

  const Pose& worldFromPart(PartId part) const { return poses_[part]; }
  /// Grants that the hand asked for and got.
  std::uint64_t granted() const { return granted_; }

 private:
  struct Mine {
    PartId part = kNoPart;
    Epoch epoch = 0;  // 0: as a co-holder
    bool releasing = false;
  };
  struct Link {
    haptics::LinkTerms terms;
    std::uint32_t sent = 0;  // packets
  };
  void handle(const NetworkEvent& event);
  void onOwnership(const sync::PartRecord& record);
  void onLink(const NetworkEvent& event);
  void onLost();
  void play(const ScriptStep& step);
  void letGo(Mine& mine);
  void drop(PartId part);
  Mine* find(PartId part);
  bool push(HandIntent intent);
  void sendLinkPackets(sync::Micros now);
  void publish(sync::Micros now);

  const std::vector<ScriptStep>& script_;
  Exchange& exchange_;
  sync::WireFrame frame_;
  std::size_t next_ = 0;
  double t_ = -1.0;  // s, scenario time of the last step
  PartId asked_ = kNoPart, held_ = kNoPart;
  std::vector<Mine> mine_;   // parts that are simulated here
  std::vector<Pose> poses_;  // of every part
  std::vector<Link> links_;
  glm::dvec3 velocity_{0.0, 0.0, 0.0};  // m/s, of the held part
  double movesUntil_ = -1.0;            // s
  std::uint32_t lost_ = 0;
  std::uint64_t granted_ = 0;
  HandOutput output_;
};

}  // namespace tandem::client
