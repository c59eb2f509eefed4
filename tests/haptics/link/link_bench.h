#pragma once

// Sites that hold one part across a modelled network, on virtual time: arms with six axes, a grasp, a replica each, and
// coordination links from site 0 to all others.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "haptics/coordination_link.h"
#include "haptics/minimum_jerk.h"
#include "haptics/replica_mass.h"
#include "haptics/simulated_hand.h"
#include "haptics/virtual_coupling.h"

namespace tandem::test {

inline constexpr double kTick = 1e-3;  // s

/// A firm arm; the relaxed one is ArmParameters{}. As fitted in the laboratory experiments on one axis.
inline haptics::ArmParameters firmArm() { return {1.5, 300.0, 12.0, 800.0, 10.0}; }
inline haptics::ArmParameters relaxedArm() { return {}; }
/// Holds on, but is easily led.
inline haptics::ArmParameters lightArm() { return {1.46, 4.88, 4.5, 375.0, 7.9}; }

/// SimulatedHand's two masses in six axes: an angle counts as the way at the end of kLever, on the hand, the grip and the
/// device alike.
class SixAxisArm {
 public:
  static constexpr double kLever = 0.07;  // m: the wrist of a firm arm holds 1.5 N m/rad

  SixAxisArm(const haptics::ArmParameters& arm, const Pose& start);
  /// Advances a tick under a held command. The target is the start pose after `way`.
  void step(const haptics::SixAxes& way, const haptics::SixAxes& velocity,
            const haptics::SixAxes& acceleration, const Wrench& command);
  void letGo() { held_ = false; }

  const Pose& reading() const { return read_; }
  Twist readingVelocity() const;
  const Pose& device() const { return device_; }
  double given() const { return given_; }  // J, from the command to the device

 private:
  void read();

  haptics::ArmParameters arm_;
  haptics::SimulatedDeviceParameters p_;
  Pose start_, armPose_, device_, read_;
  haptics::SixAxes armVelocity_, velocity_, readVelocity_;
  bool held_ = true;
  double given_ = 0.0;
};

struct Network {
  double delay = 0.025;  // s, one way
  double jitter = 0.2, loss = 0.02, duplicate = 0.0;
  double packetPeriod = 4e-3;             // s
  std::function<double(double)> delayAt;  // instead of `delay`
  double blackoutAt = 1e9, blackoutFor = 0.0;
  bool burst = true;     // what was held back comes when the blackout ends; else it is lost
  bool shuffled = true;  // jitter may reorder; else packets that overtake are held back
};

/// One direction.
class DelayedLine {
 public:
  DelayedLine(const Network& network, unsigned seed) : network_(network), random_(seed) {}
  void send(double now, const haptics::LinkPacket& packet);
  /// Calls take(packet) for all that arrive.
  void deliver(double now, const std::function<void(const haptics::LinkPacket&)>& take);

 private:
  struct Flying {
    double arrives;
    haptics::LinkPacket packet;
  };
  void fly(double now, double jitter, const haptics::LinkPacket& packet);
  Network network_;
  std::mt19937 random_;
  double last_ = 0.0;
  std::vector<Flying> flying_;
};

/// How two replicas are tied.
enum class Tie {
  link,      // haptics::CoordinationLink
  holdLast,  // the same, but a wave that runs dry goes on as it last was: must fail
  plain,     // a spring and a damper to the pose that was last heard of: must fail
};

struct BenchSite {
  haptics::ArmParameters arm;
  glm::dvec3 grip{0.0, 0.0, 0.0};  // m, from the centre of mass, body axes
};

struct BenchSetup {
  std::vector<BenchSite> sites;
  Network network;
  Tie tie = Tie::link;
  unsigned seed = 1;
  double mass = 1.0;                  // kg
  glm::dvec3 size{0.12, 0.08, 0.06};  // m, of the block
  std::optional<double> wall;         // m: the part's corners cannot pass it along x
  double plainStiffness = 400.0, plainDamping = 5.0;
  haptics::LinkParameters link;
};

class LinkBench {
 public:
  /// Where the hand of a site wants to be at a time: way from its start; angles times SixAxisArm::kLever.
  using Intent = std::function<haptics::SixAxes(double, int)>;

  explicit LinkBench(const BenchSetup& setup);
  void step(const Intent& intent);
  /// Until `time`; false when a replica has gone astray.
  bool runTo(double time, const Intent& intent);

  struct Site {
    Site(const BenchSite& given, const Pose& start, const Pose& grip)
        : arm(given.arm, start * grip), bodyFromGrip(grip) {}
    SixAxisArm arm;
    Pose bodyFromGrip;
    haptics::RigidBody body;
    haptics::MassRamp mass;
    Wrench onHand;                          // sent to the device, limited
    std::array<Wrench, 20> before{};        // of the last 20 ticks
    double change = 0.0, turnChange = 0.0;  // N, N m: of the force on the hand in 20 ms
    double push = 0.0;                      // N, of the wall
    Pose centre() const;
    haptics::SixAxes gripWay() const;  // of the device from its start
  };
  Site& site(std::size_t i) { return sites_[i]; }
  const Site& site(std::size_t i) const { return sites_[i]; }
  haptics::CoordinationLink& end(std::size_t link, std::size_t side) { return ends_[2 * link + side].link; }
  double time() const { return kTick * static_cast<double>(ticks_); }
  /// Distance between the centres of two replicas, m, and the angle between them, rad.
  double gap(std::size_t i, std::size_t j) const;
  double turnGap(std::size_t i, std::size_t j) const;
  bool astray() const;

  double mostCreated = 0.0;  // J, at all device ports together beyond what came in
  double mostInLinks = 0.0;  // J, the most that any link has given and may still give beyond what it took
  double lent() const;       // J

 private:
  struct End {
    End(const haptics::LinkParameters& p, const Network& n, unsigned seed) : link(p), out(n, seed) {}
    haptics::CoordinationLink link;
    DelayedLine out;
    std::size_t site = 0;
    haptics::LinkPacket newest, previous;  // heard, for the controls that must fail
    bool heard = false;
    haptics::LinkPull pull;
  };
  void hear(End& end, const haptics::LinkPacket& packet);
  void forge(End& end);
  haptics::LinkPull pull(End& end);
  void setMasses();
  void move(std::size_t index);
  Wrench wallForce(Site& site) const;
  void account();

  BenchSetup setup_;
  assets::MassProperties part_;
  std::vector<Site> sites_;
  std::vector<End> ends_;
  long ticks_ = 0;
};

/// The shared drag: site 0 moves 5 cm at 0.5 Hz from 1 s on, the others hold on.
haptics::SixAxes dragWay(double t, double amplitude = 0.05);

/// Seeds of a run: a few, or 20 with TANDEM_FULL_SIZE.
int seeds(int few = 2);

}  // namespace tandem::test
