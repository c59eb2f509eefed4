#pragma once

// The two ends of real sockets on loopback, driven in turn by one thread, for the tests of the transport.

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "sync/transport/socket_transport.h"

namespace tandem::sync {
using Bytes = std::vector<std::byte>;
using Kind = TransportEvent::Kind;

inline Bytes bytesOf(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

inline Bytes randomBytes(std::size_t size, unsigned seed = 1) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::byte>(random() & 0xff);
  return bytes;
}

struct Seen {
  Kind kind;
  ConnectionId connection;
  Bytes bytes;
  std::string reason;
};

/// One end with everything that it has received.
struct End {
  std::unique_ptr<SocketTransport> transport;
  std::deque<Seen> seen;

  void turn(Micros timeout) {
    if (transport == nullptr) return;
    transport->wait(timeout);
    TransportEvent event;
    while (transport->poll(event)) {
      seen.push_back(
          {event.kind, event.connection, Bytes(event.bytes.begin(), event.bytes.end()), event.reason});
    }
  }
  const TransportCounters& counters() const { return transport->counters(); }
  std::size_t count(Kind kind) const {
    return static_cast<std::size_t>(
        std::count_if(seen.begin(), seen.end(), [&](const Seen& s) { return s.kind == kind; }));
  }
  const Seen* last(Kind kind) const {
    for (auto i = seen.rbegin(); i != seen.rend(); ++i) {
      if (i->kind == kind) return &*i;
    }
    return nullptr;
  }
};

inline const TlsIdentity& identity() {
  static const TlsIdentity made = makeTlsIdentity().value();
  return made;
}
inline std::string pin() { return pinOf(identity()).value(); }

class Sockets : public testing::Test {
 protected:
  void listen(const ListenOptions& options = {}) {
    auto transport = listenOn("127.0.0.1", 0, identity(), options);
    ASSERT_TRUE(transport.ok()) << transport.error().message;
    server_.transport = std::move(transport).value();
    port_ = server_.transport->port();
  }
  End connect(const ConnectOptions& options = {}, std::uint16_t port = 0) {
    auto transport = connectTo("127.0.0.1", port == 0 ? port_ : port, pin(), options);
    EXPECT_TRUE(transport.ok());
    End end;
    end.transport = std::move(transport).value();
    return end;
  }
  /// Runs all ends until `done`, for at most `rounds` of about 2 ms each.
  bool runUntil(const std::vector<End*>& ends, const std::function<bool()>& done, int rounds = 5000) {
    for (int i = 0; i < rounds && !done(); ++i) {
      server_.turn(kMillisecond);
      for (End* end : ends) end->turn(kMillisecond / 2);
      if (meanwhile_) meanwhile_();
    }
    return done();
  }
  /// A client that is connected, known to the server, and sends its state on the expected path.
  End joined(bool udp = true) {
    End site = connect({.udp = udp});
    const std::size_t before = server_.count(Kind::connected);
    EXPECT_TRUE(runUntil({&site}, [&] {
      return server_.count(Kind::connected) > before && site.count(Kind::connected) == 1 &&
             site.transport->stateOverUdp(0) == udp &&
             server_.transport->stateOverUdp(server_.last(Kind::connected)->connection) == udp;
    }));
    server_.transport->trust(newest());
    return site;
  }

  ConnectionId newest() const { return server_.last(Kind::connected)->connection; }

  End server_;
  std::function<void()> meanwhile_;  // what else runs in each round
  std::uint16_t port_ = 0;
};

}  // namespace tandem::sync
