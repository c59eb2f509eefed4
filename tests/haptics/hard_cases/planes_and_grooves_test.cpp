#include <cmath>

#include "tests/haptics/hard_cases/hard_case.h"

namespace tandem::test {
namespace {

constexpr double kDeep = 0.002;  // m

double radians(double degrees) { return degrees * kPi / 180.0; }

TEST(HardPlane, SlidingAtAnySpeedChangesNoForce) {
  for (const double radius : {0.0, 0.0015}) {
    atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
      for (const double speed : {0.02, 0.05, 0.1, 0.2, 0.5}) {  // m/s
        ScaledHand hand(sceneOf(sheetMesh(0.2, 40)), scale, radius);
        hand.at({-0.07, 0.0123, 0.01});
        hand.to({-0.07, 0.0123, radius - kDeep}, 1e-4);
        const glm::dvec3 first = hand.force();
        double change = 0.0;
        for (int i = 1; i <= 250; ++i) {
          const glm::dvec3 step = 1e-3 * speed * i * glm::normalize(glm::dvec3(1.0, 0.3, 0.0));
          change = std::max(change,
                            glm::length(hand.at(glm::dvec3(-0.07, 0.0123, radius - kDeep) + step) - first));
        }
        EXPECT_LE(change, kStiffness * hand.skin()) << "speed " << speed << " radius " << radius;
        EXPECT_NEAR(hand.force().z, kStiffness * kDeep, 2.0 * kStiffness * hand.skin());
        forces.push_back(hand.force());
      }
    });
  }
}

class HardGroove : public testing::TestWithParam<double> {};

TEST_P(HardGroove, HoldsTheProxyAtItsApex) {
  const double half = radians(0.5 * GetParam());
  atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
    ScaledHand hand(sceneOf(grooveMesh(0.05, half)), scale);
    // The proxy stands a skin off both walls: this far above the apex.
    const double lift = 1.01 * hand.skin() / std::sin(half);
    hand.at({0.0, 0.001, 0.03});
    hand.to({0.0, 0.001, -kDeep}, 3e-4);
    for (int i = 0; i <= 50; ++i) {  // slide along
      const glm::dvec3 goal(1e-6, 0.001 + 1e-4 * i, -kDeep);
      const glm::dvec3 force = hand.at(goal);
      EXPECT_LE(glm::length(force - kStiffness * (glm::dvec3(0.0, goal.y, 0.0) - goal)), kStiffness * lift)
          << i;
      if (i % 10 == 0) forces.push_back(force);
    }
    EXPECT_EQ(hand.probe.out.contactCount, 2);
  });
}

TEST_P(HardGroove, PassesFromWallToWallWithoutZigZag) {
  const double half = radians(0.5 * GetParam());
  const glm::dvec3 left(std::cos(half), 0.0, std::sin(half));  // of the wall at -x, into the groove
  const glm::dvec3 right(-left.x, 0.0, left.z);
  atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
    ScaledHand hand(sceneOf(grooveMesh(0.05, half)), scale);
    const double lift = 1.01 * hand.skin() / std::sin(half);
    hand.at({0.0, 0.001, 0.03});
    hand.to({0.0, 0.001, -kDeep}, 3e-4);
    // The exact god object of the two half planes: the apex between the normals' directions, else one wall.
    const auto exact = [&](const glm::dvec3& g) {
      const double a = std::max(0.0, -glm::dot(left, g)), b = std::max(0.0, -glm::dot(right, g));
      const glm::dvec3 onLeft = g + a * left, onRight = g + b * right;
      if (glm::dot(onLeft, right) >= 0.0) return onLeft;
      if (glm::dot(onRight, left) >= 0.0) return onRight;
      return glm::dvec3(0.0, g.y, 0.0);
    };
    for (int i = 0; i <= 200; ++i) {  // 10 mm across, below the apex
      const glm::dvec3 goal(-0.005 + 5e-5 * i, 0.004, -kDeep);
      const glm::dvec3 force = hand.at(goal);
      EXPECT_LE(glm::length(force - kStiffness * (exact(goal) - goal)), kStiffness * lift) << i;
      if (i % 20 == 0) forces.push_back(force);
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Degrees, HardGroove, testing::Values(150.0, 90.0, 30.0, 10.0, 1.0));

TEST(HardGroove, NarrowerThanTheWayOfATickIsNotJumped) {
  // A slot of 0.2 mm with a floor 1 mm down, crossed at 2 m/s: the exact god object descends into it and is
  // held by its far wall.
  SceneBuilder b;
  const Pose left{{-0.0201, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}, right{{0.0201, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  const std::uint32_t block = b.addMesh(boxMesh({0.04, 0.04, 0.02}));
  b.addPart(block, left);
  b.addPart(block, right);
  b.addPart(boxMesh({0.04, 0.04, 0.01}), {{0.0, 0.0, 0.004}, {1.0, 0.0, 0.0, 0.0}});
  for (const double radius : {0.0, 5e-5}) {
    atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(b.scene, scale, radius);
      hand.at({-0.0101, 0.001, 0.02});
      hand.to({-0.0101, 0.001, 0.007}, 5e-4);
      for (int i = 0; i <= 10; ++i) hand.at({-0.0101 + 2e-3 * i, 0.001, 0.007});
      EXPECT_NEAR(hand.proxy().x, 0.0001 - radius, 1e-7) << radius;
      EXPECT_NEAR(hand.proxy().z, 0.009 + radius, 1e-7) << radius;
      forces.push_back(hand.force());
    });
  }
}

/// Fans of `faces` triangles around one vertex at the origin: an inner pyramid, open upwards.
std::vector<glm::dvec3> pyramid(int faces, double slope,
                                std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<glm::dvec3> corners{{0.0, 0.0, 0.0}};
  for (int i = 0; i < faces; ++i) {
    const double angle = 2.0 * kPi * (i + 0.3) / faces;
    corners.emplace_back(0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.05 * slope);
  }
  for (int i = 0; i < faces; ++i) {
    triangles.push_back(
        {0, static_cast<std::uint32_t>(1 + i), static_cast<std::uint32_t>(1 + (i + 1) % faces)});
  }
  return corners;
}

TEST(HardCorner, HoldsWhateverTheOrderOfItsFaces) {
  for (const int faces : {3, 4, 5, 6, 8, 12}) {
    atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
      std::vector<std::array<std::uint32_t, 3>> triangles;
      const std::vector<glm::dvec3> corners = pyramid(faces, 1.0, triangles);
      std::vector<glm::dvec3> first;
      for (int order = 0; order < 6; ++order) {
        std::vector<std::array<std::uint32_t, 3>> shuffled = triangles;
        std::rotate(shuffled.begin(), shuffled.begin() + order % faces, shuffled.end());
        if (order % 2 == 1) std::reverse(shuffled.begin(), shuffled.end());
        for (auto& t : shuffled) std::rotate(t.begin(), t.begin() + order % 3, t.end());
        ScaledHand hand(sceneOf(soupMesh(corners, shuffled)), scale);
        hand.at({0.001, 0.0007, 0.03});
        std::vector<glm::dvec3> felt;
        for (int i = 0; i <= 40; ++i) {
          felt.push_back(hand.at({0.001 * std::cos(0.1 * i), 0.0007 * std::sin(0.2 * i), 0.002 - 1e-4 * i}));
        }
        // Right under the vertex, well inside the cone of the normals.
        EXPECT_LE(
            glm::length(hand.at({0.0001, -0.0002, -0.003}) - kStiffness * glm::dvec3(-0.0001, 0.0002, 0.003)),
            8.0 * kStiffness * hand.skin())
            << faces << ' ' << order;
        if (first.empty()) first = felt;
        double worst = 0.0;
        for (std::size_t i = 0; i < felt.size(); ++i)
          worst = std::max(worst, glm::length(felt[i] - first[i]));
        EXPECT_LE(worst, 8.0 * kStiffness * hand.skin()) << faces << " faces, order " << order;
      }
      forces.insert(forces.end(), first.begin(), first.end());
    });
  }
}

TEST(HardCorner, TrihedralHoldsAllThreeDepths) {
  for (const double radius : {0.0, 0.003}) {
    atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(sceneOf(cornerMesh(0.05)), scale, radius);
      hand.at({0.01, 0.012, 0.013});
      const glm::dvec3 depth(0.001, 0.002, 0.003);
      forces.push_back(hand.to(radius - depth, 4e-4));
      EXPECT_LE(glm::length(hand.force() - kStiffness * depth), 3.0 * kStiffness * hand.skin());
      EXPECT_EQ(hand.probe.out.contactCount, 3);
    });
  }
}

TEST(HardCoincidence, GoalsOnFacesEdgesAndVerticesGiveNoForce) {
  for (const double radius : {0.0, 0.002}) {
    atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(sceneOf(boxMesh({0.04, 0.04, 0.04})), scale, radius);
      const double h = 0.02;
      const glm::dvec3 spots[] = {{0.003, 0.004, h}, {0.0, 0.0, h}, {h, 0.003, h},
                                  {h, h, h},         {h, h, -h},    {h, -0.0, 0.0}};
      for (const glm::dvec3& spot : spots) {
        hand.at(1.5 * spot);
        glm::dvec3 outwards(0.0);
        for (int axis = 0; axis < 3; ++axis) {
          if (std::abs(spot[axis]) >= h) outwards[axis] = spot[axis] > 0.0 ? 1.0 : -1.0;
        }
        const glm::dvec3 on = spot + radius * glm::normalize(outwards);
        for (int repeat = 0; repeat < 3; ++repeat) {
          forces.push_back(hand.at(on));
          EXPECT_LE(glm::length(hand.force()), 4.0 * kStiffness * hand.skin());
        }
      }
    });
  }
}

TEST(HardCoincidence, DeviceOnAnEncoderLatticeThatContainsTheSurface) {
  // Every reading is a multiple of 0.25 mm; faces, edges and vertices of the sheet lie on that lattice.
  atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
    ScaledHand hand(sceneOf(sheetMesh(0.016, 16)), scale);
    hand.at({-0.004, -0.004, 0.001});
    for (int i = 0; i <= 64; ++i) {
      const glm::dvec3 goal(-0.004 + 2.5e-4 * (i % 33), -0.004 + 2.5e-4 * (i / 2), 0.0005 - 2.5e-4 * (i % 5));
      const glm::dvec3 force = hand.at(goal);
      EXPECT_LE(glm::length(force - kStiffness * glm::dvec3(0.0, 0.0, std::max(0.0, -goal.z))),
                4.0 * kStiffness * hand.skin())
          << i;
      forces.push_back(force);
    }
  });
}

TEST(HardEdge, ConvexEdgeSnapsOnceAndWithinTheTick) {
  // Along the top of a box and over its edge: the god object drops to the side in the tick in which the goal
  // is nearer to it.
  atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
    ScaledHand hand(sceneOf(boxMesh({0.04, 0.04, 0.04})), scale);
    hand.at({0.015, 0.003, 0.03});
    hand.to({0.015, 0.003, 0.017}, 1e-4);
    int snaps = 0;
    double jump = 0.0;
    glm::dvec3 before = hand.force();
    for (int i = 1; i <= 100; ++i) {
      const glm::dvec3 goal(0.015 + 1e-4 * i, 0.003, 0.017);
      const glm::dvec3 force = hand.at(goal);
      // Constrained descent: on the top until its edge is reached, then to the side, which the goal is out
      // of.
      const glm::dvec3 exact =
          goal.x <= 0.02 + 1e-9 ? glm::dvec3(0.0, 0.0, kStiffness * 0.003) : glm::dvec3(0.0);
      if (std::abs(goal.x - 0.02) > 1e-6) {
        EXPECT_LE(glm::length(force - exact), 4.0 * kStiffness * hand.skin()) << i;
      }
      snaps += glm::length(force - before) > 0.1 ? 1 : 0;
      jump = std::max(jump, glm::length(force - before));
      before = force;
      if (i % 10 == 0 && i != 50) forces.push_back(force);
    }
    EXPECT_EQ(snaps, 1);
    EXPECT_LE(jump, kStiffness * 0.003 + 1e-5);
  });
}

TEST(HardEdge, BallPressedDeepAgainstAnEdgeConvergesInTheTick) {
  // Depth of the order of the radius. The answer is the nearest point at the radius from the edge line.
  atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
    const double radius = 0.003, h = 0.02;
    ScaledHand hand(sceneOf(boxMesh({0.04, 0.04, 0.04})), scale, radius);
    hand.at({0.03, 0.001, 0.03});
    for (int i = 0; i <= 40; ++i) {
      // Goals outside the solid, down to a sixth of the radius over the edge, from -40 to 40 degrees of the
      // diagonal.
      const double over = 0.0005 + 0.0002 * (i % 9), angle = radians(45.0 + 35.0 * std::sin(0.9 * i));
      const glm::dvec3 way(std::cos(angle), 0.0, std::sin(angle));
      const glm::dvec3 force = hand.at(glm::dvec3(h, 0.001 + 2e-4 * i, h) + over * way);
      EXPECT_LE(glm::length(force - kStiffness * (radius - over) * way), 1e-4 * kStiffness * radius) << i;
      forces.push_back(force);
    }
  });
}

TEST(HardEdge, BallPressedDeepAgainstATipConvergesInTheTick) {
  atEveryScale(1e-4, [&](double scale, std::vector<glm::dvec3>& forces) {
    const double radius = 0.003, h = 0.02;
    ScaledHand hand(sceneOf(boxMesh({0.04, 0.04, 0.04})), scale, radius);
    hand.at({0.03, 0.03, 0.03});
    for (int i = 0; i <= 40; ++i) {
      const double over = 0.0005 + 0.0002 * (i % 9);
      const glm::dvec3 way =
          glm::normalize(glm::dvec3(1.0 + 0.7 * std::sin(0.9 * i), 1.0 + 0.7 * std::sin(1.7 * i), 1.0));
      const glm::dvec3 force = hand.at(glm::dvec3(h) + over * way);
      EXPECT_LE(glm::length(force - kStiffness * (radius - over) * way), 1e-4 * kStiffness * radius) << i;
      forces.push_back(force);
    }
  });
}

}  // namespace
}  // namespace tandem::test
