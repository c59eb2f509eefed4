#pragma once

// Events on their way to the application, with a line for each connection and a turn for each line: a
// connection that sends much waits for itself and not the others. Internal to the transport.
//
// 1. Events of one line keep their order; those of several come by turns.
// 2. State has a line beside the control of its connection, with turns of its own.
// 3. A connection that is held keeps its control until it is released; its state passes, so that its pings
//    count. The end of the connection releases it, and what was held is dropped, as is state that waits.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "sync/transport/transport.h"

namespace tandem::sync {

class EventQueue {
 public:
  struct Event {
    TransportEvent::Kind kind = TransportEvent::Kind::closed;
    ConnectionId connection = 0;
    std::vector<std::byte> bytes;
    std::string reason;
  };

  void push(Event event);
  /// The next event of the line whose turn it is.
  std::optional<Event> pop();
  /// No pop() would give an event.
  bool empty() const { return turns_.empty(); }
  void hold(ConnectionId connection, bool held);
  /// Drops all events of a connection and its hold.
  void erase(ConnectionId connection);

 private:
  /// A connection, and whether the line is that of its state.
  using Key = std::uint64_t;
  static Key keyOf(ConnectionId connection, bool state) {
    return std::uint64_t{connection} << 1 | (state ? 1u : 0u);
  }
  struct Line {
    std::deque<Event> events;
    bool held = false;
  };
  void eraseLine(Key key);

  std::unordered_map<Key, Line> lines_;
  std::deque<Key> turns_;  // lines with events that are not held, each once
};

}  // namespace tandem::sync
