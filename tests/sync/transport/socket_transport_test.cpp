#include "sync/transport/socket_transport.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/sync/transport/socket_ends.h"

namespace tandem::sync {
namespace {

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

TEST_F(Sockets, CarryTheLargestControlMessageAndStateWhole) {
  listen({.maxRequestBytes = kMaxControlBytes});
  End site = joined();
  const Bytes control = randomBytes(kMaxControlBytes), state = randomBytes(kMaxStateBytes);
  site.transport->sendControl(0, control);
  server_.transport->sendControl(newest(), control);
  site.transport->sendState(0, state);
  server_.transport->sendState(newest(), state);
  ASSERT_TRUE(runUntil({&site}, [&] {
    return server_.count(Kind::control) == 1 && site.count(Kind::control) == 1 &&
           server_.count(Kind::state) == 1 && site.count(Kind::state) == 1;
  }));
  EXPECT_EQ(server_.last(Kind::control)->bytes, control);
  EXPECT_EQ(site.last(Kind::control)->bytes, control);
  EXPECT_EQ(server_.last(Kind::state)->bytes, state);
  EXPECT_EQ(site.last(Kind::state)->bytes, state);
}

TEST_F(Sockets, KeepTheOrderOfControlMessages) {
  listen();
  End site = joined();
  for (int i = 0; i < 300; ++i) site.transport->sendControl(0, Bytes(static_cast<std::size_t>(i * 37 % 900)));
  ASSERT_TRUE(runUntil({&site}, [&] { return server_.count(Kind::control) == 300; }));
  std::size_t i = 0;
  for (const Seen& seen : server_.seen) {
    if (seen.kind != Kind::control) continue;
    EXPECT_EQ(seen.bytes.size(), i++ * 37 % 900);
  }
}

TEST_F(Sockets, RefuseAnOversizedState) {
  listen();
  End site = joined();
  site.transport->sendState(0, Bytes(kMaxStateBytes + 1));
  EXPECT_EQ(site.counters().droppedOversized, 1u);
  EXPECT_EQ(site.counters().statePacketsOut, 0u);
}

TEST_F(Sockets, ServeManySitesAtOnce) {
  constexpr std::size_t kSites = 32;
  listen();
  std::vector<End> sites(kSites);
  std::vector<End*> ends;
  for (End& site : sites) {
    site = connect();
    ends.push_back(&site);
  }
  ASSERT_TRUE(runUntil(ends, [&] {
    return server_.count(Kind::connected) == kSites &&
           std::all_of(sites.begin(), sites.end(), [](const End& s) { return s.transport->stateOverUdp(0); });
  }));
  for (std::size_t i = 0; i < kSites; ++i) {
    sites[i].transport->sendControl(0, Bytes(i + 1));
    sites[i].transport->sendState(0, Bytes(i + 1));
  }
  ASSERT_TRUE(runUntil(
      ends, [&] { return server_.count(Kind::control) == kSites && server_.count(Kind::state) == kSites; }));
  // Each connection's control and state carry the same size: nothing is mistaken for another's.
  std::vector<std::size_t> control(kSites), state(kSites);
  for (const Seen& seen : server_.seen) {
    ASSERT_LT(seen.connection, kSites);
    if (seen.kind == Kind::control) control[seen.connection] = seen.bytes.size();
    if (seen.kind == Kind::state) state[seen.connection] = seen.bytes.size();
  }
  EXPECT_EQ(control, state);
}

TEST_F(Sockets, CloseSendsWhatIsQueuedFirst) {
  listen({.maxRequestBytes = kMaxControlBytes});
  End site = joined();
  for (unsigned i = 0; i < 40; ++i) site.transport->sendControl(0, randomBytes(64 * 1024, i));
  site.transport->close(0);
  ASSERT_TRUE(
      runUntil({&site}, [&] { return server_.count(Kind::closed) == 1 && site.count(Kind::closed) == 1; }));
  EXPECT_EQ(server_.count(Kind::control), 40u);
  EXPECT_EQ(server_.seen.back().kind, Kind::closed);
  EXPECT_EQ(server_.last(Kind::closed)->reason, "the peer closed the connection");
  EXPECT_EQ(site.last(Kind::closed)->reason, "");
}

TEST_F(Sockets, AClosedTransportThatIsDestroyedAtOnceStillSendsWhatIsQueued) {
  listen();
  End site = joined();
  site.transport->sendControl(0, bytesOf("goodbye"));
  site.transport->close(0);
  site.transport.reset();
  ASSERT_TRUE(runUntil({}, [&] { return server_.count(Kind::closed) == 1; }));
  ASSERT_EQ(server_.count(Kind::control), 1u);
  EXPECT_EQ(server_.last(Kind::control)->bytes, bytesOf("goodbye"));
}

TEST_F(Sockets, NothingButClosedComesAfterClose) {
  listen();
  End site = joined();
  site.transport->sendControl(0, bytesOf("late"));
  server_.transport->wait(20 * kMillisecond);  // it has arrived, and is not polled
  server_.transport->close(newest());
  ASSERT_TRUE(
      runUntil({&site}, [&] { return server_.count(Kind::closed) == 1 && site.count(Kind::closed) == 1; }));
  EXPECT_EQ(server_.count(Kind::control), 0u);
}

TEST_F(Sockets, AServerThatIsDestroyedIsNoticed) {
  listen();
  End site = joined();
  server_.transport.reset();
  ASSERT_TRUE(runUntil(
      {&site}, [&] { return site.count(Kind::closed) == 1; }, 200));
  EXPECT_NE(site.last(Kind::closed)->reason, "");
}

TEST_F(Sockets, ASiteThatIsDestroyedIsNoticed) {
  listen();
  End site = joined();
  site.transport.reset();
  ASSERT_TRUE(runUntil(
      {}, [&] { return server_.count(Kind::closed) == 1; }, 200));
  EXPECT_EQ(server_.last(Kind::closed)->reason, "the connection broke off: the peer is gone");
}

TEST_F(Sockets, APeerThatDoesNotReadIsClosed) {
  listen();
  End site = joined();
  const Bytes block(256 * 1024);
  std::size_t most = 0;
  for (int i = 0; i < 400 && server_.count(Kind::closed) == 0; ++i) {
    server_.transport->sendControl(newest(), block);
    most = std::max(most, server_.transport->controlBacklog(newest()));
    server_.turn(0);
  }
  ASSERT_EQ(server_.count(Kind::closed), 1u);
  EXPECT_EQ(server_.last(Kind::closed)->reason, "the peer does not read: its queue is full");
  EXPECT_GT(most, block.size());
  EXPECT_LE(most, std::size_t{5} << 20);
}

TEST_F(Sockets, AnApplicationThatDoesNotPollHoldsTheSenderBack) {
  listen({.maxRequestBytes = kMaxControlBytes});
  End site = joined();
  std::size_t sent = 0;
  for (int i = 0; i < 300; ++i) {
    if (site.transport->controlBacklog(0) < (std::size_t{1} << 20)) {
      site.transport->sendControl(0, Bytes(256 * 1024));
      ++sent;
    }
    site.turn(0);
    server_.transport->wait(0);  // reads bytes, and nothing is polled
  }
  EXPECT_LT(sent, 200u);  // otherwise 50 MB would have been accepted
  ASSERT_TRUE(runUntil({&site}, [&] { return server_.count(Kind::control) == sent; }));
}

TEST_F(Sockets, WakeEndsAWaitFromAnotherThread) {
  listen();
  for (int i = 0; i < 20; ++i) {
    std::thread other([&] { server_.transport->wake(); });
    server_.transport->wait(3600 * kSecond);  // the test's own time limit is the deadline
    other.join();
  }
}

TEST_F(Sockets, SpeakIpv6) {
  auto server = listenOn("::1", 0, identity());
  if (!server) GTEST_SKIP() << "no IPv6 here: " << server.error().message;
  server_.transport = std::move(server).value();
  End site;
  site.transport = connectTo("::1", server_.transport->port(), pin()).value();
  ASSERT_TRUE(runUntil({&site}, [&] { return site.transport->stateOverUdp(0); }));
  site.transport->sendState(0, bytesOf("six"));
  ASSERT_TRUE(runUntil({&site}, [&] { return server_.count(Kind::state) == 1; }));
}

TEST_F(Sockets, ListenOnEveryAddress) {
  server_.transport = listenOn("", 0, identity()).value();
  port_ = server_.transport->port();
  End site = connect();
  ASSERT_TRUE(runUntil({&site}, [&] { return site.transport->stateOverUdp(0); }));
}

TEST_F(Sockets, SayWhyAServerCannotBeReached) {
  listen();
  server_.transport.reset();
  End site = connect();
  ASSERT_TRUE(runUntil({&site}, [&] { return site.count(Kind::closed) == 1; }));
  EXPECT_EQ(site.last(Kind::closed)->reason, "no server answers at 127.0.0.1 port " + std::to_string(port_));
  EXPECT_EQ(site.count(Kind::connected), 0u);
}

TEST_F(Sockets, SayWhyAServerCannotListen) {
  listen();
  const auto second = listenOn("127.0.0.1", port_, identity());
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find(std::to_string(port_)), std::string::npos);
  EXPECT_FALSE(listenOn("127.0.0.1", 0, TlsIdentity{"no key", "no certificate"}).ok());
}

TEST(TlsIdentity, HasAPinOfItsOwn) {
  const std::string other = pinOf(makeTlsIdentity().value()).value();
  EXPECT_EQ(other.size(), 64u);
  EXPECT_EQ(pin(), pinOf(identity()).value());
  EXPECT_NE(pin(), other);
  EXPECT_FALSE(pinOf(TlsIdentity{"", "nonsense"}).ok());
}

}  // namespace
}  // namespace tandem::sync
