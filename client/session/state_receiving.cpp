#include "client/session/state_receiving.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "sync/wire/recording.h"

namespace tandem::client {

using namespace sync;

StateReceiving::StateReceiving(PartOwnership& ownership, Participants& people, Doubts& doubts,
                               Exchange& exchange, HandEvents& events, MessageSender& sender,
                               SessionClock& clock, const Watchers& watchers)
    : ownership_(ownership),
      people_(people),
      doubts_(doubts),
      exchange_(exchange),
      events_(events),
      sender_(sender),
      clock_(clock),
      watchers_(watchers) {}

void StateReceiving::reset() {
  receiver_.reset();
  newestOf_.clear();
  expected_ = arrived_ = 0;
  loss_ = {};
}

StateReceiver::Outcome StateReceiving::decode(std::span<const std::byte> bytes) {
  const StateReceiver::Outcome outcome = receiver_.decode(bytes, ownership_.frame(), message_);
  if (outcome != StateReceiver::Outcome::decoded && outcome != StateReceiver::Outcome::malformed)
    ++counts_.droppedBaselines;
  return outcome;
}

void StateReceiving::countLoss(std::uint32_t sequence) {
  if (arrived_++ == 0) newest_ = sequence - 1;
  const auto ahead = static_cast<std::int32_t>(sequence - newest_);
  if (ahead > 0) {
    expected_ += static_cast<std::uint64_t>(ahead);
    newest_ = sequence;
  }
  loss_.observe(expected_, arrived_);
}

/// Whether no later update of the same site has arrived before.
bool StateReceiving::isNewest(const StateUpdate& update) {
  auto last = std::find_if(newestOf_.begin(), newestOf_.end(),
                           [&](const auto& entry) { return entry.first == update.site; });
  if (last == newestOf_.end()) last = newestOf_.insert(last, {update.site, update.sequence - 1});
  if (static_cast<std::int32_t>(update.sequence - last->second) <= 0) return false;
  last->second = update.sequence;
  return true;
}

void StateReceiving::handle(const StateUpdate& update) {
  ASSERT(&update == std::get_if<StateUpdate>(&message_));
  ++counts_.updates;
  countLoss(update.sequence);
  if (isNewest(update) && update.presenceKnown) people_.show(update.site, update.presence);
  if (watchers_.recording && update.presenceKnown) watchers_.recording->write(update.time, message_);
  if (!clock_.known()) return;
  delay_.observe(update.time, clock_.time());
  ownership_.noteAge(update.site, clock_.time() - update.time);
  for (const PartState& state : update.parts) accept(update, state);
}

void StateReceiving::accept(const StateUpdate& update, const PartState& state) {
  if (ownership_.view().accept(update.site, state) != OwnershipView::Verdict::accepted) {
    ++counts_.droppedStates;
    return;
  }
  ASSERT(ownership_.exists(state.part));
  if (watchers_.observer) watchers_.observer->onAccepted(update.site, state);
  doubts_.observe(update.site, state, update.time, clock_.now());
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::state;
  event.time = update.time;
  event.state = state;
  events_.push(event);
}

void StateReceiving::acknowledge() {
  if (const std::optional<StateAck> ack = receiver_.drainAck(clock_.now()))
    sender_.sendState(*ack, ownership_.frame());
}

void StateReceiving::drainDoubts() {
  SiteId site = kNoSite;
  while (exchange_.doubts.pop(site)) doubts_.accuse(site, clock_.now());
}

void StateReceiving::publishTimeBase() {
  if (clock_.known()) playOut_ = delay_.delay(clock_.time());
  ASSERT(playOut_ >= 0);
  exchange_.timeBase.write({clock_.time() - clock_.now(), playOut_, people_.self()});
}

}  // namespace tandem::client
