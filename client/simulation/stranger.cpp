#include "client/simulation/stranger.h"

#include <algorithm>
#include <utility>

namespace tandem::client {

using namespace sync;

namespace {

constexpr Micros kPatience = 5 * kSecond;    // far above a round trip with resends
constexpr std::int64_t kAccessLasts = 3600;  // s
constexpr std::int64_t kClockSlack = 2;      // s, from the admission to the arrival of the Welcome
// What a site may ask for at once and a second, as server/README.md states it, and a margin.
constexpr double kBurst = 400.0, kRate = 200.0, kSlack = 60.0;

}  // namespace

Stranger::Stranger(const Ground& ground, Kind kind, std::string name, std::uint64_t seed, Micros now,
                   Micros until)
    : ground_(ground),
      kind_(kind),
      name_(std::move(name)),
      random_(seed),
      now_(now),
      until_(until),
      next_(now),
      frame_(wireFrame(ground.scene.bounds)) {
  if (kind_ == Kind::escalate && chance(50)) role_ = Role::observer;
}

Micros Stranger::nextDue(Micros never) const {
  if (now_ >= until_) return never;
  if (transport_ && VirtualNetwork::hasEvents(*transport_)) return now_;
  return std::min(next_, until_);
}

void Stranger::step(Micros now) {
  now_ = now;
  if (now >= until_) return transport_.reset();
  if (transport_) ground_.invariants.onStranger();
  if (transport_) receive();
  judgePatience();
  if (now < next_) return;
  if (!transport_)
    connect();
  else if (in_)
    act();
  if (kind_ == Kind::forge && transport_ && now > enteredAt_ + kSecond) transport_.reset();
  next_ = now + (kind_ == Kind::flood && in_ ? 20 : 100) * kMillisecond;
}

/// A server that stood still meanwhile is given its time anew.
void Stranger::judgePatience() {
  if (offended_ < 0) return;
  ground_.invariants.checked(Rule::R4);
  if (now_ - std::max(offended_, ground_.invariants.hinderedAt()) < kPatience) return;
  ground_.invariants.reportBroken(Rule::R4, name_ + " sent no message of the protocol and is still heard");
  offended_ = -1;
}

void Stranger::connect() {
  if (!ground_.server.running()) return;
  in_ = false;
  offended_ = -1;
  enteredAt_ = now_;
  transport_ = ground_.network.connect(name_);
  if (kind_ == Kind::replay && !token_.empty()) return;
  goodUntil_ = ground_.server.unixNow(now_);
  if (kind_ == Kind::forge) {
    const bool expired = chance(50);
    goodUntil_ = expired ? goodUntil_ - 10 : 0;
    token_ = expired ? ground_.server.makeToken(Role::instructor, -10, now_)
                     : ground_.server.forgeToken(Role::instructor);
    if (chance(30)) token_[below(token_.size())] ^= 1;
    return;
  }
  goodUntil_ += kAccessLasts;
  token_ = ground_.server.makeToken(role_, kAccessLasts, now_);
}

void Stranger::hello() {
  saidHelloAt_ = now_;
  Hello hello;
  hello.credential = token_;
  hello.name = name_;
  if (kind_ == Kind::forge && chance(20)) hello.protocolVersion ^= 1u << below(8);
  if (kind_ == Kind::forge && chance(20)) hello.resume = true;
  send(hello);
}

void Stranger::receive() {
  TransportEvent event;
  while (transport_ && transport_->poll(event)) {
    if (event.kind == TransportEvent::Kind::connected) hello();
    if (event.kind == TransportEvent::Kind::control) receive(event.bytes);
    if (event.kind == TransportEvent::Kind::closed) {
      offended_ = -1;
      in_ = false;
      transport_.reset();
      if (kind_ == Kind::flood) until_ = now_;  // with another token it would be another site
    }
  }
}

void Stranger::receive(std::span<const std::byte> bytes) {
  const Result<ControlMessage> message = decodeControl(bytes);
  if (!message) return;
  Invariants& invariants = ground_.invariants;
  const auto allowed = [&](bool granted, const char* what) {
    invariants.checked(Rule::R1);
    if (granted) invariants.reportBroken(Rule::R1, name_ + ", " + toString(role_) + ", " + what);
  };
  if (const auto* entered = std::get_if<Welcome>(&*message)) return welcome(*entered);
  if (const auto* changed = std::get_if<OwnershipChanged>(&*message)) invariants.onTold(changed->part);
  const bool observes = role_ == Role::observer;
  if (const auto* grab = std::get_if<GrabReply>(&*message)) {
    ++answers_;
    allowed(observes && grab->denial == Denial::none, "was granted a part");
    invariants.onTold(grab->part);
  }
  if (const auto* engage = std::get_if<EngageReply>(&*message))
    allowed(observes && engage->denial == Denial::none && !engage->coHolders.sites.empty(),
            "became a co-holder");
  if (const auto* release = std::get_if<ReleaseReply>(&*message)) {
    ++answers_;
    allowed(observes && release->denial == Denial::none, "released a part");
  }
  if (const auto* command = std::get_if<CommandReply>(&*message))
    allowed(command->done, "commanded the session");
  if (kind_ != Kind::flood) return;
  invariants.checked(Rule::R3);
  const double seconds = toSeconds(now_ - enteredAt_);
  if (static_cast<double>(answers_) > kBurst + kRate * seconds + kSlack)
    invariants.reportBroken(Rule::R3, name_ + " had " + std::to_string(answers_) + " requests answered in " +
                                          std::to_string(seconds) + " s");
}

void Stranger::welcome(const Welcome& message) {
  ground_.invariants.checked(Rule::R2);
  // A wall clock that is put back makes an expired token good again, unless it was used.
  const bool good = ground_.server.leastUnixSince(saidHelloAt_) < goodUntil_ + kClockSlack;
  if (kind_ == Kind::replay) goodUntil_ = 0;  // it is used now
  if (!good)
    ground_.invariants.reportBroken(Rule::R2, name_ + " came in as site " + std::to_string(message.site) +
                                                  " with a token that is not good");
  in_ = true;
  answers_ = 0;
  send(Ready{});
}

void Stranger::send(const ControlMessage& message) { transport_->sendControl(0, encodeControl(message)); }

void Stranger::sendDatagram(const StateMessage& message) {
  std::vector<std::byte> bytes;
  encodeState(message, frame_, bytes);
  transport_->sendState(0, bytes);
  if (recorded_.size() < 16) recorded_.push_back(std::move(bytes));
}

void Stranger::act() {
  switch (kind_) {
    case Kind::malformed:
      return sendMalformed();
    case Kind::replay:
      send(Grab{request_++, anyPart()});
      sendDatagram(Ping{++sequence_, now_});
      for (const auto& datagram : recorded_) transport_->sendState(0, datagram);
      return transport_.reset();  // and in again, with the same token
    case Kind::escalate:
      return sendForbidden();
    case Kind::flood:
      return sendFlood();
    default:
      return;
  }
}

void Stranger::sendMalformed() {
  for (int i = 0; i < 3; ++i) {
    std::vector<std::byte> bytes(1 + below(64));
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random_.draw());
    transport_->sendState(0, bytes);
  }
  sendState();
  if (!chance(40)) return;
  std::vector<std::byte> bytes = encodeControl(Grab{request_++, anyPart()});
  bytes.pop_back();
  if (chance(20)) bytes.assign(1, static_cast<std::byte>(0xff));
  transport_->sendControl(0, bytes);
  if (offended_ < 0) offended_ = now_;
}

ControlMessage Stranger::serverOnly() {
  switch (below(5)) {
    case 0:
      return OwnershipChanged{
          {anyPart(), static_cast<SiteId>(below(8)), static_cast<Epoch>(below(1000)), {}}};
    case 1:
      return Welcome{};
    case 2:
      return SiteLeft{static_cast<SiteId>(below(8))};
    case 3:
      return Hello{};
    default:
      return CommandReply{request_, true, ""};
  }
}

ControlMessage Stranger::forbidden() {
  const Epoch epoch = static_cast<Epoch>(below(64));
  switch (below(7)) {
    case 0:
      return Revoke{request_++, anyPart()};
    case 1:
      return ResetParts{request_++};
    case 2:
      return Reclaim{request_++, anyPart(), epoch, {}};
    case 3:
      return Release{request_++, anyPart(), epoch, {}};
    case 4:
      return Engage{request_++, anyPart()};
    case 5:
      return SceneRequest{below(1u << 20)};
    default:
      return Grab{request_++, anyPart()};
  }
}

void Stranger::sendForbidden() {
  for (int i = 0; i < 4; ++i) send(forbidden());
  sendState();
  sendDatagram(Ping{++sequence_, now_});
  if (chance(5)) {
    send(serverOnly());
    if (offended_ < 0) offended_ = now_;
  }
}

/// States of parts that belong to others, in any epoch; and a link to anybody.
void Stranger::sendState() {
  StateUpdate update;
  update.sequence = ++sequence_;
  update.time = ground_.server.session() != nullptr ? ground_.server.session()->sessionTime() : 0;
  if (chance(10)) update.time += 3600 * kSecond;
  for (std::size_t part = 0; part < ground_.scene.parts.size(); ++part) {
    const double far = chance(30) ? 1e3 : 0.05;
    update.parts.push_back({static_cast<PartId>(part),
                            static_cast<Epoch>(below(64)),
                            static_cast<std::uint32_t>(random_.draw() >> 33),
                            Pose{{far, far, far}, {1, 0, 0, 0}},
                            {}});
  }
  sendDatagram(update);
  LinkUpdate link;
  link.peer = static_cast<SiteId>(below(6));
  link.part = anyPart();
  link.sequence = 1;
  sendDatagram(link);
}

void Stranger::sendFlood() {
  for (int i = 0; i < 12; ++i) {
    const PartId part = anyPart();
    send(Grab{request_++, part});
    send(Release{request_++, part, static_cast<Epoch>(below(64)), {}});
  }
  for (int i = 0; i < 30; ++i) sendDatagram(Ping{++sequence_, now_});
}

}  // namespace tandem::client
