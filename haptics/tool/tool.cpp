#include "haptics/tool/tool.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/finite.h"
#include "haptics/proxy/contact_force.h"

namespace tandem::haptics {
namespace {

// After a change of the scene the proxy may have far to go, and takes a few moves to come to rest.
constexpr int kMovesAnew = 8;
constexpr double kStill = 1e-8;  // m

/// How far the point of a part that is at `at` before the motion moves, m, world.
glm::dvec3 displacementOf(const Pose& before, const Pose& now, const glm::dvec3& at) {
  return transformPoint(now, transformPoint(inverse(before), at)) - at;
}

}  // namespace

Tool::Tool(ContactWorld& world, FaultLatch& fault) : world_(world), fault_(fault) { measureReach(); }

void Tool::begin(const TickParameters& parameters) {
  radius_ = parameters.toolRadius;
  dt_ = parameters.dt;
  foreign_ = ForeignChange{};
  flags_ = 0;
  if (meshChange_.pending) followMeshChange();
}

void Tool::place(const glm::dvec3& device, bool anew) {
  device_ = device;
  if (!started_ || anew) reset();
  started_ = true;
}

void Tool::reset() {
  flags_ |= kFlagProxyReset;
  proxy_ = Proxy{};
  proxy_.position = device_;
  felt_.valid = false;
  surface_.shading = {};
  ignoreOverlapping();
}

void Tool::follow(PartId part, const Pose& before, const Twist& twistBefore, bool byHand) {
  if (!started_) return;
  const glm::dvec3 proxyBefore = proxy_.position;
  const bool free = pushProxy(world_, part, before, radius_, proxy_);
  if (!byHand && (proxy_.position != proxyBefore || pressesOn(part))) {
    noteForeignChange(expectedDisplacement(before, twistBefore, proxyBefore));
  }
  if (proxy_.position != proxyBefore || pressesOn(part)) noteNewGround();
  if (!free) {
    flags_ |= kFlagSqueezed;
    ignore(part);
  }
}

double Tool::workOf(PartId part, const Pose& before) const {
  const glm::dvec3 force = contactWrenchOf(part).force;
  double work = 0.0;
  for (const ProxyPlane& plane : proxy_.planes) {
    if (plane.surface.part != part || !presses(plane)) continue;
    const glm::dvec3 moved = displacementOf(before, world_.pose(part), plane.surface.point);
    work += glm::dot(force, plane.surface.normal) * glm::dot(moved, plane.surface.normal);
  }
  return work;
}

bool Tool::outruns(PartId part, const Pose& before, double most) const {
  if (!started_ || !world_.touchable(part)) return false;
  for (const ProxyPlane& plane : proxy_.planes) {
    if (plane.surface.part != part || !presses(plane)) continue;
    const glm::dvec3 moved = displacementOf(before, world_.pose(part), plane.surface.point);
    if (glm::dot(moved, plane.surface.normal) < -most) return true;
  }
  WorldHit hit;
  glm::dvec3 carried;
  return world_.sweepAgainstMoved(part, before, proxy_.position, radius_, hit, carried) &&
         std::abs(glm::dot(carried - proxy_.position, hit.normal)) > most;
}

void Tool::ignore(PartId part) {
  if (world_.ignored(part)) return;
  if (ignored_.full()) {
    flags_ |= kFlagOverflow;
    return;
  }
  ignored_.push_back(part);
  world_.setIgnored(part, true);
  noteNewGround();
}

void Tool::ignoreOverlapping() {
  const glm::dvec3& p = proxy_.position;
  const glm::dvec3 grow(radius_);
  world_.forEachNear({p - grow, p + grow}, [&](PartId part) {
    if (world_.touchable(part) && world_.overlaps(part, p, radius_)) ignore(part);
  });
}

bool Tool::isOver(PartId part) const {
  return world_.overlaps(part, device_, radius_) ||
         (proxy_.position != device_ && world_.overlaps(part, proxy_.position, radius_));
}

void Tool::ignoreIfOver(PartId part) {
  if (started_ && isOver(part)) ignore(part);
}

void Tool::forgetIgnored(PartId held) {
  if (!started_) return;
  std::size_t left = 0;
  for (const PartId part : ignored_) {
    if (part == held || isOver(part)) {
      if (part != held) flags_ |= kFlagInside;
      ignored_[left++] = part;
    } else {
      world_.setIgnored(part, false);
    }
  }
  ignored_.shrink(left);
}

Wrench Tool::contactAnew(const TickParameters& parameters) {
  if (!felt_.valid) return contactWrench_;
  for (int i = 0; i < kMovesAnew; ++i) {
    const glm::dvec3 before = proxy_.position;
    moveTo(felt_.worldFromDevice.position);
    noteNewGround();
    if (glm::distance(before, proxy_.position) < kStill) break;
  }
  TickOutput aside;
  SurfaceState surface = surface_;
  const glm::dvec3 force = contactForce(world_, proxy_, felt_, parameters, aside);
  return {applySurface(world_, proxy_, felt_, parameters, force, surface, aside), glm::dvec3(0.0)};
}

/// Whether the proxy is nearer to the part's surface than it can be kept from it. It rests at a ball's radius
/// and a skin.
bool Tool::cannotLeave(PartId part) const {
  const double half = 0.5 * world_.margin(part, proxy_.position, radius_);
  return world_.reaches(part, proxy_.position, radius_ + std::min(half, world_.skin(part, proxy_.position)));
}

void Tool::cut(const Sections& sections) {
  if (!started_) return world_.setSections(sections);
  const glm::dvec3& p = proxy_.position;
  const assets::Bounds here{p - glm::dvec3(radius_), p + glm::dvec3(radius_)};
  FixedVector<PartId, kMaxIgnored> around;  // in which the tool is already, through an opening
  world_.forEachNear(here, [&](PartId part) {
    if (world_.touchable(part) && !around.full() && world_.encloses(part, p)) around.push_back(part);
  });
  world_.setSections(sections);
  world_.forEachNear(here, [&](PartId part) {
    if (!world_.touchable(part)) return;
    const bool opened = !world_.sectionsOf(part).empty();
    const bool was = std::find(around.begin(), around.end(), part) != around.end();
    if (cannotLeave(part) || (world_.encloses(part, p) && !(was && opened))) ignore(part);
  });
}

void Tool::noteForeignChange(double expected) {
  foreign_.any = true;
  foreign_.expected += expected;
}

/// Displacement of the surface under the proxy in this tick at the last tick's velocity, m: a motion that
/// continues is felt as it is, one that begins with a jump is not.
double Tool::expectedDisplacement(const Pose& before, const Twist& twist, const glm::dvec3& proxy) const {
  const double arm = glm::length(proxy - device_);
  return dt_ * (glm::length(velocityAt(before, twist, proxy)) + glm::length(twist.angular) * arm);
}

void Tool::touch(const DeviceSample& felt, const TickParameters& parameters, TickOutput& out) {
  TICK_ASSERT(fault_, started_ && felt.worldFromDevice.position == device_);
  felt_ = felt;
  felt_.valid = true;
  moveTo(device_);
  const glm::dvec3 force = contactForce(world_, proxy_, felt, parameters, out);
  contactWrench_ = {applySurface(world_, proxy_, felt, parameters, force, surface_, out), glm::dvec3(0.0)};
  if (surface_.letGo == kNoPart) return;
  // A surface that gave way is passed through at once, so that it is left, and felt again, on its other side.
  flags_ |= kFlagPopThrough;
  ignore(surface_.letGo);
  moveTo(device_);
}

void Tool::moveTo(const glm::dvec3& device) {
  moveProxy(world_, device, radius_, proxy_);
  if (!TICK_ASSERT(fault_, isFinite(proxy_.position))) reset();
}

void Tool::carry(const glm::dvec3& position) {
  proxy_ = Proxy{};
  proxy_.position = position;
  felt_.valid = false;
  contactWrench_ = Wrench{};
  surface_.shading = {};
}

Wrench Tool::contactWrenchOf(PartId part) const {
  double all = 0.0, ofPart = 0.0;
  for (const ProxyPlane& plane : proxy_.planes) {
    all += plane.depth;
    if (plane.surface.part == part) ofPart += plane.depth;
  }
  const double share = all > 0.0 ? ofPart / all : 0.0;
  return {contactWrench_.force * share, contactWrench_.torque * share};
}

EndedContact Tool::endedContactWith(PartId part) const {
  glm::dvec3 depth(0.0);
  for (const ProxyPlane& plane : proxy_.planes) {
    if (plane.surface.part == part) depth += plane.depth * plane.surface.normal;
  }
  const Wrench ended = contactWrenchOf(part);
  const double length = glm::length(depth);
  return {ended, length > 0.0 ? glm::length(ended.force) / length : 0.0};
}

bool Tool::pressesOn(PartId part) const {
  for (const ProxyPlane& plane : proxy_.planes) {
    if (plane.surface.part == part && presses(plane)) return true;
  }
  return false;
}

double Tool::stiffest(double least) const {
  double stiffness = least;
  for (const ProxyPlane& plane : proxy_.planes) {
    stiffness = std::max(stiffness, world_.material(plane.surface.part, plane.surface.triangle).stiffness);
  }
  return stiffness;
}

PartId Tool::partUnder(PartId held) {
  if (!started_) return kNoPart;
  for (const PartId part : ignored_) {
    if (part != held) return part;
  }
  return finder_.find(world_, proxy_.position, radius_, radius_ + std::max(2.0 * radius_, touchReach_));
}

assets::Bounds Tool::reachInTick() const {
  const glm::dvec3& p = proxy_.position;
  const glm::dvec3 grow(2.0 * glm::length(device_ - p) + 4.0 * radius_ + 2.0 * touchReach_);
  return {p - grow, p + grow};
}

void Tool::beforeMeshesChange() {
  if (!meshChange_.pending) noteSides(world_, proxy_, meshChange_);
  meshChange_.pending = true;
}

/// The triangles under the proxy are others than in the last tick.
void Tool::followMeshChange() {
  if (!started_) {
    meshChange_.pending = false;
    return;
  }
  const glm::dvec3 before = proxy_.position;
  const bool touched = !proxy_.planes.empty();
  const FollowedMeshes followed = followMeshes(world_, radius_, meshChange_, proxy_);
  if (followed.overflow) flags_ |= kFlagOverflow;
  for (const PartId part : followed.squeezed) {
    flags_ |= kFlagSqueezed;
    world_.setIgnored(part, false);  // until it is on the list of those ignored
    ignore(part);
  }
  if (touched || proxy_.position != before) noteForeignChange(0.0);
  noteNewGround();
}

void Tool::measureReach() {
  touchReach_ = 0.0;
  for (PartId i = 0; world_.has(i); ++i) {
    touchReach_ = std::max(touchReach_, kTouchShare * 2.0 * world_.collider(i).radius);
  }
}

}  // namespace tandem::haptics
