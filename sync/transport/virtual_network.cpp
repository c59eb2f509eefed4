#include "sync/transport/virtual_network.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <map>
#include <random>
#include <vector>

#include "assets/base/assert.h"
#include "sync/wire/limits.h"
#include "sync/wire/time.h"

namespace tandem::sync {
namespace {

/// A lost segment is sent again a round trip and this much later.
constexpr Micros kResendPause = 10 * kMillisecond;
constexpr int kMaxResends = 10;
/// Datagrams that would wait longer than this for a slow uplink are dropped.
constexpr Micros kUplinkQueue = kSecond;

struct Received {
  TransportEvent::Kind kind = TransportEvent::Kind::closed;
  ConnectionId connection = 0;
  std::vector<std::byte> bytes;
  std::string reason;
};

struct VirtualConnection;

/// What an endpoint has received and what it counts.
struct Endpoint {
  std::deque<Received> inbox;
  TransportCounters counters;
  std::map<ConnectionId, std::shared_ptr<VirtualConnection>> connections;
  std::map<ConnectionId, std::deque<Received>> held;  // control of connections that are held
};

/// One direction of the control stream of a connection: a queue.
struct Channel {
  struct Item {
    bool closes = false;
    std::vector<std::byte> bytes;
    std::string reason;
  };
  std::deque<Item> items;
  Micros lastArrival = 0;
  std::size_t bytesInFlight = 0;
};

enum Side : int { kServerSide = 0, kSiteSide = 1 };

/// What is special about the way between one site and the server.
struct SitePath {
  Micros cutUntil[2] = {0, 0};  // toward the server, toward the site
  VirtualNetwork::Path path;
  Micros uplinkFreeAt = 0;     // when what queues in a slow uplink will have left
  Micros lastFromTheDead = 0;  // when the server received something of an end that is closed
};

struct VirtualConnection {
  SitePath* path = nullptr;
  std::string site;
  ConnectionId id = 0;    // as the server sees it
  Endpoint* end[2] = {};  // null once that side has gone
  bool open[2] = {};      // whether that side still gets events other than `closed`
  Channel toward[2];      // toward[side]: messages on their way to that side
};

struct Delivery {
  enum class Kind : std::uint8_t { connect, control, state };
  Micros at = 0;
  std::uint64_t order = 0;
  Kind kind = Kind::control;
  Side to = kServerSide;
  std::shared_ptr<VirtualConnection> connection;
  std::vector<std::byte> bytes;  // state only: control waits in its channel
};
struct Later {
  bool operator()(const Delivery& a, const Delivery& b) const {
    return a.at != b.at ? a.at > b.at : a.order > b.order;
  }
};

/// A priority queue whose first element can be moved out.
class Deliveries {
 public:
  bool empty() const { return heap_.empty(); }
  const Delivery& first() const { return heap_.front(); }
  void push(Delivery delivery) {
    heap_.push_back(std::move(delivery));
    std::push_heap(heap_.begin(), heap_.end(), Later{});
  }
  /// Changes each by `change`, in any order.
  template <typename Change>
  void forEach(const Change& change) {
    for (Delivery& delivery : heap_) change(delivery);
    std::make_heap(heap_.begin(), heap_.end(), Later{});
  }
  Delivery pop() {
    std::pop_heap(heap_.begin(), heap_.end(), Later{});
    Delivery first = std::move(heap_.back());
    heap_.pop_back();
    return first;
  }

 private:
  std::vector<Delivery> heap_;
};

/// The network between the endpoints.
struct Core {
  explicit Core(std::uint64_t seed) : random(seed) {}

  std::mt19937_64 random;
  NetworkConditions conditions;
  Micros now = 0;
  std::uint64_t order = 0;
  Deliveries deliveries;
  std::map<std::string, SitePath> paths;  // by site
  std::uint64_t heardFromTheDead = 0;
  Endpoint* server = nullptr;
  ConnectionId lastConnection = 0;

  /// Uniform in [0, 1). The standard's distributions differ between libraries; this does not.
  double uniform() { return static_cast<double>(random() >> 11) * 0x1p-53; }
  /// True with the probability of one leg, 1 - sqrt(1 - whole), where `whole` is that of both legs together.
  bool chance(double whole) { return whole > 0.0 && uniform() < 1.0 - std::sqrt(1.0 - std::min(whole, 1.0)); }
  Micros legDelay(const SitePath& path) {
    const double half = 0.5 * static_cast<double>(conditions.oneWay);
    const double factor = conditions.jitter > 0.0 ? 1.0 + conditions.jitter * (2.0 * uniform() - 1.0) : 1.0;
    return static_cast<Micros>(std::llround(std::max(0.0, half * factor))) + path.path.delay;
  }
  static bool isCut(const SitePath& path, Side to, Micros at) { return at < path.cutUntil[to]; }
  /// The probability that a datagram of the site is lost on its leg, beside `conditions.loss`.
  bool lostOnPath(const SitePath& path) { return path.path.loss > 0.0 && uniform() < path.path.loss; }
  /// When what the site sends now has passed its uplink, which sends one message after the other.
  Micros throughUplink(SitePath& path, Side to, std::size_t bytes) {
    if (to != kServerSide || path.path.uplinkRate <= 0.0) return now;
    path.uplinkFreeAt = std::max(path.uplinkFreeAt, now) +
                        static_cast<Micros>(1e6 * static_cast<double>(bytes) / path.path.uplinkRate);
    return path.uplinkFreeAt;
  }

  void schedule(Delivery delivery) {
    ASSERT(delivery.at >= now && delivery.connection != nullptr);
    delivery.order = ++order;
    deliveries.push(std::move(delivery));
  }
  void sendControl(const std::shared_ptr<VirtualConnection>& connection, Side to, Channel::Item item,
                   Micros extra = 0) {
    SitePath& path = *connection->path;
    Micros arrival = throughUplink(path, to, item.bytes.size()) + legDelay(path) + extra;
    for (int i = 0; i < kMaxResends && (chance(conditions.loss) || lostOnPath(path)); ++i)
      arrival += conditions.oneWay + 2 * path.path.delay + kResendPause;
    Channel& channel = connection->toward[to];
    channel.lastArrival = std::max(channel.lastArrival, arrival);
    channel.bytesInFlight += item.bytes.size();
    channel.items.push_back(std::move(item));
    schedule({.at = channel.lastArrival,
              .order = 0,
              .kind = Delivery::Kind::control,
              .to = to,
              .connection = connection,
              .bytes = {}});
  }
  /// What a bad way has held back is sent again at once, in its order.
  void resendNow() {
    const Micros latest = now + 2 * conditions.oneWay + kResendPause;
    deliveries.forEach([&](Delivery& delivery) {
      if (delivery.kind != Delivery::Kind::control) return;
      delivery.at = std::min(delivery.at, latest);
      Micros& last = delivery.connection->toward[delivery.to].lastArrival;
      last = std::min(last, latest);
    });
  }
  void sendState(const std::shared_ptr<VirtualConnection>& connection, Side to,
                 std::span<const std::byte> bytes) {
    // Every draw is made whatever its outcome, so that one condition does not shift the others' random
    // numbers.
    SitePath& path = *connection->path;
    const bool lostInTheMiddle = chance(conditions.loss), twice = chance(conditions.duplicate);
    const bool full = to == kServerSide && path.uplinkFreeAt - now > kUplinkQueue;
    const bool lost = lostOnPath(path) || lostInTheMiddle || full;
    const Micros leaves = full ? now : throughUplink(path, to, bytes.size());
    for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
      Micros delay = legDelay(path);
      if (chance(conditions.reorder)) delay += std::max(legDelay(path), kMillisecond);
      if (lost || isCut(path, to, now)) continue;
      schedule({.at = leaves + delay,
                .order = 0,
                .kind = Delivery::Kind::state,
                .to = to,
                .connection = connection,
                .bytes = {bytes.begin(), bytes.end()}});
    }
  }

  void close(VirtualConnection& connection, Side side, const std::string& reason) {
    if (!connection.open[side]) return;
    connection.open[side] = false;
    if (connection.end[side] == nullptr) return;
    const ConnectionId id = side == kServerSide ? connection.id : 0;
    connection.end[side]->inbox.push_back({TransportEvent::Kind::closed, id, {}, reason});
  }
  void noteTheDead(const Delivery& delivery) {
    const VirtualConnection& connection = *delivery.connection;
    if (delivery.to != kServerSide || connection.open[kSiteSide]) return;
    connection.path->lastFromTheDead = now;
    ++heardFromTheDead;
  }
  void deliverConnect(Delivery& delivery) {
    VirtualConnection& connection = *delivery.connection;
    if (connection.end[kSiteSide] == nullptr) return;
    if (server == nullptr) return close(connection, kSiteSide, "connection refused: no server");
    connection.end[kServerSide] = server;
    server->connections[connection.id] = delivery.connection;
    connection.open[kServerSide] = true;
    connection.end[kServerSide]->inbox.push_back({TransportEvent::Kind::connected, connection.id, {}, {}});
    connection.end[kSiteSide]->inbox.push_back({TransportEvent::Kind::connected, 0, {}, {}});
  }
  void deliverControl(Delivery& delivery) {
    VirtualConnection& connection = *delivery.connection;
    Channel& channel = connection.toward[delivery.to];
    if (channel.items.empty()) return;
    Channel::Item item = std::move(channel.items.front());
    channel.items.pop_front();
    ASSERT(channel.bytesInFlight >= item.bytes.size());
    channel.bytesInFlight -= item.bytes.size();
    if (item.closes) return close(connection, delivery.to, item.reason);
    Endpoint* end = connection.end[delivery.to];
    if (end == nullptr || !connection.open[delivery.to]) return;
    noteTheDead(delivery);
    end->counters.controlBytesIn += item.bytes.size();
    const ConnectionId id = delivery.to == kServerSide ? connection.id : 0;
    end->inbox.push_back({TransportEvent::Kind::control, id, std::move(item.bytes), {}});
  }
  void deliverState(Delivery& delivery) {
    VirtualConnection& connection = *delivery.connection;
    Endpoint* end = connection.end[delivery.to];
    if (end == nullptr || !connection.open[delivery.to]) return;
    noteTheDead(delivery);
    end->counters.stateBytesIn += delivery.bytes.size();
    ++end->counters.statePacketsIn;
    const ConnectionId id = delivery.to == kServerSide ? connection.id : 0;
    end->inbox.push_back({TransportEvent::Kind::state, id, std::move(delivery.bytes), {}});
  }
  void deliver(Delivery delivery) {
    const SitePath& path = *delivery.connection->path;
    if (isCut(path, delivery.to, now)) {
      if (delivery.kind == Delivery::Kind::state) return;
      delivery.at = path.cutUntil[delivery.to];
      return deliveries.push(
          std::move(delivery));  // it keeps its order, and so stays in front of later deliveries
    }
    switch (delivery.kind) {
      case Delivery::Kind::connect:
        return deliverConnect(delivery);
      case Delivery::Kind::control:
        return deliverControl(delivery);
      case Delivery::Kind::state:
        return deliverState(delivery);
    }
  }
};

/// Either end of connections: the server has many, a site one.
class VirtualTransport : public Transport {
 public:
  VirtualTransport(std::shared_ptr<Core> core, Side side, Micros deathNoticed)
      : core_(std::move(core)), side_(side), deathNoticed_(deathNoticed) {}
  ~VirtualTransport() override;

  Endpoint& endpoint() { return endpoint_; }
  bool hasEvents() const { return !endpoint_.inbox.empty(); }

  bool poll(TransportEvent& event) override;
  void sendControl(ConnectionId id, std::span<const std::byte> bytes) override;
  void sendState(ConnectionId id, std::span<const std::byte> bytes) override;
  std::size_t controlBacklog(ConnectionId id) const override;
  void hold(ConnectionId id, bool held) override;
  void close(ConnectionId id) override;
  const TransportCounters& counters() const override { return endpoint_.counters; }
  std::string addressOf(ConnectionId id) const override {
    const auto found = endpoint_.connections.find(id);
    return found == endpoint_.connections.end() ? std::string() : found->second->site;
  }

 private:
  /// Puts the event polled last aside if its connection is held.
  bool keepIfHeld();
  Side peer() const { return side_ == kServerSide ? kSiteSide : kServerSide; }
  /// Null if there is no such connection or it is closed.
  std::shared_ptr<VirtualConnection> openConnection(ConnectionId id) const {
    const auto found = endpoint_.connections.find(id);
    return found != endpoint_.connections.end() && found->second->open[side_] ? found->second : nullptr;
  }

  std::shared_ptr<Core> core_;
  Side side_;
  Micros deathNoticed_;
  Endpoint endpoint_;
  Received current_;  // keeps the bytes of the last polled event
};

VirtualTransport::~VirtualTransport() {
  if (core_->server == &endpoint_) core_->server = nullptr;
  for (auto& [id, connection] : endpoint_.connections) {
    const bool wasOpen = connection->open[side_];
    connection->open[side_] = false;
    connection->end[side_] = nullptr;
    if (wasOpen)
      core_->sendControl(connection, peer(), {true, {}, "connection lost: the peer is gone"}, deathNoticed_);
  }
}

bool VirtualTransport::poll(TransportEvent& event) {
  do {
    if (endpoint_.inbox.empty()) return false;
    current_ = std::move(endpoint_.inbox.front());
    endpoint_.inbox.pop_front();
  } while (keepIfHeld());
  if (current_.kind == TransportEvent::Kind::closed) {
    endpoint_.connections.erase(current_.connection);
    endpoint_.held.erase(current_.connection);
  }
  event = {current_.kind, current_.connection, current_.bytes, current_.reason};
  return true;
}

bool VirtualTransport::keepIfHeld() {
  if (current_.kind != TransportEvent::Kind::control) return false;
  const auto held = endpoint_.held.find(current_.connection);
  if (held == endpoint_.held.end()) return false;
  held->second.push_back(std::move(current_));
  return true;
}

void VirtualTransport::hold(ConnectionId id, bool held) {
  if (held) {
    if (openConnection(id)) endpoint_.held.try_emplace(id);
    return;
  }
  const auto kept = endpoint_.held.find(id);
  if (kept == endpoint_.held.end()) return;
  endpoint_.inbox.insert(endpoint_.inbox.begin(), std::make_move_iterator(kept->second.begin()),
                         std::make_move_iterator(kept->second.end()));
  endpoint_.held.erase(kept);
}

void VirtualTransport::sendControl(ConnectionId id, std::span<const std::byte> bytes) {
  ASSERT(bytes.size() <= kMaxControlBytes);
  const std::shared_ptr<VirtualConnection> connection = openConnection(id);
  if (!connection) return;
  endpoint_.counters.controlBytesOut += bytes.size();
  core_->sendControl(connection, peer(), {false, {bytes.begin(), bytes.end()}, {}});
}

void VirtualTransport::sendState(ConnectionId id, std::span<const std::byte> bytes) {
  if (bytes.size() > kMaxStateBytes) {
    ++endpoint_.counters.droppedOversized;
    return;
  }
  const std::shared_ptr<VirtualConnection> connection = openConnection(id);
  if (!connection) return;
  endpoint_.counters.stateBytesOut += bytes.size();
  ++endpoint_.counters.statePacketsOut;
  core_->sendState(connection, peer(), bytes);
}

std::size_t VirtualTransport::controlBacklog(ConnectionId id) const {
  const std::shared_ptr<VirtualConnection> connection = openConnection(id);
  return connection ? connection->toward[peer()].bytesInFlight : 0;
}

void VirtualTransport::close(ConnectionId id) {
  const std::shared_ptr<VirtualConnection> connection = openConnection(id);
  if (!connection) return;
  core_->sendControl(connection, peer(), {true, {}, "closed by the peer"});
  endpoint_.held.erase(id);
  std::erase_if(endpoint_.inbox, [&](const Received& r) { return r.connection == id; });
  core_->close(*connection, side_, "");
}

}  // namespace

struct VirtualNetwork::Impl : Core {
  using Core::Core;
};

VirtualNetwork::VirtualNetwork(std::uint64_t seed, const NetworkConditions& conditions)
    : impl_(std::make_shared<Impl>(seed)) {
  impl_->conditions = conditions;
}
VirtualNetwork::~VirtualNetwork() = default;

void VirtualNetwork::advanceTo(Micros now) {
  ASSERT(now >= impl_->now);
  while (!impl_->deliveries.empty() && impl_->deliveries.first().at <= now) {
    Delivery next = impl_->deliveries.pop();
    impl_->now = std::max(impl_->now, next.at);
    impl_->deliver(std::move(next));
  }
  impl_->now = now;
}

std::unique_ptr<Transport> VirtualNetwork::listen() {
  ASSERT(impl_->server == nullptr);
  auto transport = std::make_unique<VirtualTransport>(impl_, kServerSide, 0);
  impl_->server = &transport->endpoint();
  return transport;
}

std::unique_ptr<Transport> VirtualNetwork::connect(const std::string& site, Micros deathNoticed) {
  auto transport = std::make_unique<VirtualTransport>(impl_, kSiteSide, deathNoticed);
  auto connection = std::make_shared<VirtualConnection>();
  connection->path = &impl_->paths[site];
  connection->site = site;
  connection->id = ++impl_->lastConnection;
  connection->end[kSiteSide] = &transport->endpoint();
  connection->open[kSiteSide] = true;
  transport->endpoint().connections[0] = connection;
  const Micros at = impl_->now + impl_->legDelay(*connection->path);
  connection->toward[kServerSide].lastArrival = connection->toward[kSiteSide].lastArrival = at;
  impl_->schedule({.at = at,
                   .order = 0,
                   .kind = Delivery::Kind::connect,
                   .to = kServerSide,
                   .connection = connection,
                   .bytes = {}});
  return transport;
}

void VirtualNetwork::setConditions(const NetworkConditions& conditions) { impl_->conditions = conditions; }

void VirtualNetwork::blackout(const std::string& site, Micros until) {
  cut(site, Way::toServer, until);
  cut(site, Way::toSite, until);
}

void VirtualNetwork::cut(const std::string& site, Way way, Micros until) {
  Micros& end = impl_->paths[site].cutUntil[way == Way::toServer ? kServerSide : kSiteSide];
  end = std::max(end, until);
}

void VirtualNetwork::healAll() {
  for (auto& [site, path] : impl_->paths) {
    path.cutUntil[kServerSide] = path.cutUntil[kSiteSide] = 0;
    path.path = {};
  }
  impl_->resendNow();
}

void VirtualNetwork::setPath(const std::string& site, const Path& path) { impl_->paths[site].path = path; }

VirtualNetwork::Path VirtualNetwork::path(const std::string& site) const { return impl_->paths[site].path; }

Micros VirtualNetwork::lastFromTheDead(const std::string& site) const {
  const auto found = impl_->paths.find(site);
  return found == impl_->paths.end() ? 0 : found->second.lastFromTheDead;
}

std::uint64_t VirtualNetwork::heardFromTheDead() const { return impl_->heardFromTheDead; }

std::optional<Micros> VirtualNetwork::nextArrival() const {
  if (impl_->deliveries.empty()) return std::nullopt;
  return impl_->deliveries.first().at;
}

bool VirtualNetwork::hasEvents(const Transport& transport) {
  return static_cast<const VirtualTransport&>(transport).hasEvents();
}

}  // namespace tandem::sync
