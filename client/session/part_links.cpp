#include "client/session/part_links.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "assets/base/assert.h"
#include "haptics/link/link_distance.h"

namespace tandem::client {

using namespace sync;
using haptics::LinkId;

namespace {

constexpr double kUnknownAge = 0.05;          // s, of a peer of which no state has come yet
constexpr std::uint32_t kEpochsAhead = 1000;  // by which another site's clock may lead: 16 s

/// Half the diagonal of a block with these mass properties, m: the arm by which a rotation is compared with a
/// displacement.
double leverOf(const assets::MassProperties& part) {
  constexpr double kMin = 0.01, kMax = 0.15, kUnknown = 0.05;
  const double trace = part.inertia[0][0] + part.inertia[1][1] + part.inertia[2][2];
  const double lever = std::sqrt(1.5 * trace / part.mass);
  return std::isfinite(lever) ? std::clamp(lever, kMin, kMax) : kUnknown;
}

double rounded(double value, double quantum) {
  return quantum * std::clamp(std::floor(value / quantum), 1.0, 255.0);
}

haptics::LinkPacket packetOf(const LinkState& state) {
  haptics::LinkPacket packet;
  packet.epoch = state.epoch;
  packet.sequence = state.sequence;
  packet.time = static_cast<double>(state.time) * 1e-6;
  packet.wave = {{state.wave[0], state.wave[1], state.wave[2]},
                 {state.wave[3], state.wave[4], state.wave[5]}};
  packet.energy = state.energy;
  packet.fade = state.fade;
  packet.on = state.on;
  packet.asks = state.asks;
  packet.regime = static_cast<haptics::LinkRegime>(state.regime);
  packet.worldFromDrawn = state.worldFromDrawn;
  packet.twist = state.twist;
  return packet;
}

/// The link numbers its packets from 0, the wire from 1.
LinkState stateOf(const haptics::LinkPacket& packet) {
  const glm::dvec3 &along = packet.wave.along, &about = packet.wave.about;
  LinkState state;
  state.epoch = packet.epoch;
  state.sequence = packet.sequence + 1;
  state.time = static_cast<Micros>(std::llround(packet.time * 1e6));
  state.wave = {along.x, along.y, along.z, about.x, about.y, about.z};
  state.energy = packet.energy;
  state.fade = packet.fade;
  state.on = packet.on;
  state.asks = packet.asks;
  state.regime = static_cast<std::uint8_t>(packet.regime);
  state.worldFromDrawn = packet.worldFromDrawn;
  state.twist = packet.twist;
  return state;
}

/// What both ends must agree on, and the owner decides.
LinkAgreement agreementOf(const haptics::LinkTerms& terms) {
  return {terms.parameters.impedance, terms.parameters.softImpedance, terms.parameters.packetPeriod};
}

std::uint32_t epochOf(Micros now) { return static_cast<std::uint32_t>(std::max<Micros>(0, now) >> 14); }

}  // namespace

PartLinks::PartLinks(const assets::Scene& scene, double packetPeriod)
    : scene_(scene),
      packetPeriod_(rounded(packetPeriod, kPacketPeriodQuantum)),
      lastEpoch_(scene.parts.size(), 0) {}

void PartLinks::noteAge(SiteId peer, Micros age) {
  const double seconds = std::clamp(toSeconds(age), 0.0, 1.0);
  const auto known =
      std::find_if(ages_.begin(), ages_.end(), [&](const Age& entry) { return entry.site == peer; });
  if (known == ages_.end())
    ages_.push_back({peer, seconds});
  else
    known->seconds += 0.05 * (seconds - known->seconds);
}

double PartLinks::ageOf(SiteId peer) const {
  for (const Age& entry : ages_)
    if (entry.site == peer) return entry.seconds;
  return kUnknownAge;
}

PartLinks::Link* PartLinks::find(LinkId id) {
  const auto link =
      std::find_if(links_.begin(), links_.end(), [&](const Link& entry) { return entry.terms.id == id; });
  return link == links_.end() ? nullptr : &*link;
}

const PartLinks::Link* PartLinks::find(LinkId id) const { return const_cast<PartLinks*>(this)->find(id); }

PartLinks::Link& PartLinks::add(LinkId id) {
  Link& link = links_.emplace_back();
  link.terms.id = id;
  return link;
}

std::uint32_t PartLinks::newEpoch(PartId part, Micros now) {
  ASSERT(part < lastEpoch_.size());
  return std::max(lastEpoch_[part] + 1, epochOf(now));
}

LinkAgreement PartLinks::agreementWith(SiteId peer, std::size_t links) const {
  const haptics::LinkImpedances b =
      haptics::impedancesAt(ageOf(peer), packetPeriod_, static_cast<int>(links));
  return {rounded(b.stiff, kImpedanceQuantum), rounded(b.soft, kImpedanceQuantum), packetPeriod_};
}

/// Begins a link, or begins it anew, by this agreement.
void PartLinks::begin(Link& link, std::uint32_t epoch, const LinkAgreement& agreement, Micros now,
                      bool ownedByPeer) {
  haptics::LinkTerms& terms = link.terms;
  std::uint32_t& last = lastEpoch_[terms.id.part];
  last = std::max(last, epoch);
  begun_[{terms.id.part, terms.id.peer}] = epoch;
  terms.epoch = epoch;
  terms.delay = ageOf(terms.id.peer);
  terms.parameters.lever = leverOf(scene_.parts[terms.id.part].massProperties);
  terms.parameters.impedance = agreement.impedance;
  terms.parameters.softImpedance = agreement.softImpedance;
  terms.parameters.packetPeriod = agreement.packetPeriod;
  // A co-holder whose hand holds the part lowers this at its end.
  terms.parameters.longestDelay = haptics::longestDelay(false);
  link.receiver.forget();
  link.receivedAt = now;
  link.felt = false;
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::link;
  event.ownedByPeer = ownedByPeer;
  event.link = terms;
  events_.push_back(event);
}

void PartLinks::publishSimulators(const OwnershipView& view, PartId part) {
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::simulators;
  event.link.id.part = part;
  event.simulators = static_cast<int>(view.simulators(part));
  events_.push_back(event);
}

void PartLinks::follow(const OwnershipView& view, PartId part, Micros now) {
  ASSERT(part < scene_.parts.size());
  const SiteId owner = view.part(part).owner;
  std::vector<SiteId> coHolders = view.coHolders(part).sites;
  std::erase(coHolders, view.self());  // the list without a new owner arrives a moment after its ownership
  const bool owns = view.owns(part), isCoHolder = view.isCoHolder(part);
  const auto shares = [&](SiteId peer) {
    if (owns) return std::find(coHolders.begin(), coHolders.end(), peer) != coHolders.end();
    return isCoHolder && peer == owner;
  };
  const auto ends = [&](const Link& link) {
    return link.terms.id.part == part && !shares(link.terms.id.peer);
  };
  for (const Link& link : links_) {
    if (!ends(link)) continue;
    NetworkEvent event;
    event.kind = NetworkEvent::Kind::unlink;
    event.link.id = link.terms.id;
    events_.push_back(event);
  }
  std::erase_if(links_, ends);
  if (owns) linkCoHolders(part, coHolders, now);
  if (owns || isCoHolder) publishSimulators(view, part);
}

/// An existing link goes on, whichever site began it, unless its impedance is too large beside the other
/// links.
void PartLinks::linkCoHolders(PartId part, const std::vector<SiteId>& coHolders, Micros now) {
  for (const SiteId peer : coHolders) {
    const LinkAgreement agreement = agreementWith(peer, coHolders.size());
    Link* link = find({part, peer});
    if (link != nullptr && link->terms.parameters.impedance <= 1.1 * agreement.impedance) continue;
    if (link == nullptr) link = &add({part, peer});
    begin(*link, newEpoch(part, now), agreement, now, false);
  }
}

void PartLinks::beginSilentAnew(const OwnershipView& view, Micros now) {
  for (Link& link : links_) {
    const PartId part = link.terms.id.part;
    if (!view.owns(part) || now - link.receivedAt < kSilence) continue;
    begin(link, newEpoch(part, now), agreementOf(link.terms), now, false);
  }
}

/// The co-holder's end of the link to the owner. A packet of a new epoch begins it.
PartLinks::Link* PartLinks::linkToOwner(const LinkUpdate& update, Micros now) {
  const LinkId id{update.part, update.peer};
  Link* link = find(id);
  const auto begun = begun_.find({update.part, update.peer});
  const bool known = update.epoch <= (begun == begun_.end() ? 0 : begun->second),
             absurd = update.epoch > std::max(lastEpoch_[update.part], epochOf(now)) + kEpochsAhead;
  if (!update.posed || !update.on || known || absurd) return link;
  if (link == nullptr) link = &add(id);
  begin(*link, update.epoch, update.terms, now, true);
  return link;
}

std::optional<haptics::AddressedPacket> PartLinks::receive(const LinkUpdate& update,
                                                           const OwnershipView& view, Micros now) {
  if (update.part >= scene_.parts.size()) return std::nullopt;
  const std::optional<Micros> time = sessionTimeOf(update, now);
  if (!time) return std::nullopt;
  const bool fromOwner = view.isCoHolder(update.part) && view.part(update.part).owner == update.peer;
  Link* link = fromOwner ? linkToOwner(update, now) : find({update.part, update.peer});
  if (link == nullptr || update.epoch != link->terms.epoch) return std::nullopt;
  const std::optional<LinkState> state = link->receiver.receiveAt(update, *time);
  if (!state) return std::nullopt;
  link->receivedAt = now;
  const haptics::LinkPacket packet = packetOf(*state);
  link->felt = packet.regime != haptics::LinkRegime::apart;
  return haptics::AddressedPacket{link->terms.id, packet};
}

std::optional<LinkUpdate> PartLinks::toWire(const haptics::AddressedPacket& packet) const {
  const Link* link = find(packet.link);
  if (link == nullptr || packet.packet.epoch != link->terms.epoch) return std::nullopt;
  LinkUpdate update = sync::toWire(stateOf(packet.packet), packet.link.peer, packet.link.part);
  update.terms = agreementOf(link->terms);
  return update;
}

bool PartLinks::felt(PartId part, SiteId peer) const {
  const Link* link = find({part, peer});
  return link != nullptr && link->felt;
}

std::vector<NetworkEvent> PartLinks::drainEvents() { return std::exchange(events_, {}); }

}  // namespace tandem::client
