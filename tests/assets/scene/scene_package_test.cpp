#include "assets/scene/scene_package.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "assets/gltf/load_gltf.h"
#include "assets/scene/scene_check.h"
#include "assets/scene/scene_codec.h"
#include "tests/support/gltf_builder.h"

namespace tandem::assets {
namespace {

using Engine = std::mt19937;

double number(Engine& random) { return std::uniform_real_distribution<double>(-10.0, 10.0)(random); }
std::uint32_t below(Engine& random, std::uint32_t limit) {
  return static_cast<std::uint32_t>(random() % limit);
}
glm::dvec3 vector(Engine& random) { return {number(random), number(random), number(random)}; }
Pose pose(Engine& random) { return {vector(random), fromRotationVector(vector(random))}; }

Mesh randomMesh(Engine& random, std::size_t materials, bool asFloat) {
  Mesh mesh;
  const std::uint32_t vertices = 3 + below(random, 20), triangles = below(random, 30);
  for (std::uint32_t i = 0; i < vertices; ++i) {
    const glm::dvec3 p = vector(random);
    mesh.positions.push_back(asFloat ? glm::dvec3(double(float(p.x)), double(float(p.y)), -0.0) : p);
  }
  mesh.shellCount = std::min(triangles, 3u);
  for (std::uint32_t i = 0; i < triangles; ++i) {
    mesh.triangles.push_back({below(random, vertices), below(random, vertices), below(random, vertices)});
    mesh.triangleMaterial.push_back(
        static_cast<std::uint16_t>(below(random, static_cast<std::uint32_t>(materials))));
    mesh.neighbours.push_back({below(random, triangles), kNone, below(random, triangles)});
    mesh.edgeFlags.push_back({static_cast<std::uint8_t>(below(random, 8)), 0, kEdgeBoundary});
    mesh.triangleShell.push_back(below(random, mesh.shellCount));
  }
  mesh.closed = below(random, 2) == 1;
  mesh.volume = number(random);
  mesh.bounds = {glm::dvec3(-10), glm::dvec3(10)};
  return mesh;
}

/// A scene with something in every field.
Scene randomSceneWithFiles(std::uint32_t seed) {
  Engine random(seed);
  Scene scene;
  scene.name = "scene " + std::to_string(seed);
  scene.gravity = vector(random);
  for (int i = 0; i < 3; ++i) {
    Material material;
    material.name = "m" + std::to_string(i);
    material.stiffness = std::abs(number(random));
    scene.materials.push_back(material);
  }
  for (int i = 0; i < 3; ++i) scene.meshes.push_back(randomMesh(random, 3, i % 2 == 0));
  for (std::uint32_t i = 0; i < 6; ++i) scene.tree.push_back({"node", i == 0 ? kNone : below(random, i)});
  for (std::uint32_t i = 0; i < 4; ++i) {
    Part part;
    part.name = "part " + std::to_string(i);
    part.treeNode = below(random, 6);
    part.mesh = i == 0 ? kNone : i - 1;
    part.shapes.resize(below(random, 3));
    for (ImplicitShape& shape : part.shapes) shape.partFromShape = pose(random);
    part.worldFromPart = pose(random);
    part.movable = i % 2 == 0;
    part.massProperties = {1.0 + i, vector(random), glm::dmat3(2.0)};
    part.filter = {random(), random()};
    scene.parts.push_back(part);
  }
  Joint joint;
  joint.name = "hinge";
  joint.partB = 2;
  joint.aFromJoint = pose(random);
  joint.limits.push_back({true, 5, -1.0, 1e300, 3.0, 4.0});
  joint.drives.push_back({false, true, 2, 10.0, 1.0, 2.0, 3.0, 4.0});
  joint.pitch = 0.002;
  joint.detents = {{0.1, 0.2}, 3.0, 0.05};
  joint.detentsTurn = true;
  scene.joints.push_back(joint);
  scene.findings.push_back({Finding::Severity::warning, "open-shells", "part 1", 7, "Shells are open."});
  scene.bounds = {glm::dvec3(-20), glm::dvec3(20)};
  return scene;
}

std::string flip(std::vector<std::byte>& bytes, Engine& random) {
  const std::size_t at = random() % bytes.size();
  bytes[at] ^= std::byte(1u << (random() % 8));
  return "byte " + std::to_string(at);
}

TEST(ScenePackage, GivesBackWhatItWasGiven) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const Scene scene = randomSceneWithFiles(seed);
    ASSERT_TRUE(checkScene(scene).ok()) << checkScene(scene).error().message;
    const std::vector<std::byte> package = packScene(scene);
    const Result<Scene> back = unpackScene(package);
    ASSERT_TRUE(back.ok()) << back.error().message;
    // Field by field where a codec may go wrong, and all of it by packing again.
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
      EXPECT_EQ(back->meshes[m].triangles, scene.meshes[m].triangles);
      EXPECT_EQ(back->meshes[m].neighbours, scene.meshes[m].neighbours);
      EXPECT_EQ(back->meshes[m].edgeFlags, scene.meshes[m].edgeFlags);
      EXPECT_EQ(back->meshes[m].triangleShell, scene.meshes[m].triangleShell);
      EXPECT_EQ(back->meshes[m].triangleMaterial, scene.meshes[m].triangleMaterial);
      for (std::size_t i = 0; i < scene.meshes[m].positions.size(); ++i) {
        EXPECT_EQ(back->meshes[m].positions[i], scene.meshes[m].positions[i]);
        EXPECT_EQ(std::signbit(back->meshes[m].positions[i].z), std::signbit(scene.meshes[m].positions[i].z));
      }
    }
    EXPECT_EQ(back->parts[3].name, "part 3");
    EXPECT_EQ(back->parts[3].filter.memberOf, scene.parts[3].filter.memberOf);
    EXPECT_EQ(back->joints[0].limits[0].max, 1e300);
    EXPECT_EQ(back->joints[0].pitch, 0.002);
    EXPECT_EQ(back->joints[0].detents.places, (std::vector<double>{0.1, 0.2}));
    EXPECT_EQ(back->joints[0].detents.width, 0.05);
    EXPECT_TRUE(back->joints[0].detentsTurn);
    EXPECT_EQ(back->findings[0].count, 7u);
    EXPECT_EQ(packScene(*back), package);
  }
}

TEST(ScenePackage, CarriesAScenesWholeFile) {
  tests::GltfBuilder b;
  b.addNode({{"mesh", b.addBox(1, 2, 3, "box")}});
  const Result<Scene> scene = loadGltfFromMemory("box.glb", b.glb(), {});
  ASSERT_TRUE(scene.ok());
  const Result<Scene> back = unpackScene(packScene(*scene));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->meshes[0].positions, scene->meshes[0].positions);
}

TEST(ScenePackage, RefusesTruncationAtEveryByte) {
  const std::vector<std::byte> package = packScene(randomSceneWithFiles(1));
  for (std::size_t size = 0; size < package.size(); ++size)
    ASSERT_FALSE(unpackScene(std::span(package).first(size)).ok()) << size;
}

TEST(ScenePackage, NoticesEveryFlippedBitOfItsContent) {
  const std::vector<std::byte> package = packScene(randomSceneWithFiles(2));
  for (std::size_t at = 24; at < package.size(); ++at) {
    std::vector<std::byte> damaged = package;
    damaged[at] ^= std::byte{1};
    ASSERT_FALSE(unpackScene(damaged).ok()) << at;
  }
}

TEST(ScenePackage, RefusesADecompressionBomb) {
  std::vector<std::byte> package = packScene(randomSceneWithFiles(3));
  const std::uint64_t lie = std::uint64_t{3} << 30;
  std::memcpy(package.data() + 16, &lie, sizeof lie);
  const Result<Scene> scene = unpackScene(package);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("claims to unpack"), std::string::npos) << scene.error().message;
}

TEST(ScenePackage, StoresWhatCompressesTooWell) {
  Scene scene = randomSceneWithFiles(4);
  scene.meshes[0] = {};
  scene.meshes[0].positions.assign(400000, glm::dvec3(0.0));
  const std::vector<std::byte> package = packScene(scene);
  const Result<Scene> back = unpackScene(package);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->meshes[0].positions.size(), 400000u);
}

TEST(ScenePackage, IsReadAndWrittenInPiecesThatAreMuchSmallerThanTheScene) {
  Scene scene = randomSceneWithFiles(9);
  while (scene.meshes.size() < 60) {
    Mesh mesh = scene.meshes[0];
    Engine random(static_cast<std::uint32_t>(scene.meshes.size()));
    for (int i = 0; i < 8000; ++i) mesh.positions.push_back(vector(random));
    scene.meshes.push_back(std::move(mesh));
  }
  std::vector<std::byte> whole;
  std::size_t largest = 0;
  encodeScene(scene, [&](std::span<const std::byte> piece) {
    whole.insert(whole.end(), piece.begin(), piece.end());
    largest = std::max(largest, piece.size());
  });
  EXPECT_EQ(whole, encodeScene(scene));
  EXPECT_LT(4 * largest, whole.size());
  const std::vector<std::byte> package = packScene(scene);
  const Result<Scene> back = unpackScene(package);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->meshes.back().positions, scene.meshes.back().positions);
  EXPECT_EQ(packScene(*back), package);
}

TEST(Scene, KeepsWhatIsSaidOfMeshesAsAWholeWithoutTheirGeometry) {
  Scene scene = randomSceneWithFiles(10);
  const Bounds bounds = scene.meshes[0].bounds;
  ASSERT_GT(triangleCount(scene), 0u);
  dropGeometry(scene);
  EXPECT_EQ(triangleCount(scene), 0u);
  EXPECT_EQ(scene.meshes[0].bounds.max, bounds.max);
  EXPECT_TRUE(scene.meshes[0].positions.empty());
}

TEST(Scene, LosesTheShellsOfTrianglesAlone) {
  const Scene whole = randomSceneWithFiles(10);
  Scene scene = whole;
  dropShells(scene);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    EXPECT_TRUE(scene.meshes[m].triangleShell.empty());
    scene.meshes[m].triangleShell = whole.meshes[m].triangleShell;
  }
  EXPECT_EQ(packScene(scene), packScene(whole));
}

// The hash hides broken content from the decoder, so these go to the decoder itself, as a hostile packer
// would.

TEST(SceneCodec, RefusesTruncationAtEveryByte) {
  const std::vector<std::byte> raw = encodeScene(randomSceneWithFiles(5));
  ASSERT_TRUE(decodeScene(raw).ok());
  for (std::size_t size = 0; size < raw.size(); ++size)
    ASSERT_FALSE(decodeScene(std::span(raw).first(size)).ok()) << size;
}

TEST(SceneCodec, GivesAnErrorOrAValidSceneForFlippedBits) {
  const std::vector<std::byte> raw = encodeScene(randomSceneWithFiles(6));
  Engine random(7);
  int refused = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> damaged = raw;
    const std::string what = flip(damaged, random);
    const Result<Scene> scene = decodeScene(damaged);
    if (!scene) {
      ++refused;
      continue;
    }
    ASSERT_TRUE(checkScene(*scene).ok()) << what;
  }
  EXPECT_GT(refused, 1000);
}

TEST(SceneCodec, RefusesScenesThatBreakTheInvariants) {
  const auto refuses = [](const char* what, const std::function<void(Scene&)>& change) {
    Scene scene = randomSceneWithFiles(8);
    change(scene);
    EXPECT_FALSE(decodeScene(encodeScene(scene)).ok()) << what;
  };
  refuses("a part's mesh", [](Scene& s) { s.parts[1].mesh = 9; });
  refuses("a part's node", [](Scene& s) { s.parts[1].treeNode = 99; });
  refuses("a taken name", [](Scene& s) { s.parts[1].name = s.parts[0].name; });
  refuses("a vertex", [](Scene& s) { s.meshes[0].positions[0].x = std::nan(""); });
  refuses("a vertex too far", [](Scene& s) { s.meshes[0].positions[0].y = 1e9; });
  refuses("a vertex beyond any float", [](Scene& s) { s.meshes[0].positions[0].z = -1e300; });
  refuses("a pose", [](Scene& s) { s.parts[0].worldFromPart.orientation.w = 7.0; });
  refuses("a tree's order", [](Scene& s) { s.tree[1].parent = 1; });
  refuses("a joint's part", [](Scene& s) { s.joints[0].partA = 77; });
  refuses("a joint's pitch", [](Scene& s) { s.joints[0].pitch = 1e300; });
  refuses("a joint's detents", [](Scene& s) { s.joints[0].detents.places = {0.2, 0.1}; });
  refuses("a joint's axes", [](Scene& s) { s.joints[0].limits[0].axes = 8; });
  refuses("a shape's material", [](Scene& s) {
    s.parts[0].shapes.resize(1);
    s.parts[0].shapes[0].material = 3;
  });
  refuses("no material", [](Scene& s) { s.materials.clear(); });
  refuses("a mass", [](Scene& s) { s.parts[0].massProperties.mass = -1.0; });
}

TEST(ContentHash, IsBlake2b256) {
  // The empty string's, from RFC 7693's algorithm (b2sum -l 256 /dev/null).
  EXPECT_EQ(toHex(contentHash({})), "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
}

}  // namespace
}  // namespace tandem::assets
