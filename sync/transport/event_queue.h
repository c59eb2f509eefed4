#pragma once

// Events on their way to the application, with a line for each connection and a turn for each line: a
// connection that sends much waits for itself and not the others. Internal to the transport.
//
// 1. Events of one connection keep their order; those of several come by turns.
// 2. A line that is held keeps its events until it is released. The end of its connection releases it, and
//    what was held is dropped.

#include <cstddef>
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
  /// The next event of the connection whose turn it is.
  std::optional<Event> pop();
  /// No pop() would give an event.
  bool empty() const { return turns_.empty(); }
  void hold(ConnectionId connection, bool held);
  /// Drops all events of a connection and its hold.
  void erase(ConnectionId connection);

 private:
  struct Line {
    std::deque<Event> events;
    bool held = false;
  };
  std::unordered_map<ConnectionId, Line> lines_;
  std::deque<ConnectionId> turns_;  // lines with events that are not held, each once
};

}  // namespace tandem::sync
