#pragma once

// The constraints of joints as rows of a step (contact_rows.h): locks are equations, limits are half-spaces,
// and springs, drives and detents are compliant rows.
//
// Coordinates are those of KHR_physics_rigid_bodies. One linear axis is e_i . (t_B - t_A) along the axes e
// of the frame in A, two are the distance from the third axis, three the distance from the point. One
// angular axis is the twist of q_A* q_B about e_i, two are the angle between the third axes of the two
// frames.
//
// 1. Full turns about the X axis are counted, so a screw may turn without limit. 2. No allocation.

#include <cstdint>

#include "assets/scene/scene.h"
#include "haptics/solver/contact_rows.h"

namespace tandem::haptics {

/// What a joint remembers from tick to tick.
struct JointState {
  double angle = 0.0;           // rad of B about the X axis, full turns counted
  double steepestDetent = 0.0;  // N/m or N·m/rad
  double thread = 0.0;          // m by which B is off the line of the pitch since the joint was made
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

/// Updates the angle about the X axis with the full turns since the last update.
void followAngle(const PlacedJoint& placed, JointState& state);

/// Where the joint stands along (m) or about (rad) its X axis.
double jointValue(const PlacedJoint& placed, const JointState& state, bool angular);

/// Adds the rows of one joint. `maxCorrection`: m, by how much one step corrects an error of position at
/// most; dt in s.
void addJointRows(const PlacedJoint& placed, const JointState& state, double maxCorrection, double dt,
                  ContactRows& rows);

}  // namespace tandem::haptics
