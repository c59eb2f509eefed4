#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/gltf/load_gltf.h"
#include "assets/scene/field_check.h"
#include "assets/scene/scene_check.h"
#include "assets/scene/scene_codec.h"
#include "tests/assets/gltf/load_for_test.h"
#include "tests/support/gltf_builder.h"

namespace tandem::assets {
namespace {

using tests::GltfBuilder;
using Json = nlohmann::json;
using Kind = ForceField::Kind;

GltfBuilder boxAndField(const Json& field, Json node = Json::object()) {
  GltfBuilder b;
  b.addNode({{"name", "plate"}, {"mesh", b.addBox(1, 1, 1)}});
  node["extras"]["haptic"]["field"] = field;
  b.addNode(node);
  return b;
}

ForceField fieldOf(const Json& field, const Json& node = Json::object(), const LoadOptions& options = {}) {
  const Scene scene = loaded(boxAndField(field, node), options);
  EXPECT_EQ(scene.fields.size(), 1u);
  return scene.fields.empty() ? ForceField{} : scene.fields[0];
}

void expectFieldRefused(const Json& field, const std::string& message, const Json& node = Json::object()) {
  const Result<Scene> scene = loadGltfFromMemory("test.glb", boxAndField(field, node).glb(), {});
  ASSERT_FALSE(scene.ok()) << field.dump();
  EXPECT_NE(scene.error().message.find(message), std::string::npos) << scene.error().message;
  EXPECT_EQ(scene.error().message.find("test.glb: nodes[1].extras.haptic.field"), 0u)
      << scene.error().message;
  EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
}

const Json kSpring = {{"kind", "spring"}, {"stiffness", 100}};

TEST(GltfFields, AFieldStandsWhereItsNodeStands) {
  const Json node = {{"name", "pull"}, {"translation", {1, 2, 3}}, {"rotation", {0, 0, 1, 0}}};
  const ForceField field =
      fieldOf({{"kind", "spring"}, {"stiffness", 100}, {"damping", 2}, {"radius", 0.5}}, node);
  EXPECT_EQ(field.name, "pull");
  EXPECT_EQ(field.kind, Kind::spring);
  EXPECT_EQ(field.part, kNoPart);
  EXPECT_EQ(field.partFromField.position, glm::dvec3(1, 2, 3));
  EXPECT_LT(glm::distance(field.partFromField.orientation * glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0)),
            1e-12);
  EXPECT_EQ(field.stiffness, 100.0);
  EXPECT_EQ(field.damping.x, 2.0);
  EXPECT_EQ(field.radius, 0.5);
  EXPECT_EQ(field.maxForce, 3.0);
}

TEST(GltfFields, LengthsScaleWithUnitsAndNodesAndForcesDoNot) {
  LoadOptions millimetres;
  millimetres.unitScale = 1e-3;
  const Json region = {{"shape", "box"}, {"size", {20, 40, 60}}, {"fade", 5}};
  const ForceField field =
      fieldOf({{"kind", "gravity"}, {"surfaceForce", 2}, {"radius", 10}, {"region", region}},
              {{"scale", {2, 2, 2}}, {"translation", {100, 0, 0}}}, millimetres);
  EXPECT_NEAR(field.radius, 0.02, 1e-12);
  EXPECT_NEAR(field.strength, 2.0 * 0.02 * 0.02, 1e-12);  // still 2 N at the radius
  EXPECT_LT(glm::distance(field.region.halfSize, glm::dvec3(0.02, 0.04, 0.06)), 1e-12);
  EXPECT_NEAR(field.region.fade, 0.01, 1e-12);
  EXPECT_NEAR(field.partFromField.position.x, 0.1, 1e-12);
}

TEST(GltfFields, AFieldOfAMovablePartGoesWithIt) {
  GltfBuilder b;
  b.addNode({{"name", "planet"},
             {"mesh", b.addBox(1, 1, 1)},
             {"translation", {5, 0, 0}},
             {"extensions", {{"KHR_physics_rigid_bodies", {{"motion", {{"mass", 1}}}}}}},
             {"extras", {{"haptic", {{"field", kSpring}}}}}});
  b.json["nodes"][0]["extras"]["haptic"]["field"]["position"] = {0, 1, 0};
  const Scene scene = loaded(b);
  ASSERT_EQ(scene.fields.size(), 1u);
  EXPECT_EQ(scene.fields[0].part, 0);
  EXPECT_EQ(scene.fields[0].partFromField.position, glm::dvec3(0, 1, 0));
  EXPECT_TRUE(scene.findings.empty());  // a field is no property of the surface
}

TEST(GltfFields, TheSceneMayHoldFieldsOfItsOwn) {
  GltfBuilder b;
  b.addNode({{"mesh", b.addBox(1, 1, 1)}});
  Json second = kSpring;
  second["position"] = {0, 0, 4};
  b.json["scenes"][0]["extras"]["haptic"]["fields"] = Json::array({kSpring, second});
  LoadOptions options;
  options.unitScale = 0.5;
  const Scene scene = loaded(b, options);
  ASSERT_EQ(scene.fields.size(), 2u);
  EXPECT_EQ(scene.fields[1].partFromField.position, glm::dvec3(0, 0, 2));
  EXPECT_NE(scene.fields[0].name, scene.fields[1].name);
}

Json allKinds() {
  const Json wave = {{"shape", "chirp"}, {"frequency", 10}, {"endFrequency", 200}, {"sweep", 2}, {"stop", 9}};
  const Json points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  return Json::array(
      {{{"kind", "constant"}, {"force", {0, 1, 0}}},
       {{"kind", "spring"}, {"stiffness", 100}, {"to", "plane"}, {"axis", {0, 0, 2}}, {"oneSided", true}},
       {{"kind", "guide"},
        {"stiffness", 100},
        {"points", points},
        {"radius", 0.1},
        {"range", 1},
        {"drive", 0.5}},
       {{"kind", "damper"}, {"damping", {1, 2, 3}}},
       {{"kind", "viscosity"}, {"damping", 4}, {"region", {{"radius", 2}}}},
       {{"kind", "waveform"}, {"force", {1, 0, 0}}, {"waveform", wave}},
       {{"kind", "gravity"}, {"strength", 1}, {"radius", 1}},
       {{"kind", "potential"}, {"function", "gaussian"}, {"depth", 0.1}, {"sigma", 1}},
       {{"kind", "potential"}, {"function", "ripple"}, {"depth", 0.1}, {"wavelength", 1}},
       {{"kind", "potential"},
        {"function", "polynomial"},
        {"terms", {{{"coefficient", 2}, {"powers", {2, 0, 1}}}}}}});
}

TEST(GltfFields, EveryKindLoadsAndSurvivesTheCodec) {
  const Scene scene = loaded(boxAndField(allKinds()));
  ASSERT_EQ(scene.fields.size(), allKinds().size());
  EXPECT_EQ(scene.fields[1].axis, glm::dvec3(0, 0, 1));
  EXPECT_EQ(scene.fields[2].points.size(), 3u);
  const std::vector<std::byte> bytes = encodeScene(scene);
  const Result<Scene> again = decodeScene(bytes);
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(encodeScene(*again), bytes);
  EXPECT_EQ(again->fields[9].terms[0].powers[2], 1);
  EXPECT_EQ(again->fields[5].waveform.stop, 9.0);
}

TEST(GltfFields, SaysWhatEachKindDoesWithEnergy) {
  const Scene scene = loaded(boxAndField(allKinds()));
  const Passivity expected[] = {Passivity::conservative, Passivity::conservative, Passivity::source,
                                Passivity::dissipative,  Passivity::dissipative,  Passivity::source,
                                Passivity::conservative, Passivity::conservative, Passivity::conservative,
                                Passivity::conservative};
  for (std::size_t i = 0; i < scene.fields.size(); ++i)
    EXPECT_EQ(passivity(scene.fields[i]), expected[i]) << i;
}

TEST(GltfFields, RefusesWhatDependsOnAccelerationWithTheReason) {
  for (const char* kind : {"inertia", "acceleration", "mass"})
    expectFieldRefused({{"kind", kind}}, "55 m/s^2");
}

TEST(GltfFields, RefusesBadValuesNamingThePropertyAndTheReason) {
  expectFieldRefused({{"stiffness", 1}}, "field.kind: is missing");
  expectFieldRefused({{"kind", "wormhole"}}, "field.kind: 'wormhole' is unknown");
  expectFieldRefused({{"kind", "spring"}}, "field.stiffness: is missing");
  expectFieldRefused({{"kind", "spring"}, {"stiffness", -1}}, "field.stiffness: must be positive");
  expectFieldRefused({{"kind", "spring"}, {"stiffness", "x"}}, "field.stiffness: must be a finite number");
  expectFieldRefused({{"kind", "spring"}, {"stifness", 1}, {"stiffness", 1}},
                     "field.stifness: is no property");
  expectFieldRefused({{"kind", "constant"}, {"force", {0, 5, 0}}},
                     "field.force: gives up to 5 N, more than maxForce");
  expectFieldRefused({{"kind", "viscosity"}, {"damping", 1}}, "field.region: is missing");
  expectFieldRefused({{"kind", "viscosity"}, {"damping", 1}, {"region", {{"radius", 1}, {"fade", 2}}}},
                     "field.region.fade: is larger");
  expectFieldRefused({{"kind", "gravity"}, {"radius", 1}}, "field.strength: needs either");
  expectFieldRefused({{"kind", "gravity"}, {"radius", 0}, {"strength", 1}}, "field.radius: must be positive");
  expectFieldRefused({{"kind", "guide"}, {"stiffness", 1}, {"points", {{0, 0, 0}}}},
                     "field.points: must be an array");
  expectFieldRefused({{"kind", "guide"}, {"stiffness", 1}, {"points", {{0, 0, 0}, {0, 0, 0}}}}, "the same");
  const Json fast = {{"shape", "sine"}, {"frequency", 600}};
  expectFieldRefused({{"kind", "waveform"}, {"force", {1, 0, 0}}, {"waveform", fast}},
                     "field.waveform.frequency: is 600 Hz; it must lie between 1e-06 and 500 Hz");
  expectFieldRefused({{"kind", "potential"}, {"function", "gaussian"}, {"depth", 10}, {"sigma", 0.1}},
                     "field.depth: gives up to");
  expectFieldRefused(kSpring, "scaled unevenly", {{"scale", {1, 2, 1}}});
  expectFieldRefused(7, "must be an object or an array");
  expectFieldRefused(Json::array({kSpring, 3}), "field[1]: must be an object");
}

TEST(GltfFields, RefusesMoreFieldsThanATickHasRoomFor) {
  EXPECT_EQ(loaded(boxAndField(Json::array_t(kMaxForceFields, kSpring))).fields.size(), kMaxForceFields);
  expectFieldRefused(Json::array_t(kMaxForceFields + 1, kSpring), "more than 64 fields");
}

/// A value that a file might hold in the place of another.
Json strayValue(std::mt19937& random) {
  switch (random() % 10) {
    case 0:
      return nullptr;
    case 1:
      return "x";
    case 2:
      return Json::array({1, 2, 3});
    case 3:
      return Json::object();
    case 4:
      return true;
    case 5:
      return 0;
    default:
      return std::copysign(std::pow(10.0, static_cast<double>(random() % 40) - 20.0),
                           random() % 3 == 0 ? -1.0 : 1.0);
  }
}

TEST(GltfFields, WhateverAFileHoldsIsRefusedInOneLineOrPassesTheCheck) {
  std::mt19937 random(11);
  int refused = 0, accepted = 0;
  for (int round = 0; round < 1500; ++round) {
    Json field = allKinds()[random() % allKinds().size()];
    const Json flat = field.flatten();
    auto entry = flat.begin();
    std::advance(entry, static_cast<long>(random() % flat.size()));
    field[Json::json_pointer(entry.key())] = strayValue(random);
    const Result<Scene> scene = loadGltfFromMemory("test.glb", boxAndField(field).glb(), {});
    if (scene.ok()) {
      ++accepted;
      EXPECT_TRUE(checkScene(*scene).ok()) << field.dump();
    } else {
      ++refused;
      EXPECT_NE(scene.error().message.find("extras.haptic.field"), std::string::npos)
          << scene.error().message;
      EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(refused, 300);
  EXPECT_GT(accepted, 100);
}

TEST(FieldCheck, DamagedBytesGiveAnErrorOrASceneThatPasses) {
  const std::vector<std::byte> good = encodeScene(loaded(boxAndField(allKinds())));
  std::mt19937 random(12);
  int refused = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<std::byte> bytes = good;
    bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    const Result<Scene> scene = decodeScene(bytes);
    if (!scene) {
      ++refused;
    } else {
      EXPECT_TRUE(checkScene(*scene).ok());
    }
  }
  EXPECT_GT(refused, 300);
}

TEST(FieldCheck, RefusesNumbersThatATickCouldNotUse) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Scene good = loaded(boxAndField(allKinds()));
  const auto refused = [&](auto change) {
    for (std::size_t i = 0; i < good.fields.size(); ++i) {
      ForceField field = good.fields[i];
      change(field);
      EXPECT_FALSE(checkField(field, good.parts.size(), "x").ok()) << i;
    }
  };
  refused([&](ForceField& f) { f.stiffness = nan; });
  refused([&](ForceField& f) { f.maxForce = 0.0; });
  refused([&](ForceField& f) { f.part = 1; });
  refused([&](ForceField& f) { f.kind = static_cast<Kind>(8); });
  refused([&](ForceField& f) { f.axis = glm::dvec3(2.0, 0.0, 0.0); });
  refused([&](ForceField& f) { f.waveform.frequency = 0.0; });
  refused([&](ForceField& f) { f.partFromField.position.y = nan; });
  refused([&](ForceField& f) {
    f.anchor = ForceField::Anchor::path;
    f.points = {glm::dvec3(0.0)};
  });
}

}  // namespace
}  // namespace tandem::assets
