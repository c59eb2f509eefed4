// Meshes exchanged while many parts move and are kept out of the scene tree.

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/proxy/mesh_change.h"
#include "haptics/tick_data.h"
#include "tests/haptics/hand_probe.h"
#include "tests/support/allocation_counter.h"

namespace tandem::test {
namespace {

using haptics::ContactScene;
using haptics::ContactWorld;

constexpr PartId kCrowd = 100;
constexpr PartId kFirst = kCrowd, kSecond = kCrowd + 1;  // two boxes of which each comes over the tool

/// Small boxes in a row a part, half a metre off along x; behind them in the list two larger ones.
assets::Scene crowd() {
  SceneBuilder b;
  const std::uint32_t small = b.addMesh(boxMesh(glm::dvec3(0.002)));
  for (PartId i = 0; i < kCrowd; ++i) b.addPart(small, {{0.5, 0.01 * i, 0.0}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  b.addPart(b.addMesh(boxMesh({0.04, 0.04, 0.04})), {{0.0, 0.0, -0.1}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  b.addPart(b.addMesh(boxMesh({0.04, 0.04, 0.02})), {{0.0, 0.0, 0.1}, {1.0, 0.0, 0.0, 0.0}}, 0.1);
  return b.scene;
}

bool outsideAllTouchable(const ContactWorld& world, const glm::dvec3& p) {
  for (PartId i = 0; world.has(i); ++i) {
    if (world.touchable(i) && world.encloses(i, p)) return false;
  }
  return true;
}

/// All parts of the crowd move in this tick: the two larger ones to around the origin, ten small ones to
/// where the region ends up that the way out of the first one widens, in the list of parts before the larger
/// ones.
void moveAround(const assets::Scene& scene, ContactWorld& world) {
  world.beginMotions({glm::dvec3(-0.001), glm::dvec3(0.001)});
  for (PartId i = 0; world.has(i); ++i) {
    Pose pose = scene.parts[i].worldFromPart;
    if (i < 10) pose.position = {0.022 + 0.0005 * i, 0.0, 0.0025};
    if (i >= kCrowd) pose.position = {i == kFirst ? -0.002 : 0.0, 0.0, 0.002};
    if (world.noteMotion(i, pose)) world.setNearPose(i, pose, {});
  }
  world.endMotions();
}

// The way out of the first part leads beyond the region in which parts are known to be near, and asking about
// it draws up their list anew, with other places. Who asks from within a visit of that list comes to the
// first part again; that is why followMeshes() lists the parts before it leaves any.
TEST(MeshFollowing, AVisitOfNearPartsThatAsksBeyondTheRegionComesToAPartTwice) {
  const assets::Scene scene = crowd();
  const ContactScene contact(scene, 1);
  ContactWorld world(contact);
  const glm::dvec3 small(1e-4);
  for (const bool asks : {false, true}) {
    moveAround(scene, world);
    std::vector<PartId> visited;
    world.forEachNear({-small, small}, [&](PartId part) {
      visited.push_back(part);
      haptics::WorldHit hit;
      if (asks) world.sweep(glm::dvec3(0.0), {0.0181, 0.0, 0.0}, 0.0, part, hit);
    });
    EXPECT_EQ(visited,
              asks ? (std::vector<PartId>{kFirst, kFirst, kSecond}) : (std::vector<PartId>{kFirst, kSecond}));
  }
}

TEST(MeshFollowing, LeavesEveryPartThoughTheWayOutLeadsBeyondTheRegionOfTheTick) {
  const assets::Scene scene = crowd();
  const ContactScene contact(scene, 1);
  ContactWorld world(contact);
  moveAround(scene, world);
  ASSERT_TRUE(world.anyLoose());
  haptics::Proxy proxy;
  haptics::MeshChange change;
  ASSERT_TRUE(world.encloses(kFirst, proxy.position) && world.encloses(kSecond, proxy.position));
  const AllocationScope scope;
  const haptics::FollowedMeshes followed = haptics::followMeshes(world, 0.0, change, proxy);
  EXPECT_EQ(scope.count(), 0u);
  EXPECT_FALSE(followed.overflow);
  EXPECT_LE(followed.squeezed.size(), 1u);  // the larger one is left only through the other
  EXPECT_TRUE(outsideAllTouchable(world, proxy.position));
  EXPECT_GT(glm::length(proxy.position), 0.001);
}

TEST(MeshFollowing, OfMorePartsThanItCanListSaysSo) {
  SceneBuilder b;
  const std::uint32_t mesh = b.addMesh(boxMesh(glm::dvec3(0.01)));
  for (int i = 0; i <= haptics::kMaxNearParts; ++i) b.addPart(mesh, {}, 0.1);
  const ContactScene contact(b.scene, 1);
  ContactWorld world(contact);
  haptics::Proxy proxy;
  proxy.position = {0.006, 0.0, 0.0};
  haptics::MeshChange change;
  EXPECT_TRUE(haptics::followMeshes(world, 0.002, change, proxy).overflow);
  world.setHidden(0, true);
  EXPECT_FALSE(haptics::followMeshes(world, 0.002, change, proxy).overflow);
}

/// What comes over a tool of a box that grows by 10 mm while the crowd moves, or stands still.
glm::dvec3 forceAfterGrowth(bool moving) {
  const assets::Scene scene = crowd();
  haptics::TickParameters parameters = springOnly();
  HandProbe hand(scene, parameters);
  const auto tickAt = [&](const glm::dvec3& p, int step) {
    for (PartId i = 0; moving && i <= kFirst; ++i) {
      Pose pose = scene.parts[i].worldFromPart;
      if (i < kCrowd) pose.position.z += 1e-4 * step;
      hand.moved.push_back({i, pose, {}});
    }
    hand.at(p);
  };
  for (int i = 0; i < 3; ++i) tickAt({0.001, 0.002, -0.079}, i);  // 1 mm over the first box
  EXPECT_EQ(hand.state.data().world.anyLoose(), moving);
  const auto grown = std::make_shared<const assets::Mesh>(boxMesh({0.04, 0.04, 0.06}));
  ContactScene next = hand.contact.withMesh(scene.parts[kFirst].mesh, grown, 1);
  hand.state.adopt(next);
  hand.contact = std::move(next);
  // Only the part whose mesh has changed went back into the tree.
  EXPECT_EQ(hand.state.data().world.anyLoose(), moving);
  for (int i = 3; i < 6; ++i) tickAt({0.001, 0.002, -0.079}, i);
  EXPECT_EQ(hand.out.flags & (haptics::kFlagSqueezed | haptics::kFlagOverflow | haptics::kFlagFault), 0u);
  EXPECT_NEAR(hand.out.worldFromProxy.position.z, -0.07, 1e-8);
  return hand.out.hands[0].toHand.force;
}

TEST(MeshSwap, WhileAHundredPartsMoveIsFeltAsWhileTheyStandStill) {
  const glm::dvec3 still = forceAfterGrowth(false), moving = forceAfterGrowth(true);
  EXPECT_NEAR(still.z, 800.0 * 0.009, 1e-5);
  EXPECT_LE(glm::length(moving - still), 1e-9);
}

TEST(ContactWorldChange, MeasuresThePartsOfTheMeshAndNoOthers) {
  assets::Scene scene = crowd();
  ContactScene contact(scene, 1);
  ContactWorld world(contact);
  world.beginMotions({glm::dvec3(-0.001), glm::dvec3(0.001)});
  for (PartId i = 0; world.has(i); ++i) {
    Pose pose = scene.parts[i].worldFromPart;
    pose.position.y -= 0.3;
    if (world.noteMotion(i, pose)) world.setNearPose(i, pose, {});
  }
  world.endMotions();
  for (glm::dvec3& p : scene.meshes[scene.parts[kFirst].mesh].positions) p.z *= 3.0;
  contact.refitMesh(scene.parts[kFirst].mesh, 1);
  world.meshChanged(scene.parts[kFirst].mesh);
  int found = 0;
  world.forEachNear({{-0.01, -0.31, -0.05}, {0.01, -0.29, -0.045}}, [&](PartId part) {
    EXPECT_EQ(part, kFirst);
    ++found;
  });
  EXPECT_EQ(found, 1);
  for (int i = 0; i < 3; ++i) {  // 32 of the 101 others go back in each of these
    EXPECT_TRUE(world.anyLoose());
    world.beginMotions({glm::dvec3(-0.001), glm::dvec3(0.001)});
    world.endMotions();
  }
  EXPECT_TRUE(world.anyLoose());
}

}  // namespace
}  // namespace tandem::test
