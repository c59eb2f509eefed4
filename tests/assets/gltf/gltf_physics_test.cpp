#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "assets/gltf/load_gltf.h"
#include "assets/scene/scene_check.h"
#include "tests/assets/gltf/findings.h"
#include "tests/assets/gltf/load_for_test.h"
#include "tests/support/gltf_builder.h"

namespace tandem::assets {
namespace {

using tests::GltfBuilder;
using Json = nlohmann::json;

constexpr const char* kBodies = "KHR_physics_rigid_bodies";

Json physics(const Json& value) { return {{kBodies, value}}; }

/// A file with one shape, one physics material with extras.haptic, and one movable box.
GltfBuilder bodyWithBox(const Json& motion = Json::object()) {
  GltfBuilder b;
  b.json["extensions"][kBodies]["physicsMaterials"] = {
      {{"staticFriction", 0.5},
       {"dynamicFriction", 0.4},
       {"restitution", 0.1},
       {"extras", {{"haptic", {{"stiffness", 1200}, {"damping", 2}}}}}}};
  const int box = b.addBox(1, 1, 1, "box");
  b.addNode({{"name", "body"},
             {"mesh", box},
             {"extensions", physics({{"motion", motion},
                                     {"collider", {{"geometry", {{"node", 0}}}, {"physicsMaterial", 0}}}})}});
  return b;
}

TEST(GltfPhysics, TakesANodeWithMotionAsAMovablePart) {
  const Scene scene =
      loaded(bodyWithBox({{"mass", 3}, {"centerOfMass", {0.1, 0, 0}}, {"gravityFactor", 0.5}}));
  ASSERT_EQ(scene.parts.size(), 1u);
  const Part& part = scene.parts[0];
  EXPECT_EQ(part.name, "body");
  EXPECT_TRUE(part.movable);
  EXPECT_FALSE(part.kinematic);
  EXPECT_DOUBLE_EQ(part.massProperties.mass, 3.0);
  EXPECT_DOUBLE_EQ(part.massProperties.centreOfMass.x, 0.1);
  // Of a cube of 3 kg, since the file states no inertia.
  EXPECT_NEAR(part.massProperties.inertia[1][1], 3.0 / 6.0, 1e-9);
  EXPECT_DOUBLE_EQ(part.gravityFactor, 0.5);
}

TEST(GltfPhysics, GivesTrianglesTheFeelOfTheirPhysicsMaterial) {
  const Scene scene = loaded(bodyWithBox());
  const Material& material = scene.materials[scene.meshes[0].triangleMaterial[0]];
  EXPECT_DOUBLE_EQ(material.stiffness, 1200.0);
  EXPECT_DOUBLE_EQ(material.damping, 2.0);
  EXPECT_DOUBLE_EQ(material.staticFriction, 0.5);
  EXPECT_DOUBLE_EQ(material.dynamicFriction, 0.4);
  EXPECT_DOUBLE_EQ(material.restitution, 0.1);
}

TEST(GltfPhysics, KeepsLargeWholeNumbers) {
  // tinygltf's own values cut whole numbers to 32 bits.
  GltfBuilder b = bodyWithBox();
  for (nlohmann::json& node : b.json["nodes"])
    if (node.contains("extensions")) node["extensions"][kBodies]["motion"]["mass"] = 10000000000ll;
  const Scene scene = loaded(b);
  EXPECT_DOUBLE_EQ(scene.parts[0].massProperties.mass, 1e10);
}

TEST(GltfPhysics, OneCoefficientOfFrictionStatedAloneLeavesTheOtherAtItsDefault) {
  GltfBuilder b = bodyWithBox();
  b.json["extensions"][kBodies]["physicsMaterials"][0] = {{"staticFriction", 0.9}};
  const Scene khr = loaded(b);
  const Material& physics = khr.materials[khr.meshes[0].triangleMaterial[0]];
  EXPECT_DOUBLE_EQ(physics.staticFriction, 0.9);
  EXPECT_DOUBLE_EQ(physics.dynamicFriction, 0.6);
  GltfBuilder plain;
  plain.addNode({{"mesh", plain.addBox(1, 1, 1)}, {"extras", {{"haptic", {{"staticFriction", 0.9}}}}}});
  const Scene own = loaded(plain);
  const Material& material = own.materials[own.meshes[0].triangleMaterial[0]];
  EXPECT_DOUBLE_EQ(material.staticFriction, 0.9);
  EXPECT_DOUBLE_EQ(material.dynamicFriction, 0.0);
}

TEST(GltfPhysics, FallsBackToTheNodesOwnHapticExtras) {
  GltfBuilder b;
  b.addNode({{"mesh", b.addBox(1, 1, 1)}, {"extras", {{"haptic", {{"stiffness", 700}, {"sparkle", 1}}}}}});
  const Scene scene = loaded(b);
  EXPECT_DOUBLE_EQ(scene.materials[scene.meshes[0].triangleMaterial[0]].stiffness, 700.0);
  EXPECT_DOUBLE_EQ(scene.materials[scene.meshes[0].triangleMaterial[0]].staticFriction, 0.0);
  EXPECT_NE(findingOf(scene, "unused-haptic-property"), nullptr);
}

TEST(GltfPhysics, APartHasTheStrictestToleranceOfItsNodesWhateverTheFilesUnit) {
  const auto tolerance = [](double value) { return Json{{"haptic", {{"tolerance", value}}}}; };
  GltfBuilder b = bodyWithBox();
  b.json["nodes"][0]["extras"] = tolerance(5e-6);
  const int below = b.addOrphan({{"mesh", b.addBox(1, 1, 1)}, {"extras", tolerance(2e-6)}});
  b.json["nodes"][0]["children"] = {below};
  b.addNode({{"name", "other"}, {"mesh", b.addBox(1, 1, 1)}});
  LoadOptions millimetres;
  millimetres.unitScale = 1e-3;
  for (const LoadOptions& options : {LoadOptions{}, millimetres}) {
    const Scene scene = loaded(b, options);
    ASSERT_EQ(scene.parts.size(), 2u);
    EXPECT_EQ(scene.parts[findPart(scene, "body")].contactTolerance, 2e-6);
    EXPECT_EQ(scene.parts[findPart(scene, "other")].contactTolerance, 0.0);
    EXPECT_EQ(findingOf(scene, "unused-haptic-property"), nullptr);
    // A tolerance says nothing of how the surface feels.
    const Mesh& mesh = scene.meshes[scene.parts[findPart(scene, "body")].mesh];
    EXPECT_EQ(scene.materials[mesh.triangleMaterial[0]].stiffness, 1200.0);
  }
}

TEST(GltfPhysics, GathersDescendantsWithoutMotionIntoTheBody) {
  GltfBuilder b;
  const int box = b.addBox(1, 1, 1, "box");
  const int handle = b.addOrphan({{"mesh", box}, {"translation", {2, 0, 0}}, {"scale", {1, 3, 1}}});
  const int lid = b.addOrphan({{"name", "lid"},
                               {"mesh", box},
                               {"translation", {0, 9, 0}},
                               {"extensions", physics({{"motion", Json::object()}})}});
  b.addNode({{"name", "pot"},
             {"mesh", box},
             {"children", {handle, lid}},
             {"translation", {0, 0, 4}},
             {"extensions", physics({{"motion", Json::object()}})}});
  b.addNode({{"name", "table"}, {"mesh", box}, {"translation", {0, 0, -5}}});
  LoadOptions options;
  options.density = 100.0;
  const Scene scene = loaded(b, options);
  ASSERT_EQ(scene.parts.size(), 3u);
  const Part& pot = scene.parts[findPart(scene, "pot")];
  EXPECT_EQ(triangleCount(scene, pot), 24u);
  EXPECT_NEAR(scene.meshes[pot.mesh].bounds.max.x, 2.5, 1e-12);
  EXPECT_NEAR(scene.meshes[pot.mesh].bounds.max.y, 1.5, 1e-12);
  EXPECT_NEAR(pot.massProperties.mass, 400.0, 1e-6);
  EXPECT_NEAR(pot.massProperties.centreOfMass.x, 1.5, 1e-9);
  const Part& lidPart = scene.parts[findPart(scene, "lid")];
  EXPECT_TRUE(lidPart.movable);
  EXPECT_EQ(lidPart.worldFromPart.position, glm::dvec3(0, 9, 4));
  EXPECT_FALSE(scene.parts[findPart(scene, "table")].movable);
}

TEST(GltfPhysics, TurnsStatedInertiaIntoPartAxes) {
  const double s = std::sqrt(0.5);
  const Scene scene = loaded(
      bodyWithBox({{"mass", 1}, {"inertiaDiagonal", {1, 2, 3}}, {"inertiaOrientation", {0, 0, s, s}}}));
  const glm::dmat3& inertia = scene.parts[0].massProperties.inertia;
  EXPECT_NEAR(inertia[0][0], 2.0, 1e-12);
  EXPECT_NEAR(inertia[1][1], 1.0, 1e-12);
  EXPECT_NEAR(inertia[2][2], 3.0, 1e-12);
}

TEST(GltfPhysics, TakesInfiniteMassAndIsKinematicAsKinematic) {
  EXPECT_TRUE(loaded(bodyWithBox({{"isKinematic", true}})).parts[0].kinematic);
  EXPECT_TRUE(loaded(bodyWithBox({{"mass", 0}})).parts[0].kinematic);
}

TEST(GltfPhysics, ReadsImplicitShapesExactly) {
  GltfBuilder b;
  b.json["extensions"]["KHR_implicit_shapes"]["shapes"] = {
      {{"type", "box"}, {"box", {{"size", {1, 2, 3}}}}},
      {{"type", "sphere"}, {"sphere", {{"radius", 0.25}}}},
      {{"type", "capsule"}, {"capsule", {{"height", 2}, {"radiusTop", 0.1}, {"radiusBottom", 0.2}}}},
      {{"type", "cylinder"}},
      {{"type", "plane"}, {"plane", {{"sizeX", 4}, {"sizeZ", 5}}}}};
  for (int shape = 0; shape < 5; ++shape)
    b.addNode({{"name", std::string("s").append(std::to_string(shape))},
               {"scale", {2, 2, 2}},
               {"translation", {shape, 0, 0}},
               {"extensions", physics({{"collider", {{"geometry", {{"shape", shape}}}}}})}});
  const Scene scene = loaded(b);
  ASSERT_EQ(scene.parts.size(), 5u);
  for (const Part& part : scene.parts) EXPECT_EQ(part.shapes.size(), 1u);
  EXPECT_NEAR(glm::length(scene.parts[0].shapes[0].size - glm::dvec3(2, 4, 6)), 0.0, 1e-12);
  EXPECT_NEAR(scene.parts[1].shapes[0].radiusBottom, 0.5, 1e-12);
  EXPECT_NEAR(scene.parts[2].shapes[0].height, 4.0, 1e-12);
  EXPECT_NEAR(scene.parts[2].shapes[0].radiusTop, 0.2, 1e-12);
  EXPECT_NEAR(scene.parts[3].shapes[0].height, 1.0, 1e-12);  // KHR's defaults
  EXPECT_NEAR(scene.parts[3].shapes[0].radiusTop, 0.5, 1e-12);
  EXPECT_EQ(scene.parts[4].shapes[0].kind, ImplicitShape::Kind::plane);
  EXPECT_EQ(findingOf(scene, "approximated-shape"), nullptr);
}

TEST(GltfPhysics, PlacesShapesOfChildrenInTheBodyAndWeighsThem) {
  GltfBuilder b;
  b.json["extensions"]["KHR_implicit_shapes"]["shapes"] = {{{"type", "sphere"}, {"sphere", {{"radius", 1}}}}};
  const Json ball = physics({{"collider", {{"geometry", {{"shape", 0}}}}}});
  const int left = b.addOrphan({{"translation", {-3, 0, 0}}, {"extensions", ball}});
  const int right = b.addOrphan({{"translation", {3, 0, 0}}, {"extensions", ball}});
  b.addNode({{"name", "dumbbell"},
             {"children", {left, right}},
             {"extensions", physics({{"motion", Json::object()}})}});
  LoadOptions options;
  options.density = 1.0;
  const Scene scene = loaded(b, options);
  ASSERT_EQ(scene.parts.size(), 1u);
  const MassProperties& m = scene.parts[0].massProperties;
  const double ball1 = 4.0 / 3.0 * 3.14159265358979;
  EXPECT_NEAR(m.mass, 2 * ball1, 1e-9);
  EXPECT_NEAR(m.inertia[0][0], 2 * 0.4 * ball1, 1e-9);
  EXPECT_NEAR(m.inertia[1][1], 2 * ball1 * (0.4 + 9), 1e-9);
  EXPECT_EQ(scene.parts[0].shapes[1].partFromShape.position, glm::dvec3(3, 0, 0));
}

TEST(GltfPhysics, SaysWhenAScaledShapeIsNoLongerOne) {
  GltfBuilder b;
  b.json["extensions"]["KHR_implicit_shapes"]["shapes"] = {{{"type", "sphere"}}};
  b.addNode({{"scale", {1, 2, 1}}, {"extensions", physics({{"collider", {{"geometry", {{"shape", 0}}}}}})}});
  EXPECT_NE(findingOf(loaded(b), "approximated-shape"), nullptr);
}

TEST(GltfPhysics, AcceptsTheOldColliderFormWithANote) {
  GltfBuilder b;
  b.json["extensions"]["KHR_implicit_shapes"]["shapes"] = {{{"type", "sphere"}}};
  b.addNode({{"extensions", physics({{"collider", {{"shape", 0}}}})}});
  const Scene scene = loaded(b);
  EXPECT_EQ(scene.parts[0].shapes.size(), 1u);
  EXPECT_NE(findingOf(scene, "old-collider-form"), nullptr);
}

TEST(GltfPhysics, TakesTheMeshOfAnotherNodeForAPartThatShowsNothing) {
  GltfBuilder b;
  b.addOrphan({{"mesh", b.addBox(1, 1, 1)}});  // not in the scene
  b.addNode({{"name", "ghost"},
             {"scale", {2, 2, 2}},
             {"extensions", physics({{"collider", {{"geometry", {{"node", 0}}}}}})}});
  const Scene scene = loaded(b);
  ASSERT_EQ(scene.parts.size(), 1u);
  EXPECT_NEAR(scene.bounds.max.x, 1.0, 1e-12);
}

TEST(GltfPhysics, MapsCollisionSystemsToBits) {
  GltfBuilder b;
  b.json["extensions"][kBodies]["collisionFilters"] = {
      {{"collisionSystems", {"a"}}, {"notCollideWithSystems", {"b"}}},
      {{"collisionSystems", {"b"}}, {"collideWithSystems", {"c"}}}};
  const int box = b.addBox(1, 1, 1);
  for (int i = 0; i < 2; ++i)
    b.addNode(
        {{"mesh", box},
         {"extensions", physics({{"collider", {{"geometry", {{"node", i}}}, {"collisionFilter", i}}}})}});
  b.addNode({{"mesh", box}});
  const Scene scene = loaded(b);
  const CollisionFilter a = scene.parts[0].filter, c = scene.parts[1].filter, none = scene.parts[2].filter;
  EXPECT_EQ(a.collidesWith & c.memberOf, 0u);
  EXPECT_NE(a.collidesWith & none.memberOf, 0u);
  EXPECT_NE(a.collidesWith & a.memberOf, 0u);
  EXPECT_EQ(c.collidesWith & none.memberOf, 0u);
  EXPECT_EQ(none.collidesWith, ~std::uint64_t{0});
}

/// A door of 1 x 1 x 1 at x = 1, hinged to the world at x = 0.5 by node 1.
GltfBuilder door(const char* extension) {
  GltfBuilder b;
  b.json["extensions"][extension]["physicsJoints"] = {
      {{"limits",
        {{{"linearAxes", {0, 1, 2}}, {"min", 0}, {"max", 0}},
         {{"angularAxes", {1, 2}}, {"min", 0}, {"max", 0}},
         {{"angularAxes", {0}}, {"min", -0.5}},
         {{"linearAxes", {0}}, {"min", -10}, {"max", 20}, {"stiffness", 5}, {"damping", 1}}}},
       {"drives",
        {{{"type", "angular"},
          {"mode", "force"},
          {"axis", 0},
          {"velocityTarget", 1},
          {"damping", 2},
          {"maxForce", 9}}}}}};
  const int box = b.addBox(1, 1, 1);
  const int hinge = b.addOrphan({{"name", "hinge"}, {"translation", {-0.5, 0, 0}}});
  b.addNode({{"name", "door"},
             {"mesh", box},
             {"translation", {1, 0, 0}},
             {"children", {hinge}},
             {"extensions", physics({{"motion", {{"mass", 1}}}})}});
  b.addNode({{"name", "frame"}, {"translation", {0.5, 0, 0}}});
  return b;
}

TEST(GltfPhysics, ReadsJointsWithLimitsAndDrives) {
  GltfBuilder b = door(kBodies);
  b.json["nodes"][0]["extensions"] =
      physics({{"joint", {{"connectedNode", 2}, {"joint", 0}, {"enableCollision", true}}}});
  LoadOptions options;
  options.unitScale = 0.001;
  const Scene scene = loaded(b, options);
  ASSERT_EQ(scene.joints.size(), 1u);
  const Joint& joint = scene.joints[0];
  EXPECT_EQ(joint.name, "hinge");
  EXPECT_EQ(joint.partA, findPart(scene, "door"));
  EXPECT_EQ(joint.partB, kNoPart);
  EXPECT_TRUE(joint.collide);
  EXPECT_NEAR(joint.aFromJoint.position.x, -0.0005, 1e-15);
  EXPECT_NEAR(joint.bFromJoint.position.x, 0.0005, 1e-15);
  ASSERT_EQ(joint.limits.size(), 4u);
  EXPECT_EQ(joint.limits[1].axes, 6);
  EXPECT_TRUE(joint.limits[2].angular);
  EXPECT_DOUBLE_EQ(joint.limits[2].min, -0.5);
  EXPECT_GT(joint.limits[2].max, 1e299);
  EXPECT_NEAR(joint.limits[3].max, 0.020, 1e-15);
  EXPECT_DOUBLE_EQ(joint.limits[3].stiffness, 5.0);
  ASSERT_EQ(joint.drives.size(), 1u);
  EXPECT_DOUBLE_EQ(joint.drives[0].maxForce, 9.0);
}

TEST(GltfPhysics, ReadsThreadsAndDetentsOfJointsInFileUnits) {
  GltfBuilder b = door(kBodies);
  nlohmann::json& stated = b.json["extensions"][kBodies]["physicsJoints"][0];
  const nlohmann::json detents = {{"type", "linear"}, {"positions", {1, 3}}, {"force", 2}};
  stated["extras"] = {{"haptic", {{"pitch", 2.0}, {"detents", detents}}}};
  b.json["nodes"][0]["extensions"] = physics({{"joint", {{"connectedNode", 2}, {"joint", 0}}}});
  LoadOptions options;
  options.unitScale = 0.001;
  const Joint joint = loaded(b, options).joints.at(0);
  EXPECT_DOUBLE_EQ(joint.pitch, 0.002);
  ASSERT_EQ(joint.detents.places.size(), 2u);
  EXPECT_DOUBLE_EQ(joint.detents.places[1], 0.003);
  EXPECT_DOUBLE_EQ(joint.detents.force, 2.0);
  EXPECT_FALSE(joint.detentsTurn);
  const auto refused = [&](const nlohmann::json& haptic) {
    stated["extras"] = {{"haptic", haptic}};
    return !loadGltfFromMemory("test.glb", b.glb(), options).ok();
  };
  EXPECT_TRUE(refused({{"pitch", 1e300}}));
  EXPECT_TRUE(refused({{"detents", {{"type", "linear"}, {"positions", {3, 1}}}}}));
  EXPECT_TRUE(refused({{"detents", {{"type", "linear"}, {"positions", {3}}}}}));
  EXPECT_TRUE(refused({{"detents", {{"type", "sideways"}, {"positions", {1, 3}}}}}));
  EXPECT_FALSE(refused({{"pitch", -2.0}}));
}

/// Whole turns are counted about the first axis only: about another one a target beyond half a turn is never
/// reached.
TEST(GltfPhysics, RefusesADriveThatCannotArrive) {
  GltfBuilder b = door(kBodies);
  nlohmann::json& drive = b.json["extensions"][kBodies]["physicsJoints"][0]["drives"][0];
  b.json["nodes"][0]["extensions"] = physics({{"joint", {{"connectedNode", 2}, {"joint", 0}}}});
  const auto refused = [&](int axis, double target) {
    drive["axis"] = axis;
    drive["positionTarget"] = target;
    return !loadGltfFromMemory("test.glb", b.glb(), {}).ok();
  };
  EXPECT_FALSE(refused(0, 20.0));
  EXPECT_FALSE(refused(1, 3.1));
  EXPECT_TRUE(refused(1, 3.2));
  EXPECT_TRUE(refused(2, -3.2));
}

TEST(GltfPhysics, LeavesOutJointsBetweenThingsThatNeverMove) {
  GltfBuilder b = door(kBodies);
  b.json["nodes"][1].erase("extensions");
  b.json["nodes"][0]["extensions"] = physics({{"joint", {{"connectedNode", 2}, {"joint", 0}}}});
  const Scene scene = loaded(b);
  EXPECT_TRUE(scene.joints.empty());
  EXPECT_NE(findingOf(scene, "idle-joint"), nullptr);
}

TEST(GltfPhysics, ReadsOmiBodiesShapesJointsAndGravityAlike) {
  GltfBuilder b = door("OMI_physics_joint");
  b.json["extensions"]["OMI_physics_shape"]["shapes"] = {{{"type", "capsule"}},
                                                         {{"type", "trimesh"}, {"trimesh", {{"mesh", 0}}}}};
  b.json["extensions"]["OMI_physics_gravity"] = {{"gravity", 9.81}};
  b.json["nodes"][0]["extensions"] = {{"OMI_physics_joint", {{"connectedNode", 2}, {"joint", 0}}}};
  b.json["nodes"][1]["extensions"] = {
      {"OMI_physics_body", {{"motion", {{"type", "dynamic"}}}, {"collider", {{"shape", 1}}}}}};
  b.addNode({{"name", "post"},
             {"extensions",
              {{"OMI_physics_body", {{"motion", {{"type", "static"}}}, {"collider", {{"shape", 0}}}}}}}});
  const Scene scene = loaded(b);
  const Part& doorPart = scene.parts[findPart(scene, "door")];
  EXPECT_TRUE(doorPart.movable);
  EXPECT_DOUBLE_EQ(doorPart.massProperties.mass, 1.0);
  EXPECT_NEAR(doorPart.massProperties.inertia[0][0], 1.0 / 6.0, 1e-9);
  const Part& post = scene.parts[findPart(scene, "post")];
  EXPECT_FALSE(post.movable);
  EXPECT_DOUBLE_EQ(post.shapes[0].radiusTop, 0.5);  // OMI's default, not KHR's
  EXPECT_EQ(scene.joints.size(), 1u);
  EXPECT_EQ(scene.gravity, glm::dvec3(0, -9.81, 0));
}

TEST(GltfPhysics, NotesTriggers) {
  GltfBuilder b = bodyWithBox();
  b.json["extensions"]["KHR_implicit_shapes"]["shapes"] = {{{"type", "sphere"}}};
  b.addNode({{"extensions", physics({{"trigger", {{"geometry", {{"shape", 0}}}}}})}});
  EXPECT_NE(findingOf(loaded(b), "trigger"), nullptr);
}

TEST(GltfPhysics, RefusesBrokenPhysicsByPlace) {
  const auto broken = [](const char* pointer, const Json& value, const std::string& place) {
    GltfBuilder b = door(kBodies);
    b.json["extensions"]["KHR_implicit_shapes"]["shapes"] = {{{"type", "sphere"}}};
    b.json["nodes"][0]["extensions"] = physics({{"joint", {{"connectedNode", 2}, {"joint", 0}}}});
    b.json[Json::json_pointer(pointer)] = value;
    expectRefused(b, place);
  };
  broken("/extensions/KHR_implicit_shapes/shapes/0/type", "blob", "shapes[0].type");
  broken("/extensions/KHR_implicit_shapes/shapes/0/sphere", {{"radius", -1}}, "shapes[0].sphere.radius");
  broken("/nodes/0/extensions/KHR_physics_rigid_bodies/joint/joint", 4,
         "nodes[0].KHR_physics_rigid_bodies.joint.joint");
  broken("/nodes/0/extensions/KHR_physics_rigid_bodies/joint/connectedNode", 99, "joint.connectedNode");
  broken("/nodes/1/extensions/KHR_physics_rigid_bodies/motion/mass", -1, "motion.mass");
  broken("/nodes/1/extensions/KHR_physics_rigid_bodies/motion/mass", "heavy", "motion.mass");
  broken("/nodes/1/extensions/KHR_physics_rigid_bodies/motion/gravityFactor", 1e300, "motion.gravityFactor");
  broken("/extensions/OMI_physics_gravity", {{"gravity", 1e300}}, "OMI_physics_gravity.gravity");
  broken("/nodes/1/extensions/KHR_physics_rigid_bodies/motion/inertiaOrientation", {0, 0, 0, 0},
         "inertiaOrientation");
  broken("/nodes/2/extensions", physics({{"collider", {{"geometry", {{"shape", 3}}}}}}),
         "collider.geometry.shape");
  broken("/extensions/KHR_physics_rigid_bodies/physicsJoints/0/limits/0/linearAxes", {7},
         "limits[0].linearAxes");
  broken("/extensions/KHR_physics_rigid_bodies/physicsJoints/0/limits/0/min", 5, "limits[0].min");
  broken("/extensions/KHR_physics_rigid_bodies/physicsJoints/0/drives/0/axis", 3, "drives[0].axis");
}

}  // namespace
}  // namespace tandem::assets
