// The normals of a file: which of them are felt, and how they reach the mesh.

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "assets/scene/scene_codec.h"
#include "assets/scene/smooth_normals.h"
#include "tests/assets/gltf/load_for_test.h"

namespace tandem::assets {
namespace {

using tests::GltfBuilder;
using Json = nlohmann::json;

/// The side of a cylinder about z, radius 1, from z = 0 to 1, and its upper cap with vertices of its own.
struct Cylinder {
  static constexpr int kAround = 16;
  std::vector<float> positions, normals;
  std::vector<std::uint32_t> indices;

  Cylinder() {
    for (const bool cap : {false, true})
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < kAround; ++i) {
          const double a = 2.0 * kPi * i / kAround;
          const float x = static_cast<float>(std::cos(a)), y = static_cast<float>(std::sin(a));
          if (cap && j == 0) continue;
          positions.insert(positions.end(), {x, y, static_cast<float>(j)});
          if (cap)
            normals.insert(normals.end(), {0.0f, 0.0f, 1.0f});
          else
            normals.insert(normals.end(), {x, y, 0.0f});
        }
    const auto at = [](int j, int i) { return static_cast<std::uint32_t>(j * kAround + i % kAround); };
    for (int i = 0; i < kAround; ++i) {
      indices.insert(indices.end(), {at(0, i), at(0, i + 1), at(1, i + 1)});
      indices.insert(indices.end(), {at(0, i), at(1, i + 1), at(1, i)});
    }
    for (int i = 1; i + 1 < kAround; ++i) indices.insert(indices.end(), {at(2, 0), at(2, i), at(2, i + 1)});
  }
};

/// A file with that cylinder, whose primitive's `NORMAL` is the accessor that `add` appends.
GltfBuilder fileWith(const Cylinder& cylinder, const std::function<int(GltfBuilder&)>& add,
                     const Json& node = Json::object()) {
  GltfBuilder b;
  const int mesh = b.addMesh(b.addPositions(cylinder.positions), b.addIndices(cylinder.indices));
  b.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = add(b);
  Json whole = node;
  whole["mesh"] = mesh;
  b.addNode(whole);
  return b;
}

GltfBuilder fileWith(const Cylinder& cylinder, const Json& node = Json::object()) {
  return fileWith(
      cylinder, [&](GltfBuilder& b) { return b.addPositions(cylinder.normals); }, node);
}

glm::dvec3 facetOf(const Mesh& mesh, std::size_t t) {
  const auto& c = mesh.triangles[t];
  return glm::normalize(
      glm::cross(mesh.positions[c[1]] - mesh.positions[c[0]], mesh.positions[c[2]] - mesh.positions[c[0]]));
}

TEST(GltfNormals, AreKeptWhereTheySayMoreThanTheFacets) {
  const Scene scene = loaded(fileWith({}));
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.triangleNormal.size(), mesh.triangles.size());
  EXPECT_EQ(smoothTriangles(mesh, 0), 2u * Cylinder::kAround) << "the side, not the cap";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const glm::dvec3 n(mesh.triangleNormal[t][c]), p = mesh.positions[mesh.triangles[t][c]];
      const glm::dvec3 exact = facetOf(mesh, t).z > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(p.x, p.y, 0.0);
      EXPECT_LT(glm::distance(n, exact), 1e-6);
    }
}

TEST(GltfNormals, FlatOnesCostNothing) {
  const Cylinder cylinder;
  Cylinder flat;
  flat.positions.clear();
  flat.normals.clear();
  flat.indices.clear();
  for (std::size_t i = 0; i < cylinder.indices.size(); i += 3) {
    glm::vec3 p[3];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t v = cylinder.indices[i + c];
      p[c] = {cylinder.positions[3 * v], cylinder.positions[3 * v + 1], cylinder.positions[3 * v + 2]};
    }
    const glm::vec3 n = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
    for (const glm::vec3& corner : p) {
      flat.indices.push_back(static_cast<std::uint32_t>(flat.indices.size()));
      flat.positions.insert(flat.positions.end(), {corner.x, corner.y, corner.z});
      flat.normals.insert(flat.normals.end(), {n.x, n.y, n.z});
    }
  }
  EXPECT_TRUE(loaded(fileWith(flat)).meshes[0].triangleNormal.empty());
}

TEST(GltfNormals, AreTurnedOffByASwitchAndByTheSurfaceItself) {
  LoadOptions facets;
  facets.normals = false;
  EXPECT_TRUE(loaded(fileWith({}), facets).meshes[0].triangleNormal.empty());
  for (const double angle : {0.0, 0.5}) {
    const Json node = {{"extras", {{"haptic", {{"creaseAngle", angle}}}}}};
    EXPECT_TRUE(loaded(fileWith({}, node)).meshes[0].triangleNormal.empty()) << angle;
  }
  const Json other = {{"extras", {{"haptic", {{"stiffness", 500.0}, {"viscosity", 2.0}}}}}};
  EXPECT_FALSE(loaded(fileWith({}, other)).meshes[0].triangleNormal.empty());
  Scene scene = loaded(fileWith({}));
  dropNormals(scene);
  EXPECT_TRUE(scene.meshes[0].triangleNormal.empty());
}

TEST(GltfNormals, FollowTheNodesScaleShearAndMirror) {
  for (const Json& scale : {Json({1.0, 1.0, 3.0}), Json({-1.0, 1.0, 1.0}), Json({2.0, 2.0, -0.5})}) {
    const Scene scene = loaded(fileWith({}, {{"scale", scale}}));
    const Mesh& mesh = scene.meshes[0];
    ASSERT_FALSE(mesh.triangleNormal.empty());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const glm::dvec3 p = mesh.positions[mesh.triangles[t][c]], facet = facetOf(mesh, t);
        if (std::abs(facet.z) > 0.9) continue;
        const glm::dvec3 exact = glm::normalize(glm::dvec3(p.x, p.y, 0.0));
        EXPECT_LT(glm::distance(glm::dvec3(mesh.triangleNormal[t][c]), exact), 1e-6) << scale;
      }
  }
}

TEST(GltfNormals, MayBeIntegers) {
  const Cylinder cylinder;
  std::vector<std::int8_t> bytes;
  for (std::size_t i = 0; i < cylinder.normals.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k)
      bytes.push_back(static_cast<std::int8_t>(std::lround(127.0f * cylinder.normals[i + k])));
    bytes.push_back(0);
  }
  const auto add = [&](GltfBuilder& b) {
    const int view = b.addView(bytes);
    b.json["bufferViews"].back()["byteStride"] = 4;
    b.json["accessors"].push_back({{"bufferView", view},
                                   {"componentType", 5120},
                                   {"normalized", true},
                                   {"count", bytes.size() / 4},
                                   {"type", "VEC3"}});
    return static_cast<int>(b.json["accessors"].size()) - 1;
  };
  const Scene scene = loaded(fileWith(cylinder, add));
  EXPECT_EQ(smoothTriangles(scene.meshes[0], 0), 2u * Cylinder::kAround);
}

TEST(GltfNormals, ThatAreNoneOfTheSurfaceGiveWayToTheFacets) {
  Cylinder inward;
  for (float& n : inward.normals) n = -n;
  EXPECT_EQ(smoothTriangles(loaded(fileWith(inward)).meshes[0], 0), 2u * Cylinder::kAround)
      << "a file that has them the other way round";
  Cylinder broken;
  for (std::size_t i = 0; i < broken.normals.size(); ++i)
    broken.normals[i] = i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.0f;
  EXPECT_TRUE(loaded(fileWith(broken)).meshes[0].triangleNormal.empty());
  Cylinder upward;
  for (std::size_t i = 0; i < upward.normals.size(); ++i) upward.normals[i] = i % 3 == 2 ? 1.0f : 0.0f;
  EXPECT_TRUE(loaded(fileWith(upward)).meshes[0].triangleNormal.empty()) << "at right angles to the side";
  const auto tooFew = [](GltfBuilder& b) { return b.addPositions({0, 0, 1, 0, 0, 1}); };
  EXPECT_TRUE(loaded(fileWith({}, tooFew)).meshes[0].triangleNormal.empty());
  const auto noVectors = [](GltfBuilder& b) {
    return b.addAccessor(std::vector<float>(96), 5126, "VEC2", 2);
  };
  EXPECT_TRUE(loaded(fileWith({}, noVectors)).meshes[0].triangleNormal.empty());
}

TEST(GltfNormals, TravelWithTheScene) {
  const Scene scene = loaded(fileWith({}));
  const Result<Scene> back = decodeScene(encodeScene(scene));
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->meshes[0].triangleNormal, scene.meshes[0].triangleNormal);
  Scene hostile = scene;
  hostile.meshes[0].triangleNormal[3][1] = glm::vec3(0.0f, 2.0f, 0.0f);
  EXPECT_FALSE(decodeScene(encodeScene(hostile)).ok());
  hostile = scene;
  hostile.meshes[0].triangleNormal.pop_back();
  EXPECT_FALSE(decodeScene(encodeScene(hostile)).ok());
}

}  // namespace
}  // namespace tandem::assets
