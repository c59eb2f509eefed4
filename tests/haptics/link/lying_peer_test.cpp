// A peer may say anything in the packets of a link: waves that no hand makes, energy that it does not send,
// poses, fades and times. A hand that holds the part with it must not be kicked by that.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include <glm/geometric.hpp>

#include "haptics/base/minimum_jerk.h"
#include "tests/haptics/link/link_checks.h"
#include "tests/haptics/link/linked_sites.h"

namespace tandem::test {
namespace {

using haptics::LinkPacket;
using haptics::LinkRegime;
using haptics::minimumJerk;
using haptics::SixAxes;

constexpr double kLieAt = 2.0, kEnd = 3.2;  // s
constexpr int kWindow = 20;                 // ticks
constexpr double kImpedance = 27.0;         // N·s/m

enum class Lie {
  none,
  push,
  twist,
  shake,
  jumps,
  noise,
  noEnergy,
  inverted,
  poses,
  twists,
  fades,
  steps,
  flicker,
  regimes,
  times,
  late,
  silent,
  anything
};
enum class Doing { rests, presses, strokes };

constexpr Lie kLies[] = {Lie::none,     Lie::push,     Lie::twist, Lie::shake,  Lie::jumps,  Lie::noise,
                         Lie::noEnergy, Lie::inverted, Lie::poses, Lie::twists, Lie::fades,  Lie::steps,
                         Lie::flicker,  Lie::regimes,  Lie::times, Lie::late,   Lie::silent, Lie::anything};
constexpr Doing kDoings[] = {Doing::rests, Doing::presses, Doing::strokes};
const char* const kLieNames[] = {"none",      "push",     "twist", "shake",  "jumps",  "noise",
                                 "no energy", "inverted", "poses", "twists", "fades",  "steps",
                                 "flicker",   "regimes",  "times", "late",   "silent", "anything"};
const char* const kDoingNames[] = {"rests", "presses", "strokes"};

bool prints() { return std::getenv("TANDEM_FULL_SIZE") != nullptr; }

/// Makes lies of the packets of an honest end.
class Liar {
 public:
  /// `push` N, of Lie::push.
  Liar(Lie lie, unsigned seed, double push) : lie_(lie), push_(push), random_(seed) {
    axis_ = glm::normalize(glm::dvec3(in(-1.0, 1.0), in(-1.0, 1.0), in(-1.0, 1.0)));
  }

  /// False: the packet is not sent.
  bool say(LinkPacket& p) {
    const double t = p.time - kLieAt;
    if (lie_ == Lie::none || t < 0.0) {
      last_ = p;
      return true;
    }
    const LinkPacket truth = p;
    switch (lie_) {
      case Lie::push:
        return addForce(p, push_ * axis_);
      case Lie::twist:
        return addForce(p, glm::dvec3(0.0), push_ * axis_);
      case Lie::shake:
        return addForce(p, (std::fmod(t, 0.04) < 0.02 ? 10.0 : -10.0) * axis_);
      case Lie::noise:
        return addForce(p, 30.0 * any(), 30.0 * any());
      case Lie::jumps:
        if (in(0.0, 1.0) < 0.1) sum_ += SixAxes{0.1 * any(), 0.1 * any()};
        energy_ += 0.1;
        break;
      case Lie::noEnergy:
        p.energy = last_.energy;
        break;
      case Lie::inverted:
        p.wave = last_.wave - (p.wave - last_.wave);
        break;
      case Lie::poses:
        if (in(0.0, 1.0) < 0.1) offset_ = 0.5 * any();
        p.worldFromDrawn.position += offset_;
        break;
      case Lie::twists:
        p.twist = {8.0 * any(), 60.0 * any()};
        break;
      case Lie::fades:
        p.fade = std::fmod(t, 0.2) < 0.1 ? 0.0 : 1.0;
        break;
      case Lie::steps:
        p.fade = std::abs(1.0 - std::fmod(t / 0.044, 2.0));
        break;
      case Lie::flicker:
        p.on = std::fmod(t, 0.2) >= 0.1;
        break;
      case Lie::regimes:
        p.regime = static_cast<LinkRegime>(static_cast<int>(t / 0.1) % 3);
        break;
      case Lie::times:
        p.time += in(-0.1, 0.3);
        break;
      case Lie::late:
        p.time -= 0.3 * t;
        break;
      case Lie::silent:
        return false;
      default:
        addForce(p, 10.0 * any());
        if (in(0.0, 1.0) < 0.1) offset_ = 0.1 * any();
        p.worldFromDrawn.position += offset_;
        p.twist = {any(), any()};
        p.fade = in(0.8, 1.0);
        p.energy = truth.energy + energy_ * in(0.5, 1.0);
        return true;
    }
    p.wave += sum_;
    p.energy += energy_;
    return true;
  }

 private:
  static constexpr double kPeriod = 4e-3;
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  glm::dvec3 any() { return {in(-1.0, 1.0), in(-1.0, 1.0), in(-1.0, 1.0)}; }
  /// A wave that makes this force on a hand that holds still, and its energy.
  bool addForce(LinkPacket& p, const glm::dvec3& force, const glm::dvec3& turning = glm::dvec3(0.0)) {
    const SixAxes wave = (1.0 / std::sqrt(2.0 * kImpedance)) * SixAxes{force, turning};
    sum_ += kPeriod * wave;
    energy_ += 10.0 * kPeriod * haptics::dot(wave, wave);
    p.wave += sum_;
    p.energy += energy_;
    return true;
  }

  Lie lie_;
  double push_;
  std::mt19937 random_;
  glm::dvec3 axis_, offset_{0.0};
  SixAxes sum_;
  double energy_ = 0.0;
  LinkPacket last_;
};

struct Felt {
  double step = 0.0, beyond = 0.0;  // N in 20 ms; the same less stiffness x path of the hand
  double turn = 0.0;                // N·m in 20 ms
  double work = 0.0;                // J, most that the force gave the hand since the lie began
  double fade = 0.0;                // of the link, at the end
  bool named = false;               // the tick says that the peer is not believed

  void include(const Felt& other) {
    step = std::max(step, other.step), beyond = std::max(beyond, other.beyond);
    turn = std::max(turn, other.turn), work = std::max(work, other.work);
  }
};

struct Case {
  Lie lie = Lie::none;
  Doing doing = Doing::rests;
  double delay = 0.025;
  bool limited = true;
  unsigned seed = 1;
  double push = 30.0;  // N, of Lie::push
};

SixAxes intentOf(const Case& c, double t, int site) {
  if (c.doing == Doing::strokes && site == 0)
    return {{0.0, 0.015 * minimumJerk(t / 0.5) * std::sin(3.1416 * t), 0.0}, {}};
  if (c.doing == Doing::presses)
    return {{(site == 0 ? -0.02 : 0.02) * minimumJerk((t - 0.6) / 0.8), 0.0, 0.0}, {}};
  return {};
}

/// What the first hand feels of a second one that lies from kLieAt on. Appends its force in each tick.
Felt feltOf(const Case& c, std::vector<glm::dvec3>* forces = nullptr) {
  LinkedSetup setup;
  static const assets::Scene scene = benchScene();
  setup.scene = scene;
  setup.sites = twoHands(relaxedArm(), c.doing == Doing::presses ? firmArm() : relaxedArm());
  setup.network.delay = c.delay;
  setup.seed = c.seed;
  if (!c.limited) setup.link.peerSlew = 0.0;
  LinkedSites sites(setup);
  sites.linkAll();
  Liar liar(c.lie, c.seed, c.push);
  sites.tamper = [&](std::size_t site, LinkPacket& packet) { return site != 1 || liar.say(packet); };
  const auto intent = [&](double t, int site) { return intentOf(c, t, site); };
  sites.runTo(kLieAt, intent);
  const double given = sites.site(0).arm.given();
  std::vector<glm::dvec3> places;
  std::vector<glm::dvec3> turns;
  Felt felt;
  while (sites.time() < kEnd) {
    sites.step(intent);
    const LinkedSites::Site& hand = sites.site(0);
    places.push_back(hand.arm.device().position);
    if (forces != nullptr) forces->push_back(hand.onHand().force);
    turns.push_back(hand.onHand().torque);
    if (places.size() <= kWindow) continue;
    double path = 0.0;
    for (int k = 0; k < kWindow; ++k) path += glm::length(places.end()[-1 - k] - places.end()[-2 - k]);
    felt.include({hand.change, hand.change - sites.parameters.graspStiffness * path,
                  glm::length(turns.back() - turns.end()[-1 - kWindow]), hand.arm.given() - given});
  }
  felt.fade = sites.site(0).part().links.fade;
  std::array<haptics::LinkId, haptics::ReplicaLinks::kMaxLinks> doubts;
  felt.named = sites.site(0).state.drainDoubts(doubts) > 0;
  return felt;
}

/// Most lies only bend a force that is there.
bool makesForce(Lie lie) {
  return lie == Lie::push || lie == Lie::twist || lie == Lie::shake || lie == Lie::jumps ||
         lie == Lie::noise || lie == Lie::anything;
}

/// `push` N, of Lie::push.
Felt mostFelt(Lie lie, Doing doing, bool limited, double push = 30.0) {
  Felt most;
  const double delays[] = {0.050, 0.010, 0.025, 0.100};
  const int count = prints() ? 4 : 1, seedCount = prints() ? 2 : 1;
  for (int d = 0; d < count; ++d) {
    for (int seed = 1; seed <= seedCount; ++seed)
      most.include(feltOf({lie, doing, delays[d], limited, static_cast<unsigned>(seed), push}));
  }
  if (prints())
    std::printf("%-8s %-9s %.3f N in 20 ms, %6.3f N beyond the hand's own, %.4f N m, %.2f mJ\n",
                kDoingNames[static_cast<int>(doing)], kLieNames[static_cast<int>(lie)], most.step,
                most.beyond, most.turn, 1e3 * most.work);
  return most;
}

TEST(LyingPeer, KicksNoHandThatHoldsAPartWithIt) {
  for (const Doing doing : kDoings) {
    for (const Lie lie : kLies) {
      if (!prints() &&
          (doing == Doing::strokes ? lie != Lie::push : doing == Doing::rests && !makesForce(lie)))
        continue;
      const Felt most = mostFelt(lie, doing, true);
      const std::string what =
          std::string(kLieNames[static_cast<int>(lie)]) + ", " + kDoingNames[static_cast<int>(doing)];
      EXPECT_LE(most.beyond, 0.3) << what;
      EXPECT_LE(most.step, 0.5) << what;  // with what a hand that is drawn along or strokes does itself
      EXPECT_LE(most.turn, 0.04) << what;
      // A turn of the wrist is quicker than any push, so a lie about it is noticed later.
      EXPECT_LE(most.work, lie == Lie::twist ? 60e-3 : 10e-3) << what;
    }
  }
}

// A tick's difference makes a reading of the device change some ticks sooner or later: two quanta of it.
TEST(HonestPeer, IsFeltNearlyAsIfItWereBelieved) {
  for (const Doing doing : kDoings) {
    std::vector<glm::dvec3> limited, believed;
    const Felt felt = feltOf({Lie::none, doing, 0.050, true}, &limited);
    EXPECT_EQ(felt.fade, 1.0);
    EXPECT_FALSE(felt.named);
    feltOf({Lie::none, doing, 0.050, false}, &believed);
    double most = 0.0;
    for (std::size_t i = 0; i < limited.size(); ++i)
      most = std::max(most, glm::length(limited[i] - believed[i]));
    if (prints()) std::printf("honest peer, %s: %.4f N\n", kDoingNames[static_cast<int>(doing)], most);
    EXPECT_LE(most, 0.1) << kDoingNames[static_cast<int>(doing)];
  }
}

// A lie of no more than a strong hand could do is taken for one: it draws the hand along, which stretches the
// hand's own spring, and gives it what such a hand would. Beyond that it changes the force as others do.
TEST(LyingPeer, ThatSaysWhatAHandCouldDoDrawsAsOne) {
  const std::vector<double> pushes =
      prints() ? std::vector<double>{4.0, 6.0, 8.0, 12.0, 20.0} : std::vector<double>{8.0};
  for (const double push : pushes) {
    for (const Doing doing : kDoings) {
      const Felt most = mostFelt(Lie::push, doing, true, push);
      EXPECT_LE(most.beyond, 0.3) << push << " N, " << kDoingNames[static_cast<int>(doing)];
    }
  }
}

TEST(LyingPeer, IsNamedAndAsIfSilentWhereItPushesAsNoHandDoes) {
  const Felt pushed = feltOf({Lie::push, Doing::rests, 0.050, true});
  EXPECT_EQ(pushed.fade, 0.0);
  EXPECT_TRUE(pushed.named);
  const Felt mistimed = feltOf({Lie::times, Doing::presses, 0.050, true});
  EXPECT_EQ(mistimed.fade, 0.0);
  EXPECT_TRUE(mistimed.named);
}

TEST(LyingPeer, KicksAHandThatBelievesIt) {
  const Felt shaken = mostFelt(Lie::shake, Doing::presses, false);
  EXPECT_GT(shaken.step, 1.0);
  // Without a brake, what it no longer pays for breaks off.
  EXPECT_GT(mostFelt(Lie::noEnergy, Doing::presses, false).step, 0.35);
  const Felt pushed = mostFelt(Lie::push, Doing::rests, false);
  EXPECT_GT(pushed.step, 1.0);
  EXPECT_GT(pushed.work, 20e-3);
}

}  // namespace
}  // namespace tandem::test
