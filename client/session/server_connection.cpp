#include "client/session/server_connection.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace tandem::client {

using namespace sync;

namespace {

constexpr int kMostQuestions = 4;  // for a part that comes and goes: then the hand is denied it
constexpr Micros kMostPatience = 15 * kMillisecond;  // that a link's packet is waited for

}  // namespace

ServerConnection::ServerConnection(ConnectionOptions options, Connector connector)
    : options_(std::move(options)), connector_(std::move(connector)), retryDelay_(options_.retryFirst) {
  offered_.reserve(haptics::kMaxOwnedParts);
  bytes_.reserve(kMaxStateBytes);
}

ServerConnection::~ServerConnection() = default;

void ServerConnection::step(Micros now) {
  now_ = now;
  if (stage_ == Stage::ended) {
    if (transport_) takeEvents(now);  // lets a farewell leave
    return;
  }
  if (!transport_ && now >= retryAt_) connect(now);
  if (transport_) takeEvents(now);
  if (!transport_ || stage_ == Stage::connecting) return;
  if (exchange_) {
    publishTimeBase(now);
    flushEvents();
    if (stage_ == Stage::ready) {
      sendIntents();
      exchangeLinks(now);
      if (!waitsForLink(now)) tell(now);
    }
  }
  unsent_.flush([this](auto datagram) { transport_->sendState(0, datagram); });
}

/// What is no link's goes along with the links' packets while there are any: it costs no datagram of its own then.
bool ServerConnection::waitsForLink(Micros now) const {
  const auto patience = static_cast<Micros>(1.5e6 / options_.rates.most);
  return patience <= kMostPatience && now != linkSentAt_ && now - linkSentAt_ < patience;
}

void ServerConnection::tell(Micros now) {
  if (now >= nextPing_) {
    nextPing_ = now + options_.pingInterval;
    outgoingMessage_ = Ping{++pingSequence_, now};
    updatesAtPing_ = updatesSent_;
    sendState(outgoingMessage_);
  }
  acknowledge(now);
  publish(now);
}

// ---- connection ----

void ServerConnection::connect(Micros now) {
  Result<std::unique_ptr<Transport>> made = connector_();
  if (!made) {
    reason_ = made.error().message;
    retryAt_ = now + retryDelay_;
    retryDelay_ = std::min(2 * retryDelay_, options_.retryLongest);
    return;
  }
  transport_ = std::move(*made);
}

void ServerConnection::disconnected(const std::string& reason, Micros now) {
  transport_.reset();
  if (stage_ == Stage::ended) return;
  if (stage_ == Stage::ready) {
    notice(Notice::Level::warning, "connection lost: " + reason);
    ++statistics_.reconnects;
    if (observer_) observer_->onConnection(false);
    NetworkEvent event;
    event.kind = NetworkEvent::Kind::lost;
    ++lost_;
    pushEvent(event);
  }
  for (SiteView& site : sites_) site.info.connected = site.self;
  openGrabs_.clear();
  reason_ = reason;
  stage_ = Stage::connecting;
  retryAt_ = now + retryDelay_;
  retryDelay_ = std::min(2 * retryDelay_, options_.retryLongest);
}

void ServerConnection::takeEvents(Micros now) {
  TransportEvent event;
  while (transport_ && transport_->poll(event)) {
    switch (event.kind) {
      case TransportEvent::Kind::connected: {
        stage_ = Stage::entering;
        const bool resume = !resumeTicket_.empty();
        send(Hello{kProtocolVersion, resume, resume ? resumeTicket_ : options_.token, options_.name,
                   options_.colour});
        break;
      }
      case TransportEvent::Kind::control:
        statistics_.received.countControl(event.bytes.size());
        takeControl(event.bytes, now);
        break;
      case TransportEvent::Kind::state:
        do {
          takeState(takeMessage(event.bytes), now);
        } while (!event.bytes.empty());
        break;
      case TransportEvent::Kind::closed:
        disconnected(event.reason, now);
        break;
    }
  }
}

void ServerConnection::takeControl(std::span<const std::byte> bytes, Micros now) {
  Result<ControlMessage> decoded = decodeControl(bytes);
  if (!decoded) {
    ++statistics_.malformed;
    transport_->close(0);
    disconnected("the server sent something that is not of this protocol: " + decoded.error().message, now);
    return;
  }
  if (recording_ && !std::holds_alternative<SceneChunk>(*decoded) &&
      !std::holds_alternative<Welcome>(*decoded))
    recording_->write(sessionTime(now), *decoded);
  std::visit([this](auto& message) { take(message); }, *decoded);
}

template <typename Unexpected>
void ServerConnection::take(Unexpected&) {
  ++statistics_.malformed;
}

void ServerConnection::take(Welcome& message) {
  if (scene_ && message.sceneHash != welcome_.sceneHash) {
    stage_ = Stage::ended;
    reason_ = "the server now holds another scene";
    transport_->close(0);
    return;
  }
  welcome_ = std::move(message);
  resumeTicket_ = welcome_.resumeTicket;
  options_.lease.lease = welcome_.lease;
  retryDelay_ = options_.retryFirst;
  clock_.reset();
  sites_.clear();
  for (const SiteInfo& info : welcome_.sites) sites_.push_back({info, info.site == welcome_.site, false, {}});
  if (scene_)
    enterReady();
  else
    stage_ = Stage::needScene;
}

void ServerConnection::take(Refused& message) {
  // A ticket of a server that forgot this site is no reason to try for ever.
  reason_ = message.reason;
  stage_ = Stage::ended;
  notice(Notice::Level::error, "refused: " + message.reason);
}

// ---- scene ----

void ServerConnection::skipTransfer() {
  if (stage_ == Stage::needScene) stage_ = Stage::haveScene;
}

void ServerConnection::startTransfer(std::vector<std::byte> have) {
  if (stage_ != Stage::needScene) return;
  package_ = std::move(have);
  if (package_.size() > welcome_.sceneBytes) package_.clear();
  package_.reserve(welcome_.sceneBytes);
  stage_ = package_.size() == welcome_.sceneBytes ? Stage::haveScene : Stage::transferring;
  if (stage_ == Stage::transferring) send(SceneRequest{package_.size()});
}

double ServerConnection::transferProgress() const {
  return welcome_.sceneBytes == 0
             ? 0.0
             : static_cast<double>(package_.size()) / static_cast<double>(welcome_.sceneBytes);
}

void ServerConnection::take(SceneChunk& message) {
  if (stage_ != Stage::transferring || message.offset != package_.size() ||
      message.bytes.size() > welcome_.sceneBytes - package_.size()) {
    ++statistics_.malformed;
    return;
  }
  const auto* begin = reinterpret_cast<const std::byte*>(message.bytes.data());
  package_.insert(package_.end(), begin, begin + message.bytes.size());
  if (package_.size() == welcome_.sceneBytes) stage_ = Stage::haveScene;
}

void ServerConnection::sceneReady(const assets::Scene& scene, Exchange& exchange) {
  scene_ = &scene;
  exchange_ = &exchange;
  frame_ = wireFrame(scene.bounds);
  ownership_.emplace(scene.parts.size(), options_.lease);
  givenBack_.assign(scene.parts.size(), 0);
  publisher_.emplace(scene, *frame_, options_.rates);
  links_.emplace(scene, 1.0 / options_.rates.most);
  if (stage_ == Stage::haveScene) enterReady();
}

void ServerConnection::enterReady() {
  ownership_->setSelf(welcome_.site);
  ownership_->forgetMembers();
  stage_ = Stage::ready;
  nextPing_ = now_;
  publisher_->reset();
  // The server counts anew with each connection.
  updatesSent_ = updatesAtPing_ = expectedUpdates_ = heardUpdates_ = 0;
  lastSequence_.clear();
  statesOut_.reset();
  statesIn_.reset();
  lossUp_ = lossDown_ = {};
  statistics_.roundTrip_ms = statistics_.lossUp = statistics_.lossDown = 0.0;
  publishTimeBase(now_);
  if (observer_) observer_->onConnection(true);
  send(Ready{});
  recordBeginning();
  reclaimParts(true);
  for (const PartRecord& record : welcome_.parts)
    if (record.part < scene_->parts.size()) applyOwnership(record);
  shareAgain();
}

/// A recording begins with who is here and how things stand by now; the Welcome itself holds a credential.
void ServerConnection::recordBeginning() {
  if (!recording_) return;
  for (const SiteView& site : sites_) recording_->write(welcome_.sessionTime, SiteChanged{site.info});
  for (const PartRecord& record : welcome_.parts)
    recording_->write(welcome_.sessionTime, OwnershipChanged{record});
}

/// Parts that were this site's before an outage, or before its lease lapsed, are asked for again in their old
/// epoch.
void ServerConnection::reclaimParts(bool all) {
  hand_ = exchange_->output.latest();
  for (int i = 0; i < hand_.tick.ownedCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const haptics::OwnedPart& part = hand_.tick.owned[index];
    if (hand_.ownedEpoch[index] == 0 || !(all || ownership_->needsReclaim(part.part))) continue;
    if (std::any_of(openGrabs_.begin(), openGrabs_.end(), [&](const OpenGrab& grab) {
          return grab.kind == OpenGrab::Kind::reclaim && grab.part == part.part;
        }))
      continue;
    send(Reclaim{open(part.part, OpenGrab::Kind::reclaim), part.part, hand_.ownedEpoch[index],
                 part.worldFromPart});
  }
}

// ---- ownership ----

void ServerConnection::applyOwnership(const PartRecord& record) {
  if (!ownership_->apply(record)) return;
  if (observer_) observer_->onOwnership(record);
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::ownership;
  event.record = record;
  pushEvent(event);
  followLinks(record.part);
}

/// Lines of a part as ownership now has it.
void ServerConnection::followLinks(PartId part) {
  links_->follow(*ownership_, part, sessionTime(now_));
  pushOrders();
}

void ServerConnection::pushOrders() {
  for (const NetworkEvent& order : links_->takeEvents()) pushEvent(order);
}

void ServerConnection::applyMembers(const MemberRecord& members) {
  if (!ownership_->apply(members)) return;
  followLinks(members.part);
}

/// While the scene is made ready, which may take minutes, the Welcome's list is kept up to date.
void ServerConnection::rememberOwnership(const PartRecord& record) {
  const auto known = std::find_if(welcome_.parts.begin(), welcome_.parts.end(),
                                  [&](const PartRecord& part) { return part.part == record.part; });
  if (known != welcome_.parts.end())
    *known = record;
  else if (welcome_.parts.size() < kMaxParts)
    welcome_.parts.push_back(record);
}

void ServerConnection::take(OwnershipChanged& message) {
  if (!scene_ && stage_ >= Stage::needScene && stage_ <= Stage::haveScene) {
    rememberOwnership(message.part);
    return;
  }
  if (!scene_ || message.part.part >= scene_->parts.size()) {
    ++statistics_.malformed;
    return;
  }
  applyOwnership(message.part);
}

/// A question that is about to be asked.
RequestId ServerConnection::open(PartId part, OpenGrab::Kind kind, int before) {
  openGrabs_.push_back({ownership_->lapses(), nextRequest_, part, kind, before});
  return nextRequest_++;
}

/// The question that a reply answers, taken off the list; nothing if it answers none.
std::optional<ServerConnection::OpenGrab> ServerConnection::closeGrab(RequestId request, PartId part) {
  const auto found = std::find_if(openGrabs_.begin(), openGrabs_.end(),
                                  [&](const auto& entry) { return entry.request == request; });
  if (found == openGrabs_.end() || !scene_ || part >= scene_->parts.size() || found->part != part) {
    ++statistics_.malformed;
    return std::nullopt;
  }
  const OpenGrab closed = *found;
  openGrabs_.erase(found);
  return closed;
}

void ServerConnection::take(GrabReply& message) {
  const std::optional<OpenGrab> asked = closeGrab(message.request, message.part.part);
  if (!asked) return;
  const bool reclaim = asked->kind == OpenGrab::Kind::reclaim;
  if (observer_) observer_->onGrabReply(message);
  applyOwnership(message.part);
  if (message.denial == Denial::none) {
    if (asked->lapses == ownership_->lapses()) ownership_->confirmed(message.part.part, message.part.epoch);
  } else if (message.denial == Denial::ownedByOther && !reclaim && asked->before < kMostQuestions &&
             mayShare(message.part.part)) {
    askFor(message.part.part, asked->before + 1);
  } else {
    tellDenial(message, reclaim);
  }
}

void ServerConnection::take(EngageReply& message) {
  const PartId part = message.members.part;
  const std::optional<OpenGrab> asked = closeGrab(message.request, part);
  if (!asked) return;
  applyMembers(message.members);
  if (asked->kind == OpenGrab::Kind::leave) return;
  if (message.denial == Denial::none) {
    if (asked->lapses == ownership_->lapses()) ownership_->engagementConfirmed(part);
    notice(Notice::Level::info, partName(part) + " is shared with " + siteName(owner(part)));
  } else if (message.denial == Denial::notOwned && asked->before < kMostQuestions) {
    askFor(part, asked->before + 1);
  } else {
    tellDenied(ownership_->part(part), toString(message.denial));
  }
}

void ServerConnection::take(MembersChanged& message) {
  if (scene_ && message.members.part < scene_->parts.size()) applyMembers(message.members);
}

/// Whether this site may hold a part together with the one that owns it.
bool ServerConnection::mayShare(PartId part) const {
  const SiteId other = owner(part);
  return other != kNoSite && other != welcome_.site && assets::controlOf(*scene_, part) == nullptr;
}

/// To own a part, or to share it where another site owns it; as it came and went after `before` earlier questions.
void ServerConnection::askFor(PartId part, int before) {
  // It has been passed on to this site meanwhile; but what was given back is asked for anew before the answer to that.
  if (ownership_->owns(part) && givenBack_[part] != ownership_->part(part).epoch) return;
  const bool share = mayShare(part);
  const RequestId request = open(part, share ? OpenGrab::Kind::engage : OpenGrab::Kind::grab, before);
  if (share) return send(Engage{request, part});
  const Grab grab{request, part};
  if (observer_) observer_->onGrab(grab);
  send(grab);
}

/// Parts that this site shared before an outage: the server may have been started anew, and knows of none.
void ServerConnection::shareAgain() {
  for (int i = 0; i < hand_.tick.ownedCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    if (hand_.ownedEpoch[index] == 0) askFor(hand_.tick.owned[index].part, 0);
  }
}

void ServerConnection::tellDenial(const GrabReply& reply, bool reclaim) {
  const bool other = reply.part.owner != kNoSite && reply.part.owner != welcome_.site;
  if (!reclaim)
    tellDenied(reply.part, reply.denial == Denial::ownedByOther ? siteName(reply.part.owner) + " holds it"
                                                                : toString(reply.denial));
  else if (other)
    notice(Notice::Level::warning,
           partName(reply.part.part) + " now belongs to " + siteName(reply.part.owner));
}

void ServerConnection::tellDenied(const PartRecord& record, const std::string& why) {
  notice(Notice::Level::warning, partName(record.part) + " cannot be taken: " + why);
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::denied;
  event.record = record;
  pushEvent(event);
}

void ServerConnection::take(ReleaseReply& message) {
  if (scene_ && message.part.part < scene_->parts.size()) applyOwnership(message.part);
}

void ServerConnection::take(CommandReply& message) {
  if (!message.done) notice(Notice::Level::warning, "not done: " + message.reason);
}

void ServerConnection::revoke(PartId part) {
  if (stage_ == Stage::ready) send(Revoke{nextRequest_++, part});
}

void ServerConnection::resetParts() {
  if (stage_ == Stage::ready) send(ResetParts{nextRequest_++});
}

void ServerConnection::leave() {
  if (transport_ && stage_ != Stage::connecting) {
    send(Goodbye{});
    transport_->close(0);
  }
  stage_ = Stage::ended;
  reason_ = "left";
}

// ---- people ----

void ServerConnection::take(SiteChanged& message) {
  if (SiteView* known = siteView(message.site.site)) {
    if (known->info.connected && !message.site.connected)
      notice(Notice::Level::info, message.site.name + " lost the connection");
    known->info = message.site;
    return;
  }
  if (message.site.site != welcome_.site) notice(Notice::Level::info, message.site.name + " joined");
  sites_.push_back({message.site, message.site.site == welcome_.site, false, {}});
}

void ServerConnection::take(SiteLeft& message) {
  notice(Notice::Level::info, siteName(message.site) + " left");
  std::erase_if(sites_, [&](const SiteView& site) { return site.info.site == message.site; });
  statesIn_.forget(message.site);
}

SiteView* ServerConnection::siteView(SiteId site) {
  for (SiteView& view : sites_)
    if (view.info.site == site) return &view;
  return nullptr;
}

std::string ServerConnection::siteName(SiteId site) const {
  for (const SiteView& view : sites_)
    if (view.info.site == site) return view.info.name;
  return "somebody";
}

std::string ServerConnection::partName(PartId part) const {
  return scene_ && part < scene_->parts.size() ? scene_->parts[part].name : "part " + std::to_string(part);
}

void ServerConnection::notice(Notice::Level level, std::string text) {
  notices_.push_back({level, 0.0, std::move(text)});
}

std::vector<Notice> ServerConnection::takeNotices() { return std::exchange(notices_, {}); }

// ---- state ----

void ServerConnection::takeState(std::span<const std::byte> bytes, Micros now) {
  statistics_.received.countState(bytes);
  if (!frame_ || stage_ != Stage::ready) return;  // before the scene stands, nothing can be done with it
  const StateReceiver::Outcome outcome = statesIn_.decode(bytes, *frame_, incoming_);
  if (outcome != StateReceiver::Outcome::taken) {
    ++(outcome == StateReceiver::Outcome::malformed ? statistics_.malformed : statistics_.droppedBaselines);
    return;
  }
  if (const auto* pong = std::get_if<Pong>(&incoming_)) {
    if (pong->siteTime > now || now - pong->siteTime > 10 * kSecond) return;
    clock_.observe(pong->siteTime, pong->serverTime, now);
    ownership_->renewed(pong->siteTime, now);
    reclaimParts(false);
    statistics_.roundTrip_ms = toSeconds(clock_.lastRoundTrip()) * 1e3;
    // Only the newest ping's count stands beside the newest count of sent updates.
    if (pong->sequence == pingSequence_) {
      lossUp_.observe(updatesAtPing_, pong->received);
      statistics_.lossUp = lossUp_.loss();
    }
  } else if (const auto* update = std::get_if<StateUpdate>(&incoming_)) {
    takeUpdate(*update, now);
  } else if (const auto* link = std::get_if<LinkUpdate>(&incoming_)) {
    takeLink(*link, now);
  } else if (const auto* ack = std::get_if<StateAck>(&incoming_)) {
    statesOut_.acknowledged(*ack);
  }
}

/// The server may tell what follows against what has come.
void ServerConnection::acknowledge(Micros now) {
  if (const std::optional<StateAck> ack = statesIn_.takeAck(now)) sendState(*ack);
}

void ServerConnection::takeLink(const LinkUpdate& update, Micros now) {
  if (!clock_.known()) return;
  const auto packet = links_->receive(update, *ownership_, sessionTime(now));
  pushOrders();
  if (packet) static_cast<void>(exchange_->linksIn.push(*packet));  // a full ring is a hand that stands still
}

/// The server numbers what it sends to this site in one row, whosever states they are.
void ServerConnection::countDown(std::uint32_t sequence) {
  if (heardUpdates_++ == 0) newestUpdate_ = sequence - 1;
  const auto ahead = static_cast<std::int32_t>(sequence - newestUpdate_);
  if (ahead > 0) {
    expectedUpdates_ += static_cast<std::uint64_t>(ahead);
    newestUpdate_ = sequence;
  }
  lossDown_.observe(expectedUpdates_, heardUpdates_);
  statistics_.lossDown = lossDown_.loss();
}

void ServerConnection::takeUpdate(const StateUpdate& update, Micros now) {
  ++statistics_.receivedUpdates;
  countDown(update.sequence);
  auto last = std::find_if(lastSequence_.begin(), lastSequence_.end(),
                           [&](const auto& entry) { return entry.first == update.site; });
  if (last == lastSequence_.end()) last = lastSequence_.insert(last, {update.site, update.sequence - 1});
  const auto ahead = static_cast<std::int32_t>(update.sequence - last->second);
  if (ahead > 0) {
    last->second = update.sequence;
    if (SiteView* site = siteView(update.site); site != nullptr && update.presenceKnown) {
      site->presence = update.presence;
      site->seen = true;
    }
  }
  if (recording_ && update.presenceKnown) recording_->write(update.time, incoming_);
  if (!clock_.known()) return;
  playOutDelay_.observe(update.time, clock_.sessionTime(now));
  links_->heard(update.site, clock_.sessionTime(now) - update.time);
  for (const PartState& state : update.parts) {
    if (ownership_->accept(update.site, state) != OwnershipView::Verdict::accepted) {
      ++statistics_.droppedStates;
      continue;
    }
    if (observer_) observer_->onAccepted(update.site, state);
    NetworkEvent event;
    event.kind = NetworkEvent::Kind::state;
    event.time = update.time;
    event.state = state;
    pushEvent(event);
  }
}

void ServerConnection::pushEvent(const NetworkEvent& event) {
  if (!exchange_) return;
  if (waitingEvents_.empty() && exchange_->events.push(event)) return;
  if (event.kind == NetworkEvent::Kind::state)
    ++statistics_.droppedStates;  // newer ones follow
  else
    waitingEvents_.push_back(event);
}

void ServerConnection::flushEvents() {
  std::size_t sent = 0;
  while (sent < waitingEvents_.size() && exchange_->events.push(waitingEvents_[sent])) ++sent;
  waitingEvents_.erase(waitingEvents_.begin(), waitingEvents_.begin() + static_cast<std::ptrdiff_t>(sent));
}

void ServerConnection::publishTimeBase(Micros now) {
  if (clock_.known()) playOut_ = playOutDelay_.delay(clock_.sessionTime(now));
  exchange_->timeBase.write({sessionTime(now) - now, playOut_, welcome_.site});
  statistics_.playOut_ms = toSeconds(playOut_) * 1e3;
}

Micros ServerConnection::sessionTime(Micros now) { return clock_.known() ? clock_.sessionTime(now) : 0; }

void ServerConnection::sendIntents() {
  HandIntent intent;
  while (exchange_->intents.pop(intent)) {
    if (intent.lost != lost_) continue;  // the hand was told since that it gets no answer
    switch (intent.kind) {
      case HandIntent::Kind::grab:
        askFor(intent.part, 0);
        break;
      case HandIntent::Kind::release: {
        const Release release{nextRequest_++, intent.part, intent.epoch, intent.worldFromPart};
        givenBack_[intent.part] = intent.epoch;
        if (observer_) observer_->onRelease(release);
        send(release);
        break;
      }
      case HandIntent::Kind::leave:
        send(Disengage{open(intent.part, OpenGrab::Kind::leave), intent.part});
        break;
    }
  }
}

/// What the hand's ends of links say, and lines that have fallen silent.
void ServerConnection::exchangeLinks(Micros now) {
  haptics::TiedPacket packet;
  while (exchange_->linksOut.pop(packet)) {
    const std::optional<LinkUpdate> update = links_->toWire(packet);
    if (!update || !clock_.known()) continue;
    outgoingMessage_ = *update;
    sendState(outgoingMessage_);
    linkSentAt_ = now;
  }
  links_->beginSilentAnew(*ownership_, sessionTime(now));
  pushOrders();
}

/// Whether somebody else's hand feels the part as it is played out: those who share it feel the link, if the way between
/// bears one.
bool ServerConnection::othersTouch(PartId part) const {
  const std::vector<SiteId>& members = ownership_->members(part).sites;
  return std::any_of(sites_.begin(), sites_.end(), [&](const SiteView& site) {
    if (site.self || !site.info.connected || links_->felt(part, site.info.site)) return false;
    const bool shares = std::find(members.begin(), members.end(), site.info.site) != members.end();
    return shares || (site.seen && site.presence.touched == part);
  });
}

void ServerConnection::offerParts(Micros now) {
  offered_.clear();
  for (int i = 0; i < hand_.tick.ownedCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const haptics::OwnedPart& part = hand_.tick.owned[index];
    // The view, not the hand, says what this site may say (S3); the hand goes on either way.
    if (hand_.ownedEpoch[index] != ownership_->part(part.part).epoch ||
        !ownership_->mayPublish(part.part, now))
      continue;
    offered_.push_back({{part.part, hand_.ownedEpoch[index], updateSequence_ + 1, part.worldFromPart,
                         part.atRest ? Twist{} : part.twist},
                        othersTouch(part.part)});
  }
}

void ServerConnection::publish(Micros now) {
  hand_ = exchange_->output.latest();
  if (!clock_.known() || !publisher_->mayBeDue(now)) return;
  offerParts(now);
  const Presence presence{welcome_.site, hand_.tick.worldFromProxy, worldFromCamera_, hand_.tick.toHand.force,
                          hand_.tick.touched};
  bool newPresence = true;
  if (!publisher_->due(now, hand_.time, offered_, presence, newPresence)) return;
  StateUpdate& update = std::get<StateUpdate>(outgoingUpdate_);
  update.site = welcome_.site;
  update.sequence = ++updateSequence_;
  update.time = clock_.sessionTime(hand_.time);
  update.presence = presence;
  update.newPresence = newPresence;
  update.parts.clear();
  for (const OfferedPart& part : offered_) {
    update.parts.push_back(part.state);
    if (observer_) observer_->onPublished(part.state);
  }
  ++statistics_.sentUpdates;
  ++updatesSent_;
  statesOut_.encode(update, *frame_, bytes_);
  sendBytes();
  if (recording_) recording_->write(update.time, outgoingUpdate_);
}

void ServerConnection::send(const ControlMessage& message) {
  if (!transport_) return;
  const std::vector<std::byte> bytes = encodeControl(message);
  statistics_.sent.countControl(bytes.size());
  transport_->sendControl(0, bytes);
}

void ServerConnection::sendState(const StateMessage& message) {
  if (!transport_ || !frame_) return;
  encodeState(message, *frame_, bytes_);
  sendBytes();
}

void ServerConnection::sendBytes() {
  if (!transport_) return;
  statistics_.sent.countState(bytes_);
  unsent_.add(bytes_, [this](auto datagram) { transport_->sendState(0, datagram); });
}

ConnectionStatistics ServerConnection::statistics() const {
  ConnectionStatistics statistics = statistics_;
  if (transport_) statistics.transport = transport_->counters();
  return statistics;
}

}  // namespace tandem::client
