#include "haptics/foreign_limit.h"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace tandem::haptics {
namespace {

// Room around a held part, as a factor of its radius.
constexpr double kRoom = 1.1;

struct Ball {
  glm::dvec3 centre;
  double radius;
};

Ball roomOf(const ContactWorld& world, PartId part) {
  const Collider& collider = world.collider(part);
  return {transformPoint(world.pose(part), collider.centre), kRoom * collider.radius};
}

/// An upper bound of how far a point of a part moves, m.
double travelOf(const Collider& collider, const Pose& from, const Pose& to) {
  const glm::dvec3 shift = transformPoint(to, collider.centre) - transformPoint(from, collider.centre);
  const glm::dquat turn = to.orientation * glm::conjugate(from.orientation);
  return glm::length(shift) + collider.radius * glm::length(rotationVector(turn));
}

/// Whether a part is near a held one where it was, or comes near one on its way.
bool isNearHeld(const ContactWorld& world, const HeldParts& held, PartId part, const Pose& before) {
  for (const SimulatedPart& entry : held.parts()) {
    if (!entry.held() || world.model(entry.part) == nullptr || !world.mayCollide(entry.part, part)) continue;
    const Ball room = roomOf(world, entry.part);
    // The same place as seen from the part where it was.
    const glm::dvec3 seen = transformPoint(world.pose(part), transformPoint(inverse(before), room.centre));
    WorldHit hit;
    glm::dvec3 carried;
    SurfacePoint near;
    if (world.nearest(part, seen, room.radius, near) ||
        world.sweepAgainstMoved(part, before, room.centre, room.radius, hit, carried))
      return true;
  }
  return false;
}

/// Holds a part that has moved from `before` to its present pose back if it is near a part in a hand, or
/// comes near one: no point of it moves by more than `most` m. False if none is near.
bool holdBackNearHeld(ContactWorld& world, const HeldParts& held, PartId part, const Pose& before,
                      double most) {
  if (world.model(part) == nullptr || !isNearHeld(world, held, part, before)) return false;
  const Pose target = world.pose(part);
  const double travel = travelOf(world.collider(part), before, target);
  if (travel <= most) return true;
  const double share = most / travel;
  const Twist twist = world.twist(part);
  world.setPose(part, interpolate(before, target, share), {share * twist.linear, share * twist.angular});
  return true;
}

/// The work in J that the touches of the last tick do on parts here as `part` moves from `before` to its
/// present pose: positive where it pushes them.
double workOnHeld(const ContactWorld& world, std::span<const PartTouch> touches, PartId part,
                  const Pose& before) {
  double work = 0.0;
  for (const PartTouch& touch : touches) {
    if (touch.of != part && touch.part != part) continue;
    const glm::dvec3 now = transformPoint(world.pose(part), transformPoint(inverse(before), touch.point));
    // The normal points away from `part`, at `of`.
    const double push = glm::dot(now - touch.point, touch.normal) * touch.force;
    work += touch.part == part ? push : -push;
  }
  return work;
}

}  // namespace

assets::Bounds ForeignLimit::reach(assets::Bounds ofTool, const ContactWorld& world,
                                   const HeldParts& held) const {
  if (!active()) return ofTool;
  for (const SimulatedPart& entry : held.parts()) {
    if (!entry.held()) continue;
    const Ball room = roomOf(world, entry.part);
    ofTool.min = glm::min(ofTool.min, room.centre - glm::dvec3(room.radius));
    ofTool.max = glm::max(ofTool.max, room.centre + glm::dvec3(room.radius));
  }
  return ofTool;
}

void ForeignLimit::begin(double a, double stiffness, double dt) {
  travel_ = a * dt / stiffness;
  work_ = std::max(0.0, work_ - kPower * dt);
  moved_.clear();
}

bool ForeignLimit::follow(ContactWorld& world, const HeldParts& held, const PartContact* contact, Tool& tool,
                          PartId part, const Pose& before, const Twist& twistBefore) {
  if (!moved_.full()) moved_.push_back(part);
  const double most = work_ > kMostWork ? 0.0 : travel_;
  if (contact != nullptr && holdBackNearHeld(world, held, part, before, most)) {
    tool.noteForeignChange(0.0);
    work_ += workOnHeld(world, contact->touches(), part, before);
  }
  work_ += tool.workOf(part, before);
  if (tool.outruns(part, before, most)) return false;
  tool.follow(part, before, twistBefore, false);
  return true;
}

void ForeignLimit::noteTouch(Tool& tool) const {
  for (const PartId part : moved_) {
    if (!tool.foreignChange().any && tool.pressesOn(part)) tool.noteForeignChange(0.0);
  }
}

}  // namespace tandem::haptics
