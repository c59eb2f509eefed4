#include "sync/transport/event_queue.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::sync {

void EventQueue::push(Event event) {
  const ConnectionId connection = event.connection;
  const Key key = keyOf(connection, event.kind == TransportEvent::Kind::state);
  if (event.kind == TransportEvent::Kind::closed) {
    if (lines_[key].held) eraseLine(key);
    eraseLine(keyOf(connection, true));
  }
  Line& line = lines_[key];
  if (line.events.empty() && !line.held) turns_.push_back(key);
  line.events.push_back(std::move(event));
}

std::optional<EventQueue::Event> EventQueue::pop() {
  if (turns_.empty()) return std::nullopt;
  const Key key = turns_.front();
  turns_.pop_front();
  const auto at = lines_.find(key);
  ASSERT(at != lines_.end() && !at->second.held && !at->second.events.empty());
  Line& line = at->second;
  Event event = std::move(line.events.front());
  line.events.pop_front();
  if (line.events.empty())
    lines_.erase(at);
  else
    turns_.push_back(key);
  return event;
}

void EventQueue::hold(ConnectionId connection, bool held) {
  const Key key = keyOf(connection, false);
  if (!held && !lines_.contains(key)) return;
  Line& line = lines_[key];
  if (line.held == held) return;
  if (held && !line.events.empty() && line.events.back().kind == TransportEvent::Kind::closed) {
    line.events.erase(line.events.begin(), line.events.end() - 1);
    return;
  }
  line.held = held;
  if (line.events.empty()) {
    if (!held) lines_.erase(key);
  } else if (held) {
    std::erase(turns_, key);
  } else {
    turns_.push_back(key);
  }
}

void EventQueue::erase(ConnectionId connection) {
  eraseLine(keyOf(connection, false));
  eraseLine(keyOf(connection, true));
}

void EventQueue::eraseLine(Key key) {
  if (lines_.erase(key) > 0) std::erase(turns_, key);
}

}  // namespace tandem::sync
