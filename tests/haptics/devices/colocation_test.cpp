#include "haptics/devices/colocation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "haptics/devices/device_list.h"

namespace tandem::haptics {
namespace {

using glm::dvec3;

const Pose kPose{{0.3, -0.2, 1.5}, glm::normalize(glm::dquat(0.6, -0.3, 0.5, 0.2))};

/// Pairs of random points under a known similarity, the view's with noise of this size (m).
std::vector<PointPair> made(std::size_t count, double scale, double noise, bool flat = false) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-0.1, 0.1);
  std::normal_distribution<double> error(0.0, noise > 0.0 ? noise : 1.0);
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    const dvec3 d(place(random), place(random), flat ? 0.0 : place(random));
    const dvec3 off = noise > 0.0 ? dvec3(error(random), error(random), error(random)) : dvec3(0.0);
    pairs.push_back({d, transformPoint(kPose, scale * d) + off});
  }
  return pairs;
}

double angleTo(const glm::dquat& a, const glm::dquat& b) {
  return glm::length(rotationVector(a * glm::conjugate(b)));
}

std::string refusal(const std::vector<PointPair>& pairs) {
  const auto result = colocate(pairs);
  return result.ok() ? "" : result.error().message;
}

TEST(Colocation, FindsTheSimilarityOfExactPairsAtAnyScale) {
  for (const double scale : {1e-3, 1.0, 2.5, 20.0})
    for (const std::size_t count : {3u, 4u, 50u}) {
      const auto found = colocate(made(count, scale, 0.0));
      ASSERT_TRUE(found.ok()) << found.error().message;
      EXPECT_NEAR(found->scale / scale, 1.0, 1e-12);
      EXPECT_LT(angleTo(found->viewFromDevice.orientation, kPose.orientation), 1e-9);
      EXPECT_LT(glm::distance(found->viewFromDevice.position, kPose.position), 1e-9);
      EXPECT_LT(found->worst, 1e-9 * (1.0 + scale));
    }
}

TEST(Colocation, PointsInAPlaneAreEnoughWithAndWithoutNoise) {
  for (const double noise : {0.0, 1e-3}) {
    const auto found = colocate(made(40, 2.0, noise, true));
    ASSERT_TRUE(found.ok()) << found.error().message;
    EXPECT_LT(angleTo(found->viewFromDevice.orientation, kPose.orientation), 0.01);
  }
}

TEST(Colocation, ReportsTheResidualThatTheNoiseLeaves) {
  const auto found = colocate(made(400, 1.5, 1e-3));
  ASSERT_TRUE(found.ok());
  EXPECT_NEAR(found->rms, std::sqrt(3.0) * 1e-3, 0.1e-3);
  EXPECT_GT(found->worst, found->rms);
  EXPECT_NEAR(found->scale, 1.5, 5e-3);
}

TEST(Colocation, NoNeighbouringSimilarityFitsBetter) {
  const auto pairs = made(12, 1.5, 3e-3);
  const auto best = colocate(pairs);
  ASSERT_TRUE(best.ok());
  const auto squares = [&pairs](const Colocation& c) {
    double sum = 0.0;
    for (const PointPair& p : pairs)
      sum += glm::dot(c.toView(p.device) - p.view, c.toView(p.device) - p.view);
    return sum;
  };
  const double least = squares(*best);
  EXPECT_NEAR(std::sqrt(least / 12.0), best->rms, 1e-12);
  for (int axis = 0; axis < 3; ++axis)
    for (const double step : {-1e-3, 1e-3}) {
      dvec3 small(0.0);
      small[axis] = step;
      Colocation turned = *best, moved = *best, scaled = *best;
      turned.viewFromDevice.orientation = fromRotationVector(small) * best->viewFromDevice.orientation;
      // Turned about the middle of the points, not about the origin.
      moved.viewFromDevice.position += small;
      scaled.scale *= 1.0 + step;
      EXPECT_GT(squares(turned), least);
      EXPECT_GT(squares(moved), least);
      EXPECT_GT(squares(scaled), least);
    }
}

TEST(Colocation, KeepsTheScaleAtOneWhenToldTo) {
  const auto found = colocate(made(20, 2.0, 0.0), false);
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->scale, 1.0);
  EXPECT_GT(found->rms, 0.05);  // and says how badly that fits
}

TEST(Colocation, RefusesSetsThatDoNotSayWhereTheDeviceIs) {
  EXPECT_NE(refusal({}), "");
  EXPECT_NE(refusal(made(2, 1.0, 0.0)).find("three"), std::string::npos);
  std::vector<PointPair> line, heap;
  for (int i = 0; i < 10; ++i) {
    line.push_back({{0.01 * i, 0.02 * i, 0.0}, {0.0, 0.01 * i, 0.0}});
    heap.push_back({{0.1, 0.2, 0.3}, {0.01 * i, 0.0, 0.02 * (i % 3)}});
  }
  EXPECT_NE(refusal(line).find("on a line"), std::string::npos);
  EXPECT_NE(refusal(heap).find("device's points"), std::string::npos);
  auto lost = made(5, 1.0, 0.0);
  for (PointPair& pair : lost) pair.view = dvec3(1.0);
  EXPECT_NE(refusal(lost).find("view's points"), std::string::npos);
  auto mirrored = made(20, 1.0, 0.0);
  for (PointPair& pair : mirrored) pair.view.x = -pair.view.x;
  EXPECT_NE(refusal(mirrored).find("mirror"), std::string::npos);
  auto poisoned = made(5, 1.0, 0.0);
  poisoned[2].view.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(poisoned).find("finite"), std::string::npos);
  poisoned[2].view.y = 1e300;
  EXPECT_NE(refusal(poisoned), "");
}

TEST(Colocation, MapsADevicesReadingToWhereItsTargetWasSeen) {
  const auto found = colocate(made(9, 3.0, 0.0));
  ASSERT_TRUE(found.ok());
  DeviceMapping mapping = mappingOf(*found);
  DeviceSample sample;
  sample.valid = true;
  sample.worldFromDevice.position = {0.02, 0.03, -0.04};
  const dvec3 seen = transformPoint(kPose, 3.0 * sample.worldFromDevice.position);
  EXPECT_LT(glm::distance(mapping.toWorld(sample).worldFromDevice.position, seen), 1e-9);
}

TEST(Colocation, PlacesADeviceThatHasAWorkspaceAndIsRefusedByOthers) {
  const auto found = colocate(made(9, 3.0, 0.0));
  ASSERT_TRUE(found.ok());
  const auto arm = openDevice("simulated-arm", Pose{{7.0, 8.0, 9.0}, {1.0, 0.0, 0.0, 0.0}}, &*found);
  ASSERT_TRUE(arm.ok()) << arm.error().message;
  // The arm begins at the middle of its own axes, to within the encoders' steps.
  EXPECT_LT(glm::distance((*arm)->poll(0.0).worldFromDevice.position, kPose.position), 3.0 * 0.1e-3);
  EXPECT_NEAR((*arm)->limits().workspaceRadius,
              3.0 * openDevice("simulated-arm").value()->limits().workspaceRadius, 1e-9);
  const auto stylus = openDevice("stylus", Pose{}, &*found);
  ASSERT_FALSE(stylus.ok());
  EXPECT_NE(stylus.error().message.find("no workspace of its own"), std::string::npos);
}

TEST(Colocation, SurvivesItsJsonAndRefusesOthers) {
  const auto found = colocate(made(9, 3.0, 1e-3));
  ASSERT_TRUE(found.ok());
  const auto read = parseColocation(toJson(*found), "c.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->scale, found->scale);
  EXPECT_EQ(read->viewFromDevice.position, found->viewFromDevice.position);
  EXPECT_EQ(read->viewFromDevice.orientation, found->viewFromDevice.orientation);
  EXPECT_EQ(read->pairs, 9u);
  for (const char* bad :
       {"", "{", "[]", "null", "{\"scale\":1}",
        R"({"view_from_device":{"position":[0,0,0],"orientation_wxyz":[2,0,0,0]},"scale":1})",
        R"({"view_from_device":{"position":[0,0,0],"orientation_wxyz":[1,0,0,0]},"scale":0})",
        R"({"view_from_device":{"position":[0,0,0],"orientation_wxyz":[1,0,0,0]},"scale":1e99})",
        R"({"view_from_device":{"position":[0,0,0],"orientation_wxyz":[1,0,0,0]},"scale":1,"pairs":1e30})",
        R"({"view_from_device":{"position":[0,0,0],"orientation_wxyz":[1,0,0,0]},"scale":1,"pairs":-1})",
        R"({"view_from_device":{"position":[0,0],"orientation_wxyz":[1,0,0,0]},"scale":1})",
        R"({"view_from_device":{"position":[0,0,"x"],"orientation_wxyz":[1,0,0,0]},"scale":1})"})
    EXPECT_FALSE(parseColocation(bad, "c.json").ok()) << bad;
}

TEST(Colocation, ReadsPairsAndNamesTheLineThatIsWrong) {
  const auto pairs = parsePairs("dx,dy,dz,vx,vy,vz\r\n0,0,0,1,2,3\n1e-2,0,0,4,5,6\n\n", "p.csv");
  ASSERT_TRUE(pairs.ok()) << pairs.error().message;
  ASSERT_EQ(pairs->size(), 2u);
  EXPECT_EQ((*pairs)[1].device.x, 0.01);
  EXPECT_EQ((*pairs)[1].view.z, 6.0);
  const auto message = [](const char* text) {
    const auto result = parsePairs(text, "p.csv");
    return result.ok() ? std::string() : result.error().message;
  };
  EXPECT_NE(message("").find("no pairs"), std::string::npos);
  EXPECT_NE(message("x,y\n").find("p.csv:1"), std::string::npos);
  EXPECT_NE(message("dx,dy,dz,vx,vy,vz\n1,2,3\n").find("p.csv:2"), std::string::npos);
  EXPECT_NE(message("dx,dy,dz,vx,vy,vz\n1,2,3,4,5,6,7\n").find("p.csv:2"), std::string::npos);
  EXPECT_NE(message("dx,dy,dz,vx,vy,vz\n1,2,3,4,5,nan\n").find("finite"), std::string::npos);
}

}  // namespace
}  // namespace tandem::haptics
