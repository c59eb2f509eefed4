#pragma once

// The constraints of joints as rows of a step (contact_rows.h): locks are equations, limits are half-spaces,
// and springs, drives and detents are compliant rows.
//
// Coordinates as KHR_physics_rigid_bodies has them: linear[i] is e_i . (t_B - t_A) along the axes e of the
// frame in A; angular[i] the twist of q_A* q_B about e_i; of two linear axes the distance from the third, of
// three from the point; of two turns the angle between the third axes.
//
// 1. Turns about the X axis are counted: a screw may go on for as many as it likes. 2. No allocation.

#include <cstdint>

#include "assets/scene/scene.h"
#include "haptics/contact/contact_rows.h"

namespace tandem::haptics {

/// What a joint remembers from tick to tick.
struct JointState {
  double angle = 0.0;           // rad of B about the X axis, whole turns counted
  double steepestDetent = 0.0;  // N/m or N·m/rad
  double thread = 0.0;          // m that B stood off the pitch's line when the joint was made
};

/// A joint's frames and the moving part that is the first of its pair.
struct PlacedJoint {
  const assets::Joint* joint = nullptr;
  Pose worldFromA, worldFromB;       // of the joint, in the two parts
  bool firstIsB = false;             // the pair's first body is part B, else A
  glm::dvec3 centre{0.0, 0.0, 0.0};  // m, world: the first body's reference point
  double lever = 0.01;   // m, by which angles are compared with lengths: a radius of the first body
  double mass = 1.0;     // kg, that a drive in acceleration mode has to move
  double inertia = 1.0;  // kg·m^2
  std::uint16_t pair = 0;
};

/// The state of a joint as it stands.
JointState startJoint(const PlacedJoint& placed);

/// Counts the turn of a joint on to where it now is.
void followAngle(const PlacedJoint& placed, JointState& state);

/// Where the joint stands along (m) or about (rad) its X axis.
double jointValue(const PlacedJoint& placed, const JointState& state, bool angular);

/// Adds the rows of one joint. `maxCorrection`: m, by how much a step may draw together what does not fit; dt in s.
void addJointRows(const PlacedJoint& placed, const JointState& state, double maxCorrection, double dt,
                  ContactRows& rows);

}  // namespace tandem::haptics
