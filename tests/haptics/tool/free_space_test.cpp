// What a tool in the air remembers of its surroundings must never change an answer: nearest parts, sweeps and
// whole ticks are compared with those of a tool without memory, while parts move, appear, vanish and change.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/geometry/query_work.h"
#include "haptics/tick_data.h"
#include "haptics/tool/part_finder.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

using haptics::ContactScene;
using haptics::ContactWorld;
using haptics::PartFinder;
using haptics::WorldHit;

constexpr PartId kParts = 14;

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double number() { return 2.0 * (static_cast<double>(random_()) / 4294967295.0) - 1.0; }
  glm::dvec3 vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  glm::dquat turn() {
    const glm::dvec3 v = vector();
    return glm::normalize(glm::dquat(1.2 + number(), v.x, v.y, v.z));
  }
  PartId part() { return static_cast<PartId>(random_() % kParts); }
  bool once(int in) { return random_() % static_cast<unsigned>(in) == 0; }

 private:
  std::mt19937 random_;
};

/// Spheres, boxes, sheets and one part as large as all others together, within 0.1 m times `scale`.
assets::Scene someParts(Draw& draw, double scale) {
  SceneBuilder b;
  const std::uint32_t meshes[] = {b.addMesh(sphereMesh(0.02 * scale, 6)),
                                  b.addMesh(boxMesh(scale * glm::dvec3(0.03, 0.01, 0.02))),
                                  b.addMesh(sheetMesh(0.04 * scale, 4))};
  for (PartId i = 0; i + 1 < kParts; ++i)
    b.addPart(meshes[i % 3], {0.1 * scale * draw.vector(), draw.turn()}, 0.1);
  b.addPart(b.addMesh(boxMesh(scale * glm::dvec3(0.3, 0.3, 0.02))), {{0.0, 0.0, -0.08 * scale}, draw.turn()},
            0.1);
  return b.scene;
}

/// The distance of p to a part's nearest triangle, each tested alone, m.
double distanceTo(const ContactWorld& world, PartId part, const glm::dvec3& p) {
  double least = std::numeric_limits<double>::infinity();
  const auto count = static_cast<std::uint32_t>(world.collider(part).tree->mesh().triangles.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    const haptics::Triangle t = world.triangle(part, i);
    least = std::min(least, glm::distance(p, haptics::closestPointOnTriangle(p, t).point));
  }
  return least;
}

double reachOf(const ContactWorld& world, PartId part, double radius) {
  return radius + std::max(2.0 * radius, haptics::kTouchShare * 2.0 * world.collider(part).radius);
}

/// Parts that move, appear, vanish and change around a tool in the air.
class Bustle {
 public:
  Bustle(unsigned seed, double scale)
      : scale_(scale),
        draw_(seed),
        scene_(someParts(draw_, scale)),
        plain_(scene_, 1),
        other_(plain_.withMesh(0, std::make_shared<const assets::Mesh>(sphereMesh(0.023 * scale, 7)), 1)),
        world(plain_) {}

  /// The next place of the tool, and whatever happens meanwhile.
  void next() {
    if (draw_.once(40)) velocity_ = 0.002 * scale_ * draw_.vector();
    velocity_ += 1e-4 * scale_ * draw_.vector();
    place += velocity_;
    if (glm::length(place) > 0.1 * scale_) velocity_ = -0.01 * place;
    if (draw_.once(60)) place = 0.1 * scale_ * draw_.vector();
    if (draw_.once(12)) goNear(draw_.part());
    if (draw_.once(5)) nudge(draw_.part(), draw_.once(8) ? 0.02 : 0.0005);
    if (draw_.once(30)) moveMany();
    if (draw_.once(20)) hide(draw_.part());
    if (draw_.once(20)) ignore(draw_.part());
    if (draw_.once(50)) {
      exchanged_ = !exchanged_;
      world.adopt(exchanged_ ? other_ : plain_);
    }
  }
  double farthest(double radius) const {
    double most = 0.0;
    for (PartId i = 0; i < kParts; ++i) most = std::max(most, reachOf(world, i, radius));
    return most;
  }
  glm::dvec3 step() { return 0.004 * scale_ * draw_.vector(); }

 private:
  /// Onto some corner of the part, or up to 3 mm from it, slowly.
  void goNear(PartId part) {
    const auto count = static_cast<std::uint32_t>(world.collider(part).tree->mesh().triangles.size());
    const auto triangle = static_cast<std::uint32_t>((0.5 + 0.499 * draw_.number()) * count);
    place = world.triangle(part, triangle).a + 0.003 * scale_ * draw_.vector();
    velocity_ = 2e-4 * scale_ * draw_.vector();
  }
  Pose nudged(PartId part, double by) {
    const Pose& before = world.pose(part);
    return {before.position + by * scale_ * draw_.vector(),
            draw_.once(2) ? before.orientation : draw_.turn()};
  }
  void nudge(PartId part, double by) { world.setPose(part, nudged(part, by), {}); }
  void moveMany() {
    world.beginMotions({place - 0.01 * scale_, place + 0.01 * scale_});
    for (PartId i = 0; i < kParts; i += 2) {
      const Pose after = nudged(i, 0.005);
      if (world.noteMotion(i, after)) world.setNearPose(i, after, {});
    }
    world.endMotions();
  }
  void hide(PartId part) { world.setHidden(part, !world.hidden(part)); }
  void ignore(PartId part) { world.setIgnored(part, !world.ignored(part)); }

  const double scale_;
  Draw draw_;
  glm::dvec3 velocity_{0.0};
  const assets::Scene scene_;
  const ContactScene plain_, other_;
  bool exchanged_ = false;

 public:
  ContactWorld world;
  glm::dvec3 place{0.0};
};

/// Whether a surface reaches into the space that the world takes for free.
bool isLie(const ContactWorld& world) {
  for (PartId i = 0; i < kParts; ++i) {
    const bool reaches = distanceTo(world, i, world.freeBall().centre()) < world.freeBall().radius();
    if (world.touchable(i) && reaches) return true;
  }
  return false;
}

/// Whether two sweeps, one of which knows of free space, differ.
bool differ(const ContactWorld& world, const glm::dvec3& p, const glm::dvec3& motion, double radius) {
  ContactWorld without = world;
  without.keepFree(p, 0.0);
  WorldHit one, two;
  const bool hitOne = world.sweep(p, motion, radius, kNoPart, one);
  const bool hitTwo = without.sweep(p, motion, radius, kNoPart, two);
  return hitOne != hitTwo || one.t != two.t || one.part != two.part || one.triangle != two.triangle ||
         one.normal != two.normal;
}

TEST(FreeSpace, HoldsNoSurfaceWhateverMovesAppearsOrChanges) {
  int free = 0;
  for (const double scale : {1.0, 1e-3, 20.0}) {
    Bustle bustle(5, scale);
    PartFinder finder;
    for (int i = 0; i < 700; ++i) {
      bustle.next();
      const double radius = i % 300 < 150 ? 0.0 : 0.001 * scale;
      finder.find(bustle.world, bustle.place, radius, bustle.farthest(radius));
      ASSERT_FALSE(isLie(bustle.world)) << scale << " " << i;
      const glm::dvec3 motion = bustle.step();
      ASSERT_FALSE(differ(bustle.world, bustle.place, motion, radius)) << scale << " " << i;
      free += bustle.world.freeBall().contains(bustle.place + motion, radius) ? 1 : 0;
    }
  }
  EXPECT_GT(free, 300);  // the comparison is of something
}

TEST(FreeSpace, ThatIsTakenForLargerThanItIsLetsTheToolThrough) {
  Bustle bustle(5, 1.0);
  PartFinder finder;
  int lies = 0, through = 0;
  for (int i = 0; i < 700; ++i) {
    bustle.next();
    finder.find(bustle.world, bustle.place, 0.0, bustle.farthest(0.0));
    const haptics::FreeBall known = bustle.world.freeBall();
    bustle.world.keepFree(known.centre(), 2.0 * known.radius());
    lies += isLie(bustle.world) ? 1 : 0;
    const glm::dvec3 motion = 1.9 * known.radius() * glm::normalize(bustle.step());
    through += differ(bustle.world, bustle.place, motion, 0.0) ? 1 : 0;
    bustle.world.keepFree(known.centre(), known.radius());
  }
  EXPECT_GT(lies, 20);
  EXPECT_GT(through, 5);
}

TEST(PartFinder, FindsTheNearestPartWithinItsReachThatABruteSearchFinds) {
  int found = 0, none = 0;
  for (const double scale : {1.0, 1e-3, 20.0}) {
    Bustle bustle(9, scale);
    PartFinder finder;
    for (int i = 0; i < 700; ++i) {
      bustle.next();
      const double radius = i % 300 < 150 ? 0.0 : 0.001 * scale;
      const PartId under = finder.find(bustle.world, bustle.place, radius, bustle.farthest(radius));
      double least = std::numeric_limits<double>::infinity();
      for (PartId k = 0; k < kParts; ++k) {
        const double distance = distanceTo(bustle.world, k, bustle.place);
        if (!bustle.world.touchable(k) || distance > reachOf(bustle.world, k, radius)) continue;
        least = std::min(least, distance);
      }
      ASSERT_EQ(under == kNoPart, std::isinf(least)) << scale << " " << i;
      (under == kNoPart ? none : found) += 1;
      if (under != kNoPart) {
        ASSERT_NEAR(distanceTo(bustle.world, under, bustle.place), least, 1e-12 * scale);
      }
    }
  }
  EXPECT_GT(found, 300);
  EXPECT_GT(none, 300);
}

TEST(PartFinder, ThatForgetsNothingWhenAPartMovesIsFoundOut) {
  // The memory of a world in which nothing moved, asked about one in which a part has come.
  Bustle bustle(9, 1.0);
  ContactWorld still = bustle.world;
  const glm::dvec3 p(0.0, 0.0, 0.5);
  PartFinder finder;
  ASSERT_EQ(finder.find(still, p, 0.0, bustle.farthest(0.0)), kNoPart);
  ContactWorld moved = still;
  moved.setPose(3, {p + glm::dvec3(0.0, 0.0, -0.0203), {1.0, 0.0, 0.0, 0.0}}, {});
  moved.keepFree(p, 1.0);
  EXPECT_EQ(finder.find(moved, p, 0.0, bustle.farthest(0.0)), kNoPart);
  moved.keepFree(p, 0.0);
  EXPECT_EQ(finder.find(moved, p, 0.0, bustle.farthest(0.0)), PartId{3});
}

bool same(const haptics::TickOutput& a, const haptics::TickOutput& b) {
  return a.touched == b.touched && a.flags == b.flags && a.contactCount == b.contactCount &&
         a.worldFromProxy.position == b.worldFromProxy.position &&
         a.hands[0].toHand.force == b.hands[0].toHand.force;
}

/// Over a gear, down into it and out again, to and fro; a second part passes by.
TEST(FreeSpace, ChangesNoBitOfATick) {
  for (const double radius : {0.0, 0.0007}) {
    SceneBuilder b;
    b.addPart(b.addMesh(tests::gearMesh(4000)), {}, 0.0);
    b.addPart(b.addMesh(boxMesh(glm::dvec3(0.004))), {{0.03, 0.0, 0.005}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
    HandProbe with(b.scene), without(b.scene);
    with.parameters.toolRadius = without.parameters.toolRadius = radius;
    haptics::QueryWork spared;
    std::size_t allocations = 0;
    for (int i = 0; i < 3000; ++i) {
      const double a = 4e-4 * i, r = 0.0235 + radius + 0.0035 * std::sin(0.011 * i);
      const glm::dvec3 device(r * std::cos(a), r * std::sin(a), 0.005 + 0.003 * std::sin(0.003 * i));
      const auto motions = [&](HandProbe& hand) {
        const Pose pose{{0.03 * std::cos(0.002 * i), 0.03 * std::sin(0.002 * i), 0.005},
                        {1.0, 0.0, 0.0, 0.0}};
        if (i % 500 > 250) hand.moved.push_back({1, pose, {}});
      };
      motions(with);
      motions(without);
      without.state.data().world.keepFree(device, 0.0);
      const haptics::QueryWork start = haptics::queryWork;
      const AllocationScope scope;
      with.at(device);
      allocations += scope.count();
      const haptics::QueryWork middle = haptics::queryWork;
      without.at(device);
      spared.nodes += (haptics::queryWork - middle).nodes;
      spared.nodes -= (middle - start).nodes;
      ASSERT_TRUE(same(with.out, without.out)) << radius << " " << i;
    }
    EXPECT_GT(spared.nodes, 500u);
    EXPECT_EQ(allocations, 0u);
  }
}

}  // namespace
}  // namespace tandem::test
