#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "haptics/scene/contact_samples.h"
#include "tests/support/part_meshes.h"
#include "tests/support/shapes.h"

namespace tandem::test {
namespace {

using haptics::ContactSamples;
using haptics::MeshEdge;
using haptics::MeshEdges;

ContactSamples samplesOf(const assets::Mesh& mesh, const ContactSamples::Options& options = {}) {
  return ContactSamples(mesh, MeshEdges(mesh), options);
}

TEST(ContactSamples, OfABoxAreItsCornersAndEdgesAlone) {
  const ContactSamples samples = samplesOf(boxMesh({0.02, 0.03, 0.04}));
  int corners = 0;
  for (const auto& sample : samples.samples()) {
    const glm::dvec3 p = glm::abs(sample.point);
    const int onBorder = (p.x > 0.01 - 1e-12) + (p.y > 0.015 - 1e-12) + (p.z > 0.02 - 1e-12);
    EXPECT_GE(onBorder, 2);
    EXPECT_EQ(samples.normals(sample).size(), static_cast<std::size_t>(onBorder));
    corners += onBorder == 3 ? 1 : 0;
  }
  EXPECT_EQ(corners, 8);
}

TEST(ContactSamples, StandForTheWholeLengthOfEveryEdge) {
  const assets::Mesh mesh = boxMesh({0.02, 0.03, 0.04});
  const MeshEdges edges(mesh);
  const ContactSamples samples(mesh, edges, {});
  for (std::uint32_t e = 0; e < edges.count(); ++e) {
    const MeshEdge edge = edges.edge(e);
    for (int i = 0; i <= 200; ++i) {
      const glm::dvec3 p = edge.a + (edge.b - edge.a) * (i / 200.0);
      const bool stoodFor =
          std::any_of(samples.samples().begin(), samples.samples().end(), [&](const auto& s) {
            return s.edge == e && glm::length(s.point - p) <= static_cast<double>(s.along) + 1e-12;
          });
      EXPECT_TRUE(stoodFor);
    }
  }
}

TEST(ContactSamples, CoverASphereAndNoHollow) {
  const ContactSamples sphere = samplesOf(sphereMesh(0.01, 40));
  for (int i = 0; i < 400; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / 400.0, a = 2.4 * i, r = std::sqrt(1.0 - z * z);
    const glm::dvec3 p = 0.01 * glm::dvec3(r * std::cos(a), r * std::sin(a), z);
    double nearest = 1.0;
    for (const auto& sample : sphere.samples()) nearest = std::min(nearest, glm::length(sample.point - p));
    EXPECT_LT(nearest, 2.0 * sphere.smoothSpacing() + 0.01 * kPi / 40);
  }
  assets::TriangleSoup inner = sphereSoup(0.01, 40);
  for (auto& t : inner.triangles) std::swap(t[0], t[1]);
  assets::Mesh hollow = assets::analyseMesh(inner, 0.5).mesh;
  for (auto& t : hollow.triangles) std::swap(t[0], t[1]);
  for (auto& n : hollow.neighbours) std::swap(n[1], n[2]);
  EXPECT_EQ(samplesOf(hollow).samples().size(), 0u);
}

/// A rounding that is smaller than the spacing of smooth samples turns by a right angle within it.
TEST(ContactSamples, CoverEveryWayThatASmallRoundingFaces) {
  constexpr double kRadius = 2e-4;
  constexpr int kFacets = 24;
  std::vector<glm::dvec2> outline;
  std::array<glm::dvec2, 4> centres;
  for (int corner = 0; corner < 4; ++corner) {
    const double x = corner == 0 || corner == 3 ? 1.0 : -1.0, y = corner < 2 ? 1.0 : -1.0;
    centres[static_cast<std::size_t>(corner)] = {x * (0.01 - kRadius), y * (0.005 - kRadius)};
    for (int i = 0; i <= kFacets; ++i) {
      const double angle = 0.5 * kPi * (corner + static_cast<double>(i) / kFacets);
      outline.push_back(centres[static_cast<std::size_t>(corner)] +
                        kRadius * glm::dvec2(std::cos(angle), std::sin(angle)));
    }
  }
  const ContactSamples samples = samplesOf(meshOf(prismSoup(outline, 0.01)));
  ASSERT_GT(samples.smoothSpacing(), 2.0 * kRadius);
  for (int i = 0; i < 4 * kFacets; ++i) {
    const double angle = 0.5 * kPi * (i + 0.5) / kFacets;
    const glm::dvec2 &centre = centres[static_cast<std::size_t>(i / kFacets)],
                     facing(std::cos(angle), std::sin(angle));
    const bool covered = std::any_of(samples.samples().begin(), samples.samples().end(), [&](const auto& s) {
      const glm::dvec2 from = glm::dvec2(s.point) - centre;
      return ContactSamples::isSmooth(s) && glm::length(from) < 1.01 * kRadius &&
             glm::dot(from, facing) > std::cos(0.4) * kRadius;
    });
    EXPECT_TRUE(covered) << angle;
  }
}

TEST(ContactSamples, BallsOfTheTreeHoldTheirSamples) {
  const ContactSamples samples = samplesOf(sphereMesh(0.01, 60));
  const auto nodes = samples.nodes();
  ASSERT_FALSE(nodes.empty());
  EXPECT_EQ(nodes[0].end, samples.samples().size());
  for (std::uint32_t n = 0; n < nodes.size(); ++n) {
    const auto& node = nodes[n];
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const glm::dvec3 c(node.centre[0], node.centre[1], node.centre[2]);
      EXPECT_LE(glm::length(samples.samples()[i].point - c), static_cast<double>(node.radius));
    }
    if (node.second == 0) {
      EXPECT_LE(node.end - node.begin, ContactSamples::kMaxInLeaf);
    } else {
      EXPECT_EQ(nodes[n + 1].begin, node.begin);
      EXPECT_EQ(nodes[n + 1].end, nodes[node.second].begin);
      EXPECT_EQ(nodes[node.second].end, node.end);
    }
  }
}

TEST(ContactSamples, AreTheSameAtEveryScale) {
  const std::size_t count = samplesOf(sphereMesh(0.01, 50)).samples().size();
  EXPECT_GT(count, 100u);
  EXPECT_NEAR(static_cast<double>(samplesOf(sphereMesh(2e-5, 50)).samples().size()), count, 0.02 * count);
  EXPECT_NEAR(static_cast<double>(samplesOf(sphereMesh(0.2, 50)).samples().size()), count, 0.02 * count);
}

}  // namespace
}  // namespace tandem::test
