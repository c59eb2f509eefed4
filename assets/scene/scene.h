#pragma once

// A scene after loading: plain data in SI units that every folder may read.
//
// loadGltf() or unpackScene() builds it; it never changes after that, so every thread may read it.
// 1. Every part is rigid: scales and shears of the file's nodes are baked into its mesh, so
//    Part::worldFromPart has none. Instances with the same baked linear part share one Mesh.
// 2. Ids are indices: PartId into parts, mesh into meshes, material into materials.
// 3. Every number is finite, every index in range (checked by the loader and again by unpackScene).

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "assets/base/ids.h"
#include "assets/base/pose.h"
#include "assets/scene/bounds.h"
#include "assets/scene/control.h"
#include "assets/scene/force_field.h"
#include "assets/scene/surface.h"

namespace tandem::assets {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// Appearance and contact properties of a surface.
struct Material {
  std::string name;
  std::array<float, 4> baseColour{0.7f, 0.7f, 0.72f, 1.0f};  // linear RGBA, 0..1
  float metallic = 0.0f;                                     // 0..1
  float roughness = 0.7f;                                    // 0..1
  double stiffness = 0.0;                                    // N/m; 0 = the tool's default
  double damping = 0.0;                                      // N·s/m
  double staticFriction = 0.0;    // Coulomb coefficient; README.md of assets/gltf states its defaults
  double dynamicFriction = 0.0;   // Coulomb coefficient
  double restitution = 0.0;       // 0..1
  std::uint32_t surface = kNone;  // into Scene::surfaces; kNone: nothing but the above
};

/// Flags of a triangle's edge e, the edge from corner e to corner (e + 1) % 3.
enum EdgeFlag : std::uint8_t {
  kEdgeSharp = 1,        // dihedral angle above LoadOptions::creaseAngle
  kEdgeBoundary = 2,     // no triangle on the other side
  kEdgeNonManifold = 4,  // more than two triangles meet here
};

/// A triangle mesh in its part's frame, with the topology that contact and rendering need. V vertices, T
/// triangles. After welding: no two triangles that are neighbours have separate copies of a vertex.
struct Mesh {
  std::vector<glm::dvec3> positions;                     // V, m
  std::vector<std::array<std::uint32_t, 3>> triangles;   // T, counter-clockwise seen from outside
  std::vector<std::uint16_t> triangleMaterial;           // T, into Scene::materials
  std::vector<std::array<std::uint32_t, 3>> neighbours;  // T, triangle across edge e, or kNone
  std::vector<std::array<std::uint8_t, 3>> edgeFlags;    // T, EdgeFlag bits of edge e
  std::vector<std::uint32_t> triangleShell;  // T, index of the connected shell; empty after dropShells()
  std::vector<std::array<glm::vec2, 3>> triangleUv;  // T, texture coordinates of the corners; empty unless a
                                                     // surface of the mesh has an image
  std::vector<std::array<glm::vec3, 3>> triangleNormal;  // T, unit, of the corners, as the file has them;
                                                         // empty unless they say more than the facets
  std::uint32_t shellCount = 0;
  bool closed = false;  // every edge has exactly two triangles, oriented alike
  double volume = 0.0;  // m^3; 0 unless closed
  Bounds bounds;        // m, part frame
};

/// A primitive collider of KHR_implicit_shapes, exact, in its own frame within the part.
struct ImplicitShape {
  enum class Kind : std::uint8_t { box, sphere, capsule, cylinder, plane };
  Kind kind = Kind::box;
  Pose partFromShape;
  glm::dvec3 size{1.0, 1.0, 1.0};  // box: full extents; plane: x and z extents, 0 = infinite; m
  double height = 0.5;             // capsule (between sphere centres), cylinder; along +Y; m
  double radiusTop = 0.25;         // capsule, cylinder; m
  double radiusBottom = 0.25;      // capsule, cylinder; sphere uses this one; m
  std::uint16_t material = 0;
};

/// Inertia of a movable part.
struct MassProperties {
  double mass = 0.0;                       // kg; 0 = unknown (a static part)
  glm::dvec3 centreOfMass{0.0, 0.0, 0.0};  // m, part frame
  glm::dmat3 inertia{0.0};                 // kg·m^2, about the centre of mass, part axes
};

/// Which other parts a part may touch: KHR collision filter, by bit. Two parts collide only if both allow it.
struct CollisionFilter {
  std::uint64_t memberOf = 1;
  std::uint64_t collidesWith = ~std::uint64_t{0};
};

inline bool mayCollide(const CollisionFilter& a, const CollisionFilter& b) {
  return (a.collidesWith & b.memberOf) != 0 && (b.collidesWith & a.memberOf) != 0;
}

/// One rigid thing. Static unless movable; a movable part can be taken by a hand.
struct Part {
  std::string name;                   // unique within the scene
  std::uint32_t treeNode = kNone;     // into Scene::tree
  std::uint32_t mesh = kNone;         // into Scene::meshes; kNone if it has only implicit shapes
  std::vector<ImplicitShape> shapes;  // colliders that take the mesh's place in contact where present
  Pose worldFromPart;                 // at rest, as the file has it
  bool movable = false;
  bool kinematic = false;
  MassProperties massProperties;
  double gravityFactor = 1.0;
  CollisionFilter filter;
  double contactTolerance = 0.0;  // m, how far contact with other parts may be off; 0: what suits the scene
};

/// One limit of a joint (KHR_physics_rigid_bodies), in the joint frame's axes.
struct JointLimit {
  bool angular = false;
  std::uint8_t axes = 0;             // bit i = axis i
  double min = -1e300, max = 1e300;  // m or rad; beyond +-1e299 = unbounded
  double stiffness = 0.0;            // N/m or N·m/rad; 0 = rigid
  double damping = 0.0;              // N·s/m or N·m·s/rad
};

/// One drive of a joint.
struct JointDrive {
  bool angular = false;
  bool acceleration = false;  // mode: acceleration instead of force
  std::uint8_t axis = 0;
  double maxForce = 1e300;  // N or N·m
  double positionTarget = 0.0, velocityTarget = 0.0;
  double stiffness = 0.0, damping = 0.0;
};

/// A constraint between two parts; either may be kNoPart, the world.
struct Joint {
  std::string name;
  PartId partA = kNoPart, partB = kNoPart;
  Pose aFromJoint, bFromJoint;  // joint frame in each part's frame (world's where the part is kNoPart)
  std::vector<JointLimit> limits;
  std::vector<JointDrive> drives;
  double pitch = 0.0;        // m that B goes along the joint's X axis in a turn about it; 0 = not a screw
  Detents detents;           // along the X axis, or about it
  bool detentsTurn = false;  // about it: their places are angles
  bool collide = false;      // whether the two joined parts still touch each other
};

/// A node of the file's hierarchy, for the part tree.
struct TreeNode {
  std::string name;
  std::uint32_t parent = kNone;  // into Scene::tree; parents stand before their children
};

/// One kind of defect or remark found in the file, counted. `tandem check` prints these.
struct Finding {
  enum class Severity : std::uint8_t { note, warning, error };
  Severity severity = Severity::note;
  std::string code;   // stable, kebab-case: "duplicate-faces", "open-boundary", ...
  std::string where;  // part or mesh name; empty for the whole scene
  std::uint64_t count = 0;
  std::string message;  // one sentence for a person
};

/// A whole scene. See the numbered invariants above.
struct Scene {
  std::string name;
  std::vector<Mesh> meshes;
  std::vector<Material> materials;     // at least one
  std::vector<Surface> surfaces;       // of the materials that feel like more than a stiff wall
  std::vector<TextureImage> textures;  // that surfaces name
  std::vector<Part> parts;             // at most kMaxParts
  std::vector<Joint> joints;
  std::vector<ForceField> fields;  // at most kMaxForceFields
  std::vector<Control> controls;   // at most one a part
  std::vector<TreeNode> tree;
  std::vector<Finding> findings;
  glm::dvec3 gravity{0.0, 0.0, 0.0};  // m/s^2; zero unless the scene or an option sets it
  Bounds bounds;                      // m, world frame, all parts at rest
};

/// Triangles of a part's mesh (0 without one), and of the whole scene counting every instance.
std::size_t triangleCount(const Scene& scene, const Part& part);
std::size_t triangleCount(const Scene& scene);

/// Empties all arrays of the meshes, and keeps what is said of each as a whole (bounds, volume): for who
/// passes the scene on as a package and touches nothing. triangleCount() is 0 then.
void dropGeometry(Scene& scene);

/// Empties Mesh::triangleShell of all meshes; only packScene() reads it.
void dropShells(Scene& scene);

/// The part with this name, or kNoPart.
PartId findPart(const Scene& scene, std::string_view name);

}  // namespace tandem::assets
