#pragma once

// Real sockets: TLS 1.3 over TCP for control, UDP for state, sealed with keys from the TLS exporter
// (sync/transport/seal.h). Where UDP does not pass, state travels over TLS. The bytes are in sync/WIRE.md,
// section Transport.
//
// 1. One thread calls, except for wake(). Bytes move only inside wait(), which must be called in every round,
//    with 0 if there is no time.
// 2. An event may be polled as soon as wait() returns; several may have come. State events are not queued for
//    long: datagrams that nobody polls are lost in the kernel's buffer.
// 3. close() needs further wait() calls until its `closed` event; destroying the transport gives it half a
//    second.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "assets/base/result.h"
#include "sync/transport/handshake_queue.h"
#include "sync/transport/knock.h"
#include "sync/transport/transport.h"
#include "sync/wire/limits.h"
#include "sync/wire/time.h"

namespace tandem::sync {

/// A private key and its self-signed certificate, PEM.
struct TlsIdentity {
  std::string privateKey;
  std::string certificate;
};
/// A new Ed25519 (or P-256) key with a certificate for it.
Result<TlsIdentity> makeTlsIdentity();
/// The pin of an identity, as in a join link.
Result<std::string> pinOf(const TlsIdentity& identity);

class SocketTransport : public Transport {
 public:
  /// Runs the sockets until an event can be polled or `timeout` has passed.
  virtual void wait(Micros timeout) = 0;
  /// The local port of a server.
  virtual std::uint16_t port() const = 0;
  /// Whether the state of a connection travels over UDP (false: over TLS, because UDP does not pass or is not
  /// tried).
  virtual bool stateOverUdp(ConnectionId connection) const = 0;
  /// Wakes a wait() from another thread.
  virtual void wake() = 0;
};

struct ListenOptions {
  std::size_t maxConnections = kMaxSites + 264;  // beyond, a new connection is refused with the reason
  // TCP connections whose handshake has not begun. Beyond, the oldest one of the network with the most makes
  // way. Fewer where the process may open few files.
  std::size_t maxPendingHandshakes = 4096;
  Micros handshakeTimeout = 5 * kSecond;   // from TCP connection to the end of the greeting
  Micros firstBytesTimeout = 3 * kSecond;  // from TCP connection to the first TLS message
  // From the handshake's begin to trust(). Beyond, one makes way as above; known ones come last.
  std::size_t maxStrangers = 256;
  HandshakeRules handshakes{};
  std::function<bool(const Knock&)> knows{};       // whether this server made the knock
  std::size_t maxRequestBytes = kMaxRequestBytes;  // of a control message; a longer one ends its connection
};
/// host: an address or name to listen on ("" or "::": every address, IPv4 and IPv6); port 0: any free one,
/// for TCP and UDP alike.
Result<std::unique_ptr<SocketTransport>> listenOn(const std::string& host, std::uint16_t port,
                                                  const TlsIdentity& identity,
                                                  const ListenOptions& options = {});

struct ConnectOptions {
  bool udp = true;               // false: state over TLS only
  Micros timeout = 5 * kSecond;  // for the TCP connection and the handshake
  std::string credential{};      // token or ticket; its knock is shown, so that a busy server hears this site
};
/// Starts to connect; the outcome is a `connected` event, or `closed` with the reason (wrong key, refused,
/// timeout). An immediate error means that the pin is malformed.
Result<std::unique_ptr<SocketTransport>> connectTo(const std::string& host, std::uint16_t port,
                                                   const std::string& pin,
                                                   const ConnectOptions& options = {});

}  // namespace tandem::sync
