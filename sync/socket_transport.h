#pragma once

// Real sockets: TLS 1.3 over TCP for control (4-byte big-endian length, then the message), UDP for state, sealed with keys
// from the TLS exporter (sync/seal.h). Where UDP does not pass, state travels over TLS. One thread; wait() runs the
// sockets.

#include <cstdint>
#include <memory>
#include <string>

#include "assets/result.h"
#include "sync/time.h"
#include "sync/transport.h"

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
  /// Whether the state of a connection travels over UDP (false: over TLS, because UDP does not pass or is not tried).
  virtual bool stateOverUdp(ConnectionId connection) const = 0;
  /// Wakes a wait() from another thread.
  virtual void wake() = 0;
};

/// host: an address or name to listen on; port 0: any free one.
Result<std::unique_ptr<SocketTransport>> listenOn(const std::string& host, std::uint16_t port,
                                                  const TlsIdentity& identity);

struct ConnectOptions {
  bool udp = true;                     // false: state over TLS only
  Micros timeout = 5 * kSecond;        // for the TCP connection and the handshake
};
/// Starts to connect; the outcome is a `connected` event, or `closed` with the reason (wrong key, refused, timeout).
Result<std::unique_ptr<SocketTransport>> connectTo(const std::string& host, std::uint16_t port, const std::string& pin,
                                                   const ConnectOptions& options = {});

}  // namespace tandem::sync
