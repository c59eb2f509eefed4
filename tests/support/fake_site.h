#pragma once

// A site that sends exactly what a test gives it over a Transport, and keeps all that it receives.

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "sync/transport/transport.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/state_receiver.h"
#include "sync/wire/wire.h"

namespace tandem::test {

struct FakeSite {
  std::unique_ptr<sync::Transport> transport;
  sync::WireFrame frame;
  sync::StateReceiver receiver;
  bool connected = false, closed = false;
  std::vector<sync::ControlMessage> received;
  std::vector<sync::StateUpdate> updates;
  std::vector<sync::Pong> pongs;
  std::vector<sync::LinkUpdate> links;
  std::uint32_t sequence = 0, pings = 0;

  void send(const sync::ControlMessage& message) { transport->sendControl(0, sync::encodeControl(message)); }
  void send(const sync::StateMessage& message) {
    std::vector<std::byte> bytes;
    sync::encodeState(message, frame, bytes);
    transport->sendState(0, bytes);
  }
  void ping(sync::Micros now) { send(sync::Ping{++pings, now}); }

  void listen() {
    sync::TransportEvent event;
    while (transport->poll(event)) {
      using Kind = sync::TransportEvent::Kind;
      if (event.kind == Kind::connected) connected = true;
      if (event.kind == Kind::closed) closed = true;
      if (event.kind == Kind::control) {
        auto message = sync::decodeControl(event.bytes);
        ASSERT(message.ok());
        received.push_back(*message);
      }
      if (event.kind != Kind::state) continue;
      while (!event.bytes.empty()) receive(sync::popMessage(event.bytes));
    }
  }
  void receive(std::span<const std::byte> bytes) {
    sync::StateMessage message;
    const auto decoded = receiver.decode(bytes, frame, message);
    ASSERT(decoded == sync::StateReceiver::Outcome::decoded);
    if (const auto* update = std::get_if<sync::StateUpdate>(&message)) updates.push_back(*update);
    if (const auto* pong = std::get_if<sync::Pong>(&message)) pongs.push_back(*pong);
    if (const auto* link = std::get_if<sync::LinkUpdate>(&message)) links.push_back(*link);
  }

  /// The latest message of a kind, or null.
  template <typename Message>
  const Message* last() const {
    for (auto at = received.rbegin(); at != received.rend(); ++at)
      if (const auto* message = std::get_if<Message>(&*at)) return message;
    return nullptr;
  }
  template <typename Message>
  std::size_t count() const {
    std::size_t n = 0;
    for (const auto& message : received) n += std::holds_alternative<Message>(message) ? 1 : 0;
    return n;
  }
};

}  // namespace tandem::test
