#include "client/session/server_connection.h"

#include <algorithm>
#include <type_traits>

#include "assets/base/assert.h"
#include "sync/wire/recording.h"

namespace tandem::client {

using namespace sync;

namespace {

template <typename Receiver, typename Message>
concept Handles = requires(Receiver& receiver, Message& message) {
  receiver.handle(message);
};

/// How long a site that enters waits for any message: a chunk of the scene takes seconds on a slow line.
constexpr Micros kEntryPatience = 15 * kSecond;

/// Whether the receiver accepts the message; a handler that returns nothing always does.
template <typename Receiver, typename Message>
bool handleBy(Receiver& receiver, Message& message) {
  if constexpr (std::is_void_v<decltype(receiver.handle(message))>) {
    receiver.handle(message);
    return true;
  } else {
    return receiver.handle(message);
  }
}

std::string inMebibytes(std::uint64_t bytes) { return std::to_string(bytes >> 20); }

}  // namespace

ServerConnection::ServerConnection(ConnectionOptions options, Connector connector)
    : options_(std::move(options)),
      connector_(std::move(connector)),
      backoff_(options_.retryFirst, options_.retryLongest),
      pings_(options_.pingInterval, clock_),
      document_(people_, sender_),
      presentations_(people_, sender_),
      doubts_(options_.doubts, sender_, watchers_),
      requests_(people_, sender_, watchers_) {
  watchers_.undo = &document_;
}

ServerConnection::~ServerConnection() = default;

void ServerConnection::step(Micros now) {
  clock_.advance(now);
  if (stage_ == Stage::ended) {
    if (transport_) receiveEvents();  // lets queued messages leave
    return;
  }
  if (!transport_ && backoff_.due(now)) connect();
  if (transport_) receiveEvents();
  // Nothing is closed in good order with a server that does not answer: that would be waited for.
  if (transport_ && serverIsSilent()) disconnected("the server does not answer");
  if (!transport_ || stage_ == Stage::connecting) return;
  if (inScene_) {
    inScene_->receiving.publishTimeBase();
    inScene_->events.flush();
    if (stage_ == Stage::ready) stepInSession();
  }
  sender_.flush();
}

void ServerConnection::stepInSession() {
  ASSERT(inScene_ != nullptr);
  requests_.sendIntents();
  document_.step(clock_.now());
  presentations_.step(clock_.now());
  if (reports_.due(clock_.now())) sender_.send(reports_.next(clock_.now(), pings_.roundTrip_ms()));
  inScene_->receiving.drainDoubts();
  inScene_->ownership.exchangeLinks();
  if (inScene_->ownership.linkPacketIsNear()) return;
  if (pings_.due())
    sender_.sendState(pings_.next(inScene_->publishing.updatesOfConnection()), inScene_->ownership.frame());
  inScene_->receiving.acknowledge();
  inScene_->publishing.publish(worldFromCamera_);
}

// ---- connecting ----

void ServerConnection::connect() {
  Result<std::unique_ptr<Transport>> made = connector_();
  if (!made) {
    reason_ = made.error().message;
    backoff_.failed(clock_.now());
    return;
  }
  transport_ = std::move(*made);
  ASSERT(transport_ != nullptr);
  sender_.attach(transport_.get());
}

void ServerConnection::disconnected(const std::string& reason) {
  sender_.attach(nullptr);
  transport_.reset();
  if (stage_ == Stage::ended) return;
  if (stage_ == Stage::ready) {
    people_.notice(Notice::Level::warning, "connection lost: " + reason);
    ++reconnects_;
    if (watchers_.observer) watchers_.observer->onConnection(false);
    requests_.connectionLost();
    document_.connectionLost();
    presentations_.connectionLost();
  }
  people_.connectionLost();
  reason_ = reason;
  enter(Stage::connecting);
  backoff_.failed(clock_.now());
}

/// A server that hangs keeps its connections open: without this, a site would wait for it for ever.
bool ServerConnection::serverIsSilent() const {
  if (stage_ == Stage::ready) return pings_.serverIsSilent();
  const bool awaited = stage_ == Stage::entering || stage_ == Stage::transferring;
  return awaited && clock_.now() - receivedAt_ > kEntryPatience;
}

void ServerConnection::sendHello() {
  enter(Stage::entering);
  sender_.send(Hello{kProtocolVersion, !resumeTicket_.empty(), credential(), options_.name, options_.colour});
}

void ServerConnection::leave() {
  if (transport_ && stage_ != Stage::connecting) {
    sender_.send(Goodbye{});
    transport_->close(0);
  }
  enter(Stage::ended);
  reason_ = "left";
}

/// Chunks of the scene are expected only in the stage `transferring`.
void ServerConnection::enter(Stage stage) {
  if (stage != Stage::transferring) fetch_.stop();
  stage_ = stage;
}

// ---- receiving ----

void ServerConnection::receiveEvents() {
  TransportEvent event;
  while (transport_ && transport_->poll(event)) {
    receivedAt_ = clock_.now();
    // Whoever has left answers nothing more: a late Welcome or denial must not begin anything.
    if (stage_ == Stage::ended && event.kind != TransportEvent::Kind::closed) continue;
    switch (event.kind) {
      case TransportEvent::Kind::connected:
        sendHello();
        break;
      case TransportEvent::Kind::control:
        received_.countControl(event.bytes.size());
        receiveControl(event.bytes);
        break;
      case TransportEvent::Kind::state:
        do {
          receiveState(popMessage(event.bytes));
        } while (!event.bytes.empty());
        break;
      case TransportEvent::Kind::closed:
        disconnected(event.reason);
        break;
    }
  }
}

/// Passes the message to the class that has a handler for it; false if it is not allowed at this point.
template <typename Message>
bool ServerConnection::route(Message& message) {
  if constexpr (requires { this->handle(message); }) {
    handle(message);
    return true;
  } else if constexpr (Handles<Participants, Message>) {
    return handleBy(people_, message);
  } else if constexpr (Handles<SceneFetch, Message>) {
    return handleBy(fetch_, message);
  } else if constexpr (Handles<SessionDocument, Message>) {
    return handleBy(document_, message);
  } else if constexpr (Handles<Presentations, Message>) {
    return handleBy(presentations_, message);
  } else if constexpr (Handles<PartRequests, Message>) {
    return handleBy(requests_, message);
  } else {
    if constexpr (requires { this->handleBeforeScene(message); })
      if (!inScene_) return handleBeforeScene(message);
    if constexpr (Handles<PartOwnership, Message>) return handleBy(inScene_->ownership, message);
    if constexpr (Handles<StateReceiving, Message>) return handleBy(inScene_->receiving, message);
    if constexpr (Handles<StatePublishing, Message>) return handleBy(inScene_->publishing, message);
    return false;  // a message that only a site sends
  }
}

void ServerConnection::receiveControl(std::span<const std::byte> bytes) {
  Result<ControlMessage> decoded = decodeControl(bytes);
  if (!decoded) {
    ++malformed_;
    transport_->close(0);
    disconnected("the server sent something that is not of this protocol: " + decoded.error().message);
    return;
  }
  // A Welcome and a NewTicket hold a credential, and the scene is found by its hash.
  if (watchers_.recording && !std::holds_alternative<SceneChunk>(*decoded) &&
      !std::holds_alternative<Welcome>(*decoded) && !std::holds_alternative<NewTicket>(*decoded))
    watchers_.recording->write(clock_.time(), *decoded);
  if (!std::visit([this](auto& message) { return route(message); }, *decoded)) ++malformed_;
  if (stage_ == Stage::transferring && fetch_.complete()) enter(Stage::haveScene);
}

void ServerConnection::receiveState(std::span<const std::byte> bytes) {
  received_.countState(bytes);
  if (stage_ != Stage::ready) return;  // before the scene is ready, states have no use
  ASSERT(inScene_ != nullptr);
  const StateReceiver::Outcome outcome = inScene_->receiving.decode(bytes);
  if (outcome == StateReceiver::Outcome::malformed) ++malformed_;
  if (outcome != StateReceiver::Outcome::decoded) return;
  std::visit([this](const auto& message) { static_cast<void>(route(message)); },
             inScene_->receiving.message());
}

void ServerConnection::handle(Welcome& message) {
  if (inScene_ && message.sceneHash != welcome_.sceneHash) {
    enter(Stage::ended);
    reason_ = "the server now holds another scene";
    transport_->close(0);
    return;
  }
  if (message.sceneBytes > options_.maxSceneBytes) {
    enter(Stage::ended);
    reason_ = "the server's scene has " + inMebibytes(message.sceneBytes) + " MiB; this site takes " +
              inMebibytes(options_.maxSceneBytes) + " (--max-scene)";
    transport_->close(0);
    return;
  }
  if (!message.voiceUrl.empty() && message.voiceUrl != welcome_.voiceUrl)
    people_.notice(Notice::Level::info, "People talk at " + message.voiceUrl);
  welcome_ = std::move(message);
  resumeTicket_ = welcome_.resumeTicket;
  options_.lease.lease = welcome_.lease;
  backoff_.succeeded();
  clock_.reset();
  people_.reset(welcome_.site, welcome_.sites);
  fetch_.expect(welcome_.sceneBytes);
  if (inScene_)
    enterReady();
  else
    enter(Stage::needScene);
}

void ServerConnection::handle(const Refused& message) {
  // The site does not try again with a credential that the server refused.
  reason_ = message.reason;
  enter(Stage::ended);
  people_.notice(Notice::Level::error, "refused: " + message.reason);
}

void ServerConnection::handle(NewTicket& message) { resumeTicket_ = std::move(message.resumeTicket); }

void ServerConnection::handle(const SiteLeft& message) {
  people_.handle(message);
  presentations_.forget(message.site);
  doubts_.forget(message.site);
  if (inScene_) inScene_->receiving.forget(message.site);
}

void ServerConnection::handle(const Pong& message) {
  if (!pings_.observe(message)) return;
  inScene_->ownership.view().renewed(message.siteTime, clock_.now());
  requests_.reclaim(false);
  requests_.releaseAgain(clock_.now());
}

/// Keeps the Welcome's list of parts up to date while the scene is made ready, which may take minutes.
bool ServerConnection::handleBeforeScene(const OwnershipChanged& message) {
  if (stage_ < Stage::needScene || stage_ > Stage::haveScene) return false;
  const auto known = std::find_if(welcome_.parts.begin(), welcome_.parts.end(),
                                  [&](const PartRecord& part) { return part.part == message.part.part; });
  if (known != welcome_.parts.end())
    *known = message.part;
  else if (welcome_.parts.size() < kMaxParts)
    welcome_.parts.push_back(message.part);
  return true;
}

/// Ignored: the server sends the co-holders of every part to a site that becomes ready.
bool ServerConnection::handleBeforeScene(const MembersChanged&) { return true; }

// ---- into the session ----

void ServerConnection::skipTransfer() {
  if (stage_ == Stage::needScene) enter(Stage::haveScene);
}

void ServerConnection::startTransfer(std::vector<std::byte> have) {
  if (stage_ != Stage::needScene) return;
  const SceneRequest request = fetch_.start(std::move(have));
  enter(fetch_.complete() ? Stage::haveScene : Stage::transferring);
  if (stage_ == Stage::transferring) sender_.send(request);
}

ServerConnection::InScene::InScene(ServerConnection& connection, const assets::Scene& scene,
                                   Exchange& exchange)
    : events(exchange),
      ownership(scene, connection.options_.lease, connection.options_.rates.max, exchange, events,
                connection.sender_, connection.clock_, connection.watchers_),
      receiving(ownership, connection.people_, connection.doubts_, exchange, events, connection.sender_,
                connection.clock_, connection.watchers_),
      publishing(ownership, connection.people_, exchange, connection.sender_, connection.clock_,
                 connection.watchers_, connection.options_.rates) {}

void ServerConnection::sceneReady(const assets::Scene& scene, Exchange& exchange) {
  ASSERT(inScene_ == nullptr);
  inScene_ = std::make_unique<InScene>(*this, scene, exchange);
  requests_.sceneReady(inScene_->ownership, exchange, inScene_->events);
  document_.sceneReady(scene, inScene_->events);
  doubts_.sceneReady(scene);
  if (stage_ == Stage::haveScene) enterReady();
}

void ServerConnection::enterReady() {
  ASSERT(inScene_ != nullptr && transport_ != nullptr);
  PartOwnership& ownership = inScene_->ownership;
  ownership.enter(welcome_.site);
  enter(Stage::ready);
  pings_.reset();
  reports_.reset(clock_.now());
  inScene_->publishing.reset();
  inScene_->receiving.reset();
  inScene_->receiving.publishTimeBase();
  if (watchers_.observer) watchers_.observer->onConnection(true);
  sender_.send(Ready{});
  document_.enter();
  presentations_.enter();
  doubts_.enter();
  recordBeginning();
  requests_.reclaim(true);
  for (const PartRecord& record : welcome_.parts)
    if (ownership.exists(record.part)) ownership.apply(record);
  requests_.engageAgain();
}

/// A recording begins with the participants and the records of the parts, not with the Welcome, which holds a
/// credential.
void ServerConnection::recordBeginning() {
  if (!watchers_.recording) return;
  for (const SiteView& site : people_.sites())
    watchers_.recording->write(welcome_.sessionTime, SiteChanged{site.info});
  for (const PartRecord& record : welcome_.parts)
    watchers_.recording->write(welcome_.sessionTime, OwnershipChanged{record});
}

void ServerConnection::revoke(PartId part) {
  if (stage_ == Stage::ready) requests_.revoke(part);
}

void ServerConnection::resetParts() {
  if (stage_ == Stage::ready) requests_.resetParts();
}

// ---- for reports ----

SiteId ServerConnection::owner(PartId part) const {
  return inScene_ ? inScene_->ownership.view().part(part).owner : kNoSite;
}

std::span<const SiteId> ServerConnection::coHolders(PartId part) const {
  if (!inScene_) return {};
  return inScene_->ownership.view().coHolders(part).sites;
}

ConnectionStatistics ServerConnection::statistics() const {
  ConnectionStatistics statistics;
  statistics.roundTrip_ms = pings_.roundTrip_ms();
  statistics.lossUp = pings_.lossUp();
  statistics.malformed = malformed_;
  statistics.reconnects = reconnects_;
  statistics.sent = sender_.sent();
  statistics.received = received_;
  if (transport_) statistics.transport = transport_->counters();
  if (!inScene_) return statistics;
  const StateReceiving& receiving = inScene_->receiving;
  statistics.lossDown = receiving.loss();
  statistics.playOut_ms = toSeconds(receiving.playOutDelay()) * 1e3;
  statistics.receivedUpdates = receiving.counts().updates;
  statistics.droppedStates = receiving.counts().droppedStates + inScene_->events.droppedStates();
  statistics.droppedBaselines = receiving.counts().droppedBaselines;
  statistics.sentUpdates = inScene_->publishing.updates();
  return statistics;
}

}  // namespace tandem::client
