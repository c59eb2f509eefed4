#include "server/session.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "server/chat.h"
#include "server/document_service.h"
#include "server/doubts.h"
#include "server/fan_out.h"
#include "server/instructor_commands.h"
#include "server/operator_commands.h"
#include "server/part_service.h"
#include "server/peers.h"
#include "server/presentations.h"
#include "server/publisher.h"
#include "server/scene_transfer.h"
#include "server/site_admission.h"
#include "server/sites.h"
#include "server/state_relay.h"
#include "sync/wire/wire.h"

namespace tandem::server {
namespace {

constexpr int kMaxEventsPerStep = 2048;
constexpr int kMaxControlPerStep = 64;  // then the state that has come meanwhile has its turn
constexpr sync::Micros kLeasePeriod = 10 * sync::kMillisecond;
constexpr sync::Micros kPosePeriod = sync::kSecond;
constexpr sync::Micros kHousekeepingPeriod = sync::kSecond;
constexpr sync::Micros kBusyPeriod = sync::kMillisecond;  // while the disk or a transfer is awaited
constexpr sync::Micros kIdlePeriod = 500 * sync::kMillisecond;

template <typename... Handlers>
struct Overloaded : Handlers... {
  using Handlers::operator()...;
};
template <typename... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;

/// Whether the stage of a connection allows this message; roles are checked where a message has its effect.
bool belongs(Stage stage, const sync::ControlMessage& message) {
  const bool hello = std::holds_alternative<sync::Hello>(message);
  const bool whileLoading = std::holds_alternative<sync::SceneRequest>(message) ||
                            std::holds_alternative<sync::Ready>(message) ||
                            std::holds_alternative<sync::DocumentRequest>(message) ||
                            std::holds_alternative<sync::Goodbye>(message);
  if (hello != (stage == Stage::hello)) return false;
  return stage != Stage::loading || whileLoading;
}

}  // namespace

/// Gives each event, message and timer to the class that it concerns.
class Session::Dispatcher {
 public:
  Dispatcher(const assets::Scene& scene, std::span<const std::byte> package, const SessionConfig& theConfig,
             sync::Transport& theTransport, Journal& theJournal, sync::RecordingWriter* recording)
      : config(theConfig),
        transport(theTransport),
        journal(theJournal),
        publisher(context, transport, journal, peers, recording),
        parts(scene, config.lease, context, publisher, sites),
        commands(context, peers, sites, publisher, parts),
        fanOut(scene, sync::wireFrame(scene.bounds), context, transport, peers, parts),
        relay(sync::wireFrame(scene.bounds), context, peers, parts, publisher, fanOut),
        transfer(package, config, context, transport, publisher),
        documents(config, context, transport, sites, publisher),
        presentations(scene.parts.size(), context, transport, peers, sites),
        chat(scene.parts.size(), context, transport, peers, sites, publisher),
        doubts(context, transport, peers, sites),
        admission({config, context, transport, peers, sites, publisher, parts, relay, transfer}),
        operators(context, peers, sites, publisher, admission) {}

  void restore(sync::Micros callerNow, std::int64_t unixNow);
  void step(sync::Micros callerNow, std::int64_t unixNow);
  sync::Micros nextDeadline() const;
  void shutDown();

  SessionConfig config;
  SessionContext context;
  sync::Transport& transport;
  Journal& journal;
  Peers peers;
  Sites sites;
  Publisher publisher;
  PartService parts;
  InstructorCommands commands;
  FanOut fanOut;
  StateRelay relay;
  SceneTransfer transfer;
  DocumentService documents;
  Presentations presentations;
  Chat chat;
  Doubts doubts;
  SiteAdmission admission;
  OperatorCommands operators;

 private:
  void receiveEvents();
  void onControl(Peer& peer, std::span<const std::byte> bytes);
  /// Charges the site's ControlBudget, and holds the site if that is spent.
  void charge(const Peer& peer, double messages);
  /// Hears again whoever may resume; parts from whoever was held for too long.
  void releaseHeld();
  void dispatch(Peer& peer, const sync::ControlMessage& message);
  void runTimers();

  sync::Micros offset_ = 0;  // session time minus the caller's clock
  sync::Micros nextLeases_ = 0, nextPoses_ = 0, nextHousekeeping_ = 0;  // session time
  bool eventsLeft_ = false;  // the last step did not get to the end of them
  bool shutDown_ = false;
};

void Session::Dispatcher::restore(sync::Micros callerNow, std::int64_t unixNow) {
  const JournalContents contents = journal.contents();
  offset_ = std::max<sync::Micros>(0, contents.sessionTime - callerNow);
  context.advance(callerNow + offset_, unixNow);
  parts.restore(contents.parts, contents.epochFloor);
  sites.restore(contents.sites, contents.lastSite, context.now());
  admission.restore(contents.nonces);
  documents.restore(contents);
  chat.restore(contents);
  admission.relist();
  if (!publisher.recording()) return;
  for (const auto& site : sites.listed()) publisher.record(sync::SiteChanged{site});
  for (const auto& part : parts.table().records()) publisher.record(sync::OwnershipChanged{part});
}

void Session::Dispatcher::step(sync::Micros callerNow, std::int64_t unixNow) {
  ASSERT(!shutDown_);
  context.advance(callerNow + offset_, unixNow);
  journal.noteTime(context.now());
  if (const auto abandoned = publisher.watchJournal()) parts.resume(*abandoned);
  receiveEvents();
  fanOut.flush();
  runTimers();
  commands.continueReset();
  parts.publishCoHolders();
  publisher.flush([&](sync::ConnectionId connection) { admission.onLost(connection, "refused"); });
  transfer.sendChunks(peers);
  documents.sendChunks(peers);
  presentations.flush();
  chat.flush();
  doubts.flush();
}

sync::Micros Session::Dispatcher::nextDeadline() const {
  const sync::Micros local = context.now() - offset_;
  if (eventsLeft_ || commands.resetting()) return local;
  if (publisher.waiting() || transfer.anyActive() || documents.anyActive()) return local + kBusyPeriod;
  if (peers.empty() && publisher.writable() && !parts.table().recovering(context.now()))
    return local + kIdlePeriod;
  return std::min({nextLeases_, nextPoses_, nextHousekeeping_, fanOut.nextDeadline()}) - offset_;
}

void Session::Dispatcher::shutDown() {
  shutDown_ = true;
  parts.keepPoses();
  for (const auto& [connection, peer] : peers) transport.close(connection);
  peers.clear();
}

void Session::Dispatcher::receiveEvents() {
  sync::TransportEvent event;
  for (int i = 0, controls = 0; i < kMaxEventsPerStep && controls < kMaxControlPerStep; ++i) {
    eventsLeft_ = transport.poll(event);
    if (!eventsLeft_) return;
    if (event.kind == sync::TransportEvent::Kind::connected) {
      admission.onConnected(event.connection);
      continue;
    }
    Peer* peer = peers.find(event.connection);
    if (peer == nullptr) continue;  // this side closed it
    switch (event.kind) {
      case sync::TransportEvent::Kind::control:
        ++controls;
        onControl(*peer, event.bytes);
        break;
      case sync::TransportEvent::Kind::state:
        relay.onDatagram(*peer, event.bytes);
        break;
      default:
        admission.onLost(event.connection, event.reason.empty() ? "connection closed" : event.reason);
        break;
    }
  }
}

void Session::Dispatcher::onControl(Peer& peer, std::span<const std::byte> bytes) {
  context.counts.received.countControl(bytes.size());
  const SiteId site = peer.site;
  charge(peer, 1.0 + static_cast<double>(bytes.size()) / ControlBudget::kBytesPerMessage);
  const std::uint64_t published = publisher.published();
  peer.lastReceived = context.now();
  const Result<sync::ControlMessage> message = sync::decodeControl(bytes);
  if (!message) {
    admission.refuse(peer, sync::Refusal::malformed, message.error().message);
    return;
  }
  const sync::ConnectionId connection = peer.connection;
  dispatch(peer, *message);
  if (const auto told = static_cast<double>(publisher.published() - published); told > 0.0 && site != kNoSite)
    if (const Peer* still = peers.find(connection)) charge(*still, told / ControlBudget::kToldPerMessage);
}

void Session::Dispatcher::charge(const Peer& peer, double messages) {
  if (peer.site == kNoSite) return;  // its one message is the Hello, which admission charges
  ControlBudget& budget = sites.at(peer.site).budget;
  if (budget.spend(context.now(), messages)) return;
  ++context.counts.holds;
  transport.hold(peer.connection, true);
  if (budget.drainNotice(context.now()))
    context.log.note(sites.nameOf(peer.site) + " sends more requests than a site may: it is slowed",
                     peer.site);
}

void Session::Dispatcher::releaseHeld() {
  std::vector<sync::ConnectionId> abusers;
  for (const auto& [connection, peer] : peers) {
    if (peer.site == kNoSite) continue;
    ControlBudget& budget = sites.at(peer.site).budget;
    if (!budget.held()) continue;
    if (budget.abused(context.now()))
      abusers.push_back(connection);
    else if (budget.mayResume(context.now()))
      transport.hold(connection, false);
  }
  for (const sync::ConnectionId connection : abusers)
    if (Peer* peer = peers.find(connection))
      admission.refuse(*peer, sync::Refusal::unexpectedMessage, "more requests than a site may send");
}

/// `peer` may be gone afterwards.
void Session::Dispatcher::dispatch(Peer& peer, const sync::ControlMessage& message) {
  if (!belongs(peer.stage, message)) {
    admission.refuse(peer, sync::Refusal::unexpectedMessage,
                     peer.stage == Stage::hello ? "the first message must be a hello"
                                                : "this message does not belong here");
    return;
  }
  const auto refuse = [&](const std::string& reason) {
    admission.refuse(peer, sync::Refusal::unexpectedMessage, reason);
  };
  std::visit(Overloaded{
                 [&](const sync::Hello& m) { admission.onHello(peer, m); },
                 [&](const sync::SceneRequest& m) {
                   if (const Status status = transfer.onRequest(peer, m); !status)
                     refuse(status.error().message);
                 },
                 [&](const sync::Ready&) {
                   peer.stage = Stage::ready;
                   peer.figures.since = context.now();
                 },
                 [&](const sync::Grab& m) { parts.onGrab(peer, m); },
                 [&](const sync::Release& m) { parts.onRelease(peer, m); },
                 [&](const sync::Reclaim& m) { parts.onReclaim(peer, m); },
                 [&](const sync::Revoke& m) { commands.onRevoke(peer, m); },
                 [&](const sync::ResetParts& m) { commands.onReset(peer, m); },
                 [&](const sync::Engage& m) { parts.onEngage(peer, m); },
                 [&](const sync::Disengage& m) { parts.onDisengage(peer, m); },
                 [&](const sync::PutEntry& m) { documents.onPut(peer, m); },
                 [&](const sync::DocumentRequest& m) { documents.onRequest(peer, m); },
                 [&](const sync::Presentation& m) { presentations.onPresentation(peer, m); },
                 [&](const sync::Say& m) { chat.onSay(peer, m); },
                 [&](const sync::Doubt& m) { doubts.onDoubt(peer, m); },
                 [&](const sync::Goodbye&) { admission.onGoodbye(peer); },
                 [&](const sync::SiteReport& m) {
                   if (!peer.figures.add(m, context.now())) ++context.counts.refusedReports;
                 },
                 [&](const auto&) { refuse("only the server says this"); },
             },
             message);
}

void Session::Dispatcher::runTimers() {
  const sync::Micros now = context.now();
  if (now >= nextLeases_) {
    nextLeases_ = now + kLeasePeriod;
    parts.expireLeases();
    releaseHeld();
  }
  if (now >= nextPoses_) {
    nextPoses_ = now + kPosePeriod;
    parts.keepPoses();
  }
  if (now >= nextHousekeeping_) {
    nextHousekeeping_ = now + kHousekeepingPeriod;
    admission.housekeeping();
    publisher.flushRecording();
  }
}

Session::Session(const assets::Scene& scene, std::span<const std::byte> package, const SessionConfig& config,
                 sync::Transport& transport, Journal& journal, sync::RecordingWriter* recording,
                 sync::Micros now, std::int64_t unixNow)
    : dispatcher_(std::make_unique<Dispatcher>(scene, package, config, transport, journal, recording)) {
  dispatcher_->restore(now, unixNow);
}

Session::~Session() = default;

std::string Session::makeToken(sync::Role role, std::int64_t expires) const {
  Ticket ticket;
  ticket.role = role;
  ticket.nonce = makeNonce(dispatcher_->config.key);
  ticket.expires = expires;
  return sign(ticket, dispatcher_->config.linkKey.value_or(dispatcher_->config.key));
}

Result<std::string> Session::kick(const std::string& who, bool ban) {
  return dispatcher_->operators.kick(who, ban);
}
Result<std::string> Session::revokeTicket(const std::string& who) {
  return dispatcher_->operators.revokeTicket(who);
}
std::string Session::replaceLinkKey(const SigningKey& key) {
  dispatcher_->config.linkKey = key;
  return dispatcher_->operators.linksRevoked();
}
std::string Session::replaceKeys(const SigningKey& ticketKey, const SigningKey& linkKey) {
  dispatcher_->config.key = ticketKey;
  dispatcher_->config.linkKey = linkKey;
  return dispatcher_->operators.keysRotated();
}
void Session::noteInvitation(sync::Role role) { dispatcher_->operators.invited(role); }

bool Session::knows(const sync::Knock& knock) const { return server::knows(dispatcher_->config.key, knock); }

void Session::step(sync::Micros now, std::int64_t unixNow) { dispatcher_->step(now, unixNow); }
sync::Micros Session::nextDeadline() const { return dispatcher_->nextDeadline(); }
sync::Micros Session::sessionTime() const { return dispatcher_->context.now(); }
void Session::shutDown() { dispatcher_->shutDown(); }
const std::vector<sync::SiteInfo>& Session::sites() const { return dispatcher_->sites.listed(); }
const sync::OwnershipTable& Session::ownership() const { return dispatcher_->parts.table(); }
const document::Document& Session::document() const { return dispatcher_->documents.content(); }
const SessionCounters& Session::counters() const { return dispatcher_->context.counts; }
SessionFigures Session::figures() const {
  SessionFigures figures;
  figures.counters = dispatcher_->context.counts;
  figures.transport = dispatcher_->transport.counters();
  figures.journalFailure = dispatcher_->journal.failure();
  figures.strangers = dispatcher_->peers.strangers();
  for (const auto& [connection, peer] : dispatcher_->peers)
    if (peer.site != kNoSite)
      figures.sites.push_back({peer.site, peer.role, dispatcher_->sites.at(peer.site).info.name, peer.figures,
                               dispatcher_->doubts.about(peer.site)});
  return figures;
}
std::vector<LogLine> Session::drainLog() { return dispatcher_->context.log.drain(); }
std::vector<AuditEntry> Session::drainAudit() {
  return dispatcher_->context.audit.drain(dispatcher_->context.now());
}
std::vector<sync::Role> Session::drainUsedTokens() { return dispatcher_->admission.drainUsedTokens(); }

}  // namespace tandem::server
