// What extras.haptic may say about a surface: every property, its range, and what is refused.

#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "assets/generate/grey_png.h"
#include "assets/scene/scene_codec.h"
#include "tests/assets/gltf/load_for_test.h"
#include "tests/support/source_file.h"

namespace tandem::assets {
namespace {

using tests::GltfBuilder;
using Json = nlohmann::json;

GltfBuilder boxWith(const Json& haptic) {
  GltfBuilder b;
  b.addNode({{"name", "plate"}, {"mesh", b.addBox(1, 1, 1)}, {"extras", {{"haptic", haptic}}}});
  return b;
}

/// A quad with texture coordinates, and one image as its only texture.
GltfBuilder quadWith(const Json& haptic, const std::vector<unsigned char>& image, bool coordinates = true) {
  GltfBuilder b;
  const int positions = b.addPositions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  const int mesh = b.addMesh(positions, b.addIndices({0, 1, 2, 0, 2, 3}));
  if (coordinates) {
    const std::vector<float> uv = {0, 1, 1, 1, 1, 0, 0, 0};
    b.json["meshes"][static_cast<std::size_t>(mesh)]["primitives"][0]["attributes"]["TEXCOORD_0"] =
        b.addAccessor(uv, 5126, "VEC2", 2);
  }
  b.json["images"] = Json::array({{{"bufferView", b.addView(image)}, {"mimeType", "image/png"}}});
  b.json["textures"] = Json::array({{{"source", 0}}});
  b.addNode({{"name", "plate"}, {"mesh", mesh}, {"extras", {{"haptic", haptic}}}});
  return b;
}

/// The surface that the box has; a default one if its material has none.
Surface surfaceOf(const Json& haptic) {
  const Scene scene = loaded(boxWith(haptic));
  if (scene.surfaces.empty()) return {};
  EXPECT_EQ(scene.surfaces.size(), 1u);
  EXPECT_EQ(scene.materials[scene.meshes[0].triangleMaterial[0]].surface, 0u);
  return scene.surfaces[0];
}

const Finding* find(const Scene& scene, const std::string& code) {
  for (const Finding& finding : scene.findings)
    if (finding.code == code) return &finding;
  return nullptr;
}

struct Case {
  Json haptic;
  std::function<void(Surface&)> change;  // of a default surface, to what is expected
};

std::vector<Case> everyProperty() {
  using Pattern = SurfaceTexture::Pattern;
  const auto pattern = [](const char* name, Pattern is) {
    return Case{{{"texture", {{"function", name}, {"amplitude", 1e-4}, {"wavelength", 2e-3}}}},
                [is](Surface& s) { s.texture = {is, kNoTexture, 1e-4, 0.0, 2e-3, 1.0}; }};
  };
  return {
      {{{"creaseAngle", 0.4}}, [](Surface& s) { s.creaseAngle = 0.4; }},
      {{{"creaseAngle", 4.0}}, [](Surface& s) { s.creaseAngle = 3.14159265358979323846; }},
      {{{"viscosity", 3}}, [](Surface& s) { s.viscosity = 3.0; }},
      {{{"vibration", {{"frequency", 80}, {"amplitude", 0.3}}}},
       [](Surface& s) { s.vibrationFrequency = 80.0, s.vibrationAmplitude = 0.3; }},
      {{{"stickSlip", {{"force", 0.5}, {"stiffness", 400}}}},
       [](Surface& s) { s.stickSlipForce = 0.5, s.stickSlipStiffness = 400.0; }},
      {{{"magnetic", {{"force", 0.8}, {"distance", 0.01}}}},
       [](Surface& s) { s.magneticForce = 0.8, s.magneticDistance = 0.01; }},
      {{{"popThrough", {{"force", 2}}}}, [](Surface& s) { s.popThroughForce = 2.0; }},
      {{{"popThroughForce", 2.5}}, [](Surface& s) { s.popThroughForce = 2.5; }},
      {{{"law", "elastic"}, {"viscosity", 1}}, [](Surface& s) { s.viscosity = 1.0; }},
      {{{"law", {{"type", "viscoelastic"}, {"stiffness2", 900}, {"relaxation", 0.2}}}},
       [](Surface& s) { s.law = Surface::Law::viscoelastic, s.stiffness2 = 900.0, s.relaxation = 0.2; }},
      {{{"law", "viscoelastic"}, {"stiffness2", 900}, {"relaxation", 0.2}},
       [](Surface& s) { s.law = Surface::Law::viscoelastic, s.stiffness2 = 900.0, s.relaxation = 0.2; }},
      {{{"law", {{"type", "plastic"}, {"yield", 1.5}, {"hardening", 120}}}},
       [](Surface& s) { s.law = Surface::Law::plastic, s.yieldForce = 1.5, s.hardening = 120.0; }},
      {{{"law", "plastic"}, {"yield", 1.5}, {"hardening", 120}},
       [](Surface& s) { s.law = Surface::Law::plastic, s.yieldForce = 1.5, s.hardening = 120.0; }},
      pattern("sine", Pattern::sine),
      pattern("grid", Pattern::grid),
      pattern("bumps", Pattern::bumps),
      pattern("noise", Pattern::noise),
      {{{"texture", {{"function", "sine"}, {"wavelength", 1e-3}, {"frictionScale", 0}}}},
       [](Surface& s) { s.texture = {Pattern::sine, kNoTexture, 0.0, 0.0, 1e-3, 0.0}; }},
      {{{"textureAmplitude", 0.1}, {"textureWavelength", 3e-3}},
       [](Surface& s) { s.texture = {Pattern::grid, kNoTexture, 0.0, 0.1, 3e-3, 1.0}; }},
  };
}

TEST(GltfSurface, ReadsEveryProperty) {
  for (const Case& each : everyProperty()) {
    Surface expected;
    each.change(expected);
    EXPECT_TRUE(surfaceOf(each.haptic) == expected) << each.haptic.dump();
    EXPECT_EQ(find(loaded(boxWith(each.haptic)), "unused-haptic-property"), nullptr) << each.haptic.dump();
  }
}

TEST(GltfSurface, WhatAMaterialHoldsItselfMakesNoSurface) {
  const Scene scene = loaded(boxWith({{"stiffness", 500},
                                      {"damping", 2},
                                      {"staticFriction", 0.4},
                                      {"dynamicFriction", 0.3},
                                      {"law", "elastic"}}));
  EXPECT_TRUE(scene.surfaces.empty());
  const Material& material = scene.materials[scene.meshes[0].triangleMaterial[0]];
  EXPECT_EQ(material.surface, kNone);
  EXPECT_EQ(material.stiffness, 500.0);
  EXPECT_EQ(material.damping, 2.0);
  EXPECT_EQ(material.staticFriction, 0.4);
  EXPECT_EQ(material.dynamicFriction, 0.3);
}

TEST(GltfSurface, LengthsAreMetresWhateverTheUnitOfTheFile) {
  LoadOptions options;
  options.unitScale = 0.001;
  const Scene scene = loaded(
      boxWith({{"texture", {{"function", "sine"}, {"amplitude", 1e-4}, {"wavelength", 2e-3}}}}), options);
  ASSERT_EQ(scene.surfaces.size(), 1u);
  EXPECT_EQ(scene.surfaces[0].texture.amplitude, 1e-4);
  EXPECT_EQ(scene.surfaces[0].texture.wavelength, 2e-3);
}

TEST(GltfSurface, RefusesValuesThatCannotBeNamingThem) {
  const auto refuses = [](const Json& haptic, const std::string& property) {
    const Result<Scene> scene = loadGltfFromMemory("test.glb", boxWith(haptic).glb(), {});
    ASSERT_FALSE(scene.ok()) << haptic.dump();
    const std::string& message = scene.error().message;
    EXPECT_EQ(message.find("test.glb: nodes[0].extras.haptic"), 0u) << message;
    EXPECT_NE(message.find(property), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  };
  for (const char* key : {"stiffness", "damping", "staticFriction", "dynamicFriction", "creaseAngle",
                          "viscosity", "textureAmplitude", "textureWavelength", "popThroughForce"}) {
    refuses({{key, -1}}, key);
    refuses({{key, "much"}}, key);
    refuses({{key, {1, 2}}}, key);
  }
  const std::pair<const char*, std::vector<const char*>> groups[] = {
      {"vibration", {"frequency", "amplitude"}},
      {"stickSlip", {"force", "stiffness"}},
      {"magnetic", {"force", "distance"}},
      {"popThrough", {"force"}}};
  for (const auto& [group, keys] : groups) {
    refuses({{group, 1}}, group);
    refuses({{group, {1, 2}}}, group);
    for (const char* key : keys) {
      refuses({{group, {{key, -1}}}}, key);
      refuses({{group, {{key, true}}}}, key);
    }
  }
  const std::pair<const char*, std::vector<const char*>> laws[] = {
      {"viscoelastic", {"stiffness2", "relaxation"}}, {"plastic", {"yield", "hardening"}}};
  for (const auto& [law, keys] : laws)
    for (const char* key : keys) refuses({{"law", {{"type", law}, {key, -1}}}}, key);
  refuses({{"law", "jelly"}}, "law");
  refuses({{"law", 3}}, "law");
  refuses({{"law", {{"type", 3}}}}, "type");
  refuses({{"texture", "wood"}}, "texture");
  refuses({{"texture", {{"function", "wood"}, {"wavelength", 1}}}}, "function");
  refuses({{"texture", {{"function", "sine"}}}}, "wavelength");
  refuses({{"texture", {{"function", "sine"}, {"wavelength", 1}, {"amplitude", -1}}}}, "amplitude");
  refuses({{"texture", {{"function", "sine"}, {"wavelength", 1}, {"frictionScale", -1}}}}, "frictionScale");
  refuses({{"texture", {{"image", 0}}}}, "image");
  refuses({{"textureAmplitude", 1}}, "textureWavelength");
}

TEST(GltfSurface, NamesWhatItDoesNotKnow) {
  const Scene scene = loaded(boxWith({{"viscosty", 1},
                                      {"viscosity", 2},
                                      {"magnetic", {{"force", 1}, {"distance", 1}, {"colour", 3}}},
                                      {"law", {{"type", "plastic"}, {"yeild", 1}}}}));
  const Finding* finding = find(scene, "unused-haptic-property");
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->count, 3u);
  for (const char* name : {"viscosty", "colour", "yeild"})
    EXPECT_NE(finding->message.find(name), std::string::npos) << finding->message;
  EXPECT_EQ(scene.surfaces.at(0).viscosity, 2.0) << "what is known is read all the same";
  const Finding* odd = find(loaded(boxWith({{"line\nbreak\x7f", 1}})), "unused-haptic-property");
  ASSERT_NE(odd, nullptr);
}

TEST(GltfSurface, ReadsAnImageAndTheCoordinatesOfItsMesh) {
  TextureImage image{3, 2, {0, 50, 100, 150, 200, 255}};
  const Json haptic = {{"texture", {{"image", 0}, {"amplitude", 1e-4}, {"frictionScale", 2}}}};
  const Scene scene = loaded(quadWith(haptic, generate::greyPng(image)));
  ASSERT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.textures[0].width, 3u);
  EXPECT_EQ(scene.textures[0].height, 2u);
  EXPECT_EQ(scene.textures[0].texels, image.texels);
  ASSERT_EQ(scene.surfaces.size(), 1u);
  EXPECT_EQ(scene.surfaces[0].texture.image, 0u);
  EXPECT_EQ(scene.surfaces[0].texture.amplitude, 1e-4);
  const Mesh& mesh = scene.meshes.at(0);
  ASSERT_EQ(mesh.triangleUv.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const glm::dvec3 p = mesh.positions[mesh.triangles[t][c]];
      EXPECT_EQ(mesh.triangleUv[t][c], glm::vec2(p.x, 1.0 - p.y));
    }
}

TEST(GltfSurface, LeavesOutImagesThatCannotBeReadAndSaysSo) {
  const Json haptic = {{"texture", {{"image", 0}, {"amplitude", 1e-4}}}};
  std::vector<unsigned char> png = generate::greyPng({3, 2, {0, 50, 100, 150, 200, 255}});
  const auto unread = [&](const std::vector<unsigned char>& bytes) {
    const Scene scene = loaded(quadWith(haptic, bytes));
    const Finding* finding = find(scene, "unread-texture");
    return finding != nullptr && scene.textures.empty() && scene.surfaces.at(0).texture == SurfaceTexture{};
  };
  EXPECT_FALSE(unread(png));
  EXPECT_TRUE(unread({}));
  EXPECT_TRUE(unread({'G', 'I', 'F', '8', '9', 'a'}));
  std::vector<unsigned char> huge = png;
  huge[16] = 0x7f;  // two thousand million texels wide
  EXPECT_TRUE(unread(huge));
  for (std::size_t length = 8; length + 12 < png.size(); length += 5)
    EXPECT_TRUE(unread({png.begin(), png.begin() + static_cast<std::ptrdiff_t>(length)})) << length;
}

TEST(GltfSurface, AMeshWithoutTextureCoordinatesIsSmoothAndSaysSo) {
  const Json haptic = {{"texture", {{"image", 0}, {"amplitude", 1e-4}}}};
  const Scene scene = loaded(quadWith(haptic, generate::greyPng({1, 1, {7}}), false));
  EXPECT_NE(find(scene, "no-texture-coordinates"), nullptr);
}

TEST(FuzzSeeds, OfFeaturesAreScenesThatLoadWithAllOfThem) {
  const auto seed = [](const std::string& name) {
    std::ifstream file(sourceFile("tests/fuzz/seeds/gltf/") + name, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    const std::size_t end = text.find('\n');
    if (text.empty() || end == std::string::npos) return Scene{};
    // The first byte says how the fuzzer takes the rest: JSON, a line break, the binary chunk.
    const std::vector<unsigned char> glb = GltfBuilder::wrapGlb(
        text.substr(1, end - 1), {text.begin() + static_cast<std::ptrdiff_t>(end) + 1, text.end()});
    const Result<Scene> scene = loadGltfFromMemory(name, glb, {});
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    return scene ? *scene : Scene{};
  };
  const Scene surfaces = seed("surfaces"), fields = seed("fields"), controls = seed("controls");
  EXPECT_EQ(surfaces.surfaces.size(), 4u);
  EXPECT_EQ(surfaces.textures.size(), 1u);
  EXPECT_EQ(fields.fields.size(), 11u);
  EXPECT_EQ(controls.controls.size(), 4u);
  for (const Scene* scene : {&surfaces, &fields, &controls}) EXPECT_TRUE(scene->findings.empty());
}

TEST(GltfSurface, SurvivesThePackage) {
  for (const Case& each : everyProperty()) {
    const Scene scene = loaded(boxWith(each.haptic));
    const Result<Scene> again = decodeScene(encodeScene(scene));
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_TRUE(again->surfaces == scene.surfaces) << each.haptic.dump();
  }
}

}  // namespace
}  // namespace tandem::assets
