#include <cmath>

#include "tests/haptics/hard_cases/hard_case.h"
#include "tests/support/bench_meshes.h"

namespace tandem::test {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Every triangle with corners of its own.
assets::Mesh split(const assets::Mesh& mesh) {
  std::vector<glm::dvec3> positions;
  Triangles triangles;
  for (const auto& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const std::uint32_t v : t) positions.push_back(mesh.positions[v]);
    triangles.push_back({first, first + 1, first + 2});
  }
  return soupMesh(positions, triangles);
}

/// Forces while a tool slides over the plane z = 0, 2 mm deep and 0.1 m/s, must be those of a clean plane.
void slideOverPlane(const assets::Scene& scene, const char* what) {
  for (const double ball : {0.0, 0.001}) {
    atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(scene, scale, ball);
      const glm::dvec3 from(-0.03, 0.0111, ball - 0.002);
      hand.at(from + glm::dvec3(0.0, 0.0, 0.01));
      hand.to(from, 5e-4);
      for (int i = 0; i <= 600; ++i) {
        const glm::dvec3 force = hand.at(from + 1e-4 * i * glm::dvec3(1.0, -0.31, 0.0));
        EXPECT_LE(glm::length(force - glm::dvec3(0.0, 0.0, kStiffness * 0.002)),
                  4.0 * kStiffness * hand.skin())
            << what << ", ball " << ball << ", tick " << i;
        forces.push_back(force);
        if (testing::Test::HasFailure()) return;
      }
    });
  }
}

TEST(HardDirt, FacesWithoutAreaAreNotFelt) {
  const assets::Mesh clean = sheetMesh(0.1, 25);
  std::vector<glm::dvec3> positions = clean.positions;
  Triangles triangles;
  for (std::size_t i = 0; i < clean.triangles.size(); ++i) {
    triangles.push_back(clean.triangles[i]);
    if (i % 4 != 0) continue;  // a fifth of all faces
    const auto& t = clean.triangles[i];
    const auto middle = static_cast<std::uint32_t>(positions.size());
    positions.push_back(0.5 * (positions[t[0]] + positions[t[1]]));
    triangles.push_back(i % 8 == 0 ? std::array<std::uint32_t, 3>{t[0], t[1], middle}
                                   : std::array<std::uint32_t, 3>{t[2], t[2], t[2]});
  }
  slideOverPlane(sceneOf(soupMesh(positions, triangles)), "zero-area faces");
}

TEST(HardDirt, DuplicateAndFlippedFacesAreNotFelt) {
  const assets::Mesh clean = sheetMesh(0.1, 25);
  Triangles triangles = clean.triangles;
  for (std::size_t i = 0; i < clean.triangles.size(); i += 3) {
    const auto& t = clean.triangles[i];
    triangles.push_back(t);
    triangles.push_back({t[0], t[2], t[1]});
  }
  slideOverPlane(sceneOf(soupMesh(clean.positions, triangles)), "duplicate and flipped faces");
}

TEST(HardDirt, FacesThatShareNoVerticesAreNotFelt) {
  slideOverPlane(sceneOf(split(sheetMesh(0.1, 25))), "split faces");
}

TEST(HardDirt, SliversAreNotFelt) {
  // Strips of 0.1 m by 10 um: 1e4 : 1, each of two slivers.
  std::vector<glm::dvec3> positions;
  Triangles triangles;
  const int strips = 400;
  for (int i = 0; i <= strips; ++i) {
    const double y = 0.02 - 1e-5 * i * (i % 7 == 3 ? 1.03 : 1.0);
    positions.emplace_back(-0.05, y, 0.0);
    positions.emplace_back(0.05, y, 0.0);
  }
  positions.emplace_back(-0.05, -0.05, 0.0);
  positions.emplace_back(0.05, -0.05, 0.0);
  for (std::uint32_t i = 0; i <= strips; ++i) {
    triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  slideOverPlane(sceneOf(soupMesh(positions, triangles)), "slivers");
}

TEST(HardDirt, TJunctionsAreNotFelt) {
  // Columns of squares, every second column halved: its vertices lie in the middle of its neighbours' edges.
  std::vector<glm::dvec3> positions;
  Triangles triangles;
  for (int column = 0; column < 20; ++column) {
    const int rows = column % 2 == 0 ? 20 : 37;
    const double x0 = -0.05 + 0.005 * column, x1 = x0 + 0.005, h = 0.1 / rows;
    for (int row = 0; row < rows; ++row) {
      const auto at = static_cast<std::uint32_t>(positions.size());
      const double y0 = -0.05 + h * row, y1 = row + 1 == rows ? 0.05 : y0 + h;
      positions.insert(positions.end(), {{x0, y0, 0.0}, {x1, y0, 0.0}, {x1, y1, 0.0}, {x0, y1, 0.0}});
      triangles.push_back({at, at + 1, at + 2});
      triangles.push_back({at, at + 2, at + 3});
    }
  }
  slideOverPlane(sceneOf(soupMesh(positions, triangles)), "T-junctions");
}

TEST(HardParts, JointsOfTenThousandPartsAreNotFelt) {
  const assets::Scene floor = tests::plateGrid(100, 0.001, 0.0005);
  ASSERT_EQ(floor.parts.size(), 10'000u);
  for (const double ball : {0.0, 0.0004}) {
    atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
      ScaledHand hand(floor, scale, ball);
      const glm::dvec3 from(-0.0403, 0.0304, ball - 0.0007);
      hand.at(from + glm::dvec3(0.0, 0.0, 0.01));
      hand.to(from, 5e-4);
      for (int i = 0; i <= 400; ++i) {
        const glm::dvec3 force = hand.at(from + 2e-4 * i * glm::dvec3(1.0, -0.731, 0.0));
        EXPECT_LE(glm::length(force - glm::dvec3(0.0, 0.0, kStiffness * 0.0007)), 1e-6) << i;
        forces.push_back(force);
        if (testing::Test::HasFailure()) return;
      }
    });
  }
}

TEST(HardOffset, FarFromTheOriginOnlyTheRoundingOfCoordinatesIsLost) {
  for (const double ball : {0.0, 0.0015}) {
    for (const double scale : kScales) {
      const glm::dvec3 origin(1e5, -7e4, 3e4);  // m, whatever the scale
      SceneBuilder b;
      b.addPart(scaledMesh(sheetMesh(0.2, 40), scale), {origin, {1.0, 0.0, 0.0, 0.0}});
      HandProbe hand(b.scene);
      hand.parameters.toolRadius = ball * scale;
      const glm::dvec3 from(-0.05, 0.0123, ball - 0.002);
      hand.at(origin + scale * (from + glm::dvec3(0.0, 0.0, 0.02)));
      hand.to(origin + scale * from, 5e-4 * scale);
      const double skin = hand.state.data().world.skin(0, origin);
      EXPECT_LT(skin, 1.2e-7);
      for (int i = 0; i <= 200; ++i) {
        const glm::dvec3 goal = origin + scale * (from + 1e-4 * i * glm::dvec3(1.0, 0.3, 0.0));
        hand.at(goal);
        EXPECT_LE(
            glm::length(hand.out.hands[0].toHand.force - glm::dvec3(0.0, 0.0, kStiffness * 0.002 * scale)),
            4.0 * kStiffness * skin)
            << i << " scale " << scale;
      }
    }
  }
}

TEST(HardLeaks, SegmentsAimedAtEveryEdgeAndVertexAreStopped) {
  const double radius = 0.02;
  const assets::Mesh welded = sphereMesh(radius, 8);
  const double inner = radius * std::pow(std::cos(kPi / 16.0), 2.0);
  for (const assets::Mesh& mesh : {welded, split(welded)}) {
    for (const double scale : kScales) {
      for (const double ball : {0.0, 0.0007}) {
        ScaledHand hand(sceneOf(mesh), scale, ball);
        hand.at({0.0, 0.0, 0.03});
        for (const auto& t : mesh.triangles) {
          for (std::size_t e = 0; e < 3; ++e) {
            const glm::dvec3 &a = mesh.positions[t[e]], &b = mesh.positions[t[(e + 1) % 3]];
            for (const double share : {0.0, 0.25, 0.5}) {
              const glm::dvec3 aim = glm::mix(a, b, share), out = glm::normalize(aim);
              // Back out of the sphere and round it, which takes a few ticks.
              const glm::dvec3 start = 1.5 * radius * glm::normalize(out + glm::dvec3(0.1, -0.2, 0.05));
              for (int i = 0; i < 100 && (i == 0 || glm::length(hand.force()) > 0.0); ++i) hand.at(start);
              hand.at(2.0 * aim);
              hand.at(aim);
              hand.at(0.2 * aim);
              ASSERT_GE(glm::length(hand.proxy()), inner + 0.999 * ball) << share;
              ASSERT_GT(glm::dot(hand.force(), out), 0.0);
            }
          }
        }
      }
    }
  }
}

TEST(HardLeaks, NothingGoesThroughAPlateAtAnySpeed) {
  for (const double thickness : {1e-3, 1e-4, 1e-5, 0.0}) {
    SceneBuilder b;
    const std::uint32_t plate =
        b.addMesh(thickness > 0.0 ? boxMesh({0.1, 0.1, thickness}) : sheetMesh(0.1, 7));
    b.addPart(plate);
    b.addPart(plate, {{0.0, 0.0, -0.015}, {1.0, 0.0, 0.0, 0.0}});
    const double top = 0.5 * thickness;
    for (const double ball : {0.0, 0.001}) {
      for (const double speed : {0.05, 0.5, 5.0}) {  // m/s
        atEveryScale(1e-5, [&](double scale, std::vector<glm::dvec3>& forces) {
          ScaledHand hand(b.scene, scale, ball);
          const double step = 1e-3 * speed;
          for (const double side : {1.0, -1.0}) {
            // From above onto the upper plate; from below onto the lower one.
            const auto at = [&](double x, double z) {
              return glm::dvec3(x, 0.0071, side > 0.0 ? z : -0.015 - z);
            };
            hand.to(at(-0.2, 0.1), 0.05);
            hand.to(at(0.011, 0.02), 0.05);
            const auto height = [&] { return side > 0.0 ? hand.proxy().z : -0.015 - hand.proxy().z; };
            forces.push_back(hand.to(at(0.011, -0.02), step));
            EXPECT_LE(
                glm::length(hand.force() - side * glm::dvec3(0.0, 0.0, kStiffness * (0.02 + top + ball))),
                4.0 * kStiffness * hand.skin());
            forces.push_back(hand.to(at(-0.03, -0.02), step));
            EXPECT_LE(
                glm::length(hand.force() - side * glm::dvec3(0.0, 0.0, kStiffness * (0.02 + top + ball))),
                4.0 * kStiffness * hand.skin());
            EXPECT_GT(height(), top + 0.999 * ball);
            forces.push_back(hand.to(at(-0.03, 0.02), step));
            EXPECT_EQ(hand.force(), glm::dvec3(0.0));
            EXPECT_NEAR(height(), 0.02, 1e-9);
          }
        });
      }
    }
  }
}

}  // namespace
}  // namespace tandem::test
