// Newcomers under floods of peers without a token, on real sockets. The verdict is who comes in.

#include <sys/resource.h>

#include <csignal>
#include <cstdio>

#include "sync/transport/knock.h"
#include "tests/support/full_size.h"
#include "tests/sync/transport/flood.h"
#include "tests/sync/transport/socket_ends.h"

namespace tandem::sync {
namespace {

/// A credential of the right form whose knock begins with this byte; the others are the same.
std::string credentialOf(unsigned char first) {
  Bytes bytes(93);
  bytes[13] = std::byte{first};
  constexpr const char* kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const unsigned group = std::to_integer<unsigned>(bytes[i]) << 16 |
                           std::to_integer<unsigned>(bytes[i + 1]) << 8 |
                           std::to_integer<unsigned>(bytes[i + 2]);
    for (int shift = 18; shift >= 0; shift -= 6) text += kAlphabet[group >> shift & 63];
  }
  return text;
}

ListenOptions guarded() {
  ListenOptions options;
  options.knows = [](const Knock& knock) { return knock[0] != 0 && knock[15] == 0; };
  return options;
}

/// As many places as there were once, given to whoever came last.
ListenOptions unguarded() {
  ListenOptions options = guarded();
  options.handshakes.tellApart = false;
  options.maxPendingHandshakes = options.maxStrangers = 32;
  return options;
}

class Flooded : public Sockets {
 protected:
  void SetUp() override {
    // Thousands of real connections a second; HandshakeQueue shows the rules on virtual time.
    if (!test::atFullSize()) GTEST_SKIP() << "TANDEM_FULL_SIZE=1";
    std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to sockets that the server has closed
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &limit), 0);
    limit.rlim_cur = limit.rlim_max;
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &limit), 0);
  }
  /// Takes in what the server got: a site that has said something is no stranger any more.
  void hear() {
    server_.turn(kMillisecond);
    for (; !server_.seen.empty(); server_.seen.pop_front()) {
      const Seen& seen = server_.seen.front();
      if (seen.kind != Kind::control) continue;
      server_.transport->trust(seen.connection);
      ++heard_;
    }
  }
  /// How many of the newcomers, who come one after another, are heard while the flood goes on.
  std::size_t comeIn(std::size_t newcomers, bool knocking, const std::function<bool()>& flooding) {
    heard_ = 0;
    std::size_t sent = 0, over = 0;
    std::vector<End> sites;
    for (int round = 0; heard_ + over < newcomers && flooding() && round < 200000; ++round) {
      hear();
      if (round % 10 == 0 && sites.size() < newcomers)
        sites.push_back(connect({.credential = knocking ? credentialOf(sites.size() + 1) : ""}));
      for (End& site : sites) {
        if (site.transport == nullptr) continue;
        const std::size_t before = site.seen.size();
        site.turn(0);
        if (site.seen.size() == before) continue;
        if (site.count(Kind::closed) > 0) {
          ++over;
          std::printf("  not in: %s\n", site.last(Kind::closed)->reason.c_str());
          site.transport.reset();
        } else if (site.seen.size() == 1) {
          site.transport->sendControl(0, bytesOf("here I am"));
          ++sent;
        }
      }
    }
    EXPECT_LE(heard_, sent);
    return heard_;
  }
  std::size_t comeInUnder(const FloodPlan& plan, std::size_t newcomers, bool knocking) {
    Flood flood(plan, port_);
    const unsigned before = plan.attack < Attack::shaking ? 1000 : 300;  // until its places are taken
    while (flood.made() < before) hear();
    const std::size_t in = comeIn(newcomers, knocking, [&] { return flood.made() < plan.most; });
    std::printf("  %s from %u addresses: %zu of %zu came in, %u connections at %.0f/s, %llu failed\n",
                nameOf(plan.attack), plan.networks, in, newcomers, flood.made(), flood.rate(),
                static_cast<unsigned long long>(server_.counters().failedHandshakes));
    return in;
  }

  std::size_t heard_ = 0;
};

constexpr std::size_t kNewcomers = 8;

TEST_F(Flooded, NewcomersComeInUnderEveryAttackFromOneOtherAddressAndFromAThousand) {
  for (const Attack attack : kAttacks) {
    for (const unsigned networks : {1u, 1000u}) {
      listen(guarded());
      EXPECT_EQ(comeInUnder({.attack = attack, .networks = networks}, kNewcomers, false), kNewcomers)
          << nameOf(attack) << " from " << networks;
    }
  }
}

TEST_F(Flooded, WhoHasALinkComesInEvenFromTheAddressOfTheAttack) {
  for (const Attack attack : {Attack::opening, Attack::greeting}) {
    listen(guarded());
    EXPECT_EQ(comeInUnder({.attack = attack, .networks = 0}, kNewcomers, true), kNewcomers) << nameOf(attack);
  }
}

TEST_F(Flooded, WithoutTellingPeersApartNewcomersStarve) {
  for (const unsigned networks : {1u, 1000u}) {
    listen(unguarded());
    const FloodPlan plan{.attack = Attack::opening, .networks = networks, .most = 8000, .perSecond = 20000};
    EXPECT_LT(comeInUnder(plan, kNewcomers, true), kNewcomers) << networks;
  }
}

TEST_F(Flooded, TwoHundredComeInAtOnceWithAndWithoutALink) {
  for (const bool knocking : {false, true}) {
    listen(guarded());
    std::vector<End> sites;
    for (std::size_t i = 0; i < 200; ++i)
      sites.push_back(connect({.credential = knocking ? credentialOf(i + 1) : ""}));
    std::size_t in = 0;
    for (int round = 0; round < 4000 && in < sites.size(); ++round) {
      server_.turn(kMillisecond);
      for (; !server_.seen.empty(); server_.seen.pop_front()) {
        if (server_.seen.front().kind != Kind::connected) continue;
        server_.transport->trust(server_.seen.front().connection);
        ++in;
      }
      for (End& site : sites) site.turn(0);
    }
    EXPECT_EQ(in, sites.size());
    for (const End& site : sites) EXPECT_EQ(site.count(Kind::closed), 0u);
  }
}

TEST_F(Flooded, AtFullSizeFortyFiveNewcomersComeIn) {
  for (const Attack attack : kAttacks) {
    for (const unsigned networks : {0u, 1u, 1000u}) {
      listen(guarded());
      const bool same = networks == 0;
      EXPECT_EQ(comeInUnder({.attack = attack, .networks = networks, .most = 200000}, 45, same), 45u)
          << nameOf(attack) << " from " << networks;
    }
  }
}

}  // namespace
}  // namespace tandem::sync
