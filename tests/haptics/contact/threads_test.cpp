// A nut on its bolt: only contact between the two threads makes it advance by their pitch a turn.

#include <cstdlib>
#include <numbers>

#include "assets/gltf/load_gltf.h"
#include "tests/haptics/contact/part_contact_case.h"

namespace tandem::test {
namespace {

constexpr double kTurnsASecond = 1.0;
constexpr double kSettle = 0.2;     // s, in which the hand begins to push the nut down, before it turns it
constexpr double kEngaged = 0.008;  // m: a whole number of pitches
constexpr int kSegments = 40;       // of the thread that is made, a turn; ticks of 25 ms
constexpr double kPush = 2.0;       // N
constexpr double kTurnATick = 2e-3 * std::numbers::pi * kTurnsASecond;  // rad

/// The hand turns the nut and pushes it down as a thread that begins after `idle` turns would let it.
PartCase nutCase(std::string name, assets::Scene scene, PartId nut, const Pose& start, double turns,
                 double pitch, double idle = 0.0) {
  const auto path = [=](double t) {
    const double turned = kTurnsASecond * std::max(0.0, t - kSettle),
                 push = kPush / rigParameters().graspStiffness * std::min(1.0, t / (0.5 * kSettle));
    Pose pose = start;
    pose.orientation = fromRotationVector({0.0, 0.0, -2.0 * std::numbers::pi * turned}) * pose.orientation;
    pose.position.z -= pitch * std::max(0.0, turned - idle) + push;
    return pose;
  };
  return {std::move(name), std::move(scene), nut, path, kSettle + turns / kTurnsASecond, {}};
}

/// A thread of 16 mm and 2 mm pitch, the nut engaged from `height` m up: by one turn, or as given.
PartCase madeThread(double turns, double height = kEngaged) {
  Thread thread;
  thread.clearance = 0.2e-3;
  thread.length = 0.010;
  thread.segments = kSegments;
  thread.perPitch = 1;
  Thread shorter = thread;
  shorter.length = 0.005;
  assets::Scene scene = sceneOfParts({{"nut", meshOf(nutThreadSoup(shorter, 0.012)), {}, true},
                                      {"bolt", meshOf(boltThreadSoup(thread)), {}, false}});
  const Pose engaged{{0.0, 0.0, height}, glm::dquat(1.0, 0.0, 0.0, 0.0)};
  scene.parts[0].worldFromPart = engaged;
  return nutCase("nut_on_thread", std::move(scene), 0, engaged, turns, thread.pitch);
}

double turnedBy(const Pose& from, const Pose& to) {
  const glm::dquat rotation = to.orientation * glm::conjugate(from.orientation);
  return 2.0 * std::atan2(rotation.z, rotation.w);
}

/// The largest deviation of the nut from a helix of its pitch from a time on (s), m, sampled every `stride`
/// ticks.
double strayed(const HeldPartRig& rig, double pitch, std::size_t stride = 1, double from = kSettle + 0.1) {
  const auto& ticks = rig.ticks();
  const auto first = static_cast<std::size_t>(1e3 * from);
  double turned = 0.0, least = 1e300, greatest = -1e300;
  for (std::size_t i = first; i < ticks.size(); ++i) {
    turned += std::remainder(turnedBy(ticks[i - 1].part, ticks[i].part), 2.0 * std::numbers::pi);
    if ((i - first) % stride != 0) continue;
    const double off = ticks[i].part.position.z - pitch * turned / (2.0 * std::numbers::pi);
    least = std::min(least, off);
    greatest = std::max(greatest, off);
  }
  return greatest - least;
}

double furthestAside(const HeldPartRig& rig) {
  double greatest = 0.0;
  for (const RigTick& tick : rig.ticks())
    greatest = std::max(greatest, std::hypot(tick.part.position.x, tick.part.position.y));
  return greatest;
}

TEST(Threads, ANutGoesItsPitchATurn) {
  const double kTurns = atFullSize() ? 3.0 : 0.4;
  HeldPartRig rig(madeThread(kTurns));
  rig.run(0);
  report(rig);
  expectSound(rig);
  EXPECT_NEAR(rig.last().part.position.z, kEngaged - kTurns * 0.002, 0.15e-3);  // within its play
  // From facet to facet; within one it rises by what flats are lower than the round thread, 25 um of radius
  // at 30 degrees.
  EXPECT_LT(strayed(rig, 0.002, 1000 / kSegments), 5e-6);
  EXPECT_LT(strayed(rig, 0.002), 20e-6);
  EXPECT_LT(furthestAside(rig), 0.05e-3);
}

/// rad, the most that the nut has been behind its hand.
double furthestBehind(const HeldPartRig& rig) {
  double greatest = 0.0;
  for (const RigTick& tick : rig.ticks())
    greatest = std::max(greatest, std::abs(turnedBy(tick.device, tick.part)));
  return greatest;
}

/// Engaged from end to end, where the most samples are near the other thread.
HeldPartRig wholeNut(int sampleQueries) {
  haptics::TickParameters parameters = rigParameters();
  parameters.effort.sampleQueries = sampleQueries;
  return HeldPartRig(madeThread(0.25, 0.004), parameters);
}

TEST(Threads, AWholeNutGoesWithTheHandOnHalfTheQueries) {
  // A step then takes some ticks, each of which goes on from what the last one asked for. A nut whose steps
  // become shorter where queries run out is 1 rad behind.
  HeldPartRig rig = wholeNut(haptics::ContactEffort{}.sampleQueries / 2);
  rig.run(20);
  expectSound(rig);
  EXPECT_LT(rig.deepest(), kSteadyDepth);
  EXPECT_LT(furthestBehind(rig), 16.0 * kTurnATick);
}

TEST(Threads, WithoutATurnItIsHeldByThem) {
  // The control: the same push without a thread moves it by no more than the play.
  PartCase pushed = madeThread(0.0);
  pushed.duration = 0.3;
  const DevicePath path = pushed.path;
  pushed.path = [path](double t) { return path(std::min(t, kSettle)); };
  HeldPartRig rig(std::move(pushed));
  rig.run(0);
  expectSound(rig);
  EXPECT_GT(rig.last().part.position.z, kEngaged - 0.15e-3);
  EXPECT_NEAR(rig.last().toHand.force.z, kPush, 0.2);
}

/// Its thread begins after `idle` turns, and carries it `settle` turns later.
void expectTenTurnsOfM16(double height, double idle, double settle) {
  assets::LoadOptions options;
  options.allMovable = true;
  Result<assets::Scene> loaded =
      assets::loadGltf(std::string(std::getenv("TANDEM_DATA")) + "/m16_nut_bolt_loose.glb", options);
  ASSERT_TRUE(loaded);
  PartId nut = 0;
  while (loaded->parts[nut].name != "nut") ++nut;
  const Pose start{{0.0, 0.0, height}, glm::dquat(1.0, 0.0, 0.0, 0.0)};
  loaded->parts[nut].worldFromPart = start;
  const double turns = idle + settle + 10.1, pitch = 0.002,
               caught = kSettle + (idle + settle) / kTurnsASecond;
  HeldPartRig rig(nutCase("m16_nut", std::move(*loaded), nut, start, turns, pitch, idle));
  rig.run(1000);
  report(rig);
  expectSound(rig);
  EXPECT_LT(rig.deepest(), kSteadyDepth);
  EXPECT_NEAR(rig.last().part.position.z, height - pitch * (turns - idle), 0.15e-3);
  EXPECT_LT(strayed(rig, pitch, static_cast<std::size_t>(1e3 / kTurnsASecond), caught), 5e-6);
  EXPECT_LT(strayed(rig, pitch, 1, caught), 10e-6);
}

bool hasData() { return std::getenv("TANDEM_DATA") != nullptr && atFullSize(); }

TEST(Threads, AnM16NutGoesTwoMillimetresATurnForTenTurns) {
  if (!hasData()) GTEST_SKIP() << "set TANDEM_DATA and TANDEM_FULL_SIZE";
  expectTenTurnsOfM16(0.022, 0.0, 0.1);
}

TEST(Threads, AnM16NutSetDownOnTheEndOfItsBoltFindsTheThread) {
  // Where the thread begins, 0.41 turns on, is that of the file's parts.
  if (!hasData()) GTEST_SKIP() << "set TANDEM_DATA and TANDEM_FULL_SIZE";
  expectTenTurnsOfM16(0.0231, 0.41, 0.5);
}

}  // namespace
}  // namespace tandem::test
