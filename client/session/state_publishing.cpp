#include "client/session/state_publishing.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "sync/wire/recording.h"

namespace tandem::client {

using namespace sync;

StatePublishing::StatePublishing(PartOwnership& ownership, const Participants& people, Exchange& exchange,
                                 MessageSender& sender, SessionClock& clock, const Watchers& watchers,
                                 const PublishRates& rates)
    : ownership_(ownership),
      people_(people),
      exchange_(exchange),
      sender_(sender),
      clock_(clock),
      watchers_(watchers),
      publisher_(ownership.scene(), ownership.frame(), rates) {
  offered_.reserve(haptics::kMaxOwnedParts);
  bytes_.reserve(kMaxStateBytes);
}

void StatePublishing::reset() {
  publisher_.reset();
  encoder_.reset();
  updatesOfConnection_ = 0;
}

/// Whether another site's hand touches the part as it is played out there. A co-holder feels the coordination
/// link instead, where the delay allows one.
bool StatePublishing::othersTouch(PartId part) const {
  const std::vector<SiteId>& coHolders = ownership_.view().coHolders(part).sites;
  const std::vector<SiteView>& sites = people_.sites();
  return std::any_of(sites.begin(), sites.end(), [&](const SiteView& site) {
    if (site.self || !site.info.connected || ownership_.felt(part, site.info.site)) return false;
    const bool isCoHolder = std::find(coHolders.begin(), coHolders.end(), site.info.site) != coHolders.end();
    return isCoHolder || (site.seen && site.presence.touched == part);
  });
}

void StatePublishing::offerParts(const HandOutput& hand) {
  ASSERT(hand.tick.ownedCount >= 0 && hand.tick.ownedCount <= haptics::kMaxOwnedParts);
  const OwnershipView& view = ownership_.view();
  offered_.clear();
  for (int i = 0; i < hand.tick.ownedCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const haptics::OwnedPart& part = hand.tick.owned[index];
    const Epoch epoch = hand.ownedEpoch[index];
    ASSERT(ownership_.exists(part.part));
    if (epoch != view.part(part.part).epoch || !view.mayPublish(part.part, clock_.now())) continue;
    offered_.push_back(
        {{part.part, epoch, sequence_ + 1, part.worldFromPart, part.atRest ? Twist{} : part.twist},
         othersTouch(part.part)});
  }
}

void StatePublishing::publish(const Pose& worldFromCamera) {
  const Micros now = clock_.now();
  if (!clock_.known() || !publisher_.mayBeDue(now)) return;
  const HandOutput& hand = exchange_.output.latest();
  if (hand.time == 0) return;  // it has not ticked yet, so there is no pose and no time of it
  offerParts(hand);
  Presence presence{people_.self(), hand.tick.worldFromProxy, worldFromCamera,
                    hand.tick.hands[0].toHand.force, hand.tick.touched};
  if (hand.hands[1].present) presence.worldFromSecondTool = hand.hands[1].worldFromProxy;
  bool newPresence = true;
  if (!publisher_.due(now, hand.time, offered_, presence, newPresence)) return;
  auto& update = std::get<StateUpdate>(message_);
  update.site = people_.self();
  update.sequence = ++sequence_;
  update.time = clock_.at(hand.time);
  update.presence = presence;
  update.newPresence = newPresence;
  update.parts.clear();
  for (const OfferedPart& part : offered_) {
    ASSERT(part.state.sequence == update.sequence);
    update.parts.push_back(part.state);
    if (watchers_.observer) watchers_.observer->onPublished(part.state);
  }
  ++updates_;
  ++updatesOfConnection_;
  encoder_.encode(update, ownership_.frame(), bytes_);
  sender_.sendEncoded(bytes_);
  if (watchers_.recording) watchers_.recording->write(update.time, message_);
}

}  // namespace tandem::client
