#include "sync/transport/socket_core.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <chrono>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr Micros kHousekeeping = 25 * kMillisecond;
constexpr Micros kCloseTime = 2 * kSecond;  // for a peer to take what is queued
constexpr Micros kDestructionTime = 500 * kMillisecond;
constexpr std::size_t kMaxBacklog = 4 << 20;         // bytes queued to a peer that does not read
constexpr std::size_t kMaxStateBacklog = 32 * 1024;  // older state than this is of no use to anybody
constexpr std::size_t kMaxUndelivered = 4 << 20;     // bytes received that the application has not polled
constexpr std::size_t kMaxSpare = 16;
constexpr std::size_t kMaxSpareBytes = 64 * 1024;
constexpr std::size_t kMaxFarewell = 200;

/// A peer's text, made fit for one line of ours.
std::string oneLine(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes.first(std::min(bytes.size(), kMaxFarewell))) {
    const char c = static_cast<char>(byte);
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  return text;
}

}  // namespace

void Link::onHandshake() { core_->handshakeDone(*this); }

void Link::onFrame(FrameType type, std::span<const std::byte> bytes) {
  switch (type) {
    case FrameType::control:
    case FrameType::state:
      return core_->payload(*this, type, bytes);
    case FrameType::farewell:
      farewell = oneLine(bytes);
      return;
    default:
      return core_->greeting(*this, type, bytes);
  }
}

void Link::onClosed(const std::string& reason) {
  if (!refusal.empty()) return core_->linkClosed(*this, refusal);
  core_->linkClosed(*this, farewell.empty() || closing ? reason : farewell);
}

// One thread runs the sockets; only wake() comes from another one, and a name may be looked up on Asio's own.
SocketCore::SocketCore(Peers peers)
    : io_(BOOST_ASIO_CONCURRENCY_HINT_1), udp_(io_), peers_(peers), work_(io_.get_executor()), timer_(io_) {}
SocketCore::~SocketCore() = default;

Micros SocketCore::now() {
  const auto sinceBoot = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(sinceBoot).count();
}

Link* SocketCore::find(ConnectionId id) const {
  const auto found = links_.find(id);
  return found == links_.end() ? nullptr : found->second.get();
}

// ---- events out ----

bool SocketCore::poll(TransportEvent& event) {
  if (pollQueue(event)) return true;
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
  while (!queue_.empty()) {
    Event next = std::move(queue_.front());
    queue_.pop_front();
    Link* link = find(next.connection);
    if (link != nullptr) {
      const bool wasFull = link->undelivered > kMaxUndelivered;
      link->undelivered -= next.bytes.size();
      if (wasFull && link->undelivered <= kMaxUndelivered) link->stream->pauseReading(false);
    }
    const bool closed = next.kind == TransportEvent::Kind::closed;
    if (link != nullptr && link->closing && !closed) continue;
    current_ = std::move(next.bytes);
    event.kind = next.kind;
    event.connection = next.connection;
    event.bytes = current_;
    event.reason = std::move(next.reason);
    return true;
  }
  return false;
}

void SocketCore::push(Link& link, TransportEvent::Kind kind, std::span<const std::byte> bytes) {
  Event event;
  event.kind = kind;
  event.connection = link.id;
  if (!spare_.empty() && !bytes.empty()) {
    event.bytes = std::move(spare_.back());
    spare_.pop_back();
  }
  event.bytes.assign(bytes.begin(), bytes.end());
  link.undelivered += bytes.size();
  if (link.undelivered > kMaxUndelivered) link.stream->pauseReading(true);
  queue_.push_back(std::move(event));
}

void SocketCore::queueClosed(ConnectionId id, std::string reason) {
  Event event;
  event.connection = id;
  event.reason = std::move(reason);
  queue_.push_back(std::move(event));
}

void SocketCore::payload(Link& link, FrameType type, std::span<const std::byte> bytes) {
  if (!link.announced || link.closing) return;
  if (type == FrameType::control) {
    counters_.controlBytesIn += bytes.size();
    push(link, TransportEvent::Kind::control, bytes);
  } else if (bytes.size() > kMaxStateBytes) {
    ++counters_.droppedOversized;
  } else {
    ++counters_.statePacketsIn;
    counters_.stateBytesIn += bytes.size();
    push(link, TransportEvent::Kind::state, bytes);
  }
}

void SocketCore::announce(const std::shared_ptr<Link>& link, ConnectionId id) {
  link->id = id;
  link->announced = true;
  link->stream->allowFrames(kMaxFrameBytes);
  links_[id] = link;
  push(*link, TransportEvent::Kind::connected, {});
}

void SocketCore::drop(Link& link, const std::string& reason) {
  const auto found = links_.find(link.id);
  if (found == links_.end() || found->second.get() != &link) return;
  if (link.closing) std::erase_if(queue_, [&](const Event& event) { return event.connection == link.id; });
  queueClosed(link.id, reason);
  retire(std::move(found->second));
  links_.erase(found);
}

void SocketCore::refuse(Link& link, const std::string& reason) {
  if (!link.refusal.empty()) return;
  const auto stream = link.stream;
  link.refusal = reason;
  link.deadline = now() + kCloseTime;
  stream->send(FrameType::farewell, std::as_bytes(std::span(reason)));
  stream->close();
}

// ---- bytes in from the application ----

void SocketCore::sendControl(ConnectionId connection, std::span<const std::byte> bytes) {
  ASSERT(bytes.size() <= kMaxControlBytes);
  Link* link = find(connection);
  if (link == nullptr || !link->announced || link->closing) return;
  if (link->stream->backlog() + bytes.size() > kMaxBacklog) return overflow(*link);
  counters_.controlBytesOut += bytes.size();
  link->stream->send(FrameType::control, bytes);
}

/// A peer that does not read gets no farewell: it would stand behind what it has not read.
void SocketCore::overflow(Link& link) {
  ++counters_.droppedFull;
  const auto stream = link.stream;
  stream->abandon();
  linkClosed(link, "the peer does not read: its queue is full");
}

void SocketCore::sendState(ConnectionId connection, std::span<const std::byte> bytes) {
  Link* link = find(connection);
  if (link == nullptr || !link->announced || link->closing) return;
  if (bytes.size() > kMaxStateBytes) {
    ++counters_.droppedOversized;
    return;
  }
  if (link->channel != nullptr && link->channel->usable()) {
    const std::size_t size = link->channel->sealState(bytes, outgoing_.data());
    if (size == 0) return refuse(*link, "the keys of this connection are used up: connect again");
    const UdpAddress* to = link->peer.size == 0 ? nullptr : &link->peer;
    if (!sendDatagram(udp_.native_handle(), to, {outgoing_.data(), size})) {
      ++counters_.droppedFull;
      return;
    }
  } else {
    if (link->stream->backlog() > kMaxStateBacklog) {
      ++counters_.droppedFull;
      return;
    }
    link->stream->send(FrameType::state, bytes);
  }
  ++counters_.statePacketsOut;
  counters_.stateBytesOut += bytes.size();
}

std::size_t SocketCore::controlBacklog(ConnectionId connection) const {
  const Link* link = find(connection);
  return link == nullptr || link->stream == nullptr ? 0 : link->stream->backlog();
}

void SocketCore::close(ConnectionId connection) {
  Link* link = find(connection);
  if (link == nullptr || link->closing) return;
  link->closing = true;
  link->deadline = now() + kCloseTime;
  if (link->stream == nullptr) return linkClosed(*link, {});
  const auto stream = link->stream;
  stream->close();
}

bool SocketCore::stateOverUdp(ConnectionId connection) const {
  const Link* link = find(connection);
  return link != nullptr && link->channel != nullptr && link->channel->usable();
}

// ---- datagrams ----

bool SocketCore::agree(Link& link, SealAlgorithm algorithm, std::uint64_t wireId, StateChannel::Side side) {
  StateKeys keys;
  if (!link.stream->exportKeys(algorithm, keys)) return false;
  link.channel = std::make_unique<StateChannel>(side, algorithm, keys, wireId, now());
  return true;
}

void SocketCore::sendProbe(Link& link, Micros at) {
  if (const std::size_t size = link.channel->probeIfDue(at, outgoing_.data()); size != 0) {
    sendDatagram(udp_.native_handle(), nullptr, {outgoing_.data(), size});
  }
}

void SocketCore::receiveUdp() {
  if (!udpReadable_ || !batch_.empty()) return;
  datagramTime_ = now();
  udpReadable_ = batch_.receive(udp_.native_handle());
}

bool SocketCore::findState() {
  while (!batch_.empty()) {
    if (open(batch_.take())) return stateReady_ = true;
  }
  return false;
}

bool SocketCore::open(const UdpBatch::Datagram& datagram) {
  if (datagram.oversized) return ++counters_.droppedOversized, false;
  if (datagram.bytes.size() < kSealOverheadBytes) return ++counters_.droppedUnknown, false;
  Link* link = linkOf(connectionIdOf(datagram.bytes));
  if (link == nullptr || link->closing) return ++counters_.droppedUnknown, false;
  const auto received =
      link->channel->receive(datagram.bytes, datagramTime_, opened_[openedIndex_].data(), outgoing_.data());
  if (received.verdict == Opener::Verdict::forged) return ++counters_.droppedForged, false;
  if (received.verdict == Opener::Verdict::replayed) return ++counters_.droppedReplayed, false;
  if (received.newest && peers_ == Peers::many) link->peer = *datagram.from;
  if (received.replyBytes != 0) {
    sendDatagram(udp_.native_handle(), link->peer.size == 0 ? nullptr : &link->peer,
                 {outgoing_.data(), received.replyBytes});
  }
  if (!received.isState) return false;
  ++counters_.statePacketsIn;
  counters_.stateBytesIn += received.size;
  openedFrom_ = link->id;
  openedSize_ = received.size;
  return true;
}

void SocketCore::watchUdp() {
  if (udpWatched_ || udpReadable_ || !udp_.is_open()) return;
  udpWatched_ = true;
  udp_.async_wait(asio::ip::udp::socket::wait_read, [this](const error_code& failure) {
    udpWatched_ = false;
    udpReadable_ = !failure;
  });
}

// ---- time ----

bool SocketCore::eventReady() {
  if (!queue_.empty() || stateReady_) return true;
  receiveUdp();
  return findState();
}

void SocketCore::keepHouse() {
  const Micros at = now();
  if (at < nextHousekeeping_) return;
  nextHousekeeping_ = at + kHousekeeping;
  for (const auto& [id, link] : std::unordered_map(links_)) {
    if (link->channel != nullptr) link->channel->update(at);
    if ((link->closing || !link->refusal.empty()) && at > link->deadline) {
      link->stream->abandon();
      linkClosed(*link, link->refusal);
    }
  }
  housekeeping(at);
}

/// The timer stays armed over many short waits: it may ring early, never late.
void SocketCore::armTimer(Micros at) {
  if (timerArmed_ && armedAt_ <= at) return;
  timerArmed_ = true;
  armedAt_ = at;
  timer_.expires_at(asio::steady_timer::time_point(std::chrono::microseconds(at)));
  timer_.async_wait([this](const error_code& failure) { timerArmed_ = timerArmed_ && failure; });
}

void SocketCore::wait(Micros timeout) {
  const Micros deadline = now() + std::max<Micros>(timeout, 0);
  retired_.clear();
  keepHouse();
  watchUdp();
  // Where it may block, run_one() takes in what has arrived just as well, with one system call less a
  // datagram.
  if (timeout <= 0 || woken_.load(std::memory_order_acquire) || eventReady()) io_.poll();
  while (!eventReady() && !woken_.load(std::memory_order_acquire)) {
    if (now() >= deadline) break;
    watchUdp();
    armTimer(std::min(deadline, nextHousekeeping_));
    io_.run_one();
    keepHouse();
  }
  woken_.store(false, std::memory_order_release);
}

void SocketCore::wake() {
  if (!woken_.exchange(true)) asio::post(io_, [] {});
}

void SocketCore::shutDown() {
  const Micros deadline = now() + kDestructionTime;
  const auto closing = [this] {
    return std::any_of(links_.begin(), links_.end(), [](const auto& entry) { return entry.second->closing; });
  };
  while (closing() && now() < deadline) io_.run_one_for(std::chrono::milliseconds(10));
  for (const auto& [id, link] : links_) {
    if (link->stream != nullptr) link->stream->abandon();
  }
}

}  // namespace tandem::sync
