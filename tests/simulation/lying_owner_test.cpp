// What an owner that lies about its part, or a server that lies about it, can do to an honest hand: where the
// part moves as no hand moves it, the force changes by 0.3 N in 20 ms at most, and the hand is given 10 mJ at
// most. Where it moves as a hand may move it, it is felt as that. TANDEM_FULL_SIZE prints figures.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <random>

#include "tests/simulation/lied_hand.h"
#include "tests/simulation/shared_sessions.h"

namespace tandem::test {
namespace {

using Claim = LiedHand::Claim;
using Liar = LiedHand::Liar;

constexpr double kForceStep = 0.3;        // N in 20 ms
constexpr double kEnergy = 10e-3;         // J
constexpr double kLies = 2.0;             // s
constexpr std::size_t kNamedAfter = 500;  // guarded ticks
constexpr double kOfAHand = 50.0;         // m/s^2: what a hand and its device may give the block of 1 kg

struct Attack {
  std::string name;
  std::function<Liar(std::mt19937_64&)> make;
  bool unnamed = false;  // it lies for a moment only, or hardly beyond what a hand can do
};

double between(std::mt19937_64& dice, double from, double to) {
  return from + (to - from) * std::uniform_real_distribution<>()(dice);
}
glm::dvec3 direction(std::mt19937_64& dice) {
  const glm::dvec3 v(between(dice, -0.4, 0.4), between(dice, 0.5, 1.0), between(dice, -0.4, 0.4));
  return glm::normalize(v);
}
Pose shifted(const glm::dvec3& by) { return {by, {1.0, 0.0, 0.0, 0.0}}; }

Liar sine(const glm::dvec3& axis, double amplitude, double hz, double phase, double velocityShare) {
  return [=](double t) -> Claim {
    const double w = 2.0 * M_PI * hz;
    return {shifted(amplitude * (std::sin(w * t + phase) - std::sin(phase)) * axis),
            {velocityShare * amplitude * w * std::cos(w * t + phase) * axis, glm::dvec3(0.0)},
            0};
  };
}

const std::string kHereAndThere = "is now here, now there, each in an epoch of its own";
const std::string kFarAway = "is now here, now out of the world, each in an epoch of its own";

std::vector<Attack> attacks() {
  std::vector<Attack> all;
  for (const double amplitude : {0.002, 0.02, 0.1})
    for (const double hz : {amplitude < 0.01 ? 41.0 : 13.0, 61.0, 250.0})
      all.push_back({"sine of " + std::to_string(amplitude) + " m at " + std::to_string(hz) + " Hz",
                     [=](std::mt19937_64& dice) {
                       return sine(direction(dice), amplitude, hz * between(dice, 0.8, 1.2),
                                   between(dice, 0.0, 6.0), 1.0);
                     }});
  for (const double amplitude : {0.001, 0.002, 0.005, 0.01, 0.02})
    for (const double hz : {20.0, 40.0, 70.0, 130.0, 400.0})
      if (const double most = amplitude * 4.0 * M_PI * M_PI * hz * hz; most > 1.5 * kOfAHand)
        all.push_back({"shake of " + std::to_string(amplitude) + " m at " + std::to_string(hz) + " Hz",
                       [=](std::mt19937_64& dice) {
                         return sine(direction(dice), amplitude * between(dice, 0.95, 1.05),
                                     hz * between(dice, 0.95, 1.05), between(dice, 0.0, 6.0), 1.0);
                       },
                       most < 2.0 * kOfAHand});
  all.push_back({"ramps",
                 [](std::mt19937_64& dice) {
                   const double a = between(dice, 80.0, 400.0), speed = between(dice, 0.5, 5.0);
                   const double far = between(dice, 0.02, 0.2), rise = speed / a;
                   const glm::dvec3 axis = direction(dice);
                   return [=](double t) -> Claim {
                     const double y = t < rise ? 0.5 * a * t * t : 0.5 * speed * rise + speed * (t - rise);
                     const double v = y < far ? std::min(speed, a * t) : 0.0;
                     return {shifted(std::min(y, far) * axis), {v * axis, glm::dvec3(0.0)}, 0};
                   };
                 },
                 true});
  all.push_back({"a shake that says that it rests", [](std::mt19937_64& dice) {
                   return sine(direction(dice), between(dice, 0.002, 0.05), between(dice, 3.0, 90.0), 0.0,
                               0.0);
                 }});
  all.push_back({"velocities against the motion", [](std::mt19937_64& dice) {
                   return sine(direction(dice), between(dice, 0.002, 0.02), between(dice, 1.0, 30.0), 0.0,
                               -3.0);
                 }});
  for (const double every : {0.004, 0.03, 0.2})
    all.push_back({"jumps every " + std::to_string(every) + " s", [=](std::mt19937_64& dice) {
                     const glm::dvec3 by = between(dice, 0.005, 0.5) * direction(dice);
                     return [=](double t) -> Claim {
                       return {shifted(static_cast<int>(t / every) % 2 == 0 ? by : glm::dvec3(0.0)), {}, 0};
                     };
                   }});
  all.push_back({"stands still and says that it is fast", [](std::mt19937_64& dice) {
                   const glm::dvec3 v = between(dice, 1.0, 8.0) * direction(dice);
                   return [=](double t) -> Claim {
                     return {shifted({}), {std::sin(200.0 * t) * v, glm::dvec3(0.0)}, 0};
                   };
                 }});
  all.push_back({"spins",
                 [](std::mt19937_64& dice) {
                   const double rate = between(dice, 5.0, 300.0);
                   return [=](double t) -> Claim {
                     return {{glm::dvec3(0.0), glm::angleAxis(rate * t, glm::dvec3(0.0, 0.0, 1.0))},
                             {glm::dvec3(0.0), {0.0, 0.0, rate}},
                             0};
                   };
                 },
                 true});
  all.push_back({"false time stamps", [](std::mt19937_64& dice) {
                   const Liar motion = sine(direction(dice), 0.02, between(dice, 1.0, 20.0), 0.0, 1.0);
                   const std::uint64_t seed = dice();
                   return [=](double t) -> Claim {
                     Claim claim = motion(t);
                     std::mt19937_64 noise(seed + static_cast<std::uint64_t>(t * 1e3));
                     claim.late = static_cast<sync::Micros>(between(noise, -0.4e6, 0.4e6));
                     return claim;
                   };
                 }});
  for (const double speed : {2.0, 4.0, 7.5})
    all.push_back({"is at once at " + std::to_string(speed) + " m/s",
                   [=](std::mt19937_64& dice) {
                     const glm::dvec3 v = speed * direction(dice);
                     const double far = between(dice, 0.02, 0.12);
                     return [=](double t) -> Claim {
                       const bool goes = speed * t < far;
                       return {shifted(goes ? v * t : far / speed * v),
                               {goes ? v : glm::dvec3(0.0), glm::dvec3(0.0)},
                               0};
                     };
                   },
                   true});
  all.push_back({"comes and goes", [](std::mt19937_64& dice) {
                   const double speed = between(dice, 0.5, 2.0), far = between(dice, 0.01, 0.05);
                   const glm::dvec3 axis = direction(dice);
                   return [=](double t) -> Claim {
                     const double period = 2.0 * far / speed, phase = std::fmod(t, period);
                     const bool out = phase < 0.5 * period;
                     const double y = out ? speed * phase : 2.0 * far - speed * phase;
                     return {shifted(y * axis), {(out ? speed : -speed) * axis, glm::dvec3(0.0)}, 0};
                   };
                 }});
  all.push_back({kHereAndThere, nullptr});
  all.push_back({kFarAway, nullptr});
  return all;
}

struct Felt {
  double step = 0.0, energy = 0.0;
  std::size_t guardedTicks = 0, reports = 0;
};

/// A lying server gives the part to another owner now and then, each time elsewhere.
void flip(LiedHand& hand, std::mt19937_64& dice, double farthest) {
  for (const double end = hand.time() + kLies; hand.time() < end;) {
    const bool far = farthest > 1.0 && between(dice, 0.0, 1.0) < 0.5;
    hand.reown(shifted(between(dice, 0.0, far ? farthest : 0.3) * direction(dice)));
    hand.rest(between(dice, 0.01, 0.3));
  }
}

std::size_t reports(const LiedHand& hand) {
  std::size_t count = 0;
  for (const sync::ControlMessage& message : hand.heard()) {
    const auto* report = std::get_if<sync::MotionReport>(&message);
    if (report == nullptr) continue;
    EXPECT_TRUE(report->part == 0 && report->site == kLiar);
    ++count;
  }
  return count;
}

/// How the hand meets the block: with a tool over it, a tool that rests on it with about 0.7 N, or a part in
/// the hand that does.
enum class Meets { nearly, byTool, byHeldPart };

std::string scriptOf(Meets meets, bool firm) {
  if (meets == Meets::byHeldPart)
    return std::string(R"([{"t":0.2,"do":"grasp","part":"plate","over_s":0.4},)") +
           R"({"t":0.7,"do":"move_relative","by":[0,)" + (firm ? "0.034" : "0.05") + R"(,0],"over_s":0.5}])";
  const char* depth = meets == Meets::nearly ? "-0.004" : firm ? "0.004" : "0.02";
  return std::string(R"([{"t":0.3,"do":"press","part":"block","depth":)") + depth + R"(,"over_s":0.5}])";
}

Felt felt(const Attack& attack, std::uint64_t seed, bool firm, Meets meets, bool guarded) {
  LiedHand::Options options;
  options.seed = seed;
  options.guarded = guarded;
  options.arm = firm ? firmArm() : relaxedArm();
  if (meets == Meets::byHeldPart) options.start = {0.0, -0.06, 0.0};
  options.script = scriptOf(meets, firm);
  LiedHand hand(options);
  hand.rest(1.6);
  EXPECT_EQ(hand.force() > 0.3, meets != Meets::nearly) << hand.force();
  hand.mark();
  std::mt19937_64 dice(seed);
  if (attack.make != nullptr)
    hand.lie(kLies, attack.make(dice));
  else
    flip(hand, dice, attack.name == kFarAway ? 1e6 : 0.3);
  hand.rest(0.3);
  EXPECT_FALSE(hand.output().tick.flags & haptics::kFlagFault);
  return {hand.forceStep(), hand.energy(), hand.guardedTicks(), reports(hand)};
}

bool prints() { return std::getenv("TANDEM_FULL_SIZE") != nullptr; }

TEST(LyingOwner, NeitherKicksNorDrivesAHandThatMeetsItsPart) {
  const std::uint64_t seeds = prints() ? 20 : 1;
  const char* const how[] = {"over it", "touching", "held"};
  Felt worst;
  for (const Attack& attack : attacks())
    for (std::uint64_t seed = 1; seed <= seeds; ++seed)
      for (const Meets meets : {Meets::nearly, Meets::byTool, Meets::byHeldPart}) {
        const bool firm = (seed + attack.name.size()) % 2 == 0;
        const Felt now = felt(attack, seed, firm, meets, true);
        worst.step = std::max(worst.step, now.step), worst.energy = std::max(worst.energy, now.energy);
        SCOPED_TRACE(attack.name + ", seed " + std::to_string(seed) + (firm ? " firm " : " relaxed ") +
                     how[static_cast<int>(meets)]);
        if (prints())
          std::printf("%-45s seed %2d %s %s: %.3f N in 20 ms, %.2f mJ, guarded for %d ms, %d reports\n",
                      attack.name.c_str(), int(seed), firm ? "firm" : "relaxed", how[static_cast<int>(meets)],
                      now.step, 1e3 * now.energy, int(now.guardedTicks), int(now.reports));
        EXPECT_LE(now.step, kForceStep);
        EXPECT_LE(now.energy, kEnergy);
        EXPECT_TRUE(attack.unnamed || now.guardedTicks <= kNamedAfter || now.reports > 0);
      }
  if (prints()) std::printf("worst: %.3f N in 20 ms, %.2f mJ\n", worst.step, 1e3 * worst.energy);
}

TEST(LyingOwner, KicksAndDrivesAHandWithoutTheGuard) {
  int kicked = 0, driven = 0, all = 0;
  for (const Attack& attack : attacks())
    for (const Meets meets : {Meets::byTool, Meets::byHeldPart}) {
      const Felt now = felt(attack, 1, true, meets, false);
      if (prints())
        std::printf("unguarded: %-45s %.3f N in 20 ms, %.2f mJ\n", attack.name.c_str(), now.step,
                    1e3 * now.energy);
      kicked += now.step > kForceStep, driven += now.energy > kEnergy, ++all;
    }
  EXPECT_GT(kicked, all / 2);
  EXPECT_GT(driven, all / 4);
}

/// A shake that a hand could make of the part is felt as such: no receiver can tell the two apart.
TEST(LyingOwner, IsFeltAsAHandIfItMovesAsAHandCould) {
  double step = 0.0, energy = 0.0;
  for (const double hz : {3.0, 6.0, 10.0, 16.0, 24.0}) {
    const double amplitude =
        std::min(0.35 * kOfAHand / (4.0 * M_PI * M_PI * hz * hz), 0.5 / (2.0 * M_PI * hz));
    const Attack shake{"", [=](std::mt19937_64&) {
                         return sine({0.0, 1.0, 0.0}, amplitude, hz, -0.5 * M_PI, 1.0);
                       }};
    const Felt now = felt(shake, 1, true, Meets::byTool, true);
    if (prints())
      std::printf("as a hand: %.4f m at %.0f Hz: %.3f N in 20 ms, %.2f mJ\n", amplitude, hz, now.step,
                  1e3 * now.energy);
    EXPECT_EQ(now.reports, 0u);
    step = std::max(step, now.step), energy = std::max(energy, now.energy);
  }
  EXPECT_GT(step, kForceStep);
}

/// Strokes into the hand and back, as a person makes them: along minimum-jerk paths, some ended at once as at
/// a wall.
struct Stroke {
  glm::dvec3 axis;
  double far, lasts, ends;  // m, s, share of the stroke at which it hits something
  Stroke(std::mt19937_64& dice, double fastest) : axis(direction(dice)), far(between(dice, 0.01, 0.3)) {
    constexpr double kPeakSpeed = 1.875, kPeakAcceleration = 5.774;  // of a stroke of 1 m within 1 s
    const double speed = between(dice, 0.05, fastest), acceleration = between(dice, 5.0, 30.0);
    lasts = std::max(kPeakSpeed * far / speed, std::sqrt(kPeakAcceleration * far / acceleration));
    ends = between(dice, 0.0, 1.0) < 0.5 ? 1.0 : between(dice, 0.3, 1.0);
  }
  Claim at(double t) const {
    const double end = lasts * ends;
    const bool back = t > end + 0.2, stands = (t > end && !back) || t > end + 0.2 + lasts;
    if (stands) return {shifted(position(back ? 0.0 : end) * axis), {}, 0};
    if (!back) return {shifted(position(t) * axis), {speed(t) * axis, glm::dvec3(0.0)}, 0};
    const double share = position(end) / far, u = t - end - 0.2;
    return {shifted((position(end) - share * position(u)) * axis),
            {-share * speed(u) * axis, glm::dvec3(0.0)},
            0};
  }

 private:
  double position(double t) const {
    const double s = std::clamp(t / lasts, 0.0, 1.0);
    return far * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  }
  double speed(double t) const {
    const double s = std::clamp(t / lasts, 0.0, 1.0);
    return 30.0 * far / lasts * s * s * (1.0 - s) * (1.0 - s);
  }
};

TEST(LyingOwner, ButWhatAHandMayDoIsFeltToTheBitAsWithoutTheGuard) {
  double most = 0.0;
  for (std::uint64_t seed = 1; seed <= (prints() ? 200 : 20); ++seed) {
    std::array<std::vector<glm::dvec3>, 2> forces;
    for (const bool guarded : {true, false}) {
      std::mt19937_64 dice(seed);
      LiedHand::Options options;
      options.seed = seed;
      options.guarded = guarded;
      options.arm = seed % 2 == 0 ? firmArm() : relaxedArm();
      options.jitter = seed % 3 == 0 ? 0.5 : 0.2;
      options.loss = seed % 4 == 0 ? 0.1 : 0.0;
      options.script = R"([{"t":0.3,"do":"press","part":"block","depth":0.004,"over_s":0.5}])";
      LiedHand hand(options);
      hand.rest(1.0);
      hand.mark();
      for (int i = 0; i < 2; ++i) {
        const bool bad = options.jitter > 0.3 || options.loss > 0.0;
        const Stroke stroke(dice, bad ? 0.5 : 2.0);  // m/s
        hand.lie(2.0 * stroke.lasts + 0.4, [&](double t) { return stroke.at(t); });
      }
      EXPECT_EQ(hand.guardedTicks(), 0u) << seed;
      EXPECT_EQ(reports(hand), 0u) << seed;
      most = std::max(most, hand.maxForce());
      forces[guarded ? 0 : 1] = hand.forces();
    }
    EXPECT_TRUE(forces[0] == forces[1]) << seed;
  }
  EXPECT_GT(most, 2.0) << "nothing was felt";
}

TEST(LyingOwner, IsNotTrustedOnceNamed) {
  LiedHand::Options options;
  options.arm = firmArm();
  options.script = R"([{"t":0.3,"do":"press","part":"block","depth":-0.004,"over_s":0.5}])";
  LiedHand hand(options);
  hand.rest(1.2);
  hand.lie(1.0, sine({0.0, 1.0, 0.0}, 0.02, 61.0, 0.0, 1.0));
  hand.rest(4.0);
  EXPECT_EQ(reports(hand), 1u);
  hand.mark();
  hand.lie(1.0, [](double t) -> Claim {
    const double v = t < 0.2 ? 0.3 : 0.0;
    return {shifted({0.0, 0.3 * std::min(t, 0.2), 0.0}), {{0.0, v, 0.0}, glm::dvec3(0.0)}, 0};
  });
  EXPECT_GT(hand.guardedTicks(), 0u);
  EXPECT_LE(hand.forceStep(), kForceStep);
  EXPECT_LE(hand.energy(), kEnergy);
}

bool isNoted(LiedHand& hand, const std::string& text) {
  bool noted = false;
  for (const client::Notice& notice : hand.site().drainNotices())
    noted = noted || notice.text.find(text) != std::string::npos;
  return noted;
}

TEST(LyingOwner, IsNamedToThePersonAndToTheServer) {
  LiedHand::Options options;
  options.script = "[]";
  const auto told = [&](const Liar& liar) {
    LiedHand hand(options);
    hand.lie(2.0, liar);
    hand.rest(0.2);
    EXPECT_EQ(isNoted(hand, "Eve's part block moves as no hand moves it"), reports(hand) > 0);
    return reports(hand);
  };
  EXPECT_EQ(told(sine({0.0, 1.0, 0.0}, 0.02, 61.0, 0.0, 1.0)), 1u);
  EXPECT_EQ(told(sine({0.0, 1.0, 0.0}, 0.02, 11.0, 0.0, 0.0)), 1u) << "the velocities are false";
  EXPECT_EQ(told(sine({0.0, 1.0, 0.0}, 0.1, 2.0, 0.0, 1.0)), 0u) << "a hand can do that";
}

TEST(LyingOwner, IsNamedByOthersWithTheirName) {
  LiedHand::Options options;
  options.script = "[]";
  LiedHand hand(options);
  for (int i = 0; i < 1000; ++i) hand.say(sync::MotionReported{kLiar, 0, kHonest});
  hand.rest(0.1);
  const std::vector<client::Notice> notices = hand.site().drainNotices();
  std::size_t count = 0;
  for (const client::Notice& notice : notices)
    count += notice.text == "Eve's site says that your part block moves impossibly" ? 1 : 0;
  EXPECT_EQ(count, 1u) << "a flood of opinions is one line";
  EXPECT_EQ(hand.site().stage(), client::ServerConnection::Stage::ready);
}

}  // namespace
}  // namespace tandem::test
