#include "assets/gltf/load_gltf.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>
#include <glm/geometric.hpp>

#include "assets/scene/scene_check.h"
#include "tests/assets/gltf/findings.h"
#include "tests/support/gltf_builder.h"

namespace tandem::assets {
namespace {

using tests::GltfBuilder;
using Json = nlohmann::json;

Result<Scene> load(const GltfBuilder& builder, const LoadOptions& options = {}) {
  Result<Scene> scene = loadGltfFromMemory("test.glb", builder.glb(), options);
  if (scene) {
    const Status status = checkScene(*scene);
    EXPECT_TRUE(status.ok()) << status.error().message;
  }
  return scene;
}

Scene loadedFrom(const GltfBuilder& builder, const LoadOptions& options = {}) {
  Result<Scene> scene = load(builder, options);
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return scene ? std::move(scene).value() : Scene{};
}

/// The message of a refusal; it must be one line that begins with the file's name.
std::string refusal(const Result<Scene>& scene) {
  if (scene) return "loaded";
  EXPECT_EQ(scene.error().message.find('\n'), std::string::npos) << scene.error().message;
  return scene.error().message;
}

void expectRefused(const GltfBuilder& builder, const std::string& part) {
  const std::string message = refusal(load(builder));
  EXPECT_EQ(message.rfind("test.glb: ", 0), 0u) << message;
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

/// Volume enclosed by a part's triangles in the world, by the divergence theorem; negative if inside out.
double worldVolume(const Scene& scene, const Part& part) {
  double volume = 0.0;
  const Mesh& mesh = scene.meshes[part.mesh];
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 a = transformPoint(part.worldFromPart, mesh.positions[t[0]]);
    const glm::dvec3 b = transformPoint(part.worldFromPart, mesh.positions[t[1]]);
    const glm::dvec3 c = transformPoint(part.worldFromPart, mesh.positions[t[2]]);
    volume += glm::dot(a, glm::cross(b, c)) / 6.0;
  }
  return volume;
}

GltfBuilder oneBox() {
  GltfBuilder b;
  b.addNode({{"mesh", b.addBox(1, 2, 3, "box")}});
  return b;
}

// --- what is read
// ---------------------------------------------------------------------------------------------

TEST(LoadGltf, ReadsABoxFromGlb) {
  const Scene scene = loadedFrom(oneBox());
  ASSERT_EQ(scene.parts.size(), 1u);
  EXPECT_EQ(scene.parts[0].name, "box");
  EXPECT_FALSE(scene.parts[0].movable);
  EXPECT_EQ(triangleCount(scene), 12u);
  EXPECT_TRUE(scene.meshes[0].closed);
  EXPECT_NEAR(worldVolume(scene, scene.parts[0]), 6.0, 1e-12);
  EXPECT_NEAR(scene.bounds.max.z, 1.5, 1e-12);
}

TEST(LoadGltf, ReadsDataUris) {
  const Result<Scene> scene = loadGltfFromMemory("box.gltf", oneBox().gltf(), {});
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(triangleCount(*scene), 12u);
}

TEST(LoadGltf, ReadsPrimitivesWithoutIndices) {
  GltfBuilder b;
  b.addNode({{"mesh", b.addMesh(b.addPositions({0, 0, 0, 1, 0, 0, 0, 1, 0}))}});
  EXPECT_EQ(triangleCount(loadedFrom(b)), 1u);
}

TEST(LoadGltf, ReadsStripsAndFansWithTheirWinding) {
  for (const int mode : {5, 6}) {
    GltfBuilder b;
    const std::vector<float> strip{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    const std::vector<float> fan{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    b.addNode({{"mesh", b.addMesh(b.addPositions(mode == 5 ? strip : fan), -1, mode)}});
    const Scene scene = loadedFrom(b);
    ASSERT_EQ(triangleCount(scene), 2u);
    const Mesh& mesh = scene.meshes[0];
    for (const auto& t : mesh.triangles) {
      const glm::dvec3 normal = glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                           mesh.positions[t[2]] - mesh.positions[t[0]]);
      EXPECT_GT(normal.z, 0.0) << "mode " << mode;
    }
  }
}

TEST(LoadGltf, SkipsPointsAndLinesWithAFinding) {
  GltfBuilder b = oneBox();
  Json line = b.json["meshes"][0]["primitives"][0];
  line["mode"] = 1;
  b.json["meshes"][0]["primitives"].push_back(line);
  const Scene scene = loadedFrom(b);
  EXPECT_EQ(triangleCount(scene), 12u);
  ASSERT_NE(findingOf(scene, "points-and-lines"), nullptr);
  EXPECT_EQ(findingOf(scene, "points-and-lines")->count, 1u);
}

TEST(LoadGltf, ReadsByteAndShortIndices) {
  for (const bool bytes : {true, false}) {
    GltfBuilder b = oneBox();
    std::vector<std::uint8_t> u8;
    std::vector<std::uint16_t> u16;
    for (const std::uint32_t i : GltfBuilder::boxIndices()) {
      u8.push_back(static_cast<std::uint8_t>(i));
      u16.push_back(static_cast<std::uint16_t>(i));
    }
    const int indices = bytes ? b.addAccessor(u8, 5121, "SCALAR", 1) : b.addAccessor(u16, 5123, "SCALAR", 1);
    b.json["meshes"][0]["primitives"][0]["indices"] = indices;
    EXPECT_NEAR(worldVolume(loadedFrom(b), loadedFrom(b).parts[0]), 6.0, 1e-12);
  }
}

TEST(LoadGltf, ReadsInterleavedPositions) {
  GltfBuilder b;
  const int view = b.addView(std::vector<float>{9, 9, 9, 0, 0, 0, 9, 9, 9, 1, 0, 0, 9, 9, 9, 0, 1, 0});
  b.json["bufferViews"][view]["byteStride"] = 24;
  b.json["accessors"].push_back(
      {{"bufferView", view}, {"byteOffset", 12}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  b.addNode({{"mesh", b.addMesh(0)}});
  const Scene scene = loadedFrom(b);
  EXPECT_EQ(scene.bounds.max, glm::dvec3(1, 1, 0));
}

TEST(LoadGltf, ReadsSparseAccessorsWithAndWithoutABase) {
  GltfBuilder b;
  const int base = b.addPositions({0, 0, 0, 1, 0, 0, 5, 5, 5});
  const int indices = b.addView(std::vector<std::uint16_t>{2});
  const int values = b.addView(std::vector<float>{0, 1, 0});
  b.json["accessors"][base]["sparse"] = {{"count", 1},
                                         {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                         {"values", {{"bufferView", values}}}};
  const int bareIndices = b.addView(std::vector<std::uint8_t>{1, 2});
  const int bareValues = b.addView(std::vector<float>{3, 0, 0, 0, 3, 0});
  b.json["accessors"].push_back({{"componentType", 5126},
                                 {"count", 3},
                                 {"type", "VEC3"},
                                 {"sparse",
                                  {{"count", 2},
                                   {"indices", {{"bufferView", bareIndices}, {"componentType", 5121}}},
                                   {"values", {{"bufferView", bareValues}}}}}});
  b.addNode({{"mesh", b.addMesh(base)}, {"name", "base"}});
  b.addNode({{"mesh", b.addMesh(1)}, {"name", "bare"}});
  const Scene scene = loadedFrom(b);
  ASSERT_EQ(scene.parts.size(), 2u);
  EXPECT_EQ(scene.meshes[scene.parts[0].mesh].bounds.max, glm::dvec3(1, 1, 0));
  EXPECT_EQ(scene.meshes[scene.parts[1].mesh].bounds.max, glm::dvec3(3, 3, 0));
}

TEST(LoadGltf, ReadsQuantizedPositions) {
  GltfBuilder b;
  const int normalized =
      b.addAccessor(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 0, 0, -32768, 0}, 5122, "VEC3", 3);
  b.json["accessors"][normalized]["normalized"] = true;
  const int plain = b.addAccessor(std::vector<std::uint8_t>{0, 0, 0, 200, 0, 0, 0, 100, 0}, 5121, "VEC3", 3);
  b.addNode({{"mesh", b.addMesh(normalized)}});
  b.addNode({{"mesh", b.addMesh(plain)}});
  b.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const Scene scene = loadedFrom(b);
  EXPECT_EQ(scene.meshes[scene.parts[0].mesh].bounds.max, glm::dvec3(1, 0, 0));
  EXPECT_EQ(scene.meshes[scene.parts[0].mesh].bounds.min, glm::dvec3(0, -1, 0));
  EXPECT_EQ(scene.meshes[scene.parts[1].mesh].bounds.max, glm::dvec3(200, 100, 0));
}

TEST(LoadGltf, KeepsMaterialsPerTriangle) {
  GltfBuilder b = oneBox();
  b.json["materials"] = {
      {{"name", "red"},
       {"pbrMetallicRoughness", {{"baseColorFactor", {1, 0, 0, 1}}, {"metallicFactor", 0.25}}}},
      {{"name", "plain"}}};
  b.json["meshes"][0]["primitives"][0]["material"] = 0;
  const int more = b.addPositions({5, 0, 0, 6, 0, 0, 5, 1, 0});
  b.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", more}}}, {"material", 1}});
  const Scene scene = loadedFrom(b);
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.triangles.size(), 13u);
  for (std::size_t t = 0; t < 13; ++t) {
    const bool extra = mesh.positions[mesh.triangles[t][0]].x > 2.0;
    EXPECT_EQ(scene.materials[mesh.triangleMaterial[t]].name, extra ? "plain" : "red");
  }
  EXPECT_FLOAT_EQ(scene.materials[mesh.triangleMaterial[0]].baseColour[1], 0.0f);
  EXPECT_FLOAT_EQ(scene.materials[mesh.triangleMaterial[0]].metallic, 0.25f);
}

// --- transforms
// -----------------------------------------------------------------------------------------------

TEST(LoadGltf, BakesScalesAndShearsSoThatPartsAreRigid) {
  GltfBuilder b;
  const int box = b.addBox(1, 1, 1, "box");
  const int child = b.addOrphan(
      {{"mesh", box}, {"rotation", {0.0, 0.0, std::sin(0.3), std::cos(0.3)}}, {"translation", {1, 0, 0}}});
  b.addNode(
      {{"children", {child}}, {"scale", {2, 1, 0.5}}, {"rotation", {std::sin(0.2), 0, 0, std::cos(0.2)}}});
  const Scene scene = loadedFrom(b);
  const Part& part = scene.parts[0];
  EXPECT_TRUE(isValid(part.worldFromPart));
  EXPECT_NEAR(worldVolume(scene, part), 1.0, 1e-12);
  // A corner, carried by hand: parent's rotation, its scale, the child's rotation and translation.
  const double c = std::cos(0.6), s = std::sin(0.6), ca = std::cos(0.4), sa = std::sin(0.4);
  const glm::dvec3 scaled(2 * (c * 0.5 - s * 0.5 + 1), s * 0.5 + c * 0.5, 0.5 * 0.5);
  const glm::dvec3 expected(scaled.x, ca * scaled.y - sa * scaled.z, sa * scaled.y + ca * scaled.z);
  double nearest = 1e9;
  for (const glm::dvec3& p : scene.meshes[part.mesh].positions)
    nearest = std::min(nearest, glm::length(transformPoint(part.worldFromPart, p) - expected));
  EXPECT_LT(nearest, 1e-12);
}

TEST(LoadGltf, TurnsTheWindingOfMirroredParts) {
  for (const glm::dvec3& scale : {glm::dvec3(-1, 1, 1), glm::dvec3(-2, -1, -1), glm::dvec3(-1, -1, 1)}) {
    GltfBuilder b = oneBox();
    b.json["nodes"][0]["scale"] = {scale.x, scale.y, scale.z};
    const Scene scene = loadedFrom(b);
    EXPECT_NEAR(worldVolume(scene, scene.parts[0]), 6.0 * std::abs(scale.x * scale.y * scale.z), 1e-9);
    // Turned by the loader, which knows the mirror, not found out afterwards by the analysis.
    EXPECT_EQ(findingOf(scene, "inverted-shells"), nullptr);
  }
}

TEST(LoadGltf, SharesOneMeshAmongInstancesThatDifferOnlyRigidly) {
  GltfBuilder b;
  const int box = b.addBox(1, 2, 3, "bolt");
  for (int i = 0; i < 5; ++i) {
    const float a = 0.37f * static_cast<float>(i);
    // As exporters write it: a matrix of floats.
    b.addNode(
        {{"mesh", box},
         {"matrix",
          {std::cos(a), std::sin(a), 0, 0, -std::sin(a), std::cos(a), 0, 0, 0, 0, 1, 0, i * 10, 0, 0, 1}}});
  }
  b.addNode({{"mesh", box}, {"scale", {2, 2, 2}}});
  const Scene scene = loadedFrom(b);
  EXPECT_EQ(scene.parts.size(), 6u);
  EXPECT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.parts[4].mesh, scene.parts[0].mesh);
  EXPECT_NE(scene.parts[5].mesh, scene.parts[0].mesh);
  EXPECT_EQ(triangleCount(scene), 72u);
}

TEST(LoadGltf, ScalesUnits) {
  LoadOptions options;
  options.unitScale = parseUnits("mm").value();
  const Scene scene = loadedFrom(oneBox(), options);
  EXPECT_NEAR(scene.bounds.max.z, 0.0015, 1e-15);
  EXPECT_FALSE(parseUnits("parsec").ok());
  EXPECT_EQ(parseUnits("inch").value(), 0.0254);
}

TEST(LoadGltf, LeavesOutNodesWithoutThickness) {
  GltfBuilder b = oneBox();
  b.addNode({{"mesh", 0}, {"scale", {1, 0, 1}}, {"name", "flat"}});
  const Scene scene = loadedFrom(b);
  EXPECT_EQ(scene.parts.size(), 1u);
  EXPECT_NE(findingOf(scene, "flattened-node"), nullptr);
}

// --- names, movable parts
// -------------------------------------------------------------------------------------

TEST(LoadGltf, MakesNamesUniqueAndListsTheTree) {
  GltfBuilder b;
  const int box = b.addBox(1, 1, 1, "bolt");
  const int a = b.addOrphan({{"mesh", box}, {"translation", {5, 0, 0}}});
  const int c = b.addOrphan({{"mesh", box}, {"translation", {9, 0, 0}}});
  b.addNode({{"name", "group"}, {"children", {a, c}}});
  const Scene scene = loadedFrom(b);
  ASSERT_EQ(scene.parts.size(), 2u);
  EXPECT_EQ(scene.parts[0].name, "bolt");
  EXPECT_EQ(scene.parts[1].name, "bolt #2");
  EXPECT_EQ(findPart(scene, "bolt #2"), 1);
  ASSERT_EQ(scene.tree.size(), 3u);
  EXPECT_EQ(scene.tree[0].name, "group");
  EXPECT_EQ(scene.tree[scene.parts[1].treeNode].parent, 0u);
}

TEST(LoadGltf, MakesNamesFitForOneLine) {
  // A scene whose names its own package would refuse could be loaded but never sent.
  GltfBuilder b = oneBox();
  b.json["nodes"][0]["name"] = "two\nlines";
  b.addNode({{"name", std::string(5000, 'x')}});
  b.json["extensionsUsed"] = {"ACME\twobble"};
  const Scene scene = loadedFrom(b);
  EXPECT_EQ(scene.parts[0].name, "two_lines");
  EXPECT_EQ(scene.tree[0].name, "two_lines");
  EXPECT_EQ(scene.tree[1].name.size(), 200u);
  b.json["extensionsRequired"] = {"ACME\nwobble"};
  expectRefused(b, "ACME_wobble");
}

TEST(LoadGltf, MakesNamedPartsMovableWithMassFromDensity) {
  LoadOptions options;
  options.movable = {"box"};
  options.density = 1000.0;
  const Scene scene = loadedFrom(oneBox(), options);
  ASSERT_TRUE(scene.parts[0].movable);
  EXPECT_NEAR(scene.parts[0].massProperties.mass, 6000.0, 1e-6);
  EXPECT_NEAR(scene.parts[0].massProperties.inertia[0][0], 6000.0 / 12.0 * (4 + 9), 1e-6);
}

TEST(LoadGltf, TakesTheDensityOfANodeOrOfTheNearestAboveIt) {
  const auto density = [](Json value) { return Json{{"cad", {{"density", std::move(value)}}}}; };
  GltfBuilder b;
  const int box = b.addBox(1, 2, 3);
  const int own = b.addOrphan({{"name", "steel"}, {"mesh", box}, {"extras", density(7850.0)}});
  const int above = b.addOrphan({{"name", "brass"}, {"mesh", box}});
  b.addNode({{"children", {own, above}}, {"extras", density(8500.0)}});
  for (const Json& none : {Json("heavy"), Json(-1.0), Json(1e300), Json(nullptr)})
    b.addNode({{"name", "none"}, {"mesh", box}, {"extras", density(none)}});
  LoadOptions options;
  options.allMovable = true;
  const Scene scene = loadedFrom(b, options);
  ASSERT_EQ(scene.parts.size(), 6u);
  for (const Part& part : scene.parts) {
    const double stated = part.name == "steel" ? 7850.0 : part.name == "brass" ? 8500.0 : options.density;
    EXPECT_NEAR(part.massProperties.mass, 6.0 * stated, 1e-6) << part.name;
    EXPECT_NEAR(part.massProperties.inertia[0][0], 6.0 * stated / 12.0 * (4 + 9), 1e-6) << part.name;
  }
}

TEST(LoadGltf, NamesNearPartsWhenAMovableOneDoesNotExist) {
  LoadOptions options;
  options.movable = {"bax"};
  const std::string message = refusal(load(oneBox(), options));
  EXPECT_NE(message.find("'bax'"), std::string::npos) << message;
  EXPECT_NE(message.find("'box'"), std::string::npos) << message;
}

TEST(LoadGltf, IsTheSameOnEveryRun) {
  GltfBuilder b;
  for (int i = 1; i < 20; ++i) b.addNode({{"mesh", b.addBox(float(i), 1, 1)}});
  const Scene first = loadedFrom(b), second = loadedFrom(b);
  ASSERT_EQ(first.meshes.size(), 19u);
  for (std::size_t i = 0; i < first.meshes.size(); ++i) {
    EXPECT_EQ(first.meshes[i].positions, second.meshes[i].positions);
    EXPECT_EQ(first.meshes[i].triangles, second.meshes[i].triangles);
  }
}

// --- what is refused
// ------------------------------------------------------------------------------------------

TEST(LoadGltfRefuses, ATruncatedFileAtEveryByte) {
  const std::vector<unsigned char> whole = oneBox().glb();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Result<Scene> scene =
        loadGltfFromMemory("cut.glb", {whole.begin(), whole.begin() + static_cast<long>(size)}, {});
    ASSERT_FALSE(scene.ok()) << size;
  }
}

TEST(LoadGltfRefuses, IndicesOutOfRange) {
  GltfBuilder b = oneBox();
  std::vector<std::uint32_t> indices = GltfBuilder::boxIndices();
  indices[7] = 8;
  b.json["meshes"][0]["primitives"][0]["indices"] = b.addIndices(indices);
  expectRefused(b, "meshes[0].primitives[0].indices: index 8 at 7 is out of range");
}

TEST(LoadGltfRefuses, ReferencesOutOfRange) {
  const auto broken = [](const char* pointer, const Json& value, const std::string& place) {
    GltfBuilder b = oneBox();
    b.json[Json::json_pointer(pointer)] = value;
    expectRefused(b, place);
  };
  broken("/nodes/0/mesh", 7, "nodes[0].mesh: index 7 is out of range (1 meshes)");
  broken("/nodes/0/mesh", -1, "nodes[0].mesh: -1 is negative");
  broken("/nodes/0/mesh", "x", "nodes[0].mesh: must be a whole number");
  broken("/nodes/0/children", {5}, "nodes[0].children[0]");
  broken("/scenes/0/nodes", {3}, "scenes[0].nodes[0]");
  broken("/scene", 2, "scene: index 2");
  broken("/meshes/0/primitives/0/indices", 99, "meshes[0].primitives[0].indices");
  broken("/meshes/0/primitives/0/attributes/POSITION", 99, "attributes.POSITION");
  broken("/meshes/0/primitives/0/material", 0, "primitives[0].material");
  broken("/accessors/0/bufferView", 9, "accessors[0].bufferView");
  broken("/bufferViews/0/buffer", 1, "bufferViews[0].buffer");
}

TEST(LoadGltfRefuses, CountsThatTheBytesCannotHold) {
  const auto broken = [](const char* pointer, const Json& value, const std::string& place) {
    GltfBuilder b = oneBox();
    b.json[Json::json_pointer(pointer)] = value;
    expectRefused(b, place);
  };
  broken("/accessors/0/count", 2147483648u, "accessors[0].count: 2147483648 is too large");
  broken("/accessors/0/count", 2147483647, "accessors[0]: 2147483647 elements do not fit");
  broken("/accessors/0/count", 9, "accessors[0]: 9 elements do not fit");
  broken("/accessors/0/byteOffset", 4, "accessors[0]");
  broken("/bufferViews/1/byteLength", 100000, "bufferViews[1]: reaches past the end");
  broken("/bufferViews/1/byteOffset", 2147483647, "bufferViews[1]: reaches past the end");
  broken("/buffers", Json::array({{{"byteLength", 100000}}}), "buffers[0]: holds");
}

TEST(LoadGltfRefuses, ZerosFromNowhere) {
  GltfBuilder b = oneBox();
  const int view = b.addView(std::vector<std::uint8_t>{0});
  b.json["accessors"].push_back({{"componentType", 5126},
                                 {"count", 2000000000},
                                 {"type", "VEC3"},
                                 {"sparse",
                                  {{"count", 0},
                                   {"indices", {{"bufferView", view}, {"componentType", 5121}}},
                                   {"values", {{"bufferView", view}}}}}});
  b.json["meshes"][0]["primitives"][0] = {{"attributes", {{"POSITION", 2}}}};
  const std::string message = refusal(load(b));
  EXPECT_NE(message.find("accessors[2]: 2000000000 elements do not fit"), std::string::npos) << message;
}

TEST(LoadGltfRefuses, PositionsThatAreNotFinite) {
  for (const float bad : {std::nanf(""), INFINITY}) {
    GltfBuilder b;
    b.addNode({{"mesh", b.addMesh(b.addPositions({0, 0, 0, 1, bad, 0, 0, 1, 0}))}});
    expectRefused(b, "accessors[0]: position 1 is not finite");
  }
}

TEST(LoadGltfRefuses, TransformsThatAreNotFinite) {
  GltfBuilder b = oneBox();
  b.json["nodes"][0]["scale"] = {1e308, 1e308, 1};
  const int child = b.addOrphan({{"mesh", 0}, {"scale", {1e308, 1, 1}}});
  b.json["nodes"][0]["children"] = {child};
  expectRefused(b, "nodes[1]: the transform is not finite");
  GltfBuilder zero = oneBox();
  zero.json["nodes"][0]["rotation"] = {0, 0, 0, 0};
  expectRefused(zero, "nodes[0].rotation");
  GltfBuilder far = oneBox();
  far.json["nodes"][0]["scale"] = {1e12, 1, 1};
  expectRefused(far, "farther than 1e9 m");
}

TEST(LoadGltfRefuses, CyclesAndSecondParents) {
  GltfBuilder self = oneBox();
  const int a = self.addOrphan({{"name", "a"}}), b = self.addOrphan({{"name", "b"}});
  self.json["nodes"][a]["children"] = {b};
  self.json["nodes"][b]["children"] = {a};
  expectRefused(self, "cycle");
  GltfBuilder own = oneBox();
  own.json["nodes"][0]["children"] = {0};
  expectRefused(own, "nodes[0]");
  GltfBuilder two = oneBox();
  const int child = two.addOrphan({{"name", "c"}});
  two.addNode({{"children", {child}}});
  two.addNode({{"children", {child}}});
  expectRefused(two, "second parent");
  GltfBuilder twice = oneBox();
  twice.json["scenes"][0]["nodes"] = {0, 0};
  expectRefused(twice, "listed twice");
}

TEST(LoadGltf, SurvivesADeepHierarchy) {
  GltfBuilder b;
  const int box = b.addBox(1, 1, 1);
  constexpr int kDepth = 20000;
  for (int i = 0; i + 1 < kDepth; ++i) b.addOrphan({{"children", {i + 1}}});
  b.addOrphan({{"mesh", box}});
  b.json["scenes"][0]["nodes"] = {0};
  EXPECT_EQ(loadedFrom(b).tree.size(), std::size_t{kDepth});
}

TEST(LoadGltfRefuses, DeeplyNestedJson) {
  const std::string text = "{\"asset\":{\"version\":\"2.0\"},\"extras\":" + std::string(100000, '[') +
                           std::string(100000, ']') + "}";
  const std::string message = refusal(loadGltfFromMemory("deep.gltf", {text.begin(), text.end()}, {}));
  EXPECT_NE(message.find("nested deeper"), std::string::npos) << message;
}

TEST(LoadGltfRefuses, BrokenJsonAndOtherVersions) {
  const auto message = [](const std::string& text) {
    return refusal(loadGltfFromMemory("f.gltf", {text.begin(), text.end()}, {}));
  };
  EXPECT_NE(message("{\"asset\":").find("f.gltf: json: "), std::string::npos);
  EXPECT_NE(message("[]").find("not an object"), std::string::npos);
  EXPECT_NE(message("{\"asset\":{\"version\":\"1.0\"}}").find("asset.version"), std::string::npos);
  EXPECT_NE(message("{\"asset\":{\"version\":\"2.0\"},\"nodes\":{}}").find("nodes: must be an array"),
            std::string::npos);
  EXPECT_NE(message("{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"scale\":[1,1e999,1]}]}").find("json"),
            std::string::npos);
  EXPECT_NE(message("{\"asset\":{\"version\":\"2.0\"}}").find("no triangles"), std::string::npos);
  EXPECT_NE(message("").find("empty"), std::string::npos);
}

TEST(LoadGltfRefuses, RequiredExtensionsByName) {
  GltfBuilder b = oneBox();
  b.json["extensionsRequired"] = {"ACME_wobble"};
  expectRefused(b, "ACME_wobble");
  b.json.erase("extensionsRequired");
  b.json["extensionsUsed"] = {"ACME_wobble"};
  ASSERT_NE(findingOf(loadedFrom(b), "unknown-extension"), nullptr);
}

TEST(LoadGltfRefuses, BadOptions) {
  for (const double scale : {0.0, -1.0, std::nan(""), double{INFINITY}}) {
    LoadOptions options;
    options.unitScale = scale;
    EXPECT_NE(refusal(load(oneBox(), options)).find("unit scale"), std::string::npos);
  }
  LoadOptions few;
  few.maxTriangles = 5;
  EXPECT_NE(refusal(load(oneBox(), few)).find("more than 5 triangles"), std::string::npos);
}

TEST(LoadGltfRefuses, MoreJsonThanTheLimitWithoutReadingIt) {
  for (const std::size_t limit : {1u << 20, 3u << 20}) {
    LoadOptions options;
    options.maxJsonBytes = limit;
    // Numbers, short texts and what is no JSON at all count; the contents of long texts do not.
    for (const std::string& part : {std::string("0,"), std::string("\"some\\\"text\","), std::string("[")}) {
      std::string text = "[";
      while (text.size() <= limit) text += part;
      const std::string message =
          refusal(loadGltfFromMemory("big.gltf", {text.begin(), text.end()}, options));
      EXPECT_NE(message.find("at most " + std::to_string(limit >> 20) + " are read (--max-json)"),
                std::string::npos)
          << message;
    }
    GltfBuilder b = oneBox();
    b.json["extras"] = std::string(2 * limit, 'x');
    EXPECT_TRUE(load(b, options).ok());
    b.json["extras"] = std::vector<int>(limit / 2, 1);
    EXPECT_NE(refusal(load(b, options)).find("--max-json"), std::string::npos);
    options.maxJsonBytes = 2 * limit;
    EXPECT_TRUE(load(b, options).ok());
  }
}

TEST(LoadGltf, SaysHowMuchOfTheJsonIsRead) {
  GltfBuilder b = oneBox();
  b.json["extras"] = std::vector<int>(3 << 20, 1);
  LoadOptions options;
  std::vector<double> shares;
  options.progress = [&](double share, const char* what) {
    if (std::string(what) == "reading the JSON") shares.push_back(share);
  };
  ASSERT_TRUE(load(b, options).ok());
  EXPECT_GE(shares.size(), 6u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_LE(shares.back(), 0.05);
}

TEST(LoadGltf, NeverLooksAtImages) {
  GltfBuilder b = oneBox();
  b.json["images"] = {{{"uri", "missing.png"}}, {{"bufferView", 99}, {"mimeType", "image/png"}}, 7};
  b.json["textures"] = {{{"source", 0}}};
  b.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  EXPECT_EQ(triangleCount(loadedFrom(b)), 12u);
}

// --- files
// ----------------------------------------------------------------------------------------------------

class LoadGltfFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    directory_ =
        std::filesystem::temp_directory_path() / ("tandem_load_gltf_" + name + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_ / "scene");
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string write(const std::string& name, const std::vector<unsigned char>& bytes) {
    const std::filesystem::path path = directory_ / name;
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
    return path.string();
  }

  Result<Scene> loadWithUri(const std::string& uri) {
    GltfBuilder b = oneBox();
    b.json["buffers"] = Json::array({{{"byteLength", b.binary.size()}, {"uri", uri}}});
    return loadGltf(write("scene/box.gltf", b.gltf()), {});
  }

  std::filesystem::path directory_;
};

TEST_F(LoadGltfFiles, ReadsExternalBuffersBesideTheFile) {
  write("scene/my data.bin", oneBox().binary);
  const Result<Scene> scene = loadWithUri("my%20data.bin");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(triangleCount(*scene), 12u);
}

TEST_F(LoadGltfFiles, RefusesMissingAndShortBuffers) {
  EXPECT_NE(refusal(loadWithUri("missing.bin")).find("does not exist"), std::string::npos);
  write("scene/short.bin", {1, 2, 3});
  EXPECT_NE(refusal(loadWithUri("short.bin")).find("buffers[0]: holds 3"), std::string::npos);
}

TEST_F(LoadGltfFiles, RefusesPathsOutOfTheDirectory) {
  write("secret.bin", oneBox().binary);
  for (const std::string uri :
       {"../secret.bin", "a/../../secret.bin", "%2e%2e/secret.bin", "/etc/passwd", "file:///etc/passwd",
        "http://localhost/x", "..\\secret.bin", "%2Fetc%2Fpasswd", ""})
    EXPECT_NE(refusal(loadWithUri(uri)).find("does not lie in the directory"), std::string::npos) << uri;
}

TEST_F(LoadGltfFiles, CachesBySceneContentAndOptions) {
  const std::string path = write("box.glb", oneBox().glb());
  const std::string cache = (directory_ / "cache").string();
  const auto files = [&] {
    std::vector<std::filesystem::path> out;
    for (const auto& entry : std::filesystem::directory_iterator(cache)) out.push_back(entry.path());
    return out;
  };
  bool fromCache = false;
  LoadOptions options;
  options.progress = [&](double, const char* what) {
    fromCache = fromCache || std::string(what) == "read from the cache";
  };
  ASSERT_TRUE(loadScene(path, options, cache).ok());
  EXPECT_FALSE(fromCache);
  ASSERT_EQ(files().size(), 1u);
  const Result<Scene> warm = loadScene(path, options, cache);
  EXPECT_TRUE(fromCache);
  EXPECT_EQ(triangleCount(*warm), 12u);

  options.unitScale = 0.001;
  fromCache = false;
  EXPECT_NEAR(loadScene(path, options, cache)->bounds.max.z, 0.0015, 1e-15);
  EXPECT_FALSE(fromCache);
  EXPECT_EQ(files().size(), 2u);
}

TEST_F(LoadGltfFiles, IgnoresADamagedCacheAndWritesItAnew) {
  const std::string path = write("box.glb", oneBox().glb());
  const std::string cache = (directory_ / "cache").string();
  ASSERT_TRUE(loadScene(path, {}, cache).ok());
  const std::filesystem::path file = std::filesystem::directory_iterator(cache)->path();
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  const Result<Scene> scene = loadScene(path, {}, cache);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(triangleCount(*scene), 12u);
  bool fromCache = false;
  LoadOptions options;
  options.progress = [&](double, const char* what) {
    fromCache = fromCache || std::string(what) == "read from the cache";
  };
  ASSERT_TRUE(loadScene(path, options, cache).ok());
  EXPECT_TRUE(fromCache);
}

TEST_F(LoadGltfFiles, RefusesDirectoriesAndMissingFiles) {
  EXPECT_FALSE(loadGltf(directory_.string(), {}).ok());
  EXPECT_NE(refusal(loadGltf((directory_ / "none.glb").string(), {})).find("does not exist"),
            std::string::npos);
}

// --- real CAD
// -------------------------------------------------------------------------------------------------

TEST(LoadGltfRealCad, ReadsTheEngine) {
  const char* data = std::getenv("TANDEM_DATA");
  if (data == nullptr) GTEST_SKIP() << "TANDEM_DATA is not set";
  LoadOptions options;
  options.unitScale = 0.001;
  options.allMovable = true;
  const Result<Scene> scene = loadGltf(std::string(data) + "/2CylinderEngine.glb", options);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->parts.size(), 67u);
  EXPECT_EQ(scene->meshes.size(), 29u);
  EXPECT_EQ(scene->tree.size(), 82u);
  EXPECT_TRUE(checkScene(*scene).ok());
  for (const Part& part : scene->parts) EXPECT_TRUE(part.movable) << part.name;
}

}  // namespace
}  // namespace tandem::assets
