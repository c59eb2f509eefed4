#include "client/session/state_receiving.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "sync/wire/recording.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr Micros kBetweenReports = 5 * kSecond;  // of this site; the server passes on no more
constexpr Micros kBetweenOpinions = kSecond;     // of other sites, shown to the person
constexpr Micros kSuspects = 2 * kSecond;        // after a state that no hand makes
constexpr Micros kDistrusts = 60 * kSecond;      // after the report of its owner

std::vector<double> massesOf(const assets::Scene& scene) {
  std::vector<double> masses;
  for (const assets::Part& part : scene.parts) masses.push_back(part.massProperties.mass);
  return masses;
}

}  // namespace

StateReceiving::StateReceiving(PartOwnership& ownership, Participants& people, Exchange& exchange,
                               HandEvents& events, MessageSender& sender, SessionClock& clock,
                               const Watchers& watchers)
    : ownership_(ownership),
      people_(people),
      exchange_(exchange),
      events_(events),
      sender_(sender),
      clock_(clock),
      watchers_(watchers),
      judge_(massesOf(ownership.scene())),
      distrustedUntil_(ownership.scene().parts.size(), 0) {}

void StateReceiving::reset() {
  receiver_.reset();
  judge_.restart();
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
  judge(update, state);
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::state;
  event.time = update.time;
  event.state = state;
  events_.push(event);
}

std::string StateReceiving::partOf(PartId part, SiteId site) const {
  const std::string& name = ownership_.scene().parts[part].name;
  return (site == people_.self() ? "your" : people_.nameOf(site) + "'s") + " part " + name;
}

/// The hand guards itself against what it plays out already (sync/replica/motion_trust.h); this adds what
/// play-out smooths.
void StateReceiving::judge(const StateUpdate& update, const PartState& state) {
  const bool calls = judge_.judge(state, update.time, clock_.now());
  if (judge_.impossible() == counts_.impossible) return;
  counts_.impossible = judge_.impossible();
  distrust(state.part, kSuspects);
  if (calls) name(state.part, update.site);
}

void StateReceiving::judgePlayed() {
  const PartId part = exchange_.output.latest().impossible;
  if (part == kNoPart) return;
  const SiteId owner = ownership_.view().part(part).owner;
  if (owner != kNoSite && owner != people_.self()) name(part, owner);
}

/// Nobody who was named is trusted for a while.
void StateReceiving::name(PartId part, SiteId site) {
  distrust(part, kDistrusts);
  if (clock_.now() < nextReport_) return;
  nextReport_ = clock_.now() + kBetweenReports;
  ++counts_.reports;
  people_.notice(Notice::Level::warning, partOf(part, site) + " moves as no hand moves it");
  sender_.send(MotionReport{part, site});
}

void StateReceiving::distrust(PartId part, Micros lasts) {
  Micros& until = distrustedUntil_[part];
  if (clock_.now() + lasts < until + kSecond) return;  // a flood is few events
  until = clock_.now() + lasts;
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::distrusted;
  event.state.part = part;
  event.time = lasts + kSecond;
  events_.push(event);
}

void StateReceiving::handle(const MotionReported& report) {
  if (report.reporter == people_.self() || !ownership_.exists(report.part) || clock_.now() < nextOpinion_)
    return;
  nextOpinion_ = clock_.now() + kBetweenOpinions;
  people_.notice(Notice::Level::warning, people_.nameOf(report.reporter) + "'s site says that " +
                                             partOf(report.part, report.site) + " moves impossibly");
}

void StateReceiving::acknowledge() {
  if (const std::optional<StateAck> ack = receiver_.drainAck(clock_.now()))
    sender_.sendState(*ack, ownership_.frame());
}

void StateReceiving::publishTimeBase() {
  if (clock_.known()) playOut_ = delay_.delay(clock_.time());
  ASSERT(playOut_ >= 0);
  exchange_.timeBase.write({clock_.time() - clock_.now(), playOut_, people_.self()});
}

}  // namespace tandem::client
