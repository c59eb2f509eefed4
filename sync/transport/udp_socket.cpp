#include "sync/transport/udp_socket.h"

#include <sys/socket.h>

#include <cerrno>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

constexpr int kSocketBufferBytes = 4 << 20;

}  // namespace

struct UdpBatch::Buffers {
  // One byte more than the largest good datagram, so that a longer one is detected.
  std::array<std::array<std::byte, kMaxDatagramBytes + 1>, kCapacity> bytes;
  std::array<UdpAddress, kCapacity> addresses;
  std::array<iovec, kCapacity> vectors{};
  std::array<mmsghdr, kCapacity> headers{};
};

UdpBatch::UdpBatch() : buffers_(std::make_unique<Buffers>()) {
  for (std::size_t i = 0; i < kCapacity; ++i) {
    buffers_->vectors[i] = {buffers_->bytes[i].data(), buffers_->bytes[i].size()};
    msghdr& header = buffers_->headers[i].msg_hdr;
    header.msg_iov = &buffers_->vectors[i];
    header.msg_iovlen = 1;
    header.msg_name = &buffers_->addresses[i].storage;
  }
}
UdpBatch::~UdpBatch() = default;

bool UdpBatch::receive(int socket) {
  ASSERT(empty());
  next_ = count_ = 0;
  for (mmsghdr& header : buffers_->headers) header.msg_hdr.msg_namelen = sizeof(sockaddr_in6);
  const int received = recvmmsg(socket, buffers_->headers.data(), kCapacity, MSG_DONTWAIT, nullptr);
  // ECONNREFUSED reports an earlier packet that met a closed port; it is consumed by reading it, and more may
  // follow.
  if (received < 0) return errno == ECONNREFUSED || errno == EINTR;
  count_ = static_cast<std::size_t>(received);
  return count_ == kCapacity;
}

UdpBatch::Datagram UdpBatch::pop() {
  ASSERT(!empty());
  const std::size_t i = next_++;
  const mmsghdr& header = buffers_->headers[i];
  UdpAddress& from = buffers_->addresses[i];
  from.size = header.msg_hdr.msg_namelen;
  const bool oversized = header.msg_len > kMaxDatagramBytes || (header.msg_hdr.msg_flags & MSG_TRUNC) != 0;
  return {{buffers_->bytes[i].data(), header.msg_len}, &from, oversized};
}

struct UdpSendBatch::Buffers {
  std::array<std::array<std::byte, kMaxDatagramBytes>, kCapacity> bytes;
  std::array<UdpAddress, kCapacity> addresses;
  std::array<iovec, kCapacity> vectors{};
  std::array<mmsghdr, kCapacity> headers{};
};

UdpSendBatch::UdpSendBatch() : buffers_(std::make_unique<Buffers>()) {
  for (std::size_t i = 0; i < kCapacity; ++i) {
    buffers_->vectors[i] = {buffers_->bytes[i].data(), 0};
    msghdr& header = buffers_->headers[i].msg_hdr;
    header.msg_iov = &buffers_->vectors[i];
    header.msg_iovlen = 1;
    header.msg_name = &buffers_->addresses[i].storage;
  }
}
UdpSendBatch::~UdpSendBatch() = default;

std::byte* UdpSendBatch::next() {
  ASSERT(!full());
  return buffers_->bytes[count_].data();
}

void UdpSendBatch::add(const UdpAddress& to, std::size_t bytes) {
  ASSERT(!full() && bytes > 0 && bytes <= kMaxDatagramBytes && to.size > 0);
  buffers_->vectors[count_].iov_len = bytes;
  buffers_->addresses[count_] = to;
  buffers_->headers[count_].msg_hdr.msg_namelen = to.size;
  ++count_;
}

std::size_t UdpSendBatch::send(int socket) {
  std::size_t dropped = 0;
  for (std::size_t from = 0; from < count_;) {
    const int sent = sendmmsg(socket, &buffers_->headers[from], static_cast<unsigned>(count_ - from),
                              MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent > 0) {
      from += static_cast<std::size_t>(sent);
    } else if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS) {
      dropped = count_ - from;
      break;
    } else if (errno != EINTR) {
      ++from;  // unreachable, refused: a lost datagram, which the probes notice when it lasts
    }
  }
  count_ = 0;
  return dropped;
}

bool sendDatagram(int socket, const UdpAddress* to, std::span<const std::byte> bytes) {
  const auto* address = to == nullptr ? nullptr : reinterpret_cast<const sockaddr*>(&to->storage);
  const ssize_t sent = sendto(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL, address,
                              to == nullptr ? 0 : to->size);
  // Any other error (unreachable, refused) is a lost datagram: the probes notice when it lasts.
  return sent >= 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != ENOBUFS);
}

void enlargeBuffers(int socket) {
  setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &kSocketBufferBytes, sizeof kSocketBufferBytes);
  setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kSocketBufferBytes, sizeof kSocketBufferBytes);
}

}  // namespace tandem::sync
