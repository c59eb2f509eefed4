#include <random>

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "assets/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"

namespace tandem::assets {
namespace {

using tests::GltfBuilder;
using Json = nlohmann::json;
using Bytes = std::vector<unsigned char>;

/// The tetrahedron that both codecs are given.
const std::vector<float> kCorners{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
const std::vector<std::uint32_t> kFaces{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

struct DracoFile {
  GltfBuilder builder;
  Bytes data;
};

Bytes dracoTetrahedron(int& positionId) {
  draco::TriangleSoupMeshBuilder soup;
  soup.Start(4);
  const int attribute = soup.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (std::uint32_t f = 0; f < 4; ++f)
    soup.SetAttributeValuesForFace(attribute, draco::FaceIndex(f), &kCorners[kFaces[f * 3] * 3],
                                   &kCorners[kFaces[f * 3 + 1] * 3], &kCorners[kFaces[f * 3 + 2] * 3]);
  const auto mesh = soup.Finalize();
  positionId = static_cast<int>(mesh->attribute(attribute)->unique_id());
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.data() + buffer.size()};
}

GltfBuilder dracoFile(const Bytes& data, int positionId) {
  GltfBuilder b;
  const int view = b.addView(data);
  b.json["accessors"] = {{{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
                         {{"componentType", 5125}, {"count", 12}, {"type", "SCALAR"}}};
  b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}};
  b.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", positionId}}}};
  b.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  b.addNode({{"mesh", 0}});
  return b;
}

GltfBuilder meshoptFile(const Bytes& vertices, const Bytes& indices) {
  GltfBuilder b;
  b.addView(vertices);
  b.addView(indices);
  Json& views = b.json["bufferViews"];
  const auto compress = [&](int view, std::size_t count, std::size_t stride, const char* mode) {
    Json extension = views[view];
    extension["count"] = count;
    extension["byteStride"] = stride;
    extension["mode"] = mode;
    views[view] = {{"buffer", 1},
                   {"byteLength", count * stride},
                   {"extensions", {{"EXT_meshopt_compression", extension}}}};
  };
  compress(0, 4, 12, "ATTRIBUTES");
  compress(1, 12, 4, "TRIANGLES");
  b.json["buffers"] = {
      {{"byteLength", b.binary.size()}},
      {{"byteLength", 96}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  b.json["accessors"] = {{{"bufferView", 0}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
                         {{"bufferView", 1}, {"componentType", 5125}, {"count", 12}, {"type", "SCALAR"}}};
  b.addNode({{"mesh", b.addMesh(0, 1)}});
  b.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  return b;
}

Bytes meshoptVertices() {
  Bytes out(meshopt_encodeVertexBufferBound(4, 12));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), kCorners.data(), 4, 12));
  return out;
}

Bytes meshoptIndices() {
  Bytes out(meshopt_encodeIndexBufferBound(12, 4));
  out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), kFaces.data(), 12));
  return out;
}

void expectTetrahedron(const Result<Scene>& scene) {
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(triangleCount(*scene), 4u);
  EXPECT_TRUE(scene->meshes[0].closed);
  EXPECT_NEAR(scene->meshes[0].volume, 1.0 / 6.0, 1e-4);
}

TEST(GltfDecode, ReadsDraco) {
  int id = 0;
  const Bytes data = dracoTetrahedron(id);
  expectTetrahedron(loadGltfFromMemory("draco.glb", dracoFile(data, id).glb(), {}));
}

TEST(GltfDecode, ReadsMeshoptThroughAFallbackBuffer) {
  expectTetrahedron(
      loadGltfFromMemory("meshopt.glb", meshoptFile(meshoptVertices(), meshoptIndices()).glb(), {}));
}

TEST(GltfDecode, RefusesOrSurvivesDamagedDraco) {
  int id = 0;
  const Bytes whole = dracoTetrahedron(id);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(
        loadGltfFromMemory("cut.glb",
                           dracoFile({whole.begin(), whole.begin() + static_cast<long>(size)}, id).glb(), {})
            .ok())
        << size;
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    Bytes damaged = whole;
    damaged[random() % damaged.size()] ^= static_cast<unsigned char>(1u << random() % 8);
    (void)loadGltfFromMemory("damaged.glb", dracoFile(damaged, id).glb(), {}).ok();
  }
}

TEST(GltfDecode, RefusesOrSurvivesDamagedMeshopt) {
  const Bytes vertices = meshoptVertices(), indices = meshoptIndices();
  for (std::size_t size = 1; size < vertices.size(); ++size)
    EXPECT_FALSE(
        loadGltfFromMemory(
            "cut.glb",
            meshoptFile({vertices.begin(), vertices.begin() + static_cast<long>(size)}, indices).glb(), {})
            .ok());
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    Bytes damaged = indices;
    damaged[random() % damaged.size()] ^= static_cast<unsigned char>(1u << random() % 8);
    (void)loadGltfFromMemory("damaged.glb", meshoptFile(vertices, damaged).glb(), {}).ok();
  }
}

TEST(GltfDecode, RefusesMeshoptThatClaimsTooMuch) {
  GltfBuilder b = meshoptFile(meshoptVertices(), meshoptIndices());
  b.json["bufferViews"][0]["byteLength"] = 1200000000;
  b.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] = 100000000;
  const Result<Scene> scene = loadGltfFromMemory("bomb.glb", b.glb(), {});
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("claims more data"), std::string::npos) << scene.error().message;
}

}  // namespace
}  // namespace tandem::assets
