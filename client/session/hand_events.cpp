#include "client/session/hand_events.h"

namespace tandem::client {

void HandEvents::push(const NetworkEvent& event) {
  if (waiting_.empty() && exchange_.events.push(event)) return;
  if (event.kind == NetworkEvent::Kind::state)
    ++droppedStates_;
  else
    waiting_.push_back(event);
}

void HandEvents::flush() {
  std::size_t sent = 0;
  while (sent < waiting_.size() && exchange_.events.push(waiting_[sent])) ++sent;
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(sent));
}

}  // namespace tandem::client
