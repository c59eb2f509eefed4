// The pieces of a coordination link: play-out, regime, mass; and one end against a peer that may be anything.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "haptics/link/coordination_link.h"
#include "haptics/link/link_brake.h"
#include "haptics/link/replica_mass.h"
#include "haptics/link/wave_play_out.h"
#include "tests/haptics/link/link_checks.h"
#include "tests/support/allocation_counter.h"

namespace tandem::test {
namespace {

using haptics::LinkPacket;
using haptics::LinkRegime;
using haptics::SixAxes;
using haptics::WavePlayOut;

LinkPacket packetAt(std::uint32_t sequence) {
  LinkPacket p;
  p.epoch = 1;
  p.sequence = sequence;
  p.time = 0.004 * sequence;
  p.wave = {{std::sin(0.1 * sequence), 0.01 * sequence, 0.0}, {0.0, std::cos(0.07 * sequence), 0.0}};
  p.energy = 0.001 * sequence;
  p.fade = 1.0;
  p.on = true;
  p.regime = LinkRegime::stiff;
  return p;
}

std::vector<double> played(const std::vector<std::vector<LinkPacket>>& arrivals) {
  WavePlayOut buffer;
  buffer.restart(1);
  std::vector<double> all;
  for (std::size_t tick = 0; tick < arrivals.size(); ++tick) {
    for (const LinkPacket& packet : arrivals[tick]) buffer.receive(packet);
    const haptics::PlayedWave wave = buffer.play(1e-3 * static_cast<double>(tick) - 0.06);
    all.insert(all.end(), {wave.fresh ? 1.0 : 0.0, wave.state.wave.along.x, wave.state.wave.about.y,
                           wave.state.energy, wave.rate.along.x});
  }
  return all;
}

TEST(WavePlayOut, OrderAndDuplicatesChangeNothing) {
  std::mt19937 random(5);
  std::vector<std::vector<LinkPacket>> ordered(1000), shuffled(1000);
  for (std::uint32_t i = 0; i < 220; ++i) {
    // All come before they are played, 60 ms late; which of them first is another matter.
    const std::size_t made = 4 * i;
    ordered[made + 30].push_back(packetAt(i));
    shuffled[made + 5 + random() % 50].push_back(packetAt(i));
    shuffled[made + 5 + random() % 90].push_back(packetAt(i));
  }
  EXPECT_EQ(played(ordered), played(shuffled));
  shuffled[333].clear();  // the control: what is lost is seen
  for (std::size_t i = 300; i < 333; ++i) shuffled[i].clear();
  EXPECT_NE(played(ordered), played(shuffled));
}

TEST(WavePlayOut, LostPacketsLoseNeitherWayNorEnergy) {
  WavePlayOut buffer;
  buffer.restart(1);
  for (const std::uint32_t i : {0u, 1u, 9u, 10u}) EXPECT_TRUE(buffer.receive(packetAt(i)));
  const haptics::PlayedWave between = buffer.play(0.020), after = buffer.play(0.0361);
  EXPECT_TRUE(between.fresh);
  EXPECT_NEAR(between.state.energy, 0.005, 1e-12);
  EXPECT_NEAR(between.state.wave.along.y, 0.05, 1e-12);
  EXPECT_NEAR(after.state.energy, 0.009025, 1e-12);
}

TEST(WavePlayOut, RunsDryBeyondTheNewest) {
  WavePlayOut buffer;
  buffer.restart(1);
  for (std::uint32_t i = 0; i < 5; ++i) buffer.receive(packetAt(i));
  const haptics::PlayedWave last = buffer.play(0.0165);
  EXPECT_FALSE(last.fresh);
  EXPECT_EQ(last.state.energy, packetAt(4).energy);
}

TEST(WavePlayOut, DropsWhatIsForeignBrokenOrLate) {
  WavePlayOut buffer;
  buffer.restart(1);
  for (std::uint32_t i = 5; i < 8; ++i) ASSERT_TRUE(buffer.receive(packetAt(i)));
  LinkPacket old = packetAt(9), broken = packetAt(9), shrinking = packetAt(9), back = packetAt(9);
  old.epoch = 0;
  broken.wave.about.x = std::numeric_limits<double>::quiet_NaN();
  shrinking.energy = 0.0;
  back.time = 0.0;
  for (const LinkPacket& packet : {old, broken, shrinking, back}) EXPECT_FALSE(buffer.receive(packet));
  EXPECT_FALSE(buffer.receive(packetAt(6)));
  EXPECT_TRUE(buffer.receive(packetAt(4)));  // nothing was played yet
  buffer.play(0.021);
  EXPECT_FALSE(buffer.receive(packetAt(3)));
  EXPECT_TRUE(buffer.receive(packetAt(9)));
}

TEST(WavePlayOut, DropsAFadeThatFallsToWhereItCannotBe) {
  WavePlayOut buffer;
  buffer.restart(1);
  ASSERT_TRUE(buffer.receive(packetAt(5)));
  LinkPacket falls = packetAt(6), begins = packetAt(7), lost = packetAt(100);
  falls.fade = 0.8;
  EXPECT_FALSE(buffer.receive(falls));
  EXPECT_TRUE(buffer.drainContradiction());
  // The link of the peer has begun anew, and most packets since were lost.
  begins.fade = 0.0, lost.fade = 0.5;
  EXPECT_TRUE(buffer.receive(lost));
  EXPECT_TRUE(buffer.receive(begins));
  EXPECT_FALSE(buffer.drainContradiction());
}

TEST(LinkBrake, HoldsWhatALinkNoLongerHoldsAndLetsGo) {
  haptics::LinkBrake brake;
  const SixAxes missing{{1.0, 0.0, 0.0}, {}}, away{{-0.01, 0.0, 0.0}, {}}, along{{0.01, 0.0, 0.0}, {}};
  brake.replace(missing, along);
  EXPECT_EQ(brake.damping(along), 0.0);  // what drove the replica
  brake.replace(missing, away);
  EXPECT_NEAR(brake.damping(away) * 0.01, 0.9, 1e-9);
  EXPECT_LT(brake.damping({}), 500.0);
  for (int i = 0; i < 300; ++i) brake.advance(4.0, 1e-3);
  EXPECT_EQ(brake.damping(away), 0.0);
}

TEST(WavePlayOut, BurstLeavesTheNewest) {
  WavePlayOut buffer;
  buffer.restart(1);
  for (std::uint32_t i = 0; i < 3000; ++i) EXPECT_TRUE(buffer.receive(packetAt(i)));
  EXPECT_EQ(buffer.newest().sequence, 2999u);
  EXPECT_TRUE(buffer.play(packetAt(2999).time - 0.5).fresh);
}

TEST(LinkRegime, WorseAtOnceBetterAfterHalfASecond) {
  haptics::RegimeByAge regime;
  regime.restart(0.025);
  EXPECT_EQ(regime.regime(), LinkRegime::stiff);
  for (int i = 0; i < 100; ++i) regime.advance(0.1, LinkRegime::stiff, 1e-3);
  EXPECT_EQ(regime.regime(), LinkRegime::soft);
  EXPECT_TRUE(regime.advance(0.16, LinkRegime::stiff, 1e-3));
  EXPECT_EQ(regime.regime(), LinkRegime::apart);
  int ticks = 0;
  while (regime.regime() != LinkRegime::stiff && ticks < 2000)
    regime.advance(0.025, LinkRegime::stiff, 1e-3), ++ticks;
  EXPECT_GE(ticks, 500);
  EXPECT_LT(ticks, 1200);
}

/// How often the regime changes in a minute in which the age swings about `mean` (s) by a quarter of it, as
/// where queues on the way fill and empty.
int changesAbout(double mean, double period) {
  haptics::RegimeByAge regime;
  regime.restart(0.052);
  int changes = 0;
  for (int tick = 0; tick < 60'000; ++tick) {
    const double swing = std::sin(2.0 * 3.14159265 * 1e-3 * tick / period);
    if (regime.advance(mean * (1.0 + 0.25 * swing), LinkRegime::stiff, 1e-3)) ++changes;
  }
  return changes;
}

TEST(LinkRegime, JitterDoesNotChangeIt) {
  EXPECT_EQ(changesAbout(0.054, 0.4), 0);  // low-passed over a tenth of a second 61 ms, too far to be stiff
  EXPECT_EQ(changesAbout(0.066, 0.4), 1);
  EXPECT_GT(changesAbout(0.054, 20.0), 1);  // that is no jitter
}

TEST(LinkRegime, TheWorseOfBothEndsCounts) {
  haptics::RegimeByAge regime;
  regime.restart(0.025);
  EXPECT_TRUE(regime.advance(0.025, LinkRegime::soft, 1e-3));
  EXPECT_EQ(regime.regime(), LinkRegime::soft);
  EXPECT_EQ(regime.measured(), LinkRegime::stiff);
}

double kineticEnergy(const haptics::RigidBody& body) {
  const glm::dmat3 turn = glm::mat3_cast(body.worldFromBody.orientation);
  const glm::dvec3 com = transformPoint(body.worldFromBody, body.centreOfMass);
  const glm::dvec3 v = velocityAt(body.worldFromBody, body.twist, com),
                   w = glm::transpose(turn) * body.twist.angular;
  return 0.5 * body.mass * glm::dot(v, v) + 0.5 * glm::dot(w, body.inertia * w);
}

TEST(ReplicaMass, ReplicasAndTheLineMakeUpThePart) {
  const assets::MassProperties part{1.0, glm::dvec3(0.0), glm::dmat3(2e-3)};
  const assets::MassProperties half = haptics::replicaMass(part, 2, 0.5 * 0.6, 0.05);
  EXPECT_NEAR(2.0 * half.mass + 0.6, part.mass, 1e-12);
  EXPECT_NEAR(2.0 * half.inertia[1][1] + 0.6 * 0.05 * 0.05, part.inertia[1][1], 1e-12);
  EXPECT_NEAR(haptics::replicaMass(part, 2, 5.0, 0.05).mass, 0.05, 1e-12);
  EXPECT_NEAR(haptics::replicaMass(part, 20, 5.0, 0.05).mass, haptics::kMinReplicaMass, 1e-12);
}

TEST(ReplicaMass, ChangingItNeverAddsEnergy) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (int i = 0; i < 300; ++i) {
    haptics::RigidBody body;
    body.mass = 1.1 + number(random);
    body.centreOfMass = {number(random), number(random), number(random)};
    body.worldFromBody.orientation = fromRotationVector({number(random), number(random), number(random)});
    const auto inertia = [&] {
      const glm::dmat3 turn =
          glm::mat3_cast(fromRotationVector({number(random), number(random), number(random)}));
      return turn *
             glm::dmat3(1.1 + number(random), 0, 0, 0, 1.1 + number(random), 0, 0, 0, 1.1 + number(random)) *
             glm::transpose(turn);
    };
    body.inertia = inertia();
    body.twist = {{number(random), number(random), number(random)},
                  {number(random), number(random), number(random)}};
    const double before = kineticEnergy(body);
    haptics::changeMass(body, {1.1 + number(random), glm::dvec3(0.0), inertia()}, i % 2 == 0 ? 0.05 : 10.0);
    EXPECT_LE(kineticEnergy(body), before * (1.0 + 1e-12));
  }
}

/// An end whose replica is moved to and fro by a strong hand.
struct Lone {
  Lone() : link(haptics::LinkParameters{}) { link.begin(1, 0.025); }
  void tick() {
    const double now = 1e-3 * ticks++;
    const Pose pose{{0.05 * std::sin(3.0 * now), 0.0, 0.0},
                    fromRotationVector({0.0, 0.3 * std::sin(2.0 * now), 0.0})};
    const Twist twist{{0.15 * std::cos(3.0 * now), 0.0, 0.0}, {0.0, 0.6 * std::cos(2.0 * now), 0.0}};
    link.pull(now, pose, twist);
    force = link.account(pose, twist);
  }
  double now() const { return 1e-3 * ticks; }
  haptics::CoordinationLink link;
  Wrench force;
  int ticks = 0;
};

TEST(CoordinationLink, APeerThatLiesGetsNoMoreThanItAnnounces) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (const double power : {0.0, 0.02}) {  // W announced
    Lone lone;
    LinkPacket packet = packetAt(0);
    double most = 0.0;
    for (int i = 0; i < 5000; ++i) {
      if (i % 4 == 0) {
        packet.sequence += 1;
        packet.time = lone.now() - 0.02;
        packet.wave +=
            SixAxes{{0.1 * number(random), 0.1 * number(random), 0.0}, {0.0, 0.1 * number(random), 0.0}};
        packet.energy = power * lone.now();
        lone.link.receive(packet);
      }
      lone.tick();
      const haptics::LinkAccount& a = lone.link.account();
      most = std::max(most, a.work + a.stored + a.reserve - power * lone.now());
    }
    EXPECT_LE(most, 1e-9) << power;
    EXPECT_TRUE(std::isfinite(lone.link.account().work));
  }
}

TEST(CoordinationLink, TicksAllocateNothingAndRepeatToTheBit) {
  Lone a, b;
  test::AllocationScope allocations;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    for (Lone* lone : {&a, &b}) {
      if (i % 4 == 0) {
        LinkPacket packet = packetAt(i / 4);
        packet.wave = 0.01 * packet.wave;
        lone->link.receive(packet);
        lone->link.packet(lone->now());
      }
      lone->tick();
    }
    ASSERT_EQ(a.force.force.x, b.force.force.x);
    ASSERT_EQ(a.force.torque.y, b.force.torque.y);
  }
  EXPECT_EQ(allocations.count(), 0u);
  EXPECT_TRUE(a.link.fresh());
}

TEST(CoordinationLink, SwitchedOffItsForceRunsOut) {
  Lone lone;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    if (i % 4 == 0) {
      LinkPacket packet = packetAt(i / 4);
      packet.wave = {{1e-4 * i, 0.0, 0.0}, {}};
      packet.energy = 1e-3 * i;
      lone.link.receive(packet);
    }
    lone.tick();
  }
  const double before = glm::length(lone.force.force);
  lone.link.setOn(false);
  lone.tick();
  EXPECT_NEAR(glm::length(lone.force.force), before, 0.2);
  // An end that has been put off goes calmly, at 1.5 N/s.
  for (int i = 0; i < 100; ++i) lone.tick();
  EXPECT_GT(glm::length(lone.force.force), before - 0.4);
  for (int i = 0; i < 900; ++i) lone.tick();
  EXPECT_LT(glm::length(lone.force.force), before - 1.5);
  for (int i = 0; i < 1000; ++i) lone.tick();
  EXPECT_LT(glm::length(lone.force.force), 0.1);
  EXPECT_FALSE(lone.link.packet(lone.now()).on);
}

TEST(PlayOutDelay, MarginIsAddedToWhatIsEnough) {
  haptics::PlayOutDelay plain, later(0.010), sooner(-0.004);
  for (haptics::PlayOutDelay* delay : {&plain, &later, &sooner}) {
    delay->restart(0.025, 4e-3, kTick);
    for (int i = 0; i < 5000; ++i) delay->advance(0.025 + 1e-3 * (i % 7));
  }
  EXPECT_DOUBLE_EQ(later.seconds(), plain.seconds() + 0.010);
  EXPECT_DOUBLE_EQ(sooner.seconds(), plain.seconds() - 0.004);
}

TEST(CoordinationLink, PlayingOutSoonerItLendsMore) {
  const auto lentWith = [](double margin) {
    BenchSetup setup;
    setup.sites = twoHands(firmArm(), lightArm());
    setup.link.playOutMargin = margin;
    LinkBench bench(setup);
    bench.runTo(4.0, [](double t, int who) { return who == 0 ? dragPath(t) : haptics::SixAxes{}; });
    return bench.end(0, 0).account().borrowed + bench.end(0, 1).account().borrowed;
  };
  const double usual = lentWith(0.0);
  EXPECT_GT(lentWith(-0.004), 2.0 * usual);
  EXPECT_LT(lentWith(0.010), usual);
}

}  // namespace
}  // namespace tandem::test
