#include <cmath>

#include "tests/haptics/hard_cases/hard_case.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

constexpr double kStatic = 0.6, kDynamic = 0.4;

assets::Scene rough(assets::Scene scene) {
  for (assets::Material& m : scene.materials) {
    m.staticFriction = kStatic;
    m.dynamicFriction = kDynamic;
  }
  return scene;
}

/// Tangential force over the sum of the normal forces of all contacts.
double frictionRatio(const ScaledHand& hand) {
  const haptics::TickOutput& out = hand.probe.out;
  glm::dvec3 rest = out.hands[0].toHand.force;
  double pressed = 0.0;
  for (int i = 0; i < out.contactCount; ++i) {
    const haptics::Contact& c = out.contacts[static_cast<std::size_t>(i)];
    rest -= c.force * c.normal;
    pressed += c.force;
  }
  return pressed > 0.0 ? glm::length(rest) / pressed : 0.0;
}

constexpr double kSpeeds[] = {0.005, 0.02, 0.05, 0.1, 0.2};  // m/s

TEST(HardFriction, SlidesOnAPlaneAtTheDynamicCoefficient) {
  for (const double ball : {0.0, 0.002}) {
    for (const double speed : kSpeeds) {
      atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
        ScaledHand hand(rough(sceneOf(sheetMesh(0.2, 30))), scale, ball);
        const glm::dvec3 from(-0.05, 0.01, ball - 0.002), way = glm::normalize(glm::dvec3(1.0, 0.37, 0.0));
        hand.at(from + glm::dvec3(0.0, 0.0, 0.01));
        hand.to(from, 1e-4);
        hand.to(from + 0.002 * way, 1e-3 * speed);
        for (int i = 1; i <= 200; ++i) {
          const glm::dvec3 force = hand.at(from + (0.002 + 1e-3 * speed * i) * way);
          EXPECT_NEAR(glm::length(force - force.z * glm::dvec3(0.0, 0.0, 1.0)) / force.z, kDynamic,
                      0.005 * kDynamic);
          EXPECT_NEAR(force.z, kStiffness * 0.002, 1e-5);
          EXPECT_LT(glm::dot(force, way), 0.0);
        }
        forces.push_back(hand.force());
      });
    }
  }
}

TEST(HardFriction, SlidesOverASphereAtTheDynamicCoefficient) {
  const assets::Mesh mesh = tests::sphereMesh(0.02, 20'000, tests::Topology::always);
  for (const double ball : {0.0, 0.002}) {
    for (const double speed : kSpeeds) {
      atEveryScale(0.1, [&](double scale, std::vector<glm::dvec3>& forces) {
        ScaledHand hand(rough(sceneOf(mesh)), scale, ball);
        const double inside = 0.02 + ball - 0.003;
        const auto goal = [&](double s) {
          return inside *
                 glm::dvec3(std::cos(s / inside), 0.6 * std::sin(s / inside), 0.8 * std::sin(s / inside));
        };
        hand.at(2.0 * goal(0.0));
        hand.to(goal(0.0), 1e-4);
        for (double s = 0.0; s < 0.003; s += 1e-3 * speed) hand.at(goal(s));
        double sum = 0.0;
        for (int i = 1; i <= 150; ++i) {
          hand.at(goal(0.003 + 1e-3 * speed * i));
          sum += frictionRatio(hand);
          // From facet to facet the normal turns by 0.8 degrees: each one is off by as much at most.
          EXPECT_NEAR(frictionRatio(hand), kDynamic, 0.8 * kPi / 180.0) << "speed " << speed << " tick " << i;
        }
        EXPECT_NEAR(sum / 150, kDynamic, 0.005 * kDynamic) << "speed " << speed << " ball " << ball;
        forces.push_back(hand.force());
      });
    }
  }
}

TEST(HardFriction, SlidesAlongAGrooveUnderTheForcesOfBothWalls) {
  const double half = 0.5;
  for (const double speed : kSpeeds) {
    atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(rough(sceneOf(grooveMesh(0.1, half))), scale);
      hand.at({0.0, -0.03, 0.03});
      hand.to({0.0, -0.03, -0.002}, 2e-4);
      hand.to({0.0, -0.026, -0.002}, 1e-3 * speed);
      for (int i = 1; i <= 100; ++i) {
        const glm::dvec3 force = hand.at({0.0, -0.026 + 1e-3 * speed * i, -0.002});
        // Two walls of N each: their sum lifts by 2 N sin(half), friction is 2 N mu.
        EXPECT_NEAR(-force.y / (force.z / std::sin(half)), kDynamic, 0.005 * kDynamic);
        EXPECT_NEAR(force.z, kStiffness * 0.002, 1e-4);
      }
      forces.push_back(hand.force());
    });
  }
}

TEST(HardFriction, SlidesAlongAnEdgeAtTheDynamicCoefficient) {
  for (const double speed : kSpeeds) {
    atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(rough(sceneOf(boxMesh({0.04, 0.2, 0.04}))), scale, 0.003);
      const glm::dvec3 goal(0.0205, -0.05, 0.0205);
      hand.at(goal + glm::dvec3(0.01, 0.0, 0.01));
      hand.to(goal, 1e-4);
      hand.to(goal + glm::dvec3(0.0, 0.004, 0.0), 1e-3 * speed);
      for (int i = 1; i <= 100; ++i) {
        const glm::dvec3 force = hand.at(goal + glm::dvec3(0.0, 0.004 + 1e-3 * speed * i, 0.0));
        const double pressed = kStiffness * (0.003 - 0.0005 * std::sqrt(2.0));
        EXPECT_NEAR(-force.y, kDynamic * pressed, 0.005 * kDynamic * pressed);
        EXPECT_NEAR(force.x, pressed / std::sqrt(2.0), 1e-3 * pressed);
      }
      forces.push_back(hand.force());
    });
  }
}

TEST(HardFriction, BreaksAwayAtTheStaticCoefficient) {
  atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
    ScaledHand hand(rough(sceneOf(sheetMesh(0.2, 30))), scale);
    hand.at({0.0, 0.001, 0.01});
    hand.to({0.0, 0.001, -0.002}, 1e-4);
    const glm::dvec3 stuck = hand.proxy();
    double highest = 0.0;
    bool slipped = false;
    for (int i = 1; i <= 2000; ++i) {
      const glm::dvec3 force = hand.at({1e-6 * i, 0.001, -0.002});
      slipped = slipped || hand.proxy() != stuck;
      highest = std::max(highest, -force.x / force.z);
      if (slipped) {
        EXPECT_NEAR(-force.x / force.z, kDynamic, 0.005 * kDynamic) << i;
      }
      if (i % 200 == 0 && i != 1200) forces.push_back(force);
    }
    EXPECT_TRUE(slipped);
    EXPECT_NEAR(highest, kStatic, 1e-3);
  });
}

TEST(HardFriction, DoesNotCreepWhileItSticksUnderNoise) {
  for (const double ball : {0.0, 0.002}) {
    atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(rough(sceneOf(sphereMesh(0.05, 60))), scale, ball);
      const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, 0.5, 0.7));
      const glm::dvec3 side = glm::normalize(glm::cross(n, glm::dvec3(0.0, 0.0, 1.0)));
      hand.at(0.08 * n);
      hand.to((0.048 + ball) * n, 1e-4);
      const glm::dvec3 hold = (0.048 + ball) * n + 0.0005 * side;
      hand.to(hold, 1e-5);
      const glm::dvec3 stuck = hand.probe.out.worldFromProxy.position;
      std::uint32_t seed = 99;
      const auto noise = [&seed] {  // 20 um
        seed = seed * 1664525u + 1013904223u;
        return 2e-5 * (static_cast<double>(seed >> 8) / double(1 << 23) - 1.0);
      };
      for (int i = 0; i < 20'000; ++i) hand.at(hold + glm::dvec3(noise(), noise(), noise()));
      EXPECT_EQ(hand.probe.out.worldFromProxy.position, stuck);  // to the bit
      forces.push_back(hand.at(hold));
    });
  }
}

TEST(HardFriction, StaysWhereItStuckOnAMovingPart) {
  atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
    SceneBuilder b;
    const PartId part = b.addPart(boxMesh({0.2, 0.2, 0.02}), {}, 1.0);
    ScaledHand hand(rough(b.scene), scale);
    hand.at({0.01, 0.02, 0.02});
    hand.to({0.01, 0.02, 0.008}, 1e-4);
    const glm::dvec3 stuck = hand.proxy();
    for (int i = 1; i <= 2000; ++i) {
      // Turning by 0.1 rad and gliding by 5 mm, the hand with it.
      const double t = 5e-4 * i;
      const Pose unscaled{{0.005 * t, -0.003 * t, 0.002 * std::sin(3.0 * t)},
                          fromRotationVector({0.0, 0.05 * t, 0.1 * t})};
      Pose pose = unscaled;
      pose.position *= scale;
      hand.probe.moved = {{part, pose, {}}};
      hand.at(transformPoint(unscaled, {0.01, 0.02, 0.008}));
      if (i % 200 == 0) {
        const glm::dvec3 inPart = transformPoint(inverse(unscaled), hand.proxy());
        EXPECT_LE(glm::length(inPart - stuck), 4.0 * hand.skin()) << i;
        forces.push_back(hand.force());
      }
    }
  });
}

}  // namespace
}  // namespace tandem::test
