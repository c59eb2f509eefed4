#pragma once

// The physics that a glTF file states: KHR_physics_rigid_bodies with KHR_implicit_shapes, and
// OMI_physics_shape, _body, _joint and _gravity, brought into one form; and extras.haptic. Lengths stay in
// file units here. For the loader's sources only.

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "assets/gltf/gltf_document.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// Contact properties of a surface, from a physics material and extras.haptic.
struct PhysicsSurface {
  double staticFriction = 0.0, dynamicFriction = 0.0, restitution = 0.0;
  double stiffness = 0.0, damping = 0.0;  // N/m, N·s/m
  Surface feel;                           // texture.image is a glTF texture here
  bool saysHowSmooth = false;             // states creaseAngle; else the normals of the file say it

  auto operator<=>(const PhysicsSurface&) const = default;
};

/// The `motion` of a node, which makes it a body.
struct PhysicsMotion {
  bool kinematic = false;
  std::optional<double> mass;                 // kg; 0 = infinite
  std::optional<glm::dvec3> centreOfMass;     // file units, node frame
  std::optional<glm::dvec3> inertiaDiagonal;  // kg·m^2
  glm::dquat inertiaOrientation{1.0, 0.0, 0.0, 0.0};
  double gravityFactor = 1.0;
};

/// The `collider` of a node. Exactly one of shape, node and mesh is set.
struct PhysicsCollider {
  std::optional<std::size_t> shape;    // into GltfPhysics::shapes
  std::optional<std::size_t> node;     // whose mesh it is, with its children's
  std::optional<std::size_t> mesh;     // a glTF mesh (OMI)
  std::optional<std::size_t> surface;  // into GltfPhysics::surfaces
  std::optional<std::size_t> filter;   // into GltfPhysics::filters
};

struct PhysicsJointUse {
  std::size_t joint = 0;          // into GltfPhysics::joints
  std::size_t connectedNode = 0;  // glTF node
  bool collide = false;
};

struct PhysicsNode {
  std::optional<PhysicsMotion> motion;
  std::optional<PhysicsCollider> collider;
  std::optional<PhysicsJointUse> joint;
  std::optional<std::size_t> hapticSurface;  // extras.haptic of the node itself, into GltfPhysics::surfaces
  double contactTolerance = 0.0;             // m, extras.haptic.tolerance; 0: none stated
  double density = 0.0;                      // kg/m^3, extras.cad.density; 0: none stated
};

/// A primitive shape, or the mesh that an OMI shape stands for.
struct PhysicsShape {
  ImplicitShape shape;              // file units
  std::optional<std::size_t> mesh;  // OMI convex or trimesh
};

struct PhysicsJoint {
  std::vector<JointLimit> limits;  // file units
  std::vector<JointDrive> drives;
  double pitch = 0.0;  // file units a turn
  Detents detents;
  bool detentsTurn = false;
};

struct GltfPhysics {
  std::vector<PhysicsNode> nodes;  // one a glTF node
  std::vector<PhysicsShape> shapes;
  std::vector<PhysicsSurface> surfaces;
  std::vector<CollisionFilter> filters;
  std::vector<PhysicsJoint> joints;
  std::optional<glm::dvec3> gravity;  // m/s^2
  std::vector<Finding> findings;
};

/// Reads all physics of a file; every index is in range and every number finite.
GltfPhysics readPhysics(const GltfDocument& document);

}  // namespace tandem::assets
