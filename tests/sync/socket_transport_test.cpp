#include "sync/socket_transport.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <vector>

#include "sync/messages.h"

namespace tandem::sync {
namespace {

using Bytes = std::vector<std::byte>;
using Kind = TransportEvent::Kind;

Bytes bytesOf(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

struct Seen {
  Kind kind;
  ConnectionId connection;
  Bytes bytes;
  std::string reason;
};

/// One end with everything it has heard.
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

const TlsIdentity& identity() {
  static const TlsIdentity made = makeTlsIdentity().value();
  return made;
}
std::string pin() { return pinOf(identity()).value(); }

class Sockets : public testing::Test {
 protected:
  void listen(const ListenOptions& options = {}) {
    auto transport = listenOn("127.0.0.1", 0, identity(), options);
    ASSERT_TRUE(transport.ok()) << transport.error().message;
    server_.transport = std::move(transport).value();
    port_ = server_.transport->port();
  }
  End connect(const ConnectOptions& options = {}) {
    auto transport = connectTo("127.0.0.1", port_, pin(), options);
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
    }
    return done();
  }
  /// A client that is connected, known to the server, and sends its state the way it should.
  End joined(bool udp = true) {
    End site = connect({.udp = udp});
    const std::size_t before = server_.count(Kind::connected);
    EXPECT_TRUE(runUntil({&site}, [&] {
      return server_.count(Kind::connected) > before && site.count(Kind::connected) == 1 &&
             site.transport->stateOverUdp(0) == udp &&
             server_.transport->stateOverUdp(server_.last(Kind::connected)->connection) == udp;
    }));
    return site;
  }

  End server_;
  std::uint16_t port_ = 0;
};

TEST_F(Sockets, CarryControlBothWays) {
  listen();
  End site = joined();
  const ConnectionId id = server_.last(Kind::connected)->connection;
  site.transport->sendControl(0, bytesOf("up"));
  server_.transport->sendControl(id, bytesOf("down"));
  ASSERT_TRUE(
      runUntil({&site}, [&] { return server_.count(Kind::control) == 1 && site.count(Kind::control) == 1; }));
  EXPECT_EQ(server_.last(Kind::control)->bytes, bytesOf("up"));
  EXPECT_EQ(server_.last(Kind::control)->connection, id);
  EXPECT_EQ(site.last(Kind::control)->bytes, bytesOf("down"));
}

TEST_F(Sockets, CarryStateOverUdp) {
  listen();
  End site = joined();
  const ConnectionId id = server_.last(Kind::connected)->connection;
  site.transport->sendState(0, bytesOf("up"));
  server_.transport->sendState(id, bytesOf("down"));
  ASSERT_TRUE(
      runUntil({&site}, [&] { return server_.count(Kind::state) == 1 && site.count(Kind::state) == 1; }));
  EXPECT_EQ(server_.last(Kind::state)->bytes, bytesOf("up"));
  EXPECT_EQ(site.last(Kind::state)->bytes, bytesOf("down"));
}

TEST_F(Sockets, CarryStateOverTlsWhereUdpIsNotUsed) {
  listen();
  End site = joined(false);
  const ConnectionId id = server_.last(Kind::connected)->connection;
  site.transport->sendState(0, bytesOf("up"));
  server_.transport->sendState(id, bytesOf("down"));
  ASSERT_TRUE(
      runUntil({&site}, [&] { return server_.count(Kind::state) == 1 && site.count(Kind::state) == 1; }));
  EXPECT_EQ(server_.last(Kind::state)->bytes, bytesOf("up"));
  EXPECT_EQ(site.last(Kind::state)->bytes, bytesOf("down"));
}

}  // namespace
}  // namespace tandem::sync
