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
    JointRecord& record = joints_.emplace_back();
    record.joint = &joint;
    record.sprung = movesByItself(joint);
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
  for (JointRecord& record : joints_) {
    if (record.joint->partA == part || record.joint->partB == part)
      record.started = record.started && record.joint->pitch != 0.0;
  }
}

void PartJoints::addRows(const ContactIsland& island, double dt, ContactRows& rows) {
  for (int i = 0; i < island.pairCount(); ++i) {
    const ContactPair& pair = island.pair(i);
    if (!pair.isJoint()) continue;
    const ContactBody& first = island.first(pair);
    JointRecord& record = joints_[static_cast<std::size_t>(pair.joint)];
    if (!TICK_ASSERT(fault_, record.joint->partA == first.part || record.joint->partB == first.part))
      continue;
    PlacedJoint& placed = record.placed;
    placed.joint = record.joint;
    placed.firstIsB = record.joint->partB == first.part;
    placed.worldFromA = (placed.firstIsB ? island.otherPose(pair) : first.pose) * record.joint->aFromJoint;
    placed.worldFromB = (placed.firstIsB ? first.pose : island.otherPose(pair)) * record.joint->bFromJoint;
    placed.centre = first.centre;
    placed.lever = first.radius;
    placed.mass = first.mass;
    placed.inertia = 0.4 * first.mass * first.radius * first.radius;  // of a solid ball
    placed.pair = static_cast<std::uint16_t>(i);
    if (!record.started) record.state = startJoint(placed);
    record.started = true;
    followAngle(placed, record.state);
    addJointRows(placed, record.state, island.push() + first.escapeDistance(dt), dt, rows);
  }
}

double PartJoints::value(std::uint32_t joint, bool angular) const {
  if (!TICK_ASSERT(fault_, joint < joints_.size())) return 0.0;
  const JointRecord& record = joints_[joint];
  return record.started ? jointValue(record.placed, record.state, angular) : 0.0;
}

}  // namespace tandem::haptics
