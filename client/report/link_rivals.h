#pragma once

// The architectures with which the coordination link is compared, implemented from their equations: the part
// simulated on the server, an energy tank in front of a delayed spring, and both hands on the part itself
// without a network. The plain delayed spring is bench::PlainSpringEnd.

#include <array>
#include <vector>

#include "haptics/link_bench/delayed_line.h"
#include "haptics/link_bench/hand_bench.h"
#include "haptics/link_bench/link_end.h"

namespace tandem::client::report {

/// Gains of a spring and its damper; a rotation counts as the displacement at the end of the link's lever.
struct SpringGains {
  double stiffness = 0.0, damping = 0.0;  // N/m, N·s/m
};

/// The two layers of Franken, Stramigioli, Misra, Secchi & Macchelli 2011, "Bilateral telemanipulation with
/// time delays: a two-layer approach combining passivity and transparency", IEEE T-RO 27(4), between local
/// replicas. Transparency: a spring to the last received pose of the peer's replica. Passivity: every move of
/// the spring's far end, dP = K/2 |y' - x|^2 - K/2 |y - x|^2, is paid from a tank, and goes only as far as
/// the tank reaches. The tank is filled by the damper, which is larger while the tank is low (their tank
/// level controller); what does not fit is sent to the peer (their energy protocol, surplus only).
/// Deviations: six axes on one lever; the tank starts at its level, or a hand that never moves would feel
/// nothing; the spring is taken at the end of the step.
class TankEnd : public bench::LinkEnd {
 public:
  TankEnd(const SpringGains& gains, const haptics::LinkParameters& parameters)
      : gains_(gains), period_(parameters.period), lever_(parameters.lever) {}

  void receive(const haptics::LinkPacket& packet) override;
  haptics::LinkPull pull(double now, const Pose& worldFromCentre, const Twist& twist) override;
  void account(const Pose& worldFromCentre, const Twist& twist) override;
  haptics::LinkPacket packet(double now) override;

 private:
  static constexpr double kDrag = 0.1;                            // N·s/m, as a link has on its replica
  static constexpr double kLevel = 0.01;                          // J, that the tank is to have
  static constexpr double kFilling = 2000.0, kMaxFilling = 20.0;  // N·s/m a J that is missing; N·s/m at most

  SpringGains gains_;
  double period_, lever_;  // s, m
  haptics::LinkPacket peer_, own_;
  bool hasPeer_ = false;
  double tank_ = kLevel, taken_ = 0.0;  // J: in the tank; of the energy that the peer has sent
  double damping_ = 0.0;                // N·s/m, of this tick
  Pose drawnTo_;                        // the far end of the spring: y
};

/// One body on a server midway, coupled by springs to the last received device poses. Each site receives the
/// pose to display and the force of its spring, and holds both until the next packet.
class ServerBench : public bench::HandBench {
 public:
  struct Setup {
    std::vector<bench::BenchSite> sites;
    bench::Network network;  // from site to site: each leg has half the delay
    bench::Block block;
    unsigned seed = 1;
    SpringGains gains;
  };
  explicit ServerBench(const Setup& setup);

 private:
  struct Up {
    double time = 0.0;
    Pose device;
    Twist twist;
  };
  struct Down {
    double time = 0.0;
    Pose part;
    Wrench onHand;
  };
  struct Leg {
    bench::DelayedLine<Up> up;
    bench::DelayedLine<Down> down;
    Up received;
    Down shown;
    bool hasReceived = false;
  };
  void tick() override;
  void stepServer();
  void send(double now);

  Setup setup_;
  bench::PacketClock clock_;
  haptics::RigidBody body_;
  double push_ = 0.0;  // N, of the wall
  std::vector<Wrench> onHands_;
  std::vector<Leg> legs_;
};

/// Both hands on the part itself, as if there were no network.
class OneRoomBench : public bench::HandBench {
 public:
  OneRoomBench(const std::vector<bench::BenchSite>& sites, const bench::Block& block);

 private:
  void tick() override;
  bench::Block block_;
  haptics::RigidBody body_;
};

}  // namespace tandem::client::report
