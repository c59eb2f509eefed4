#include "sync/transport/socket_core.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <chrono>
#include <limits>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr Micros kHousekeeping = 25 * kMillisecond;
constexpr Micros kCloseTime = 2 * kSecond;  // for a peer to read what is queued
constexpr Micros kDestructionTime = 500 * kMillisecond;
constexpr std::size_t kMaxBacklog = 4 << 20;         // bytes queued to a peer that does not read
constexpr std::size_t kMaxStateBacklog = 32 * 1024;  // state beyond this would arrive too late
// Bytes received that the application has not polled: of the scene at a site; of requests at a server.
constexpr std::size_t kMaxUndeliveredOfOne = 4 << 20, kMaxUndeliveredOfMany = 256 << 10;
// Messages of state of one connection that a server opens: a site sends a few hundred a second, in a row of
// owners a few thousand.
constexpr double kMaxStateRate = 8000.0, kStateBurst = 1000.0;
// Batches of strangers' datagrams that a server receives between two housekeepings; the kernel drops the
// rest. What is genuine among them: probes of sites that have just come in.
constexpr std::size_t kOtherBatches = 2;
constexpr std::size_t kEventBytes = 128;  // what an event takes besides its message
constexpr std::size_t kMaxSpare = 16;
constexpr std::size_t kMaxSpareBytes = 64 * 1024;

}  // namespace

// One thread runs the sockets. Only wake() is called from another one, and Asio may resolve a name on a
// thread of its own.
SocketCore::SocketCore(Peers peers)
    : io_(BOOST_ASIO_CONCURRENCY_HINT_1),
      datagrams_(io_),
      others_(io_),
      peers_(peers),
      work_(io_.get_executor()),
      timer_(io_) {}
SocketCore::~SocketCore() = default;

Micros SocketCore::now() {
  const auto sinceBoot = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(sinceBoot).count();
}

Connection* SocketCore::find(ConnectionId id) const {
  const auto found = connections_.find(id);
  return found == connections_.end() ? nullptr : found->second.get();
}

// ---- events out ----

std::size_t SocketCore::maxUndelivered() const {
  return peers_ == Peers::one ? kMaxUndeliveredOfOne : kMaxUndeliveredOfMany;
}

/// A server hands out state before control: no number of requests delays a batch of datagrams. A site, which
/// trusts its server, learns of a part before it learns where the part is.
bool SocketCore::poll(TransportEvent& event) {
  const bool stateFirst = peers_ == Peers::many && (stateReady_ || findState());
  if (!stateFirst && pollQueue(event)) return true;
  if (!stateReady_ && !findState()) return false;
  stateReady_ = false;
  event.kind = TransportEvent::Kind::state;
  event.connection = openedFrom_;
  event.bytes = {opened_[openedIndex_].data(), openedSize_};
  event.reason.clear();
  openedIndex_ ^= 1;
  return true;
}

bool SocketCore::pollQueue(TransportEvent& event) {
  if (!current_.empty() && spare_.size() < kMaxSpare && current_.capacity() <= kMaxSpareBytes) {
    spare_.push_back(std::move(current_));
  }
  current_.clear();
  while (std::optional<Event> next = queue_.pop()) {
    Connection* connection = find(next->connection);
    if (connection != nullptr) {
      const bool wasFull = connection->undelivered > maxUndelivered();
      connection->undelivered -= next->bytes.size() + kEventBytes;
      if (wasFull && connection->undelivered <= maxUndelivered() && !connection->resting)
        connection->stream->pauseReading(false);
    }
    const bool closed = next->kind == TransportEvent::Kind::closed;
    if (connection != nullptr && connection->closing && !closed) continue;
    current_ = std::move(next->bytes);
    event.kind = next->kind;
    event.connection = next->connection;
    event.bytes = current_;
    event.reason = std::move(next->reason);
    return true;
  }
  return false;
}

void SocketCore::push(Connection& connection, TransportEvent::Kind kind, std::span<const std::byte> bytes) {
  Event event;
  event.kind = kind;
  event.connection = connection.id;
  if (!spare_.empty() && !bytes.empty()) {
    event.bytes = std::move(spare_.back());
    spare_.pop_back();
  }
  event.bytes.assign(bytes.begin(), bytes.end());
  connection.undelivered += bytes.size() + kEventBytes;
  if (connection.undelivered > maxUndelivered()) connection.stream->pauseReading(true);
  queue_.push(std::move(event));
}

void SocketCore::queueClosed(ConnectionId id, std::string reason) {
  Event event;
  event.connection = id;
  event.reason = std::move(reason);
  queue_.push(std::move(event));
}

void SocketCore::payload(Connection& connection, FrameType type, std::span<const std::byte> bytes) {
  if (!connection.announced || connection.closing) return;
  if (type == FrameType::control) {
    counters_.controlBytesIn += bytes.size();
    push(connection, TransportEvent::Kind::control, bytes);
  } else if (bytes.size() > kMaxStateBytes) {
    ++counters_.droppedOversized;
  } else if (peers_ == Peers::many && !withinRate(connection, now())) {
    ++counters_.droppedFlood;
    rest(connection, true);
  } else {
    ++counters_.statePacketsIn;
    counters_.stateBytesIn += bytes.size();
    push(connection, TransportEvent::Kind::state, bytes);
  }
}

void SocketCore::announce(const std::shared_ptr<Connection>& connection, ConnectionId id) {
  connection->id = id;
  connection->announced = true;
  connection->stream->allowFrames(maxMessageBytes_ + 1);
  connections_[id] = connection;
  push(*connection, TransportEvent::Kind::connected, {});
}

std::string SocketCore::addressOf(ConnectionId id) const {
  const Connection* connection = find(id);
  return connection == nullptr ? std::string() : connection->address;
}

void SocketCore::drop(Connection& connection, const std::string& reason) {
  const auto found = connections_.find(connection.id);
  if (found == connections_.end() || found->second.get() != &connection) return;
  if (connection.closing) queue_.erase(connection.id);
  queueClosed(connection.id, reason);
  retire(std::move(found->second));
  connections_.erase(found);
}

void SocketCore::refuse(Connection& connection, const std::string& reason) {
  if (!connection.refusal.empty()) return;
  const auto stream = connection.stream;
  connection.refusal = reason;
  connection.deadline = now() + kCloseTime;
  stream->send(FrameType::farewell, std::as_bytes(std::span(reason)));
  stream->close();
}

// ---- bytes in from the application ----

void SocketCore::sendControl(ConnectionId id, std::span<const std::byte> bytes) {
  ASSERT(bytes.size() <= kMaxControlBytes);
  Connection* connection = find(id);
  if (connection == nullptr || !connection->announced || connection->closing) return;
  if (connection->stream->backlog() + bytes.size() > kMaxBacklog) return overflow(*connection);
  counters_.controlBytesOut += bytes.size();
  connection->stream->send(FrameType::control, bytes);
}

/// A peer that does not read gets no farewell, which would queue behind what it has not read.
void SocketCore::overflow(Connection& connection) {
  ++counters_.droppedFull;
  const auto stream = connection.stream;
  stream->abandon();
  connectionClosed(connection, "the peer does not read: its queue is full");
}

void SocketCore::sendState(ConnectionId id, std::span<const std::byte> bytes) {
  Connection* connection = find(id);
  if (connection == nullptr || !connection->announced || connection->closing) return;
  if (bytes.size() > kMaxStateBytes) {
    ++counters_.droppedOversized;
    return;
  }
  if (connection->channel != nullptr && connection->channel->usable()) {
    if (!sendSealed(*connection, bytes)) return;
  } else {
    if (connection->stream->backlog() > kMaxStateBacklog) {
      ++counters_.droppedFull;
      return;
    }
    connection->stream->send(FrameType::state, bytes);
  }
  ++counters_.statePacketsOut;
  counters_.stateBytesOut += bytes.size();
}

/// A site has one datagram at a time, and it leaves at once; a server has many.
bool SocketCore::sendSealed(Connection& connection, std::span<const std::byte> bytes) {
  const bool batched = peers_ == Peers::many && connection.peer.size != 0;
  std::byte* out = batched ? unsent_.next() : outgoing_.data();
  const std::size_t size = connection.channel->sealState(bytes, out);
  if (size == 0) {
    refuse(connection, "the keys of this connection are used up: connect again");
    return false;
  }
  if (batched) {
    unsent_.add(connection.peer, size);
    if (unsent_.full()) flush();
    return true;
  }
  const UdpAddress* to = connection.peer.size == 0 ? nullptr : &connection.peer;
  const bool sent = sendDatagram(datagrams_.socket.native_handle(), to, {out, size});
  if (!sent) ++counters_.droppedFull;
  return sent;
}

void SocketCore::flush() {
  if (!unsent_.empty()) counters_.droppedFull += unsent_.send(datagrams_.socket.native_handle());
}

std::size_t SocketCore::controlBacklog(ConnectionId id) const {
  const Connection* connection = find(id);
  return connection == nullptr || connection->stream == nullptr ? 0 : connection->stream->backlog();
}

void SocketCore::close(ConnectionId id) {
  Connection* connection = find(id);
  if (connection == nullptr || connection->closing) return;
  connection->closing = true;
  connection->deadline = now() + kCloseTime;
  if (connection->stream == nullptr) return connectionClosed(*connection, {});
  const auto stream = connection->stream;
  stream->close();
}

bool SocketCore::stateOverUdp(ConnectionId id) const {
  const Connection* connection = find(id);
  return connection != nullptr && connection->channel != nullptr && connection->channel->usable();
}

// ---- datagrams ----

bool SocketCore::agree(Connection& connection, SealAlgorithm algorithm, std::uint64_t wireId,
                       StateChannel::Side side) {
  StateKeys keys;
  if (!connection.stream->exportKeys(algorithm, keys)) return false;
  connection.channel = std::make_unique<StateChannel>(side, algorithm, keys, wireId, now());
  return true;
}

void SocketCore::sendProbe(Connection& connection, Micros at) {
  if (const std::size_t size = connection.channel->probeIfDue(at, outgoing_.data()); size != 0) {
    sendDatagram(datagrams_.socket.native_handle(), nullptr, {outgoing_.data(), size});
  }
}

void SocketCore::receiveUdp() {
  const auto receive = [this](Intake& intake) {
    datagramTime_ = now();
    intake.readable = intake.batch.receive(intake.socket.native_handle());
  };
  if (datagrams_.readable && datagrams_.batch.empty()) receive(datagrams_);
  if (!others_.readable || !others_.batch.empty() || othersLeft_ == 0) return;
  --othersLeft_;
  receive(others_);
}

bool SocketCore::findState() {
  for (Intake* intake : {&datagrams_, &others_})
    while (!intake->batch.empty())
      if (open(intake->batch.pop())) return stateReady_ = true;
  return false;
}

bool SocketCore::withinRate(Connection& connection, Micros at) {
  const double elapsed = toSeconds(std::max<Micros>(0, at - connection.statesAt));
  connection.states = std::min(kStateBurst, connection.states + elapsed * kMaxStateRate);
  connection.statesAt = std::max(connection.statesAt, at);
  if (connection.states < 1.0) return false;
  connection.states -= 1.0;
  return true;
}

void SocketCore::rest(Connection& connection, bool resting) {
  connection.resting = resting;
  connection.stream->pauseReading(resting || connection.undelivered > maxUndelivered());
}

bool SocketCore::open(const UdpBatch::Datagram& datagram) {
  if (datagram.oversized) return ++counters_.droppedOversized, false;
  if (datagram.bytes.size() < kSealOverheadBytes) return ++counters_.droppedUnknown, false;
  Connection* connection = connectionOf(connectionIdOf(datagram.bytes));
  if (connection == nullptr || connection->closing) return ++counters_.droppedUnknown, false;
  if (peers_ == Peers::many && !withinRate(*connection, datagramTime_)) {
    sendsTooMuch(*connection);
    return ++counters_.droppedFlood, false;
  }
  const auto received = connection->channel->receive(datagram.bytes, datagramTime_,
                                                     opened_[openedIndex_].data(), outgoing_.data());
  if (received.verdict == Opener::Verdict::forged) return ++counters_.droppedForged, false;
  if (received.verdict == Opener::Verdict::replayed) return ++counters_.droppedReplayed, false;
  if (received.newest && peers_ == Peers::many) connection->peer = *datagram.from;
  if (received.replyBytes != 0) {
    sendDatagram(datagrams_.socket.native_handle(), connection->peer.size == 0 ? nullptr : &connection->peer,
                 {outgoing_.data(), received.replyBytes});
  }
  if (!received.isState) return false;
  ++counters_.statePacketsIn;
  counters_.stateBytesIn += received.size;
  openedFrom_ = connection->id;
  openedSize_ = received.size;
  return true;
}

void SocketCore::watchUdp() {
  watch(datagrams_);
  watch(others_);
}

void SocketCore::watch(Intake& intake) {
  if (intake.watched || intake.readable || !intake.socket.is_open()) return;
  intake.watched = true;
  intake.socket.async_wait(asio::ip::udp::socket::wait_read, [&intake](const error_code& failure) {
    intake.watched = false;
    intake.readable = !failure;
  });
}

// ---- time ----

bool SocketCore::eventReady() {
  receiveUdp();
  return !queue_.empty() || stateReady_ || findState();
}

void SocketCore::keepHouse() {
  const Micros at = now();
  if (at < nextHousekeeping_) return;
  nextHousekeeping_ = at + kHousekeeping;
  othersLeft_ = kOtherBatches;
  for (const auto& [id, connection] : std::unordered_map(connections_)) {
    if (connection->resting) rest(*connection, false);
    if (connection->channel != nullptr) connection->channel->update(at);
    if ((connection->closing || !connection->refusal.empty()) && at > connection->deadline) {
      connection->stream->abandon();
      connectionClosed(*connection, connection->refusal);
    }
  }
  housekeeping(at);
}

Micros SocketCore::attend(Micros, bool) { return std::numeric_limits<Micros>::max(); }

/// The timer stays armed over many short waits: it may expire early, never late.
void SocketCore::armTimer(Micros at) {
  if (timerArmed_ && armedAt_ <= at) return;
  timerArmed_ = true;
  armedAt_ = at;
  timer_.expires_at(asio::steady_timer::time_point(std::chrono::microseconds(at)));
  timer_.async_wait([this](const error_code& failure) { timerArmed_ = timerArmed_ && failure; });
}

void SocketCore::wait(Micros timeout) {
  const Micros deadline = now() + std::max<Micros>(timeout, 0);
  flush();
  retired_.clear();
  keepHouse();
  attend(now(), false);
  watchUdp();
  // Where wait() may block, run_one() below handles what has arrived just as well, with one system call fewer
  // for each datagram.
  if (timeout <= 0 || woken_.load(std::memory_order_acquire) || eventReady()) io_.poll();
  while (!eventReady() && !woken_.load(std::memory_order_acquire)) {
    if (now() >= deadline) break;
    watchUdp();
    armTimer(std::min({deadline, nextHousekeeping_, attend(now(), true)}));
    io_.run_one();
    keepHouse();
  }
  woken_.store(false, std::memory_order_release);
}

void SocketCore::wake() {
  if (!woken_.exchange(true)) asio::post(io_, [] {});
}

void SocketCore::shutDown() {
  flush();
  const Micros deadline = now() + kDestructionTime;
  const auto closing = [this] {
    return std::any_of(connections_.begin(), connections_.end(),
                       [](const auto& entry) { return entry.second->closing; });
  };
  while (closing() && now() < deadline) io_.run_one_for(std::chrono::milliseconds(10));
  for (const auto& [id, connection] : connections_) {
    if (connection->stream != nullptr) connection->stream->abandon();
  }
}

}  // namespace tandem::sync
