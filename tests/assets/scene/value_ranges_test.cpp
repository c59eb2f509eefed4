// Every number that says how a scene feels has a range, the same in a file and from a network.

#include "assets/scene/value_ranges.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "assets/scene/field_check.h"
#include "assets/scene/scene_check.h"
#include "assets/scene/scene_codec.h"
#include "tests/assets/gltf/load_for_test.h"

namespace tandem::assets {
namespace {

using tests::GltfBuilder;
using Json = nlohmann::json;

const double kNan = std::numeric_limits<double>::quiet_NaN();

GltfBuilder boxWith(const Json& haptic, const Json& node = Json::object()) {
  GltfBuilder b;
  Json full = {{"name", "plate"}, {"mesh", b.addBox(0.1, 0.1, 0.1)}, {"extras", {{"haptic", haptic}}}};
  full.update(node);
  b.addNode(full);
  return b;
}

/// The same property with a value that is just inside, and one that is just outside of its range.
struct Edge {
  Json inside, outside;
  std::string message;
};

TEST(ValueRanges, TheLoaderNamesFilePlacePropertyValueAndRange) {
  const auto pair = [](const char* group, const char* key, double value, Json other) {
    other[key] = value;
    return Json{{group, std::move(other)}};
  };
  const Json sine = {{"function", "sine"}, {"wavelength", 1e-3}};
  const std::vector<Edge> edges = {
      {{{"stiffness", 1e6}},
       {{"stiffness", 1.01e6}},
       "stiffness: is 1.01e+06 N/m; it must lie between 0 and 1e+06 N/m"},
      {{{"damping", 1e3}},
       {{"damping", 1e308}},
       "damping: is 1e+308 N*s/m; it must lie between 0 and 1000 N*s/m"},
      {{{"staticFriction", 1e3}},
       {{"staticFriction", 1001}},
       "staticFriction: is 1001; it must lie between 0 and 1000"},
      {{{"dynamicFriction", 1e3}}, {{"dynamicFriction", 1e9}}, "dynamicFriction: is 1e+09;"},
      {{{"creaseAngle", 6.28}},
       {{"creaseAngle", 30}},
       "creaseAngle: is 30 rad; it must lie between 0 and 6.28319 rad"},
      {{{"viscosity", 1e3}}, {{"viscosity", 1e4}}, "viscosity: is 10000 N*s/m;"},
      {{{"tolerance", 1e-9}}, {{"tolerance", 0}}, "tolerance: is 0 m; it must lie between 1e-09 and 1000 m"},
      {{{"tolerance", 1e3}}, {{"tolerance", -1e-6}}, "tolerance: is -1e-06 m;"},
      {{{"tolerance", 1e-5}}, {{"tolerance", 1e4}}, "tolerance: is 10000 m;"},
      {{{"tolerance", 1e-5}}, {{"tolerance", "fine"}}, "tolerance: must be a finite number"},
      {pair("texture", "amplitude", 1.0, sine), pair("texture", "amplitude", 1e15, sine),
       "texture.amplitude: is 1e+15 m;"},
      {pair("texture", "wavelength", 1e-6, sine), pair("texture", "wavelength", 1e-300, sine),
       "texture.wavelength: is 1e-300 m;"},
      {pair("texture", "frictionScale", 1e3, sine), pair("texture", "frictionScale", 1e4, sine),
       "texture.frictionScale: is 10000;"},
      {{{"textureAmplitude", 1e4}, {"textureWavelength", 1}},
       {{"textureAmplitude", 1e5}, {"textureWavelength", 1}},
       "textureAmplitude: is 100000 N;"},
      {pair("vibration", "frequency", 1e4, {}), pair("vibration", "frequency", 1e5, {}),
       "vibration.frequency: is 100000 Hz;"},
      {pair("vibration", "amplitude", 1e4, {}), pair("vibration", "amplitude", 1e5, {}),
       "vibration.amplitude: is 100000 N;"},
      {pair("stickSlip", "force", 1e4, {}), pair("stickSlip", "force", 1e308, {}),
       "stickSlip.force: is 1e+308 N; it must lie between 0 and 10000 N"},
      {pair("stickSlip", "stiffness", 1e6, {}), pair("stickSlip", "stiffness", 1e7, {}),
       "stickSlip.stiffness: is 1e+07 N/m;"},
      {pair("magnetic", "force", 1e4, {}), pair("magnetic", "force", 1e308, {}),
       "magnetic.force: is 1e+308 N;"},
      {pair("magnetic", "distance", 1e3, {}), pair("magnetic", "distance", 1e4, {}),
       "magnetic.distance: is 10000 m;"},
      {pair("popThrough", "force", 1e4, {}), pair("popThrough", "force", 1e5, {}),
       "popThrough.force: is 100000 N;"},
      {pair("law", "stiffness2", 1e6, {{"type", "viscoelastic"}}),
       pair("law", "stiffness2", 1e7, {{"type", "viscoelastic"}}), "law.stiffness2: is 1e+07 N/m;"},
      {pair("law", "relaxation", 1e6, {{"type", "viscoelastic"}}),
       pair("law", "relaxation", 1e7, {{"type", "viscoelastic"}}), "law.relaxation: is 1e+07 s;"},
      {pair("law", "yield", 1e4, {{"type", "plastic"}}), pair("law", "yield", 1e5, {{"type", "plastic"}}),
       "law.yield: is 100000 N;"},
      {pair("law", "hardening", 1e6, {{"type", "plastic"}}),
       pair("law", "hardening", 1e7, {{"type", "plastic"}}), "law.hardening: is 1e+07 N/m;"},
  };
  for (const Edge& edge : edges) {
    const Result<Scene> good = loadGltfFromMemory("test.glb", boxWith(edge.inside).glb(), {});
    ASSERT_TRUE(good.ok()) << good.error().message;
    EXPECT_TRUE(checkScene(*good).ok()) << edge.inside.dump();
    expectRefused(boxWith(edge.outside), "test.glb: nodes[0].extras.haptic." + edge.message);
  }
}

TEST(ValueRanges, HoldForPhysicsMaterials) {
  GltfBuilder b = boxWith(Json::object());
  b.json["extensions"]["KHR_physics_rigid_bodies"]["physicsMaterials"] = {{{"staticFriction", 1e9}}};
  b.json["extensionsUsed"] = {"KHR_physics_rigid_bodies"};
  expectRefused(b, "physicsMaterials[0].staticFriction: is 1e+09; it must lie between 0 and 1000");
}

TEST(ValueRanges, HoldForControlsAndFields) {
  const Json motion = {{"extensions", {{"KHR_physics_rigid_bodies", {{"motion", {{"mass", 0.1}}}}}}}};
  const auto control = [&](const Json& change) {
    Json full = {{"kind", "slider"}, {"axis", {1, 0, 0}}, {"min", 0}, {"max", 0.1}};
    full.update(change);
    return boxWith({{"control", full}}, motion);
  };
  EXPECT_TRUE(loadGltfFromMemory("test.glb", control(Json::object()).glb(), {}).ok());
  expectRefused(control({{"friction", 1e308}}), "extras.haptic.control.friction: is 1e+308 N; it must lie");
  expectRefused(control({{"damping", 1e9}}), "control.damping: is 1e+09 N*s/m");
  expectRefused(control({{"inertia", 1e-40}}), "control.inertia: is 1e-40 kg");
  expectRefused(control({{"spring", {{"stiffness", 1e9}}}}), "control.spring.stiffness: is 1e+09 N/m");
  expectRefused(control({{"detents", {{"count", 3}, {"force", 1e9}}}}), "control.detents.force: is 1e+09 N;");
  expectRefused(control({{"click", {{"drop", 1e9}}}}), "control.click.drop: is 1e+09 N;");
  const auto field = [](const Json& value) { return boxWith({{"field", value}}); };
  expectRefused(field({{"kind", "spring"}, {"stiffness", 1e308}}),
                "extras.haptic.field.stiffness: is 1e+308 N/m; it must lie between 0 and 1e+06 N/m");
  expectRefused(field({{"kind", "spring"}, {"stiffness", 10}, {"radius", 1e12}}),
                "field.radius: is 1e+12 m;");
  expectRefused(field({{"kind", "damper"}, {"damping", {1, 2, 1e9}}}), "field.damping: is 1e+09 N*s/m;");
  expectRefused(field({{"kind", "constant"}, {"force", {0, 1, 0}}, {"maxForce", 1e9}}),
                "field.maxForce: is 1e+09 N;");
  expectRefused(field({{"kind", "constant"}, {"force", {0, 1, 0}}, {"region", {{"size", {1, 1, 1e30}}}}}),
                "field.region.size: is 5e+29 m;");
}

TEST(ValueRanges, ShapesAndPosesLieWhereMeshesMay) {
  const auto shape = [](const Json& value, const Json& node) {
    GltfBuilder b;
    b.json["extensions"]["KHR_implicit_shapes"]["shapes"] = Json::array({value});
    b.json["extensionsUsed"] = {"KHR_implicit_shapes", "KHR_physics_rigid_bodies"};
    Json full = {
        {"extensions", {{"KHR_physics_rigid_bodies", {{"collider", {{"geometry", {{"shape", 0}}}}}}}}}};
    full.update(node);
    b.addNode(full);
    return b;
  };
  const Json sphere = {{"type", "sphere"}, {"sphere", {{"radius", 0.1}}}};
  const Result<Scene> good = loadGltfFromMemory("test.glb", shape(sphere, Json::object()).glb(), {});
  ASSERT_TRUE(good.ok()) << good.error().message;
  expectRefused(shape({{"type", "sphere"}, {"sphere", {{"radius", 1e12}}}}, Json::object()),
                "nodes[0].collider.radius: is 1e+12 m; it must lie between 0 and 1e+09 m");
  expectRefused(shape({{"type", "box"}, {"box", {{"size", {1, 1e300, 1}}}}}, Json::object()),
                "collider.size: is 1e+300 m;");
  expectRefused(shape(sphere, {{"translation", {0, 2e9, 0}}}), "farther than 1e9 m");
  Scene scene = *good;
  scene.parts[0].worldFromPart.position.x = 2e9;
  EXPECT_FALSE(checkScene(scene).ok());
  scene = *good;
  scene.parts[0].shapes[0].radiusBottom = 2e9;
  EXPECT_FALSE(checkScene(scene).ok());
  scene = *good;
  scene.parts[0].shapes[0].partFromShape.position.z = -2e9;
  EXPECT_FALSE(checkScene(scene).ok());
}

/// A scene with one of everything, as bytes from a network would bring it.
Scene sceneWithAll() {
  GltfBuilder b = boxWith({{"viscosity", 1},
                           {"control", {{"kind", "slider"}, {"axis", {1, 0, 0}}, {"min", 0}, {"max", 0.1}}},
                           {"field", {{"kind", "spring"}, {"stiffness", 10}}}},
                          {{"extensions", {{"KHR_physics_rigid_bodies", {{"motion", {{"mass", 0.1}}}}}}}});
  return loaded(b);
}

TEST(ValueRanges, ToleranceFromANetworkIsAbsentOrInRange) {
  Scene scene = sceneWithAll();
  for (const double bad : {-1e-6, 1e-12, 1e4, kNan, std::numeric_limits<double>::infinity()}) {
    scene.parts[0].contactTolerance = bad;
    const Result<Scene> back = decodeScene(encodeScene(scene));
    ASSERT_FALSE(back.ok()) << bad;
    EXPECT_NE(back.error().message.find("tolerance"), std::string::npos) << back.error().message;
  }
  scene.parts[0].contactTolerance = 2e-6;
  const Result<Scene> back = decodeScene(encodeScene(scene));
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->parts[0].contactTolerance, 2e-6);
}

TEST(ValueRanges, GravityFromANetworkIsInRange) {
  for (const double bad : {1e300, -1e4, kNan}) {
    Scene scene = sceneWithAll();
    scene.gravity.y = bad;
    EXPECT_FALSE(decodeScene(encodeScene(scene)).ok()) << bad;
    scene.gravity.y = -9.81;
    EXPECT_TRUE(decodeScene(encodeScene(scene)).ok());
    scene.parts[0].gravityFactor = bad;
    EXPECT_FALSE(decodeScene(encodeScene(scene)).ok()) << bad;
  }
}

TEST(ValueRanges, WhatTheLoaderRefusesIsRefusedFromANetworkToo) {
  const Scene good = sceneWithAll();
  ASSERT_EQ(good.surfaces.size() * good.controls.size() * good.fields.size(), 1u);
  ASSERT_TRUE(decodeScene(encodeScene(good)).ok());
  using Member = double& (*)(Scene&);
  const std::pair<const char*, Member> members[] = {
      {"stiffness", [](Scene& s) -> double& { return s.materials[0].stiffness; }},
      {"damping", [](Scene& s) -> double& { return s.materials[0].damping; }},
      {"staticFriction", [](Scene& s) -> double& { return s.materials[0].staticFriction; }},
      {"dynamicFriction", [](Scene& s) -> double& { return s.materials[0].dynamicFriction; }},
      {"restitution", [](Scene& s) -> double& { return s.materials[0].restitution; }},
      {"creaseAngle", [](Scene& s) -> double& { return s.surfaces[0].creaseAngle; }},
      {"viscosity", [](Scene& s) -> double& { return s.surfaces[0].viscosity; }},
      {"amplitude", [](Scene& s) -> double& { return s.surfaces[0].texture.amplitude; }},
      {"textureAmplitude", [](Scene& s) -> double& { return s.surfaces[0].texture.amplitudeForce; }},
      {"wavelength", [](Scene& s) -> double& { return s.surfaces[0].texture.wavelength; }},
      {"frictionScale", [](Scene& s) -> double& { return s.surfaces[0].texture.frictionScale; }},
      {"frequency", [](Scene& s) -> double& { return s.surfaces[0].vibrationFrequency; }},
      {"vibration.amplitude", [](Scene& s) -> double& { return s.surfaces[0].vibrationAmplitude; }},
      {"stickSlip.force", [](Scene& s) -> double& { return s.surfaces[0].stickSlipForce; }},
      {"stickSlip.stiffness", [](Scene& s) -> double& { return s.surfaces[0].stickSlipStiffness; }},
      {"magnetic.force", [](Scene& s) -> double& { return s.surfaces[0].magneticForce; }},
      {"magnetic.distance", [](Scene& s) -> double& { return s.surfaces[0].magneticDistance; }},
      {"popThrough.force", [](Scene& s) -> double& { return s.surfaces[0].popThroughForce; }},
      {"stiffness2", [](Scene& s) -> double& { return s.surfaces[0].stiffness2; }},
      {"relaxation", [](Scene& s) -> double& { return s.surfaces[0].relaxation; }},
      {"yield", [](Scene& s) -> double& { return s.surfaces[0].yieldForce; }},
      {"hardening", [](Scene& s) -> double& { return s.surfaces[0].hardening; }},
      {"maxForce", [](Scene& s) -> double& { return s.fields[0].maxForce; }},
      {"stiffness", [](Scene& s) -> double& { return s.fields[0].stiffness; }},
      {"damping", [](Scene& s) -> double& { return s.fields[0].damping.z; }},
      {"radius", [](Scene& s) -> double& { return s.fields[0].radius; }},
      {"region.radius", [](Scene& s) -> double& { return s.fields[0].region.radius; }},
      {"waveform.start", [](Scene& s) -> double& { return s.fields[0].waveform.start; }},
      {"inertia", [](Scene& s) -> double& { return s.controls[0].inertia; }},
      {"spring.stiffness", [](Scene& s) -> double& { return s.controls[0].springStiffness; }},
      {"damping", [](Scene& s) -> double& { return s.controls[0].damping; }},
      {"friction", [](Scene& s) -> double& { return s.controls[0].friction; }},
      {"detents.force", [](Scene& s) -> double& { return s.controls[0].detents.force; }},
      {"detents.width", [](Scene& s) -> double& { return s.controls[0].detents.width; }},
      {"click.drop", [](Scene& s) -> double& { return s.controls[0].click.drop; }},
  };
  for (const auto& [name, member] : members)
    for (const double value : {1e308, -1.0, kNan}) {
      Scene scene = good;
      member(scene) = value;
      const Result<Scene> result = decodeScene(encodeScene(scene));
      ASSERT_FALSE(result.ok()) << name << " = " << value;
      EXPECT_NE(result.error().message.find(std::string(name) + ": is "), std::string::npos)
          << result.error().message;
    }
}

}  // namespace
}  // namespace tandem::assets
