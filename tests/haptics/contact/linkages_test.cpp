// A part in the hand that joints connect to other moving parts: the whole linkage follows the hand.

#include "tests/haptics/contact/moving_rig.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {
namespace {

constexpr double kLink = 0.02;  // m
const glm::dquat kLevel(1, 0, 0, 0);

/// Links end to end along X, joined by balls; the first one to the world at its left end too, if it is to
/// hang there.
assets::Scene chain(int links, bool hangs) {
  std::vector<CasePart> parts;
  for (int i = 0; i < links; ++i)
    parts.push_back({.name = "link" + std::to_string(i),
                     .mesh = meshOf(boxSoup({kLink, 0.004, 0.004})),
                     .worldFromPart = {{kLink * i, 0.0, 0.0}, kLevel},
                     .movable = true,
                     .mass = 0.01});
  assets::Scene scene = sceneOfParts(parts);
  for (PartId i = hangs ? 0 : 1; i < static_cast<PartId>(links); ++i) {
    assets::Joint joint;
    joint.name = "joint" + std::to_string(i);
    joint.partA = i == 0 ? kNoPart : i - 1;
    joint.partB = i;
    joint.aFromJoint = {{i == 0 ? -0.5 * kLink : 0.5 * kLink, 0.0, 0.0}, kLevel};
    joint.bFromJoint = {{-0.5 * kLink, 0.0, 0.0}, kLevel};
    joint.limits = {{false, 7, 0.0, 0.0, 0.0, 0.0}};
    scene.joints.push_back(joint);
  }
  return scene;
}

/// The last link is in the hand. `answers`: the hand gets the parts that it pushes, as a session gives
/// them.
struct Chain {
  Chain(int links, bool hangs, bool answers, const glm::dvec3& gravity = glm::dvec3(0.0))
      : rig(chain(links, hangs), gravity), last(static_cast<PartId>(links - 1)), grip(rig.pose(last)) {
    rig.ownAndGrasp(last, grip);
    if (answers) {
      rig.each = [this] {
        pushed += rig.out.pushedCount;
        rig.answer();
      };
    }
    rig.tick();
  }
  /// Leads the hand along a straight path and waits.
  void to(const glm::dvec3& by) {
    const Pose from = grip;
    const auto path = [&](double t) {
      const double s = t, ease = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
      return Pose{from.position + ease * by, from.orientation};
    };
    rig.lead(path, 1.0);
    grip = path(1.0);
    rig.at(grip);
    rig.tick(1000);
  }
  /// The largest distance of the ends of two joined links, m.
  double gap() const {
    double greatest = 0.0;
    for (const assets::Joint& joint : rig.scene().joints) {
      const glm::dvec3 b = transformPoint(rig.pose(joint.partB), joint.bFromJoint.position);
      const glm::dvec3 a = joint.partA == kNoPart
                               ? joint.aFromJoint.position
                               : transformPoint(rig.pose(joint.partA), joint.aFromJoint.position);
      greatest = std::max(greatest, glm::length(a - b));
    }
    return greatest;
  }
  MovingRig rig;
  PartId last;
  Pose grip;
  int pushed = 0;
};

TEST(Linkages, AChainFollowsTheHandThatPullsItsEnd) {
  Chain chain(4, false, true);
  chain.to({0.05, 0.0, 0.0});
  EXPECT_NEAR(chain.rig.pose(0).position.x, 0.05, 1e-3);
  EXPECT_LT(chain.gap(), 1e-6);
  EXPECT_LT(glm::length(chain.rig.out.hands[0].toHand.force), 0.05);
  EXPECT_EQ(chain.rig.out.ownedCount, 4);
}

TEST(Linkages, WithoutItsOtherLinksTheHandPullsAtAWall) {
  Chain chain(4, false, false);
  chain.to({0.05, 0.0, 0.0});
  EXPECT_NEAR(chain.rig.pose(0).position.x, 0.0, 1e-12);
  EXPECT_NEAR(glm::length(chain.rig.out.hands[0].toHand.force), 50.0, 1.0);
}

TEST(Linkages, AChainThatHangsCarriesPartOfItsWeight) {
  Chain chain(5, true, true, {0.0, 0.0, -9.81});
  chain.to({-0.02, 0.0, 0.0});
  // Between its end in the world and the hand it sags; who holds it carries less than all of it.
  EXPECT_LT(chain.rig.pose(2).position.z, -0.01);
  EXPECT_LT(chain.gap(), 1e-6);
  EXPECT_LT(-chain.rig.out.hands[0].toHand.force.z, 5 * 0.01 * 9.81);
  EXPECT_GT(-chain.rig.out.hands[0].toHand.force.z, 0.01 * 9.81);
}

TEST(Linkages, EachLinkIsAskedForOnceWhileTheHandHoldsOne) {
  Chain chain(5, true, true, {0.0, 0.0, -9.81});
  chain.to({-0.01, 0.0, 0.005});
  chain.rig.tick(2000);  // the hand holds still
  EXPECT_EQ(chain.rig.out.ownedCount, 5);
  EXPECT_EQ(chain.pushed, 4);
}

TEST(Linkages, AllAreGivenBackOnceTheyRest) {
  Chain chain(5, true, true);
  chain.to({-0.01, 0.0, 0.005});
  chain.rig.letGo(chain.last);
  chain.rig.tick(2000);
  EXPECT_EQ(chain.rig.out.ownedCount, 0);
  EXPECT_EQ(chain.pushed, 4);
  EXPECT_LT(chain.gap(), 1e-6);
}

}  // namespace
}  // namespace tandem::test
