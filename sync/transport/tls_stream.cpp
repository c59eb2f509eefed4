#include "sync/transport/tls_stream.h"

#include <netinet/tcp.h>
#include <openssl/crypto.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/ssl/error.hpp>
#include <cstring>
#include <string_view>

#include "sync/transport/tls_identity.h"

namespace tandem::sync {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr std::size_t kLengthBytes = 4;
constexpr std::size_t kFirstInputBytes = 20 * 1024;  // a TLS record and what is left of the one before
constexpr std::string_view kExporterLabel = "EXPORTER-tandem-state-v1";

std::uint32_t loadLength(const std::byte* in) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < kLengthBytes; ++i) value = value << 8 | std::to_integer<std::uint32_t>(in[i]);
  return value;
}

std::string reasonOf(const error_code& failure) {
  if (failure == asio::error::eof) return "the peer closed the connection";
  if (failure == asio::ssl::error::stream_truncated || failure == asio::error::connection_reset ||
      failure == asio::error::broken_pipe) {
    return "the connection broke off: the peer is gone";
  }
  if (failure == asio::error::timed_out) return "the connection broke off: no sign of the peer";
  if (failure.category() == asio::error::get_ssl_category()) return "TLS failed: " + failure.message();
  return "the connection broke off: " + failure.message();
}

}  // namespace

TlsStream::TlsStream(asio::ip::tcp::socket socket, asio::ssl::context& context, Listener& listener)
    : stream_(std::move(socket), context), listener_(&listener) {}

void TlsStream::showProtocol(const std::string& name) {
  const std::string list = static_cast<char>(name.size()) + name;
  SSL_set_alpn_protos(stream_.native_handle(), reinterpret_cast<const unsigned char*>(list.data()),
                      static_cast<unsigned>(list.size()));
}

void TlsStream::start(Side side) {
  const auto type = side == Side::client ? asio::ssl::stream_base::client : asio::ssl::stream_base::server;
  stream_.async_handshake(
      type, [self = shared_from_this()](const error_code& failure) { self->handshakeDone(failure); });
}

void TlsStream::handshakeDone(const Code& failure) {
  if (listener_ == nullptr) return;
  if (failure) {
    if (failedByPin(stream_.native_handle()))
      return finish("the server's key is not the one in the join link");
    return finish("no TLS 1.3 handshake: " + failure.message());
  }
  open_ = true;
  input_.resize(kFirstInputBytes);
  listener_->onHandshake();
  read();
  write();
}

void TlsStream::read() {
  if (!open_ || reading_ || readingPaused_ || listener_ == nullptr) return;
  compactInput();
  reading_ = true;
  stream_.async_read_some(asio::buffer(input_.data() + inputEnd_, input_.size() - inputEnd_),
                          [self = shared_from_this()](const error_code& failure, std::size_t bytes) {
                            self->readDone(failure, bytes);
                          });
}

void TlsStream::compactInput() {
  if (inputBegin_ == inputEnd_) {
    inputBegin_ = inputEnd_ = 0;
  } else if (inputEnd_ == input_.size()) {
    if (inputBegin_ > 0) {
      std::memmove(input_.data(), input_.data() + inputBegin_, inputEnd_ - inputBegin_);
      inputEnd_ -= inputBegin_;
      inputBegin_ = 0;
    } else {
      input_.resize(std::min(input_.size() * 2, kLengthBytes + maxFrame_ + kFirstInputBytes));
    }
  }
}

void TlsStream::readDone(const Code& failure, std::size_t bytes) {
  reading_ = false;
  if (listener_ == nullptr) return;
  inputEnd_ += bytes;
  if (!parseFrames()) return;
  if (failure) return finish(closing_ ? std::string() : reasonOf(failure));
  read();
}

bool TlsStream::parseFrames() {
  const auto self = shared_from_this();  // a listener may release this stream
  while (listener_ != nullptr && inputEnd_ - inputBegin_ >= kLengthBytes) {
    const std::byte* begin = input_.data() + inputBegin_;
    const std::size_t length = loadLength(begin);
    if (length == 0 || length > maxFrame_) {
      finish("the peer broke the protocol: a frame of " + std::to_string(length) + " bytes");
      return false;
    }
    if (inputEnd_ - inputBegin_ < kLengthBytes + length) break;
    inputBegin_ += kLengthBytes + length;
    if (closing_) continue;  // what arrives after close() is dropped
    listener_->onFrame(static_cast<FrameType>(begin[kLengthBytes]), {begin + kLengthBytes + 1, length - 1});
  }
  return listener_ != nullptr;
}

void TlsStream::pauseReading(bool paused) {
  readingPaused_ = paused;
  if (!paused) read();
}

void TlsStream::send(FrameType type, std::span<const std::byte> bytes) {
  if (listener_ == nullptr || closing_) return;
  const auto length = static_cast<std::uint32_t>(bytes.size() + 1);
  for (int shift = 24; shift >= 0; shift -= 8)
    pending_.push_back(static_cast<std::byte>(length >> shift & 0xff));
  pending_.push_back(static_cast<std::byte>(type));
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  write();
}

void TlsStream::write() {
  if (!open_ || writeInFlight_ || shuttingDown_) return;
  if (written_ == writing_.size()) {
    writing_.clear();
    written_ = 0;
    writing_.swap(pending_);
  }
  if (writing_.empty()) {
    if (closing_) shutDown();
    return;
  }
  writeInFlight_ = true;
  stream_.async_write_some(asio::buffer(writing_.data() + written_, writing_.size() - written_),
                           [self = shared_from_this()](const error_code& failure, std::size_t bytes) {
                             self->writeDone(failure, bytes);
                           });
}

void TlsStream::writeDone(const Code& failure, std::size_t bytes) {
  writeInFlight_ = false;
  if (listener_ == nullptr) return;
  written_ += bytes;
  // A peer that closed may have sent a farewell, which is still in the input. The pending read then reports
  // the end of the connection.
  if (failure && reading_ && !closing_) return;
  if (failure) return finish(closing_ ? std::string() : reasonOf(failure));
  write();
}

void TlsStream::close() {
  if (closing_ || listener_ == nullptr) return;
  closing_ = true;
  readingPaused_ = false;
  if (!open_) return finish(std::string());
  read();
  write();
}

void TlsStream::shutDown() {
  shuttingDown_ = true;
  stream_.async_shutdown([self = shared_from_this()](const error_code&) { self->finish(std::string()); });
}

void TlsStream::finish(const std::string& reason) {
  if (listener_ == nullptr) return;
  Listener* listener = std::exchange(listener_, nullptr);
  abandon();
  listener->onClosed(reason);
}

void TlsStream::abandon() {
  listener_ = nullptr;
  auto& socket = stream_.next_layer();
  if (!socket.is_open()) return;
  // Closing a TCP socket with unread input resets the connection (RFC 1122 section 4.2.2.13), which discards
  // what the peer has not read yet.
  std::array<char, 4096> rest;
  for (int i = 0; i < 64 && recv(socket.native_handle(), rest.data(), rest.size(), MSG_DONTWAIT) > 0; ++i) {
  }
  error_code ignored;
  socket.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket.close(ignored);
}

bool TlsStream::exportKeys(SealAlgorithm algorithm, StateKeys& keys) {
  std::array<unsigned char, 88> material;
  const auto context = static_cast<unsigned char>(algorithm);
  if (SSL_export_keying_material(stream_.native_handle(), material.data(), material.size(),
                                 kExporterLabel.data(), kExporterLabel.size(), &context, 1, 1) != 1) {
    return false;
  }
  const unsigned char* from = material.data();
  const auto fill = [&from](auto& field) {
    std::memcpy(field.data(), from, field.size());
    from += field.size();
  };
  fill(keys.clientToServer.key);
  fill(keys.serverToClient.key);
  fill(keys.clientToServer.iv);
  fill(keys.serverToClient.iv);
  OPENSSL_cleanse(material.data(), material.size());
  return true;
}

void tuneTcp(asio::ip::tcp::socket& socket) {
  error_code ignored;
  socket.set_option(asio::ip::tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::keep_alive(true), ignored);
  const auto set = [&](int option, unsigned value) {
    setsockopt(socket.native_handle(), IPPROTO_TCP, option, &value, sizeof value);
  };
  set(TCP_KEEPIDLE, 5);
  set(TCP_KEEPINTVL, 2);
  set(TCP_KEEPCNT, 3);
  set(TCP_USER_TIMEOUT, 10000);  // ms
}

}  // namespace tandem::sync
