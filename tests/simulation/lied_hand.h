#pragma once

// A site with a hand whose server lies to it: what the server sends about a part that "another site" owns is
// what a test makes up. It covers whatever a peer can send too, because all of that comes through the server.
//
// Everything below the server is what a site runs: connection, hand loop, tick, arm and device models, on
// virtual time.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/hand/hand_loop.h"
#include "client/hand/scripted_device.h"
#include "client/session/server_connection.h"
#include "haptics/scene/contact_scene.h"
#include "sync/transport/virtual_network.h"
#include "sync/wire/state_sender.h"
#include "sync/wire/wire.h"

namespace tandem::test {

inline constexpr SiteId kHonest = 1, kLiar = 2;

/// The scene of the family: part 0, `block`, is the liar's; part 1, `plate`, may be in the honest hand.
const haptics::ContactScene& lyingScene();

class LiedHand {
 public:
  /// One state of the liar's block.
  struct Claim {
    Pose worldFromPart;
    Twist twist;
    sync::Micros late = 0;  // the time stamp lies so far before the present
  };
  using Liar = std::function<Claim(double t)>;  // t: s since the lies began

  struct Options {
    std::string script;  // of the hand
    glm::dvec3 start{0.0, 0.09, 0.0};
    haptics::ArmParameters arm;
    bool guarded = true;
    std::uint64_t seed = 1;
    double packetHz = 250.0, jitter = 0.2, loss = 0.0;
  };
  explicit LiedHand(const Options& options);

  /// Runs for so long (s): the block stands still where it last was.
  void rest(double seconds);
  /// Runs while the block does what the liar says.
  void lie(double seconds, const Liar& liar);
  void say(const sync::ControlMessage& message) { server_->sendControl(peer_, sync::encodeControl(message)); }
  /// Puts the block into a new epoch at this pose.
  void reown(const Pose& worldFromPart);
  /// A datagram for the site.
  void send(const sync::StateMessage& message);

  // What the hand felt since mark(), measured at the device alone.
  void mark();
  /// N: the largest change of the force within 20 ms.
  double forceStep() const;
  /// J: the most that the force has given to the device, net, at any time.
  double energy() const { return energy_; }
  double energyNow() const { return device_->hand().energyGiven() - energyAt_; }
  double blockY() const { return hand_->worldFromPart(0).position.y; }
  double maxForce() const;
  /// N: of each tick since mark().
  const std::vector<glm::dvec3>& forces() const { return forces_; }
  /// Ticks since mark() in which the hand was given less than what others moved would have given.
  std::size_t guardedTicks() const { return guardedTicks_; }
  double force() const { return glm::length(forces_.back()); }

  const client::HandOutput& output() const { return hand_->output(); }
  client::ServerConnection& site() { return *site_; }
  client::Exchange& exchange() { return *exchange_; }
  double time() const { return sync::toSeconds(now_); }
  /// The session's time, as the server has it.
  sync::Micros sessionTime() const { return now_; }
  bool coHolds() const { return coHolds_; }
  /// Control messages that came from the site.
  const std::vector<sync::ControlMessage>& heard() const { return heard_; }
  /// Called with each link packet of the site.
  std::function<void(const sync::LinkUpdate&)> onLink;
  bool grantsCoHolding = false;

 private:
  void tick();
  void serve();
  void answer(const sync::ControlMessage& message);
  void publish(const Claim& claim);

  sync::VirtualNetwork network_;
  std::unique_ptr<sync::Transport> server_;
  sync::WireFrame frame_;
  sync::StateSender sender_;
  std::unique_ptr<client::Exchange> exchange_;
  std::unique_ptr<client::HandLoop> hand_;
  std::unique_ptr<client::ServerConnection> site_;
  std::unique_ptr<client::ScriptedDevice> device_;
  sync::ConnectionId peer_ = 0;
  sync::Micros now_ = 0, period_;
  sync::PartState block_;
  std::uint32_t sequence_ = 0;
  bool coHolds_ = false;
  std::vector<sync::ControlMessage> heard_;
  std::vector<glm::dvec3> forces_;
  double energyAt_ = 0.0, energy_ = 0.0;
  std::size_t guardedTicks_ = 0;
};

}  // namespace tandem::test
