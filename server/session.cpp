#include "server/session.h"

#include <algorithm>

#include "assets/scene/scene_package.h"
#include "server/session_state.h"

namespace tandem::server {
namespace {

constexpr int kMaxEventsPerStep = 2048;
constexpr int kMaxMessagesPerStep = 4096;
constexpr std::size_t kMaxUnknownPeers = 64;  // connections that have not said hello
constexpr std::size_t kMaxLogLines = 1000;    // between two calls of takeLog()
constexpr sync::Micros kLeasePeriod = 10 * sync::kMillisecond;
constexpr sync::Micros kPosePeriod = sync::kSecond;
constexpr sync::Micros kHousekeepingPeriod = sync::kSecond;
constexpr sync::Micros kBusyPeriod = sync::kMillisecond;  // while the disk or a transfer is awaited
constexpr sync::Micros kIdlePeriod = 500 * sync::kMillisecond;

std::vector<bool> movableParts(const assets::Scene& scene) {
  std::vector<bool> movable;
  for (const auto& part : scene.parts) movable.push_back(part.movable);
  return movable;
}

std::vector<Pose> restPoses(const assets::Scene& scene) {
  std::vector<Pose> poses;
  for (const auto& part : scene.parts) poses.push_back(part.worldFromPart);
  return poses;
}

template <typename... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};
template <typename... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;

}  // namespace

Session::State::State(const assets::Scene& theScene, std::span<const std::byte> thePackage,
                      const SessionConfig& theConfig, sync::Transport& theTransport, Journal& theJournal,
                      sync::RecordingWriter* theRecording)
    : scene(theScene),
      package(thePackage),
      config(theConfig),
      transport(theTransport),
      journal(theJournal),
      recording(theRecording),
      sceneHash(assets::contentHash(thePackage)),
      frame(sync::wireFrame(theScene.bounds)),
      table(movableParts(theScene), restPoses(theScene), theConfig.lease),
      moved(theScene.parts.size(), false) {
  config.maxSites = std::min(config.maxSites, sync::kMaxSites);
  config.chunkBytes = std::clamp<std::size_t>(config.chunkBytes, 1, sync::kMaxChunkBytes);
  stateBytes.reserve(sync::kMaxStateBytes);
  std::get<sync::StateUpdate>(incoming).parts.reserve(256);
  movedParts.reserve(scene.parts.size());
}

void Session::State::restore(sync::Micros callerNow) {
  const JournalContents contents = journal.contents();
  offset = std::max<sync::Micros>(0, contents.sessionTime - callerNow);
  now = callerNow + offset;
  appended = journal.durableUpTo();
  std::vector<sync::PartRecord> parts;
  for (const auto& record : contents.parts)
    if (record.part < scene.parts.size()) parts.push_back(record);
  if (!parts.empty()) table.restore(parts, now);
  for (const auto& record : contents.sites) {
    KnownSite& site = known[record.info.site];
    site.info = record.info;
    site.info.connected = false;
    site.left = record.left;
    site.listed = !record.left;
    site.disconnectedAt = now;
    nextSite = std::max<SiteId>(nextSite, static_cast<SiteId>(record.info.site + 1));
  }
  for (const auto& record : contents.nonces) usedNonces[record.nonce] = record.expires;
  relist();
  if (recording == nullptr) return;
  for (const auto& site : listed) recording->write(now, sync::SiteChanged{site});
  for (const auto& part : table.records()) recording->write(now, sync::OwnershipChanged{part});
}

Session::Session(const assets::Scene& scene, std::span<const std::byte> package, const SessionConfig& config,
                 sync::Transport& transport, Journal& journal, sync::RecordingWriter* recording,
                 sync::Micros now, std::int64_t unixNow)
    : state_(std::make_unique<State>(scene, package, config, transport, journal, recording)) {
  state_->unixNow = unixNow;
  state_->restore(now);
}

Session::~Session() = default;

std::string Session::makeToken(sync::Role role, std::int64_t expires) const {
  Ticket ticket;
  ticket.role = role;
  ticket.nonce = makeNonce();
  ticket.expires = expires;
  return sign(ticket, state_->config.key);
}

void Session::step(sync::Micros now, std::int64_t unixNow) {
  State& s = *state_;
  s.now = std::max(s.now, now + s.offset);
  s.unixNow = unixNow;
  s.journal.noteTime(s.now);
  s.watchJournal();
  s.takeEvents();
  for (auto& [connection, peer] : s.peers) s.flushStates(peer);
  s.runTimers();
  s.continueReset();
  s.tellMembers();
  s.flushOutbox();
  for (auto& [connection, peer] : s.peers) s.sendChunks(peer);
}

sync::Micros Session::nextDeadline() const {
  const State& s = *state_;
  const sync::Micros local = s.now - s.offset;
  if (s.eventsLeft || s.reset) return local;
  const bool transfers = std::any_of(s.peers.begin(), s.peers.end(),
                                     [](const auto& entry) { return entry.second.transferring; });
  if (!s.outbox.empty() || transfers) return local + kBusyPeriod;
  if (s.peers.empty() && s.journalFailure.empty() && !s.table.recovering(s.now)) return local + kIdlePeriod;
  return std::min({s.nextLeases, s.nextPoses, s.nextHousekeeping}) - s.offset;
}

sync::Micros Session::sessionTime() const { return state_->now; }
const std::vector<sync::SiteInfo>& Session::sites() const { return state_->listed; }
const sync::OwnershipTable& Session::ownership() const { return state_->table; }
const SessionCounters& Session::counters() const { return state_->counts; }
std::vector<LogLine> Session::takeLog() { return std::exchange(state_->log, {}); }
std::vector<sync::Role> Session::takeUsedTokens() { return std::exchange(state_->usedTokens, {}); }

void Session::shutDown() {
  State& s = *state_;
  s.keepPoses();
  for (const auto& [connection, peer] : s.peers) s.transport.close(connection);
  s.peers.clear();
}

void Session::State::takeEvents() {
  sync::TransportEvent event;
  for (int i = 0; i < kMaxEventsPerStep; ++i) {
    eventsLeft = transport.poll(event);
    if (!eventsLeft) return;
    if (event.kind == sync::TransportEvent::Kind::connected) {
      onConnected(event.connection);
      continue;
    }
    const auto at = peers.find(event.connection);
    if (at == peers.end()) continue;  // this side closed it
    switch (event.kind) {
      case sync::TransportEvent::Kind::control:
        onControl(at->second, event.bytes);
        break;
      case sync::TransportEvent::Kind::state:
        while (onState(at->second, sync::takeMessage(event.bytes)) && !event.bytes.empty()) continue;
        break;
      default:
        forget(event.connection, event.reason.empty() ? "connection closed" : event.reason);
        break;
    }
  }
}

void Session::State::onConnected(sync::ConnectionId connection) {
  const auto strangers = std::count_if(peers.begin(), peers.end(),
                                       [](const auto& entry) { return entry.second.stage == Stage::hello; });
  if (static_cast<std::size_t>(strangers) >= kMaxUnknownPeers) {
    ++counts.refusedHellos;
    transport.close(connection);
    return;
  }
  Peer peer;
  peer.connection = connection;
  peer.serial = nextSerial++;
  peer.since = peer.lastHeard = peer.allowanceAt = now;
  peers[connection] = peer;
}

void Session::State::sendControl(sync::ConnectionId connection, std::span<const std::byte> bytes) {
  counts.sent.countControl(bytes.size());
  transport.sendControl(connection, bytes);
}

void Session::State::onControl(Peer& peer, std::span<const std::byte> bytes) {
  counts.received.countControl(bytes.size());
  peer.lastHeard = now;
  const Result<sync::ControlMessage> message = sync::decodeControl(bytes);
  if (!message) {
    refuse(peer, sync::Refusal::malformed, message.error().message);
    return;
  }
  dispatch(peer, *message);
}

/// Checks the stage first; roles are checked where a message has its effect. `peer` may be gone afterwards.
void Session::State::dispatch(Peer& peer, const sync::ControlMessage& message) {
  const bool hello = std::holds_alternative<sync::Hello>(message);
  const bool whileLoading = std::holds_alternative<sync::SceneRequest>(message) ||
                            std::holds_alternative<sync::Ready>(message) ||
                            std::holds_alternative<sync::Goodbye>(message);
  if (hello != (peer.stage == Stage::hello) || (peer.stage == Stage::loading && !whileLoading)) {
    refuse(peer, sync::Refusal::unexpectedMessage,
           peer.stage == Stage::hello ? "the first message must be a hello"
                                      : "this message does not belong here");
    return;
  }
  std::visit(
      Overloaded{
          [&](const sync::Hello& m) { onHello(peer, m); },
          [&](const sync::SceneRequest& m) { onSceneRequest(peer, m); },
          [&](const sync::Ready&) { peer.stage = Stage::ready; },
          [&](const sync::Grab& m) { onGrab(peer, m); },
          [&](const sync::Release& m) { onRelease(peer, m); },
          [&](const sync::Reclaim& m) { onReclaim(peer, m); },
          [&](const sync::Revoke& m) { onRevoke(peer, m); },
          [&](const sync::ResetParts& m) { onReset(peer, m); },
          [&](const sync::Engage& m) { onEngage(peer, m); },
          [&](const sync::Disengage& m) { onDisengage(peer, m); },
          [&](const sync::Goodbye&) { onGoodbye(peer); },
          [&](const auto&) { refuse(peer, sync::Refusal::unexpectedMessage, "only the server says this"); },
      },
      message);
}

void Session::State::watchJournal() {
  if (!journalFailure.empty()) return;
  journalFailure = journal.failure();
  if (journalFailure.empty()) return;
  sayError("journal: " + journalFailure +
           "; nothing is granted, kept or admitted until the server is started again");
  outbox.abandon(journal.durableUpTo());
}

void Session::State::runTimers() {
  if (now >= nextLeases) {
    nextLeases = now + kLeasePeriod;
    if (journalFailure.empty()) {
      const auto freed = table.expire(now);
      counts.expiries += freed.size();
      freeParts(freed, "its lease ran out");
    }
  }
  if (now >= nextPoses) {
    nextPoses = now + kPosePeriod;
    keepPoses();
  }
  if (now >= nextHousekeeping) {
    nextHousekeeping = now + kHousekeepingPeriod;
    dropSilent();
    relist();
    forgetOldNonces();
    if (recording != nullptr && !recording->flush()) {
      sayError("recording: cannot be written any more");
      recording = nullptr;
    }
  }
}

void Session::State::flushOutbox() {
  const std::uint64_t durable = journal.durableUpTo();
  for (int i = 0; i < kMaxMessagesPerStep; ++i) {
    // After a failure nothing new waits for the disk: what is made then depends on no record.
    const Outgoing* item = outbox.front(journalFailure.empty() ? durable : ~std::uint64_t{0});
    if (item == nullptr) return;
    send(*item);
    outbox.pop();
  }
}

void Session::State::send(const Outgoing& item) {
  if (item.to == kRecordingOnly) {
    if (recording != nullptr) recording->write(now, *item.message);
    return;
  }
  const auto at = std::find_if(peers.begin(), peers.end(),
                               [&](const auto& entry) { return entry.second.serial == item.to; });
  if (at == peers.end()) return;  // gone meanwhile
  if (const auto* welcome = std::get_if<sync::Welcome>(item.message.get())) {
    sync::Welcome timed = *welcome;
    timed.sessionTime = now;
    sendControl(at->first, sync::encodeControl(timed));
    at->second.welcomed = true;
    return;
  }
  sendControl(at->first, sync::encodeControl(*item.message));
  if (std::holds_alternative<sync::Refused>(*item.message)) {
    const sync::ConnectionId connection = at->first;
    transport.close(connection);
    forget(connection, "refused");
  }
}

void Session::State::tell(const Peer& peer, sync::ControlMessage message) {
  outbox.push(peer.serial, std::make_shared<const sync::ControlMessage>(std::move(message)), appended);
}

void Session::State::tellAll(sync::ControlMessage message, SiteId except) {
  const auto shared = std::make_shared<const sync::ControlMessage>(std::move(message));
  for (const auto& [connection, peer] : peers)
    if (peer.stage != Stage::hello && peer.site != except) outbox.push(peer.serial, shared, appended);
  if (recording != nullptr) outbox.push(kRecordingOnly, shared, appended);
}

void Session::State::say(std::string line) {
  if (log.size() < kMaxLogLines) log.push_back({std::move(line), false});
}

/// Never left out: there are at most two, the journal's and the recording's.
void Session::State::sayError(std::string line) { log.push_back({std::move(line), true}); }

Peer* Session::State::peerOf(SiteId site) {
  for (auto& [connection, peer] : peers)
    if (peer.site == site) return &peer;
  return nullptr;
}

std::string Session::State::nameOf(SiteId site) const {
  const auto at = known.find(site);
  return "site " + std::to_string(site) + (at == known.end() ? "" : " \"" + at->second.info.name + "\"");
}

}  // namespace tandem::server
