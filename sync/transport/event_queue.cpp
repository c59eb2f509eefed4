#include "sync/transport/event_queue.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::sync {

void EventQueue::push(Event event) {
  const ConnectionId connection = event.connection;
  if (event.kind == TransportEvent::Kind::closed && lines_[connection].held) erase(connection);
  Line& line = lines_[connection];
  if (line.events.empty() && !line.held) turns_.push_back(connection);
  line.events.push_back(std::move(event));
}

std::optional<EventQueue::Event> EventQueue::pop() {
  if (turns_.empty()) return std::nullopt;
  const ConnectionId connection = turns_.front();
  turns_.pop_front();
  const auto at = lines_.find(connection);
  ASSERT(at != lines_.end() && !at->second.held && !at->second.events.empty());
  Line& line = at->second;
  Event event = std::move(line.events.front());
  line.events.pop_front();
  if (line.events.empty())
    lines_.erase(at);
  else
    turns_.push_back(connection);
  return event;
}

void EventQueue::hold(ConnectionId connection, bool held) {
  if (!held && !lines_.contains(connection)) return;
  Line& line = lines_[connection];
  if (line.held == held) return;
  if (held && !line.events.empty() && line.events.back().kind == TransportEvent::Kind::closed) {
    line.events.erase(line.events.begin(), line.events.end() - 1);
    return;
  }
  line.held = held;
  if (line.events.empty()) {
    if (!held) lines_.erase(connection);
  } else if (held) {
    std::erase(turns_, connection);
  } else {
    turns_.push_back(connection);
  }
}

void EventQueue::erase(ConnectionId connection) {
  lines_.erase(connection);
  std::erase(turns_, connection);
}

}  // namespace tandem::sync
