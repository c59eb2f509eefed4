// A path for datagrams that is blocked or too narrow, or that fails and recovers: state must arrive
// nevertheless, over UDP where it passes and else over TLS. Real sockets on loopback with a forwarder between
// them that loses datagrams on demand.

#include <gtest/gtest.h>

#include "sync/replica/lease_rules.h"
#include "sync/transport/state_channel.h"
#include "sync/wire/limits.h"
#include "sync/wire/time.h"
#include "tests/support/forwarder.h"
#include "tests/sync/transport/socket_ends.h"

namespace tandem::sync {
namespace {

class SocketPath : public Sockets {
 protected:
  /// A site that is connected through the box; whether its datagrams pass is not decided yet.
  void connectThroughBox() {
    listen();
    box_ = std::make_unique<test::Forwarder>(port_);
    meanwhile_ = [this] { box_->turn(); };
  }
  void finishConnecting() {
    site_ = connect({}, box_->port());
    ASSERT_TRUE(runUntil(
        {&site_}, [&] { return server_.count(Kind::connected) == 1 && site_.count(Kind::connected) == 1; }));
  }
  bool runUntilBothUse(bool udp) {
    return runUntil({&site_}, [&] {
      return site_.transport->stateOverUdp(0) == udp && server_.transport->stateOverUdp(newest()) == udp;
    });
  }
  /// Lets the box lose a number of probes and answers.
  bool runUntilLost(std::uint64_t more) {
    return runUntil({&site_}, [&, until = box_->lost() + more] { return box_->lost() >= until; });
  }
  /// One state each way; true once both have arrived, whole.
  bool stateArrives() {
    const Bytes up = randomBytes(kMaxStateBytes, ++seed_), down = randomBytes(kMaxStateBytes, ++seed_);
    site_.transport->sendState(0, up);
    server_.transport->sendState(newest(), down);
    const auto arrived = [](const End& end, const Bytes& bytes) {
      const Seen* last = end.last(Kind::state);
      return last != nullptr && last->bytes == bytes;
    };
    return runUntil({&site_}, [&] { return arrived(server_, up) && arrived(site_, down); });
  }
  void expectStillConnected() {
    EXPECT_EQ(server_.count(Kind::closed), 0u);
    EXPECT_EQ(site_.count(Kind::closed), 0u);
  }

  std::unique_ptr<test::Forwarder> box_;
  End site_;
  unsigned seed_ = 0;
};

TEST(StateChannel, GivesUpDatagramsLongBeforeALeaseLapses) {
  // The pings that renew a lease are state messages: half a second is left for them to travel over TLS.
  EXPECT_LE(kPathSilence + kSecond / 2, LeaseRules{}.siteLease());
}

TEST_F(SocketPath, ThatPassesIsUsed) {
  connectThroughBox();
  finishConnecting();
  ASSERT_TRUE(runUntilBothUse(true));
  const std::uint64_t before = box_->passed();
  EXPECT_TRUE(stateArrives());
  EXPECT_GE(box_->passed(), before + 2);
}

TEST_F(SocketPath, ThatIsBlockedAtFirstIsUsedOnceItPasses) {
  connectThroughBox();
  box_->pass(false, false);
  finishConnecting();
  ASSERT_TRUE(runUntilLost(5));
  EXPECT_FALSE(site_.transport->stateOverUdp(0));
  EXPECT_FALSE(server_.transport->stateOverUdp(newest()));
  EXPECT_TRUE(stateArrives());
  EXPECT_EQ(box_->passed(), 0u);

  box_->pass(true, true);
  ASSERT_TRUE(runUntilBothUse(true));
  const std::uint64_t before = box_->passed();
  EXPECT_TRUE(stateArrives());
  EXPECT_GE(box_->passed(), before + 2);
  expectStillConnected();
}

TEST_F(SocketPath, ThatPassesOneWayOnlyIsNotUsed) {
  for (const bool toServer : {true, false}) {
    server_ = {};
    site_ = {};
    connectThroughBox();
    box_->pass(toServer, !toServer);
    finishConnecting();
    ASSERT_TRUE(runUntilLost(5));
    EXPECT_FALSE(site_.transport->stateOverUdp(0)) << toServer;
    EXPECT_FALSE(server_.transport->stateOverUdp(newest())) << toServer;
    EXPECT_TRUE(stateArrives()) << toServer;
  }
}

TEST_F(SocketPath, ThatIsTooNarrowForTheLargestStateIsNotUsed) {
  connectThroughBox();
  box_->passUpTo(kMaxDatagramBytes - 1);
  finishConnecting();
  ASSERT_TRUE(runUntilLost(5));
  EXPECT_FALSE(site_.transport->stateOverUdp(0));
  EXPECT_TRUE(stateArrives());
}

TEST_F(SocketPath, ThatStopsIsLeftForTlsAndUsedAgain) {
  connectThroughBox();
  finishConnecting();
  ASSERT_TRUE(runUntilBothUse(true));
  ASSERT_TRUE(stateArrives());

  box_->pass(false, false);
  const std::size_t before = server_.count(Kind::state);
  site_.transport->sendState(0, bytesOf("lost"));
  ASSERT_TRUE(runUntilBothUse(false));
  EXPECT_EQ(server_.count(Kind::state), before);  // the box does block datagrams
  EXPECT_TRUE(stateArrives());

  box_->pass(true, true);
  ASSERT_TRUE(runUntilBothUse(true));
  const std::uint64_t passed = box_->passed();
  EXPECT_TRUE(stateArrives());
  EXPECT_GE(box_->passed(), passed + 2);
  expectStillConnected();
}

// The server receives datagrams of its client throughout; it learns only from the client's probes that its
// own are lost.
TEST_F(SocketPath, ThatStopsTowardsTheClientIsLeftByBothEnds) {
  connectThroughBox();
  finishConnecting();
  ASSERT_TRUE(runUntilBothUse(true));
  box_->pass(true, false);
  ASSERT_TRUE(runUntilBothUse(false));
  EXPECT_TRUE(stateArrives());
  expectStillConnected();
}

TEST_F(SocketPath, FollowsAClientWhosePortChanges) {
  connectThroughBox();
  finishConnecting();
  ASSERT_TRUE(runUntilBothUse(true));
  box_->changePort();
  site_.transport->sendState(0, bytesOf("here I am now"));
  ASSERT_TRUE(runUntil({&site_}, [&] { return server_.count(Kind::state) == 1; }));
  const std::uint64_t before = box_->passed();
  EXPECT_TRUE(stateArrives());
  EXPECT_GE(box_->passed(), before + 2);
}

}  // namespace
}  // namespace tandem::sync
