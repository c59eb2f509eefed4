#pragma once

// One TLS connection that carries frames: 4 bytes of length (big-endian), one byte of type, the payload; the
// length counts type and payload. Internal to the transport: includes Asio.
//
// 1. Everything runs on the thread of the io_context; a listener is called from there and may call back.
// 2. After onClosed, or abandon(), the listener is never called again.
// 3. The memory that a peer can occupy is bounded: input grows only as bytes arrive, up to one frame of the
//    allowed size.

#include <utility>
// Asio needs <utility> before it.
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sync/transport/state_channel.h"
#include "sync/wire/limits.h"

namespace tandem::sync {

enum class FrameType : std::uint8_t {
  control = 0,   // a control message
  state = 1,     // a state packet, where UDP does not pass
  offer = 2,     // client, first: version, algorithms
  accept = 3,    // server, in answer: algorithm, connection id of the datagrams
  farewell = 4,  // why this end closes, UTF-8
};

inline constexpr std::size_t kMaxFrameBytes = kMaxControlBytes + 1;  // with its type
inline constexpr std::size_t kMaxGreetingBytes = 64;                 // before the peer has introduced itself

class TlsStream : public std::enable_shared_from_this<TlsStream> {
 public:
  class Listener {
   public:
    virtual ~Listener() = default;
    virtual void onHandshake() = 0;
    /// The bytes are valid during the call.
    virtual void onFrame(FrameType type, std::span<const std::byte> bytes) = 0;
    /// The connection is over; empty: it was closed by close() and everything was sent.
    virtual void onClosed(const std::string& reason) = 0;
  };
  enum class Side : std::uint8_t { client, server };

  TlsStream(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context& context, Listener& listener);

  /// Begins the TLS handshake over a connected socket.
  void start(Side side);
  /// A client shows this name in its list of protocols (ALPN). Before start().
  void showProtocol(const std::string& name);
  /// Sets the largest size of a frame from now on.
  void allowFrames(std::size_t bytes) { maxFrame_ = bytes; }
  /// Queues a frame.
  void send(FrameType type, std::span<const std::byte> bytes);
  /// Bytes queued and not yet given to the kernel.
  std::size_t backlog() const { return writing_.size() - written_ + pending_.size(); }
  /// Stops or resumes reading, for a listener with too much queued.
  void pauseReading(bool paused);
  /// Sends what is queued, shuts TLS down, closes; then onClosed("").
  void close();
  bool closing() const { return closing_; }
  /// Cuts the connection; the listener is not called again.
  void abandon();

  /// Exports keying material for the datagrams (RFC 8446 section 7.5). After onHandshake.
  [[nodiscard]] bool exportKeys(SealAlgorithm algorithm, StateKeys& keys);

 private:
  using Code = boost::system::error_code;
  void handshakeDone(const Code& failure);
  void read();
  void readDone(const Code& failure, std::size_t bytes);
  /// Hands out whole frames; false if the connection ended meanwhile.
  bool parseFrames();
  void compactInput();
  void write();
  void writeDone(const Code& failure, std::size_t bytes);
  void shutDown();
  void finish(const std::string& reason);

  boost::asio::ssl::stream<boost::asio::ip::tcp::socket> stream_;
  Listener* listener_;
  std::vector<std::byte> input_;
  std::size_t inputBegin_ = 0, inputEnd_ = 0;
  std::vector<std::byte> pending_, writing_;
  std::size_t written_ = 0;
  std::size_t maxFrame_ = kMaxGreetingBytes;
  bool open_ = false, readingPaused_ = false, reading_ = false, writeInFlight_ = false;
  bool closing_ = false, shuttingDown_ = false;
};

/// Bounds the time for which TCP retransmits to a silent peer or keeps an idle connection to one, and turns
/// off Nagle's algorithm (RFC 896), which delays small messages.
void tuneTcp(boost::asio::ip::tcp::socket& socket);

}  // namespace tandem::sync
