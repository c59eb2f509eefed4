#include "sync/transport/front_door.h"

#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace tandem::sync {
namespace {

constexpr int kAcceptsAtOnce = 64;
constexpr int kEventsAtOnce = 128;
constexpr Micros kAcceptPause = 100 * kMillisecond;  // when the process is out of file descriptors
constexpr std::uint64_t kListener = 0;               // what epoll says of the listener, no visitor's id

/// A quarter of what the process may open: the rest is for connections and files.
std::size_t descriptorShare() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return 4096;
  return std::max<std::size_t>(16, limit.rlim_cur / 4);
}

/// Ends a connection with a reset, after which the kernel keeps nothing of it.
void cut(int socket) {
  const linger none{.l_onoff = 1, .l_linger = 0};
  setsockopt(socket, SOL_SOCKET, SO_LINGER, &none, sizeof none);
  ::close(socket);
}

std::uint64_t keyOf(const Knock& knock) {
  std::uint64_t key = 0;
  std::memcpy(&key, knock.data(), sizeof key);
  return key;
}

}  // namespace

Network networkOf(const sockaddr_storage& address) {
  constexpr Network kIpv4 = 0xffffffff00000000u;  // no prefix of a sender: FF00::/8 is multicast
  if (address.ss_family == AF_INET)
    return kIpv4 | ntohl(reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr);
  if (address.ss_family != AF_INET6) return 0;
  const in6_addr& ipv6 = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  Network high = 0, low = 0;
  for (int i = 0; i < 8; ++i) high = high << 8 | ipv6.s6_addr[i];
  for (int i = 8; i < 16; ++i) low = low << 8 | ipv6.s6_addr[i];
  return IN6_IS_ADDR_V4MAPPED(&ipv6) ? kIpv4 | (low & 0xffffffffu) : high;
}

FrontDoor::FrontDoor(const ListenOptions& options)
    : maxVisitors_(std::min(options.maxPendingHandshakes, descriptorShare())),
      firstBytesTimeout_(std::min(options.firstBytesTimeout, options.handshakeTimeout)),
      handshakeTimeout_(options.handshakeTimeout),
      knows_(options.knows),
      queue_(options.handshakes) {}

FrontDoor::~FrontDoor() {
  close();
  if (epoll_ >= 0) ::close(epoll_);
}

bool FrontDoor::open(int listener) {
  epoll_ = epoll_create1(EPOLL_CLOEXEC);
  listener_ = listener;
  epoll_event event{.events = EPOLLIN, .data = {.u64 = kListener}};
  return epoll_ >= 0 && epoll_ctl(epoll_, EPOLL_CTL_ADD, listener, &event) == 0;
}

void FrontDoor::close() {
  if (listener_ >= 0) epoll_ctl(epoll_, EPOLL_CTL_DEL, listener_, nullptr);
  listener_ = -1;
  while (!visitors_.empty()) drop(visitors_.begin()->first);
}

void FrontDoor::watchListener(bool watched) {
  epoll_event event{.events = watched ? EPOLLIN : 0u, .data = {.u64 = kListener}};
  epoll_ctl(epoll_, EPOLL_CTL_MOD, listener_, &event);
}

void FrontDoor::work(Micros now) {
  std::array<epoll_event, kEventsAtOnce> events;
  const int count = epoll_wait(epoll_, events.data(), kEventsAtOnce, 0);
  for (int i = 0; i < count; ++i) {
    const epoll_event& event = events[static_cast<std::size_t>(i)];
    const std::uint64_t id = event.data.u64;
    if (id == kListener)
      acceptSome(now);
    else if ((event.events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0)
      drop(id);
    else
      readFirst(id, now);
  }
}

void FrontDoor::acceptSome(Micros now) {
  for (int i = 0; i < kAcceptsAtOnce; ++i) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    const int socket = accept4(listener_, reinterpret_cast<sockaddr*>(&address), &size,
                               SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket >= 0) {
      accepted(socket, address, now);
    } else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
      if (queue_.size() > 0) {
        drop(queue_.crowded());
        continue;
      }
      watchListener(false);
      acceptAt_ = now + kAcceptPause;
      return;
    } else if (errno != ECONNABORTED && errno != EINTR) {
      return;
    }
  }
}

void FrontDoor::accepted(int socket, const sockaddr_storage& address, Micros now) {
  if (queue_.size() >= maxVisitors_) drop(queue_.crowded());
  const VisitorId id = nextId_++;
  const Network network = networkOf(address);
  epoll_event event{.events = EPOLLIN | EPOLLRDHUP | EPOLLET, .data = {.u64 = id}};
  if (epoll_ctl(epoll_, EPOLL_CTL_ADD, socket, &event) != 0) {
    cut(socket);
    ++dropped_;
    return;
  }
  visitors_[id] = {socket, network, now, false};
  queue_.enter(id, network);
}

void FrontDoor::readFirst(VisitorId id, Micros now) {
  const auto found = visitors_.find(id);
  if (found == visitors_.end() || found->second.ready) return;
  std::array<std::uint8_t, kMaxFirstBytes> bytes;
  const ssize_t size = recv(found->second.socket, bytes.data(), bytes.size(), MSG_PEEK | MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) return drop(id);
  const FirstBytes first = readFirstBytes({bytes.data(), static_cast<std::size_t>(size)});
  if (first.kind == FirstBytes::Kind::incomplete) return;
  if (first.kind == FirstBytes::Kind::foreign) return drop(id);
  found->second.ready = true;
  const bool known = first.knock && knows_ && knows_(*first.knock);
  queue_.ready(id, known ? std::optional(keyOf(*first.knock)) : std::nullopt, now);
}

void FrontDoor::drop(VisitorId id) {
  const auto found = visitors_.find(id);
  if (found == visitors_.end()) return;
  cut(found->second.socket);  // which takes it off epoll
  queue_.leave(id);
  visitors_.erase(found);
  ++dropped_;
}

void FrontDoor::expire(Micros now) {
  if (acceptAt_ != 0 && now >= acceptAt_ && listener_ >= 0) {
    acceptAt_ = 0;
    watchListener(true);
  }
  for (auto at = visitors_.begin(); at != visitors_.end();) {
    const auto [id, visitor] = *at++;
    const Micros waited = now - visitor.since;
    if (waited < firstBytesTimeout_) break;
    if (!visitor.ready || waited >= handshakeTimeout_) drop(id);
  }
}

std::optional<FrontDoor::Guest> FrontDoor::next(Micros now, bool idle) {
  const std::optional<HandshakeQueue::Turn> turn = queue_.next(now, idle);
  if (!turn) return std::nullopt;
  const auto found = visitors_.find(turn->visitor);
  const Guest guest{turn->visitor, found->second.socket, found->second.network, turn->known,
                    found->second.since};
  epoll_ctl(epoll_, EPOLL_CTL_DEL, guest.socket, nullptr);
  visitors_.erase(found);
  return guest;
}

std::uint64_t FrontDoor::drainDropped() { return std::exchange(dropped_, 0); }

}  // namespace tandem::sync
