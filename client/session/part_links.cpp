#include "client/session/part_links.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr double kUnknownAge = 0.05;    // s, of a peer that was not heard yet
constexpr double kFarImpedance = 10.0;  // N s/m, where only parts that touch are linked
// Inertia that all such lines of a part add together, kg: they last for as long as parts are near each other.
constexpr double kFarLineMass = 3.4;
constexpr double kSoftDelay = 0.06;           // s, of play-out: the least in the regime soft
constexpr std::uint32_t kEpochsAhead = 1000;  // that another clock may be: 16 s

/// Half the diagonal of a block with these mass properties, m: the arm by which a rotation is compared with a
/// displacement.
double leverOf(const assets::MassProperties& part) {
  constexpr double kLeast = 0.01, kMost = 0.15, kUnknown = 0.05;
  const double trace = part.inertia[0][0] + part.inertia[1][1] + part.inertia[2][2];
  const double lever = std::sqrt(1.5 * trace / part.mass);
  return std::isfinite(lever) ? std::clamp(lever, kLeast, kMost) : kUnknown;
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

std::uint32_t epochOf(Micros now) { return static_cast<std::uint32_t>(std::max<Micros>(0, now) >> 14); }

}  // namespace

PartLinks::PartLinks(const assets::Scene& scene, double packetPeriod)
    : scene_(scene),
      packetPeriod_(rounded(packetPeriod, kPacketPeriodQuantum)),
      lastEpoch_(scene.parts.size(), 0) {}

void PartLinks::heard(SiteId peer, Micros age) {
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

PartLinks::Line* PartLinks::find(PartId part, SiteId peer) {
  const auto line = std::find_if(lines_.begin(), lines_.end(),
                                 [&](const Line& entry) { return entry.part == part && entry.peer == peer; });
  return line == lines_.end() ? nullptr : &*line;
}

const PartLinks::Line* PartLinks::find(PartId part, SiteId peer) const {
  return const_cast<PartLinks*>(this)->find(part, peer);
}

std::uint32_t PartLinks::newEpoch(PartId part, Micros now) {
  ASSERT(part < lastEpoch_.size());
  return lastEpoch_[part] = std::max(lastEpoch_[part] + 1, epochOf(now));
}

LineTerms PartLinks::termsFor(SiteId peer, std::size_t lines) const {
  const haptics::LinkParameters standard;
  const auto count = static_cast<int>(lines);
  haptics::PlayOutDelay delay;
  delay.restart(ageOf(peer), packetPeriod_, standard.period);
  const double late = delay.seconds();
  const bool far = ageOf(peer) > standard.farthest;
  const double soft = far ? std::min(kFarImpedance, kFarLineMass / (late * count))
                          : haptics::lineImpedance(standard.softImpedance, std::max(late, kSoftDelay), count);
  return {rounded(haptics::lineImpedance(standard.impedance, late, count), kImpedanceQuantum),
          rounded(soft, kImpedanceQuantum), packetPeriod_};
}

void PartLinks::begin(Line& line, Micros now, bool guest) {
  ASSERT(line.epoch == lastEpoch_[line.part]);
  line.receiver.forget();
  line.heardAt = now;
  line.felt = false;
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::tie;
  event.guest = guest;
  event.record.part = event.tie.part = line.part;
  event.tie.peer = line.peer;
  event.tie.epoch = line.epoch;
  event.tie.delay = ageOf(line.peer);
  event.tie.link.lever = leverOf(scene_.parts[line.part].massProperties);
  event.tie.link.impedance = line.terms.impedance;
  event.tie.link.softImpedance = line.terms.softImpedance;
  event.tie.link.packetPeriod = line.terms.packetPeriod;
  event.tie.link.farthest =
      haptics::TiedParts::kFarthestTouched;  // a guest whose hand holds the part lowers this
  events_.push_back(event);
}

void PartLinks::tellSimulators(const OwnershipView& view, PartId part) {
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::simulators;
  event.record.part = part;
  event.simulators = static_cast<int>(view.simulators(part));
  events_.push_back(event);
}

void PartLinks::follow(const OwnershipView& view, PartId part, Micros now) {
  ASSERT(part < scene_.parts.size());
  const SiteId owner = view.part(part).owner;
  std::vector<SiteId> members = view.members(part).sites;
  std::erase(members, view.self());  // the list without a new owner arrives a moment after its ownership
  const bool owns = view.owns(part), guest = view.engaged(part);
  const auto shares = [&](SiteId peer) {
    if (owns) return std::find(members.begin(), members.end(), peer) != members.end();
    return guest && peer == owner;
  };
  const auto ends = [&](const Line& line) { return line.part == part && !shares(line.peer); };
  for (const Line& line : lines_) {
    if (!ends(line)) continue;
    NetworkEvent event;
    event.kind = NetworkEvent::Kind::untie;
    event.record.part = event.tie.part = part;
    event.tie.peer = line.peer;
    events_.push_back(event);
  }
  std::erase_if(lines_, ends);
  for (std::size_t i = 0; owns && i < members.size(); ++i) {
    const LineTerms terms = termsFor(members[i], members.size());
    Line* line = find(part, members[i]);
    // An existing line goes on, whichever site began it, unless its impedance is too large beside the other
    // lines.
    if (line != nullptr && line->terms.impedance <= 1.1 * terms.impedance) continue;
    if (line == nullptr) line = &lines_.emplace_back(Line{part, members[i], 0, {}, {}, 0});
    line->terms = terms;
    line->epoch = newEpoch(part, now);
    begin(*line, now, false);
  }
  if (owns || guest) tellSimulators(view, part);
}

void PartLinks::beginSilentAnew(const OwnershipView& view, Micros now) {
  for (Line& line : lines_) {
    if (!view.owns(line.part) || now - line.heardAt < kSilence) continue;
    line.epoch = newEpoch(line.part, now);
    begin(line, now, false);
  }
}

/// The guest's end of the line to the owner. A packet of a new epoch begins it.
PartLinks::Line* PartLinks::lineOfOwner(const LinkUpdate& update, Micros now) {
  Line* line = find(update.part, update.peer);
  std::uint32_t& last = lastEpoch_[update.part];
  const bool known = update.epoch <= last,
             absurd = update.epoch > std::max(last, epochOf(now)) + kEpochsAhead;
  if (!update.posed || !update.on || known || absurd) return line;
  if (line == nullptr) line = &lines_.emplace_back(Line{update.part, update.peer, 0, {}, {}, 0});
  line->epoch = last = update.epoch;
  line->terms = update.terms;
  begin(*line, now, true);
  return line;
}

std::optional<haptics::TiedPacket> PartLinks::receive(const LinkUpdate& update, const OwnershipView& view,
                                                      Micros now) {
  if (update.part >= scene_.parts.size()) return std::nullopt;
  const std::optional<Micros> time = sessionTimeOf(update, now);
  if (!time) return std::nullopt;
  const bool fromOwner = view.engaged(update.part) && view.part(update.part).owner == update.peer;
  Line* line = fromOwner ? lineOfOwner(update, now) : find(update.part, update.peer);
  if (line == nullptr || update.epoch != line->epoch) return std::nullopt;
  const std::optional<LinkState> state = line->receiver.receiveAt(update, *time);
  if (!state) return std::nullopt;
  line->heardAt = now;
  const haptics::LinkPacket packet = packetOf(*state);
  line->felt = packet.regime != haptics::LinkRegime::apart;
  return haptics::TiedPacket{line->part, line->peer, packet};
}

std::optional<LinkUpdate> PartLinks::toWire(const haptics::TiedPacket& packet) const {
  const Line* line = find(packet.part, packet.peer);
  if (line == nullptr || packet.packet.epoch != line->epoch) return std::nullopt;
  LinkUpdate update = sync::toWire(stateOf(packet.packet), packet.peer, packet.part);
  update.terms = line->terms;
  return update;
}

bool PartLinks::felt(PartId part, SiteId peer) const {
  const Line* line = find(part, peer);
  return line != nullptr && line->felt;
}

std::vector<NetworkEvent> PartLinks::takeEvents() { return std::exchange(events_, {}); }

}  // namespace tandem::client
