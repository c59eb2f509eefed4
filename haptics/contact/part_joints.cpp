#include "haptics/contact/part_joints.h"

#include <algorithm>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

bool movesByItself(const assets::Joint& joint) {
  return !joint.drives.empty() || joint.detents.force > 0.0 ||
         std::any_of(joint.limits.begin(), joint.limits.end(),
                     [](const assets::JointLimit& limit) { return limit.stiffness > 0.0; });
}

}  // namespace

PartJoints::PartJoints(const assets::Scene& scene, FaultLatch& fault) : fault_(fault) {
  if (scene.joints.empty()) return;
  jointsOf_.resize(scene.parts.size());
  for (const assets::Joint& joint : scene.joints) {
    HeldJoint& held = joints_.emplace_back();
    held.joint = &joint;
    held.sprung = movesByItself(joint);
    const auto index = static_cast<std::uint32_t>(joints_.size() - 1);
    for (const PartId part : {joint.partA, joint.partB}) {
      if (part == kNoPart) continue;
      ASSERT(part < scene.parts.size());
      if (assets::controlOf(scene, part) == nullptr) jointsOf_[part].push_back(index);
    }
  }
}

bool PartJoints::letTouch(PartId a, PartId b) const {
  if (!joined(a) || !joined(b)) return true;
  const std::span<const std::uint32_t> joints = of(a);
  return std::none_of(joints.begin(), joints.end(), [&](std::uint32_t index) {
    const assets::Joint& joint = *joints_[index].joint;
    return !joint.collide && (joint.partA == b || joint.partB == b);
  });
}

void PartJoints::restart(PartId part) {
  for (HeldJoint& held : joints_) {
    if (held.joint->partA == part || held.joint->partB == part)
      held.started = held.started && held.joint->pitch != 0.0;
  }
}

void PartJoints::addRows(const ContactIsland& island, double dt, ContactRows& rows) {
  for (int i = 0; i < island.pairCount(); ++i) {
    const ContactPair& pair = island.pair(i);
    if (!pair.isJoint()) continue;
    const ContactBody& first = island.first(pair);
    HeldJoint& held = joints_[static_cast<std::size_t>(pair.joint)];
    if (!TICK_ASSERT(fault_, held.joint->partA == first.part || held.joint->partB == first.part)) continue;
    PlacedJoint& placed = held.placed;
    placed.joint = held.joint;
    placed.firstIsB = held.joint->partB == first.part;
    placed.worldFromA = (placed.firstIsB ? island.otherPose(pair) : first.pose) * held.joint->aFromJoint;
    placed.worldFromB = (placed.firstIsB ? first.pose : island.otherPose(pair)) * held.joint->bFromJoint;
    placed.centre = first.centre;
    placed.lever = first.radius;
    placed.mass = first.mass;
    placed.inertia = 0.4 * first.mass * first.radius * first.radius;  // of a solid ball
    placed.pair = static_cast<std::uint16_t>(i);
    if (!held.started) held.state = startJoint(placed);
    held.started = true;
    followTurn(placed, held.state);
    addJointRows(placed, held.state, island.push() + first.escapeDistance(dt), dt, rows);
  }
}

double PartJoints::value(std::uint32_t joint, bool angular) const {
  if (!TICK_ASSERT(fault_, joint < joints_.size())) return 0.0;
  const HeldJoint& held = joints_[joint];
  return held.started ? jointValue(held.placed, held.state, angular) : 0.0;
}

}  // namespace tandem::haptics
