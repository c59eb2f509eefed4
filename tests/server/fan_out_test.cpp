// Who gets which update when: all of them among few; in a crowd those of near sites, and the rest at display
// rate, with nothing of the end of a motion lost.

#include "server/fan_out.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "server/journal/memory_journal.h"
#include "server/session.h"
#include "sync/transport/virtual_network.h"
#include "sync/wire/state_sender.h"
#include "tests/support/fake_site.h"

namespace tandem::server {
namespace {

using namespace sync;
using test::FakeSite;

constexpr std::int64_t kWallClock = 1000000;
constexpr Micros kLeg = 5 * kMillisecond;  // from site to server, and back

/// A part for each of `sites` participants, 1 m apart on a line, and `observers` who watch.
struct Crowd {
  assets::Scene scene;
  std::vector<std::byte> package{std::byte{1}};
  VirtualNetwork network{1, NetworkConditions{2 * kLeg, 0, 0, 0, 0}};
  MemoryJournal journal;
  std::unique_ptr<Transport> transport;
  std::unique_ptr<Session> session;
  struct Site {
    FakeSite fake;
    StateSender sender;
    Epoch epoch = 0;
    glm::dvec3 place{0.0};
    PartId touched = kNoPart;
    std::size_t heard = 0;              // of fake.updates
    std::map<SiteId, int> updatesFrom;  // since reset()
    std::map<SiteId, Micros> worst;     // age at arrival
    std::map<PartId, glm::dvec3> lastPosition;
    std::uint32_t gaps = 0, lastSequence = 0;
  };
  std::vector<std::unique_ptr<Site>> all;
  std::size_t sites;
  Micros now = 0;

  Crowd(std::size_t siteCount, std::size_t observers) : sites(siteCount) {
    scene.bounds = {glm::dvec3(-0.5), glm::dvec3(static_cast<double>(sites), 0.5, 0.5)};
    for (std::size_t i = 0; i < sites; ++i) {
      assets::Part& part = scene.parts.emplace_back();
      part.name = "part " + std::to_string(i);
      part.movable = true;
      part.worldFromPart.position.x = static_cast<double>(i);
    }
    SessionConfig config;
    config.key = SigningKey({7});
    transport = network.listen();
    session =
        std::make_unique<Session>(scene, package, config, *transport, journal, nullptr, now, kWallClock);
    for (std::size_t i = 0; i < sites + observers; ++i) join(i);
    for (std::size_t i = 0; i < sites; ++i) site(i).fake.send(Grab{1, static_cast<PartId>(i)});
    run(100 * kMillisecond);
    for (std::size_t i = 0; i < sites; ++i) site(i).epoch = site(i).fake.last<GrabReply>()->part.epoch;
  }
  Site& site(std::size_t i) { return *all[i]; }
  SiteId idOf(std::size_t i) { return static_cast<SiteId>(i + 1); }

  void join(std::size_t i) {
    Site& joined = *all.emplace_back(std::make_unique<Site>());
    joined.fake.frame = wireFrame(scene.bounds);
    joined.fake.transport = network.connect("site " + std::to_string(i));
    joined.place.x = static_cast<double>(i);
    run(3 * kLeg);
    const Role role = i < sites ? Role::participant : Role::observer;
    joined.fake.send(
        Hello{kProtocolVersion, false, session->makeToken(role, kWallClock + 3600), "", {1, 2, 3}});
    run(4 * kLeg);
    ASSERT_NE(joined.fake.last<Welcome>(), nullptr);
    joined.fake.send(Ready{});
    run(2 * kLeg);
  }
  /// One millisecond at a time; `hz` updates a second of each participant in `movers`.
  void run(Micros length, double hz = 0.0, std::size_t movers = 0) {
    const Micros period = hz > 0.0 ? static_cast<Micros>(1e6 / hz) : 0;
    for (const Micros end = now + length; now < end;) {
      now += kMillisecond;
      network.advanceTo(now);
      journal.advanceTo(now);
      session->step(now, kWallClock + now / kSecond);
      for (std::size_t i = 0; i < all.size(); ++i) {
        listen(site(i));
        if (now % (100 * kMillisecond) == 0 && site(i).fake.last<Welcome>() != nullptr)
          site(i).fake.ping(now);
        if (i < movers && (now + static_cast<Micros>(i) * 977) % period < kMillisecond) move(i);
      }
    }
  }
  void move(std::size_t i) {
    Site& mover = site(i);
    StateUpdate update;
    update.sequence = ++mover.fake.sequence;
    update.time = now;
    update.presence.worldFromTool.position = update.presence.worldFromCamera.position = mover.place;
    update.presence.touched = mover.touched;
    if (i < sites) {
      PartState& state = update.parts.emplace_back();
      state = {static_cast<PartId>(i), mover.epoch, mover.fake.sequence, {}, {}};
      state.worldFromPart.position = mover.place + glm::dvec3(0.0, 0.05 * std::sin(1e-6 * now), 0.0);
      state.twist.linear = {0.0, 0.05 * std::cos(1e-6 * now), 0.0};
    }
    std::vector<std::byte> bytes;
    mover.sender.encode(update, mover.fake.frame, bytes);
    mover.fake.transport->sendState(0, bytes);
  }
  void listen(Site& listener) {
    listener.fake.listen();
    const auto& updates = listener.fake.updates;
    for (; listener.heard < updates.size(); ++listener.heard) {
      const StateUpdate& update = updates[listener.heard];
      ++listener.updatesFrom[update.site];
      Micros& worst = listener.worst[update.site];
      worst = std::max(worst, now - update.time);
      if (listener.lastSequence != 0) listener.gaps += update.sequence - listener.lastSequence - 1;
      listener.lastSequence = update.sequence;
      for (const PartState& state : update.parts)
        listener.lastPosition[state.part] = state.worldFromPart.position;
    }
    if (const auto ack = listener.fake.receiver.drainAck(now)) listener.fake.send(*ack);
  }
  void reset() {
    for (auto& listener : all) {
      listener->updatesFrom.clear();
      listener->worst.clear();
    }
  }
};

TEST(FanOut, AmongFewEverybodyGetsEveryUpdateInTheStepInWhichItCame) {
  Crowd crowd(12, 4);
  crowd.run(300 * kMillisecond, 60.0, 12);
  crowd.reset();
  crowd.run(kSecond, 60.0, 12);
  for (std::size_t i = 0; i < crowd.all.size(); ++i)
    for (std::size_t k = 0; k < crowd.sites; ++k) {
      if (i == k) continue;
      EXPECT_NEAR(crowd.site(i).updatesFrom[crowd.idOf(k)], 60, 3) << k << " to " << i;
      EXPECT_LE(crowd.site(i).worst[crowd.idOf(k)], 2 * kLeg + kMillisecond) << k << " to " << i;
    }
}

TEST(FanOut, InACrowdFarSitesAndObserversGetDisplayRateAndNearOnesEverything) {
  Crowd crowd(24, 4);
  crowd.site(3).place = crowd.site(2).place + glm::dvec3(0.1, 0.0, 0.0);  // near each other
  crowd.run(kSecond, 60.0, 24);
  crowd.reset();
  crowd.run(kSecond, 60.0, 24);
  for (std::size_t i = 0; i < crowd.all.size(); ++i)
    for (std::size_t k = 0; k < crowd.sites; ++k) {
      if (i == k || (i < crowd.sites && std::abs(crowd.site(i).place.x - crowd.site(k).place.x) < 1.95))
        continue;
      EXPECT_NEAR(crowd.site(i).updatesFrom[crowd.idOf(k)], 30, 3) << k << " to " << i;
      const Micros hold = i < crowd.sites ? FanOut::kSiteHold : FanOut::kObserverHold;
      EXPECT_LE(crowd.site(i).worst[crowd.idOf(k)], 2 * kLeg + hold + 2 * kMillisecond) << k << " to " << i;
    }
  for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{2, 3}, {3, 2}}) {
    EXPECT_NEAR(crowd.site(a).updatesFrom[crowd.idOf(b)], 60, 3);
    EXPECT_LE(crowd.site(a).worst[crowd.idOf(b)], 2 * kLeg + FanOut::kSiteHold + 2 * kMillisecond);
  }
  for (const auto& listener : crowd.all) EXPECT_EQ(listener->gaps, 0u) << "each counts in its own numbers";
}

TEST(FanOut, InACrowdATouchedOrCoHeldPartIsRelayedInItsStep) {
  Crowd crowd(20, 0);
  crowd.site(15).touched = 4;             // far away by the poses, yet in contact
  crowd.site(9).fake.send(Engage{2, 6});  // co-holds the part of site 6
  crowd.run(500 * kMillisecond, 60.0, 20);
  ASSERT_EQ(crowd.site(9).fake.last<EngageReply>()->denial, Denial::none);
  crowd.reset();
  crowd.run(kSecond, 60.0, 20);
  for (const auto& [to, from] : {std::pair<std::size_t, std::size_t>{15, 4}, {4, 15}, {9, 6}, {6, 9}}) {
    EXPECT_NEAR(crowd.site(to).updatesFrom[crowd.idOf(from)], 60, 3) << from << " to " << to;
    EXPECT_LE(crowd.site(to).worst[crowd.idOf(from)], 2 * kLeg + kMillisecond) << from << " to " << to;
  }
}

TEST(FanOut, TheLastStateBeforeAPauseReachesAllHoweverTheMotionEnds) {
  std::mt19937 random(11);
  for (int round = 0; round < 6; ++round) {
    Crowd crowd(18, 2);
    const double hz = 20.0 + random() % 230;
    crowd.run(300 * kMillisecond + static_cast<Micros>(random() % 200'000), hz, 18);
    crowd.run(150 * kMillisecond);  // nobody sends
    for (const auto& listener : crowd.all)
      for (std::size_t k = 0; k < crowd.sites; ++k) {
        if (listener.get() == crowd.all[k].get()) continue;
        const glm::dvec3 is = crowd.session->ownership().part(static_cast<PartId>(k)).worldFromPart.position;
        EXPECT_NEAR(glm::length(listener->lastPosition[static_cast<PartId>(k)] - is), 0.0, 1e-5)
            << "part " << k << " at " << hz << " Hz";
      }
  }
}

TEST(FanOut, InACrowdHandsOfObserversReachTheSitesOnceASecondAndNoObserver) {
  Crowd crowd(18, 4);
  crowd.run(kSecond);
  crowd.reset();
  for (int i = 0; i < 180; ++i) {
    crowd.site(19).place.y += 0.01;
    crowd.move(19);
    crowd.run(16 * kMillisecond);
  }
  for (std::size_t i = 0; i < crowd.all.size(); ++i) {
    if (i == 19) continue;
    const int heard = crowd.site(i).updatesFrom[crowd.idOf(19)];
    if (i < crowd.sites)
      EXPECT_NEAR(heard, 3, 1) << i;
    else
      EXPECT_EQ(heard, 0) << i;
  }
}

TEST(FanOut, WhatRestsIsToldSeldom) {
  Crowd crowd(20, 1);
  crowd.run(kSecond, 60.0, 20);
  crowd.reset();
  for (int i = 0; i < 60; ++i) {
    // The same pose at rest again and again, as a site repeats it.
    StateUpdate update;
    update.sequence = ++crowd.site(0).fake.sequence;
    update.time = crowd.now;
    update.parts = {{0, crowd.site(0).epoch, crowd.site(0).fake.sequence, {}, {}}};
    crowd.site(0).fake.send(update);
    crowd.run(16 * kMillisecond);
  }
  EXPECT_LE(crowd.site(10).updatesFrom[crowd.idOf(0)], 7);
  EXPECT_GE(crowd.site(10).updatesFrom[crowd.idOf(0)], 3);
}

TEST(FanOut, ASessionThatGrowsAndShrinksLosesNobody) {
  Crowd crowd(17, 0);
  crowd.run(300 * kMillisecond, 60.0, 17);
  for (std::size_t i = 16; i > 4; --i) {
    crowd.site(i).fake.send(Goodbye{});
    crowd.run(50 * kMillisecond, 60.0, i);
  }
  crowd.reset();
  crowd.run(kSecond, 60.0, 5);
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t k = 0; k < 5; ++k)
      if (i != k) {
        EXPECT_NEAR(crowd.site(i).updatesFrom[crowd.idOf(k)], 60, 3) << k << " to " << i;
      }
}

}  // namespace
}  // namespace tandem::server
