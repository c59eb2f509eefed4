#include "assets/gltf/gltf_controls.h"
#include "assets/base/constants.h"

#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/gltf/load_gltf.h"
#include "assets/scene/scene_check.h"
#include "assets/scene/scene_codec.h"
#include "tests/assets/gltf/load_for_test.h"
#include "tests/support/gltf_builder.h"

namespace tandem::assets {
namespace {

using tests::GltfBuilder;
using Json = nlohmann::json;

constexpr const char* kRigidBodies = "KHR_physics_rigid_bodies";

/// A body with this control; node 1 is a fixed frame, node 2 a fixed box named "shown".
GltfBuilder withControl(const Json& control, Json node = Json::object()) {
  GltfBuilder b;
  const int box = b.addBox(1, 1, 1, "box");
  node["name"] = "knob";
  node["mesh"] = box;
  node["extensions"][kRigidBodies]["motion"] = {{"mass", 2.0}};
  node["extras"]["haptic"]["control"] = control;
  b.addNode(node);
  b.addNode({{"name", "frame"}, {"translation", {0, 0, 1}}});
  b.addNode({{"name", "shown"}, {"mesh", box}, {"translation", {5, 0, 0}}});
  return b;
}

const Json kSlider = {{"kind", "slider"}, {"axis", {0, 2, 0}}, {"min", -0.01}, {"max", 0.03}};

TEST(GltfControls, ReadsEveryPropertyOfAControl) {
  Json json = kSlider;
  json.update({{"name", "level"},
               {"value", 0.02},
               {"inertia", 0.5},
               {"damping", 3.0},
               {"friction", 0.4},
               {"spring", {{"stiffness", 200}, {"rest", -0.02}}},
               {"detents", {{"positions", {0.0, 0.01, 0.03}}, {"force", 0.6}, {"width", 0.005}}},
               {"click", {{"at", 0.02}, {"drop", 0.7}, {"width", 0.001}}},
               {"roles", {"instructor"}}});
  const Scene scene = loaded(withControl(json));
  ASSERT_EQ(scene.controls.size(), 1u);
  const Control& c = scene.controls[0];
  EXPECT_EQ(c.name, "level");
  EXPECT_EQ(c.part, findPart(scene, "knob"));
  EXPECT_EQ(c.kind, ControlKind::slider);
  EXPECT_EQ(c.min, -0.01);
  EXPECT_EQ(c.max, 0.03);
  EXPECT_EQ(c.initial, 0.02);
  EXPECT_EQ(c.inertia, 0.5);
  EXPECT_EQ(c.damping, 3.0);
  EXPECT_EQ(c.friction, 0.4);
  EXPECT_EQ(c.springStiffness, 200.0);
  EXPECT_EQ(c.springRest, -0.02);
  EXPECT_EQ(c.detents.places, (std::vector<double>{0.0, 0.01, 0.03}));
  EXPECT_EQ(c.detents.force, 0.6);
  EXPECT_EQ(c.detents.width, 0.005);
  EXPECT_EQ(c.click.at, 0.02);
  EXPECT_EQ(c.click.drop, 0.7);
  EXPECT_EQ(c.click.width, 0.001);
  EXPECT_EQ(c.roles, 4u);
  EXPECT_TRUE(roleMaySet(scene, c.part, 2));
  EXPECT_FALSE(roleMaySet(scene, c.part, 1));
  EXPECT_TRUE(roleMaySet(scene, findPart(scene, "shown"), 1));
  EXPECT_LT(glm::distance(axisOf(c), glm::dvec3(0, 1, 0)), 1e-12);
}

TEST(GltfControls, ValueAndPoseAreEachOthersInverse) {
  const Json turned = {{"rotation", {0.0, 0.0, std::sin(0.3), std::cos(0.3)}}, {"translation", {1, 2, 3}}};
  Json dial = {{"kind", "dial"}, {"axis", {1, 1, 0}}, {"origin", {0.2, 0, 0}}, {"min", -2.5}, {"max", 2.0}};
  for (const Json& json : {kSlider, dial}) {
    for (const double value : {-0.005, 0.0, 0.02}) {
      Json stated = json;
      stated["value"] = value;
      const Scene scene = loaded(withControl(stated, turned));
      const Control& c = scene.controls[0];
      const Pose rest = scene.parts[c.part].worldFromPart;
      EXPECT_NEAR(controlValue(c, rest), value, 1e-12);
      EXPECT_LT(glm::distance(poseAt(c, value).position, rest.position), 1e-12);
      for (int i = 0; i <= 10; ++i) {
        const double q = c.min + (c.max - c.min) * i / 10.0;
        EXPECT_NEAR(controlValue(c, poseAt(c, q)), q, 1e-12);
      }
      // The pose moves as the twist says.
      const double h = 1e-6;
      const Twist twist = twistAt(c, poseAt(c, value), 1.0);
      const glm::dvec3 moved = (poseAt(c, value + h).position - poseAt(c, value - h).position) / (2.0 * h);
      EXPECT_LT(glm::distance(moved, twist.linear), 1e-8);
    }
  }
}

TEST(GltfControls, LengthsAreInTheUnitOfTheFileAndAnglesAreNot) {
  LoadOptions mm;
  mm.unitScale = 1e-3;
  Json json = {{"kind", "slider"},
               {"axis", {1, 0, 0}},
               {"min", 0},
               {"max", 30},
               {"spring", {{"stiffness", 200}, {"rest", -5}}},
               {"click", {{"at", 10}, {"drop", 1}, {"width", 2}}},
               {"detents", {{"count", 4}, {"force", 1}}}};
  const Control c = loaded(withControl(json), mm).controls.at(0);
  EXPECT_DOUBLE_EQ(c.max, 0.03);
  EXPECT_DOUBLE_EQ(c.springRest, -0.005);
  EXPECT_EQ(c.springStiffness, 200.0);
  EXPECT_DOUBLE_EQ(c.click.at, 0.01);
  EXPECT_DOUBLE_EQ(c.click.width, 0.002);
  ASSERT_EQ(c.detents.places.size(), 4u);
  EXPECT_DOUBLE_EQ(c.detents.places[1], 0.01);
  const Json dial = {{"kind", "dial"}, {"axis", {1, 0, 0}}, {"min", 0}, {"max", 3}};
  EXPECT_DOUBLE_EQ(loaded(withControl(dial), mm).controls.at(0).max, 3.0);
}

TEST(GltfControls, ADialWithoutStopsIsEndlessAndItsDetentsGoAround) {
  const Json dial = {{"kind", "dial"}, {"axis", {0, 1, 0}}, {"detents", {{"count", 12}, {"force", 0.02}}}};
  const Control c = loaded(withControl(dial)).controls.at(0);
  EXPECT_TRUE(c.endless);
  ASSERT_EQ(c.detents.places.size(), 12u);
  EXPECT_NEAR(c.detents.places[11], kPi - kPi / 6.0, 1e-12);
  EXPECT_NEAR(admissible(c, 3.5), 3.5 - 2.0 * kPi, 1e-12);
}

TEST(GltfControls, ADialsInertiaIsThatAboutItsAxis) {
  Json dial = {{"kind", "dial"}, {"axis", {0, 0, 1}}, {"origin", {3, 0, 0}}};
  // A cube of 1 m and 2 kg, 3 m from the axis: m/6 + m d^2.
  EXPECT_NEAR(loaded(withControl(dial)).controls.at(0).inertia, 2.0 / 6.0 + 2.0 * 9.0, 1e-6);
}

/// The knob's joint with the fixed frame: free along Y, or about it.
GltfBuilder withJoint(const char* kind, bool knobIsA) {
  GltfBuilder b = withControl({{"kind", kind}});
  const bool dial = std::string(kind) == "dial";
  const char *open = dial ? "angularAxes" : "linearAxes", *locked = dial ? "linearAxes" : "angularAxes";
  b.json["extensions"][kRigidBodies]["physicsJoints"] = {{{"limits",
                                                           {{{locked, {0, 1, 2}}, {"min", 0}, {"max", 0}},
                                                            {{open, {0, 2}}, {"min", 0}, {"max", 0}},
                                                            {{open, {1}}, {"min", -0.5}, {"max", 1.5}}}}}};
  b.json["nodes"][knobIsA ? 0 : 1]["extensions"][kRigidBodies]["joint"] = {{"connectedNode", knobIsA ? 1 : 0},
                                                                           {"joint", 0}};
  return b;
}

TEST(GltfControls, TakesAxisStopsAndValueFromAJoint) {
  for (const char* kind : {"slider", "dial"}) {
    for (const bool knobIsA : {false, true}) {
      GltfBuilder b = withJoint(kind, knobIsA);
      b.json["nodes"][1]["translation"] = {0, -0.25, 0};
      const Scene scene = loaded(b);
      ASSERT_EQ(scene.controls.size(), 1u);
      const Control& c = scene.controls[0];
      // The joint measures its B from its A: what is A moves against the axis.
      EXPECT_LT(glm::distance(axisOf(c), glm::dvec3(0, knobIsA ? -1 : 1, 0)), 1e-12) << kind;
      EXPECT_EQ(c.min, -0.5);
      EXPECT_EQ(c.max, 1.5);
      EXPECT_NEAR(c.initial, std::string(kind) == "dial" ? 0.0 : (knobIsA ? -0.25 : 0.25), 1e-12) << knobIsA;
      EXPECT_NEAR(controlValue(c, scene.parts[c.part].worldFromPart), c.initial, 1e-12);
    }
  }
}

TEST(GltfControls, ALayerNamesTheNodesThatItShows) {
  Json layer = kSlider;
  layer.update({{"kind", "layer"}, {"shows", {2}}});
  const Scene scene = loaded(withControl(layer));
  const Control& c = scene.controls.at(0);
  EXPECT_EQ(c.shows, std::vector<PartId>{findPart(scene, "shown")});
  EXPECT_NEAR(c.threshold, 0.01, 1e-15);
  EXPECT_FALSE(isShowing(c, 0.009));
  EXPECT_TRUE(isShowing(c, 0.011));
}

TEST(GltfControls, SurvivesThePackage) {
  Json json = kSlider;
  json.update({{"kind", "layer"},
               {"shows", {2}},
               {"detents", {{"positions", {0.0, 0.01}}, {"force", 0.6}}},
               {"click", {{"at", 0.02}, {"drop", 0.7}, {"width", 0.001}}}});
  const Scene scene = loaded(withControl(json));
  const Result<Scene> again = decodeScene(encodeScene(scene));
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(encodeScene(*again), encodeScene(scene));
  EXPECT_EQ(again->controls.at(0).detents.places, scene.controls[0].detents.places);
  EXPECT_EQ(again->controls.at(0).shows, scene.controls[0].shows);
}

TEST(GltfControls, SaysWhatIsWrongAndWhere) {
  const auto with = [](const Json& change) {
    Json json = kSlider;
    json.update(change);
    return withControl(json);
  };
  const auto without = [](const char* key) {
    Json json = kSlider;
    json.erase(key);
    return withControl(json);
  };
  expectRefused(with({{"kind", "lever"}}), "nodes[0].extras.haptic.control.kind");
  expectRefused(without("axis"), "control.axis");
  expectRefused(with({{"axis", {0, 0, 0}}}), "control.axis");
  expectRefused(without("max"), "control.max");
  expectRefused(with({{"max", -1.0}}), "control.max");
  expectRefused(with({{"value", 0.5}}), "control.value");
  expectRefused(with({{"friction", -1.0}}), "control.friction");
  expectRefused(with({{"inertia", 0.0}}), "control.inertia");
  expectRefused(with({{"click", {{"at", 0.2}, {"drop", 1.0}}}}), "control.click.at");
  expectRefused(with({{"detents", {{"force", 1.0}}}}), "control.detents.count");
  expectRefused(with({{"detents", {{"count", 1}}}}), "control.detents.count");
  expectRefused(with({{"detents", {{"positions", {0.02, 0.01}}}}}), "control.detents.positions");
  expectRefused(with({{"detents", {{"positions", {0.5}}}}}), "control.detents.positions");
  expectRefused(with({{"detents", {{"positions", {0.0}}, {"force", 1.0}}}}), "control.detents.width");
  expectRefused(with({{"roles", {"visitor"}}}), "control.roles");
  expectRefused(with({{"roles", {"observer"}}}), "control.roles");
  expectRefused(with({{"shows", {2}}}), "control.shows");
  expectRefused(with({{"kind", "layer"}}), "control.shows");
  expectRefused(with({{"kind", "layer"}, {"shows", {0}}}), "control.shows");
  expectRefused(with({{"kind", "layer"}, {"shows", {7}}}), "control.shows");
  expectRefused(withControl({{"kind", "dial"}, {"axis", {1, 0, 0}}, {"min", -4}, {"max", 4}}), "control.max");
  GltfBuilder fixed = with(Json::object());
  fixed.json["nodes"][0]["extensions"].erase(kRigidBodies);
  expectRefused(fixed, "must be a body with a motion");
  GltfBuilder both = withJoint("slider", true);
  both.json["nodes"][0]["extras"]["haptic"]["control"]["axis"] = {1, 0, 0};
  expectRefused(both, "is given by the joint");
}

TEST(SceneCheck, RefusesControlsThatCannotBe) {
  const Scene good = loaded(withControl(kSlider));
  ASSERT_TRUE(checkScene(good).ok());
  const auto refused = [&](auto&& change) {
    Scene scene = good;
    change(scene.controls[0]);
    return !checkScene(scene).ok();
  };
  EXPECT_TRUE(refused([](Control& c) { c.part = 99; }));
  EXPECT_TRUE(refused([](Control& c) { c.part = 1; }));  // does not move
  EXPECT_TRUE(refused([](Control& c) { c.max = c.min; }));
  EXPECT_TRUE(refused([](Control& c) { c.initial = 1.0; }));
  EXPECT_TRUE(refused([](Control& c) { c.inertia = 0.0; }));
  EXPECT_TRUE(refused([](Control& c) { c.damping = std::nan(""); }));
  EXPECT_TRUE(refused([](Control& c) { c.endless = true; }));
  EXPECT_TRUE(refused([](Control& c) { c.detents.places = {0.02, 0.01}; }));
  EXPECT_TRUE(refused([](Control& c) { c.click.drop = 1.0; }));
  EXPECT_TRUE(refused([](Control& c) { c.shows = {9}; }));
  EXPECT_TRUE(refused([](Control& c) { c.kind = static_cast<ControlKind>(9); }));
  Scene twice = good;
  twice.controls.push_back(good.controls[0]);
  EXPECT_FALSE(checkScene(twice).ok());
}

}  // namespace
}  // namespace tandem::assets
