// What an unauthenticated peer can send to a server's ports, which must not affect other connections.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <memory>

#include "sync/transport/state_channel.h"
#include "tests/sync/transport/socket_ends.h"

namespace tandem::sync {
namespace {

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A plain socket that uses none of the transport's code.
struct RawSocket {
  explicit RawSocket(int type) : fd(socket(AF_INET, type, 0)) {}
  RawSocket(RawSocket&& other) noexcept : fd(std::exchange(other.fd, -1)) {}
  ~RawSocket() {
    if (fd >= 0) ::close(fd);
  }
  void connectTo(std::uint16_t port) const {
    const sockaddr_in address = loopback(port);
    ASSERT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  void send(std::span<const std::byte> bytes) const {
    EXPECT_EQ(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
  }
  bool hasSomethingToRead() const {
    char byte = 0;
    return recv(fd, &byte, 1, MSG_DONTWAIT | MSG_PEEK) > 0;
  }
  int fd;
};

/// A peer that speaks TLS and knows the keys of its own connection, and breaks the rules above them.
class Outlaw {
 public:
  explicit Outlaw(std::uint16_t port) : tcp_(SOCK_STREAM), udp_(SOCK_DGRAM) {
    tcp_.connectTo(port);
    udp_.connectTo(port);
    const timeval patience{.tv_sec = 0, .tv_usec = 2000};
    setsockopt(tcp_.fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    context_.reset(SSL_CTX_new(TLS_client_method()));
    ssl_.reset(SSL_new(context_.get()));
    SSL_set_fd(ssl_.get(), tcp_.fd);
  }
  bool shakeHands(End& server) {
    for (int i = 0; i < 2000; ++i) {
      if (SSL_connect(ssl_.get()) == 1) return true;
      server.turn(0);
    }
    return false;
  }
  void frame(std::uint32_t length, const Bytes& rest) {
    Bytes bytes;
    for (int shift = 24; shift >= 0; shift -= 8)
      bytes.push_back(static_cast<std::byte>(length >> shift & 0xff));
    bytes.insert(bytes.end(), rest.begin(), rest.end());
    SSL_write(ssl_.get(), bytes.data(), static_cast<int>(bytes.size()));
  }
  void offer(unsigned version = 1) {
    frame(3, {std::byte{2}, static_cast<std::byte>(version), std::byte{2}});  // ChaCha20-Poly1305 only
  }
  /// What the server has sent, as far as it arrived within some rounds.
  Bytes read(End& server, std::size_t size) {
    Bytes all;
    for (int i = 0; i < 500 && all.size() < size; ++i) {
      server.turn(0);
      Bytes part(4096);
      const int got = SSL_read(ssl_.get(), part.data(), static_cast<int>(part.size()));
      if (got > 0) all.insert(all.end(), part.begin(), part.begin() + got);
    }
    return all;
  }
  /// Reads the accept frame and makes the sealer a client would have.
  std::unique_ptr<Sealer> keys(End& server) {
    const Bytes accept = read(server, 14);
    EXPECT_EQ(accept.size(), 14u);
    if (accept.size() != 14u) return nullptr;
    for (std::size_t i = 6; i < 14; ++i) id_ = id_ << 8 | std::to_integer<std::uint64_t>(accept[i]);
    std::array<unsigned char, 88> material{};
    const unsigned char algorithm = 2;
    const std::string label = "EXPORTER-tandem-state-v1";
    SSL_export_keying_material(ssl_.get(), material.data(), material.size(), label.data(), label.size(),
                               &algorithm, 1, 1);
    SealKey key;
    std::copy_n(reinterpret_cast<const std::byte*>(material.data()), 32, key.key.begin());
    std::copy_n(reinterpret_cast<const std::byte*>(material.data()) + 64, 12, key.iv.begin());
    return std::make_unique<Sealer>(SealAlgorithm::chaCha20Poly1305, key, id_);
  }
  void datagram(const Bytes& bytes) const { udp_.send(bytes); }
  void moveTo(std::uint16_t port) {
    RawSocket other(SOCK_DGRAM);
    other.connectTo(port);
    std::swap(udp_.fd, other.fd);
  }
  bool hearsUdp() const { return udp_.hasSomethingToRead(); }
  void vanish() { ::close(std::exchange(tcp_.fd, -1)); }

 private:
  struct FreeContext {
    void operator()(SSL_CTX* p) const { SSL_CTX_free(p); }
  };
  struct FreeSsl {
    void operator()(SSL* p) const { SSL_free(p); }
  };
  RawSocket tcp_, udp_;
  std::unique_ptr<SSL_CTX, FreeContext> context_;
  std::unique_ptr<SSL, FreeSsl> ssl_;
  std::uint64_t id_ = 0;
};

class Hostile : public Sockets {
 protected:
  /// An honest site can still connect and exchange messages.
  void expectService() {
    End site = joined();
    const std::size_t before = server_.count(Kind::control);
    site.transport->sendControl(0, bytesOf("still here"));
    EXPECT_TRUE(runUntil({&site}, [&] { return server_.count(Kind::control) == before + 1; }));
  }
  static Bytes seal(Sealer& sealer, const Bytes& plain) {
    Bytes out(plain.size() + kSealOverheadBytes);
    EXPECT_EQ(sealer.seal(DatagramKind::state, plain, out.data()), out.size());
    return out;
  }
};

TEST_F(Hostile, AnotherKeyThanTheLinksIsRefusedWithThatReason) {
  listen();
  End site;
  site.transport = connectTo("127.0.0.1", port_, std::string(64, 'a')).value();
  ASSERT_TRUE(runUntil({&site}, [&] { return site.count(Kind::closed) == 1; }));
  EXPECT_EQ(site.last(Kind::closed)->reason, "the server's key is not the one in the join link");
  EXPECT_EQ(site.count(Kind::connected), 0u);
  ASSERT_TRUE(runUntil({}, [&] { return server_.counters().failedHandshakes == 1; }));
  EXPECT_TRUE(server_.seen.empty());
  EXPECT_FALSE(connectTo("127.0.0.1", port_, "no pin").ok());
}

TEST_F(Hostile, GarbageOnTheTcpPortIsCountedAndClosed) {
  listen();
  for (unsigned i = 0; i < 5; ++i) {
    RawSocket stranger(SOCK_STREAM);
    stranger.connectTo(port_);
    stranger.send(randomBytes(500, i));
    ASSERT_TRUE(runUntil({}, [&] { return server_.counters().failedHandshakes == i + 1; }));
  }
  EXPECT_TRUE(server_.seen.empty());
  expectService();
}

TEST_F(Hostile, GarbageOnTheUdpPortMeetsSilence) {
  listen();
  RawSocket stranger(SOCK_DGRAM);
  stranger.connectTo(port_);
  for (const std::size_t size : {0u, 1u, 31u, 32u, 500u, 1232u}) stranger.send(randomBytes(size));
  for (const std::size_t size : {1233u, 1234u, 9000u}) stranger.send(randomBytes(size));
  ASSERT_TRUE(runUntil({}, [&] {
    return server_.counters().droppedUnknown == 6 && server_.counters().droppedOversized == 3;
  }));
  EXPECT_FALSE(stranger.hasSomethingToRead());
  EXPECT_TRUE(server_.seen.empty());
  expectService();
}

TEST_F(Hostile, ForgedAndReplayedDatagramsAreCountedAndNeverApplied) {
  listen();
  Outlaw peer(port_);
  ASSERT_TRUE(peer.shakeHands(server_));
  peer.offer();
  const auto sealer = peer.keys(server_);
  ASSERT_NE(sealer, nullptr);
  const Bytes first = seal(*sealer, bytesOf("first")), second = seal(*sealer, bytesOf("second"));
  Bytes forged = first;
  forged[13] = std::byte{9};  // a far counter must not move the window
  peer.datagram(forged);
  peer.datagram(second);
  peer.datagram(first);  // late, and genuine
  peer.datagram(first);
  peer.datagram(second);
  ASSERT_TRUE(runUntil(
      {}, [&] { return server_.counters().droppedForged == 1 && server_.counters().droppedReplayed == 2; }));
  ASSERT_EQ(server_.count(Kind::state), 2u);
  EXPECT_EQ(server_.last(Kind::state)->bytes, bytesOf("first"));
}

TEST_F(Hostile, StateFollowsASiteWhoseAddressChanges) {
  listen();
  Outlaw peer(port_);
  ASSERT_TRUE(peer.shakeHands(server_));
  peer.offer();
  const auto sealer = peer.keys(server_);
  ASSERT_NE(sealer, nullptr);
  const Bytes old = seal(*sealer, bytesOf("old"));
  peer.datagram(seal(*sealer, bytesOf("one")));
  ASSERT_TRUE(runUntil({}, [&] { return server_.count(Kind::state) == 1; }));
  peer.moveTo(port_);
  peer.datagram(old);  // genuine, but not the newest: the address stays
  ASSERT_TRUE(runUntil({}, [&] { return server_.count(Kind::state) == 2; }));
  server_.transport->sendState(newest(), bytesOf("to the old place"));
  server_.turn(5 * kMillisecond);
  EXPECT_FALSE(peer.hearsUdp());
  peer.datagram(seal(*sealer, bytesOf("two")));
  ASSERT_TRUE(runUntil({}, [&] { return server_.count(Kind::state) == 3; }));
  server_.transport->sendState(newest(), bytesOf("to the new place"));
  EXPECT_TRUE(runUntil({}, [&] { return peer.hearsUdp(); }));
}

TEST_F(Hostile, AnOversizedFrameEndsTheConnection) {
  listen();
  Outlaw peer(port_);
  ASSERT_TRUE(peer.shakeHands(server_));
  peer.offer();
  ASSERT_TRUE(runUntil({}, [&] { return server_.count(Kind::connected) == 1; }));
  peer.frame(0xffffffffu, {std::byte{0}});
  ASSERT_TRUE(runUntil({}, [&] { return server_.count(Kind::closed) == 1; }));
  EXPECT_EQ(server_.last(Kind::closed)->reason, "the peer broke the protocol: a frame of 4294967295 bytes");
  expectService();
}

TEST_F(Hostile, NothingIsAcceptedBeforeTheGreeting) {
  listen();
  for (const std::uint32_t length : {0u, 5u, 66u, 100000u}) {
    const auto failed = server_.counters().failedHandshakes;
    Outlaw peer(port_);
    ASSERT_TRUE(peer.shakeHands(server_));
    peer.frame(length, Bytes(5));  // a control message, or a frame too long for a greeting
    peer.vanish();
    ASSERT_TRUE(runUntil({}, [&] { return server_.counters().failedHandshakes == failed + 1; }));
  }
  EXPECT_TRUE(server_.seen.empty());
}

TEST_F(Hostile, AnotherVersionIsRefusedWithTheReason) {
  listen();
  Outlaw peer(port_);
  ASSERT_TRUE(peer.shakeHands(server_));
  peer.offer(9);
  const Bytes farewell = peer.read(server_, 60);
  const std::string text(reinterpret_cast<const char*>(farewell.data()), farewell.size());
  EXPECT_NE(text.find("the server speaks transport version 1, this site version 9"), std::string::npos);
}

TEST_F(Hostile, AConnectionCutWithoutGoodbyeIsReportedAsCut) {
  listen();
  Outlaw peer(port_);
  ASSERT_TRUE(peer.shakeHands(server_));
  peer.offer();
  peer.frame(100, {std::byte{0}, std::byte{1}});  // and 98 bytes that never come
  ASSERT_TRUE(runUntil({}, [&] { return server_.count(Kind::connected) == 1; }));
  peer.vanish();
  ASSERT_TRUE(runUntil({}, [&] { return server_.count(Kind::closed) == 1; }));
  EXPECT_EQ(server_.last(Kind::closed)->reason, "the connection broke off: the peer is gone");
  EXPECT_EQ(server_.count(Kind::control), 0u);
}

TEST_F(Hostile, SilentHandshakesTimeOut) {
  listen({.handshakeTimeout = 50 * kMillisecond});
  RawSocket silent(SOCK_STREAM);
  silent.connectTo(port_);
  Outlaw mute(port_);  // TLS, but no greeting
  ASSERT_TRUE(mute.shakeHands(server_));
  EXPECT_TRUE(runUntil({}, [&] { return server_.counters().failedHandshakes == 2; }));
}

TEST_F(Hostile, SilentHandshakesDoNotKeepHonestSitesOut) {
  listen({.maxPendingHandshakes = 4, .handshakeTimeout = 3600 * kSecond});
  std::vector<RawSocket> silent;
  for (int i = 0; i < 12; ++i) {
    silent.emplace_back(SOCK_STREAM);
    silent.back().connectTo(port_);
  }
  ASSERT_TRUE(runUntil({}, [&] { return server_.counters().failedHandshakes == 8; }));
  expectService();
}

TEST_F(Hostile, RequestsThatPileUpDelayNoStateAndNoOtherSitesRequests) {
  listen();
  End flooder = joined();
  const ConnectionId flooding = newest();
  End honest = joined();
  const ConnectionId calm = newest();
  for (int i = 0; i < 20000; ++i) flooder.transport->sendControl(0, bytesOf("again"));
  for (int i = 0; i < 20; ++i) flooder.transport->wait(kMillisecond);
  honest.transport->sendControl(0, bytesOf("please"));
  honest.transport->sendState(0, bytesOf("here"));
  for (int i = 0; i < 5; ++i) honest.transport->wait(kMillisecond);
  // The server polls a few events a round, as a session does whose step is bounded.
  int floodBefore = 0, floodBetween = 0;
  bool state = false, asked = false;
  for (int round = 0; round < 5000 && !(state && asked); ++round) {
    server_.transport->wait(kMillisecond);
    flooder.transport->wait(0);
    honest.transport->wait(0);
    TransportEvent event;
    for (int i = 0; i < 4 && server_.transport->poll(event); ++i) {
      state = state || event.kind == Kind::state;
      asked = asked || (event.kind == Kind::control && event.connection == calm);
      if (event.kind != Kind::control || event.connection != flooding) continue;
      ++(state ? floodBetween : floodBefore);
    }
  }
  EXPECT_TRUE(state);
  EXPECT_TRUE(asked);
  EXPECT_LE(floodBefore + floodBetween, 1000);
}

TEST_F(Hostile, ARequestThatIsTooLongEndsItsConnectionBeforeItIsTakenIn) {
  listen();
  End greedy = joined();
  greedy.transport->sendControl(0, randomBytes(kMaxRequestBytes));
  ASSERT_TRUE(runUntil({&greedy}, [&] { return server_.count(Kind::control) == 1; }));
  greedy.transport->sendControl(0, randomBytes(kMaxRequestBytes + 1));
  ASSERT_TRUE(runUntil({&greedy}, [&] { return server_.count(Kind::closed) == 1; }));
  EXPECT_EQ(server_.count(Kind::control), 1u);
  expectService();
}

TEST_F(Hostile, StateOfAHeldConnectionPassesOverTlsToo) {
  listen();
  End held = joined(false);
  const ConnectionId holding = newest();
  server_.transport->hold(holding, true);
  held.transport->sendControl(0, bytesOf("a request"));
  held.transport->sendState(0, bytesOf("a ping"));
  ASSERT_TRUE(runUntil({&held}, [&] { return server_.count(Kind::state) == 1; }));
  EXPECT_EQ(server_.count(Kind::control), 0u);
  held.transport->sendState(0, bytesOf("another ping"));
  ASSERT_TRUE(runUntil({&held}, [&] { return server_.count(Kind::state) == 2; }));
  server_.transport->hold(holding, false);
  ASSERT_TRUE(runUntil({&held}, [&] { return server_.count(Kind::control) == 1; }));
}

TEST_F(Hostile, StateBeyondASitesRateIsDroppedBeforeItIsOpened) {
  for (const bool udp : {true, false}) {
    server_ = {};
    listen();
    End flooder = joined(udp), honest = joined();
    const ConnectionId calm = newest();
    const auto of = [&](bool wanted) {
      return std::count_if(server_.seen.begin(), server_.seen.end(), [&](const Seen& s) {
        return s.kind == Kind::state && (s.connection == calm) == wanted;
      });
    };
    const auto begun = std::chrono::steady_clock::now();
    std::size_t sent = 0;
    for (int i = 0; i < 100; ++i) {
      for (int k = 0; k < 100; ++k, ++sent) flooder.transport->sendState(0, bytesOf("again"));
      if (i % 10 == 0) honest.transport->sendState(0, bytesOf("here"));
      server_.turn(0);
      flooder.turn(0);
    }
    ASSERT_TRUE(runUntil({&flooder, &honest}, [&] { return of(true) == 10; }));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
    const double allowed = 1010.0 + 8000.0 * took.count();
    EXPECT_LT(static_cast<double>(of(false)), allowed) << udp;
    // A machine that takes over a second to send all this sends no more than the rate.
    if (static_cast<double>(sent) > allowed) {
      EXPECT_GT(server_.counters().droppedFlood, 0u) << udp;
      EXPECT_LT(static_cast<std::size_t>(of(false)), sent);
    }
    // Once it is calm it is heard again.
    ASSERT_TRUE(runUntil({&flooder, &honest}, [&] {
      flooder.transport->sendState(0, bytesOf("calm"));
      return flooder.transport->stateOverUdp(0) == udp && server_.last(Kind::state)->bytes == bytesOf("calm");
    }));
  }
}

/// What the first datagram of an honest site finds before it: thousands of another's.
TEST_F(Hostile, NoFloodOfDatagramsIsReadBeforeAKnownSitesState) {
  listen();
  End flooder = joined(), honest = joined();
  const ConnectionId calm = newest();
  RawSocket stranger(SOCK_DGRAM);
  stranger.connectTo(port_);
  for (int i = 0; i < 4; ++i) server_.turn(20 * kMillisecond);  // the kernel is told of both
  for (const bool ofStrangers : {true, false}) {
    // The first flood of a site shows what it is.
    if (!ofStrangers) {
      for (int i = 0; i < 3000; ++i) flooder.transport->sendState(0, bytesOf("again"));
      for (int i = 0; i < 150; ++i) server_.turn(0);
    }
    const auto refused = [&] { return server_.counters().droppedUnknown + server_.counters().droppedFlood; };
    for (unsigned i = 0; i < 3000; ++i) {
      if (ofStrangers)
        stranger.send(randomBytes(32 + i % 100, i));
      else
        flooder.transport->sendState(0, bytesOf("again"));
    }
    honest.transport->sendState(0, bytesOf("here"));
    server_.seen.clear();
    const std::uint64_t before = refused();
    server_.transport->wait(kSecond);
    TransportEvent event;
    ASSERT_TRUE(server_.transport->poll(event));
    EXPECT_EQ(event.kind, Kind::state);
    EXPECT_EQ(event.connection, calm) << ofStrangers;
    EXPECT_LE(refused() - before, 64u) << ofStrangers;
  }
}

TEST_F(Hostile, AConnectionThatIsHeldWaitsInItsOwnNetwork) {
  listen();
  End flooder = joined();
  const ConnectionId flooding = newest();
  End honest = joined();
  const ConnectionId calm = newest();
  server_.transport->hold(flooding, true);
  const std::size_t sentBefore = server_.count(Kind::control);
  for (int i = 0; i < 200; ++i) flooder.transport->sendControl(0, randomBytes(10000));
  honest.transport->sendControl(0, bytesOf("please"));
  ASSERT_TRUE(runUntil({&flooder, &honest}, [&] { return server_.count(Kind::control) > sentBefore; }));
  for (int i = 0; i < 100; ++i)
    runUntil(
        {&flooder, &honest}, [] { return false; }, 1);
  EXPECT_EQ(server_.count(Kind::control), sentBefore + 1);
  EXPECT_EQ(server_.last(Kind::control)->connection, calm);
  // Of 2 MB that were sent, no more than the bound and one read has been taken in.
  EXPECT_LE(server_.counters().controlBytesIn, 300000u);
  server_.transport->hold(flooding, false);
  ASSERT_TRUE(
      runUntil({&flooder, &honest}, [&] { return server_.count(Kind::control) == sentBefore + 201; }));
  // A connection that ends while it is held is reported, without what was held.
  server_.transport->hold(flooding, true);
  flooder.transport->sendControl(0, bytesOf("never read"));
  for (int i = 0; i < 5; ++i)
    runUntil(
        {&flooder, &honest}, [] { return false; }, 1);
  flooder.transport->close(0);
  ASSERT_TRUE(runUntil({&flooder, &honest}, [&] { return server_.count(Kind::closed) == 1; }));
  EXPECT_EQ(server_.count(Kind::control), sentBefore + 201);
}

TEST_F(Hostile, AFullServerRefusesWithTheReason) {
  listen({.maxConnections = 1});
  End first = joined();
  End second = connect();
  ASSERT_TRUE(runUntil({&first, &second}, [&] { return second.count(Kind::closed) == 1; }));
  EXPECT_EQ(second.last(Kind::closed)->reason, "the server is full");
  EXPECT_EQ(first.count(Kind::closed), 0u);
}

TEST_F(Hostile, AServerThatNeverAnswersIsGivenUp) {
  RawSocket listener(SOCK_STREAM);
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(listener.fd, reinterpret_cast<const sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(listener.fd, 4), 0);
  ASSERT_EQ(getsockname(listener.fd, reinterpret_cast<sockaddr*>(&address), &size), 0);
  End site = connect({.timeout = kSecond / 2}, ntohs(address.sin_port));
  ASSERT_TRUE(runUntil({&site}, [&] { return site.count(Kind::closed) == 1; }));
  EXPECT_NE(site.last(Kind::closed)->reason.find("no answer from 127.0.0.1"), std::string::npos);
}

}  // namespace
}  // namespace tandem::sync
