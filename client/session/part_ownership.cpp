#include "client/session/part_ownership.h"

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr Micros kMaxPatience = 15 * kMillisecond;  // for which messages wait for a link's packet

}  // namespace

PartOwnership::PartOwnership(const assets::Scene& scene, const LeaseRules& lease, double packetRate,
                             Exchange& exchange, HandEvents& events, MessageSender& sender,
                             SessionClock& clock, const Watchers& watchers)
    : scene_(scene),
      exchange_(exchange),
      events_(events),
      sender_(sender),
      clock_(clock),
      watchers_(watchers),
      frame_(wireFrame(scene.bounds)),
      view_(scene.parts.size(), lease),
      links_(scene, 1.0 / packetRate),
      patience_(static_cast<Micros>(1.5e6 / packetRate)) {
  ASSERT(packetRate > 0.0);
}

void PartOwnership::enter(SiteId self) {
  view_.setSelf(self);
  view_.forgetCoHolders();
}

bool PartOwnership::handle(const OwnershipChanged& message) {
  if (!exists(message.part.part)) return false;
  apply(message.part);
  return true;
}

void PartOwnership::handle(const MembersChanged& message) {
  if (exists(message.coHolders.part)) apply(message.coHolders);
}

void PartOwnership::apply(const PartRecord& told) {
  ASSERT(exists(told.part));
  PartRecord record = told;
  // A server that is broken or lies cannot take a part out of reach.
  if (!contains(frame_, record.worldFromPart.position))
    record.worldFromPart = scene_.parts[record.part].worldFromPart;
  if (!view_.apply(record)) return;
  if (watchers_.observer) watchers_.observer->onOwnership(record);
  if (watchers_.undo) watchers_.undo->onOwnership(record);
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::ownership;
  event.record = record;
  events_.push(event);
  followLinks(record.part);
}

void PartOwnership::apply(const CoHolderRecord& coHolders) {
  ASSERT(exists(coHolders.part));
  if (view_.apply(coHolders)) followLinks(coHolders.part);
}

/// Matches the links of a part to its present owner and co-holders.
void PartOwnership::followLinks(PartId part) {
  links_.follow(view_, part, clock_.time());
  pushOrders();
}

void PartOwnership::pushOrders() {
  for (const NetworkEvent& order : links_.drainEvents()) events_.push(order);
}

void PartOwnership::handle(const LinkUpdate& update) {
  if (!clock_.known()) return;
  const auto packet = links_.receive(update, view_, clock_.time());
  pushOrders();
  if (packet)
    static_cast<void>(
        exchange_.linksIn.push(*packet));  // the ring is full only while the hand's loop stands still
}

void PartOwnership::exchangeLinks() {
  haptics::AddressedPacket packet;
  while (exchange_.linksOut.pop(packet)) {
    const std::optional<LinkUpdate> update = links_.toWire(packet);
    if (!update || !clock_.known()) continue;
    ASSERT(exists(update->part));
    sender_.sendState(*update, frame_);
    linkSentAt_ = clock_.now();
  }
  links_.beginSilentAnew(view_, clock_.time());
  pushOrders();
}

/// Non-link traffic rides on link datagrams while a link is active, so it costs no datagrams of its own.
bool PartOwnership::linkPacketIsNear() const {
  const Micros now = clock_.now();
  return patience_ <= kMaxPatience && now != linkSentAt_ && now - linkSentAt_ < patience_;
}

}  // namespace tandem::client
