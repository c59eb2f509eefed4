#pragma once

// A hostile peer of a simulated session: it speaks the protocol as far as it helps, then does harm. What it
// gets by that is judged here (R1 to R4); what it does to others, by the rules that the others keep.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/simulation/invariants.h"
#include "client/simulation/scenario.h"
#include "client/simulation/simulated_server.h"
#include "sync/transport/virtual_network.h"
#include "sync/wire/state_sender.h"
#include "sync/wire/wire.h"

namespace tandem::client {

class Stranger {
 public:
  /// The session that it attacks. All of it outlives the stranger.
  struct Ground {
    sync::VirtualNetwork& network;
    SimulatedServer& server;
    Invariants& invariants;
    const assets::Scene& scene;
  };
  Stranger(const Ground& ground, Fault::Kind kind, std::string name, std::uint64_t seed, sync::Micros now,
           sync::Micros until);

  void step(sync::Micros now);
  sync::Micros nextDue(sync::Micros never) const;

 private:
  using Kind = Fault::Kind;
  std::uint64_t below(std::uint64_t n) { return random_.draw() % n; }
  bool chance(unsigned percent) { return below(100) < percent; }

  void connect();
  void hello();
  void receive();
  void receive(std::span<const std::byte> bytes);
  void welcome(const sync::Welcome& message);
  void act();
  void sendMalformed();
  void sendForbidden();
  void sendFlood();
  void sendState();
  void send(const sync::ControlMessage& message);
  void sendDatagram(const sync::StateMessage& message);
  sync::ControlMessage forbidden();
  sync::ControlMessage serverOnly();
  PartId anyPart() { return static_cast<PartId>(below(ground_.scene.parts.size() + 1)); }
  void judgePatience();

  Ground ground_;
  Kind kind_;
  std::string name_;
  SplitMix64 random_;
  sync::Micros now_, until_, next_;
  sync::Role role_ = sync::Role::participant;
  std::unique_ptr<sync::Transport> transport_;
  std::string token_;
  std::int64_t goodUntil_ = 0;  // Unix time, s, until which the server may admit who shows it
  sync::Micros saidHelloAt_ = 0;
  bool in_ = false;
  sync::Micros offended_ = -1;  // since when the server should have closed the connection; < 0: it need not
  sync::Micros enteredAt_ = 0;
  std::uint64_t answers_ = 0;  // to a flood
  std::uint32_t request_ = 1, sequence_ = 0;
  std::vector<std::vector<std::byte>> recorded_;  // datagrams, to be sent again
  sync::WireFrame frame_;
};

}  // namespace tandem::client
