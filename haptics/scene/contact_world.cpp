#include "haptics/scene/contact_world.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "assets/base/assert.h"
#include "haptics/geometry/segment.h"

namespace tandem::haptics {
namespace {

const assets::Material kDefaultMaterial;
constexpr int kSettleATick = 32;  // parts put back into the tree, some 130 ns each

assets::Bounds worldBox(const Collider& collider, const Pose& pose) {
  if (collider.tree == nullptr) return {};
  const assets::Bounds& local = collider.tree->bounds();
  const glm::dvec3 half = 0.5 * (local.max - local.min);
  const glm::dmat3 turn = glm::mat3_cast(pose.orientation);
  // The bounding box of a rotated box: the absolute rotation matrix times its half extents (Arvo 1990,
  // Graphics Gems).
  const glm::dvec3 reach =
      glm::abs(turn[0]) * half.x + glm::abs(turn[1]) * half.y + glm::abs(turn[2]) * half.z;
  const glm::dvec3 centre = transformPoint(pose, collider.centre);
  const glm::dvec3 slack(collider.skin + 2.0 * collider.leastTool +
                         0x1p-42 * (glm::length(pose.position) + collider.radius));
  return {centre - reach - slack, centre + reach + slack};
}

glm::dvec3 toPart(const Pose& worldFromPart, const glm::dvec3& p) {
  return glm::conjugate(worldFromPart.orientation) * (p - worldFromPart.position);
}

}  // namespace

ContactWorld::ContactWorld(const ContactScene& scene) : data_(&scene.data()) {
  ASSERT(data_->scene != nullptr && data_->colliders.size() == data_->scene->parts.size());
  const std::vector<assets::Part>& parts = data_->scene->parts;
  std::vector<assets::Bounds> boxes(parts.size());
  parts_.resize(parts.size());
  poses_.resize(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    poses_[i] = parts[i].worldFromPart;
    boxes[i] = worldBox(data_->colliders[i], poses_[i]);
  }
  broad_ = SceneBvh(boxes);
  loose_ = LooseParts(parts.size());
  for (PartId i = 0; has(i); ++i) measure(i);
}

void ContactWorld::adopt(const ContactScene& scene) {
  ASSERT(scene.data().scene == data_->scene);
  ASSERT(scene.data().colliders.size() == data_->colliders.size());
  const ContactScene::Data& before = *data_;
  data_ = &scene.data();
  for (PartId i = 0; has(i); ++i) {
    if (data_->colliders[i] != before.colliders[i]) measure(i);
  }
}

void ContactWorld::meshChanged(std::uint32_t mesh) {
  ASSERT(mesh < data_->trees.size());
  const TriangleBvh* const changed = data_->trees[mesh].get();
  for (PartId i = 0; has(i); ++i) {
    if (changed != nullptr && data_->colliders[i].tree == changed) measure(i);
  }
}

void ContactWorld::measure(PartId part) {
  ASSERT(has(part));
  const Collider& collider = data_->colliders[part];
  const assets::CollisionFilter& filter = data_->scene->parts[part].filter;
  const bool empty = collider.tree == nullptr;
  // The tool belongs to every collision system and collides with every system, so only a part that excludes
  // all systems is untouchable.
  parts_[part].solid = !empty && broad_.contains(part) && filter.memberOf != 0 && filter.collidesWith != 0;
  loose_.setReach(
      part,
      empty ? -1.0 : 1.001 * (glm::length(collider.centre) + collider.radius + 2.0 * collider.leastTool));
  loose_.drop(part);
  free_.forget();
  fronts_.forget();
  if (!empty && broad_.contains(part)) broad_.update(part, worldBox(collider, poses_[part]));
}

void ContactWorld::setPose(PartId part, const Pose& worldFromPart, const Twist& twist) {
  ASSERT(has(part));
  poses_[part] = worldFromPart;
  parts_[part].twist = twist;
  loose_.drop(part);
  const assets::Bounds box = worldBox(data_->colliders[part], worldFromPart);
  free_.exclude(box);
  broad_.update(part, box);
}

void ContactWorld::noteNear(PartId part, const Pose& worldFromPart) {
  ASSERT(has(part));
  const assets::Bounds before = worldBox(data_->colliders[part], poses_[part]);
  const assets::Bounds after = worldBox(data_->colliders[part], worldFromPart);
  loose_.addNear(part, {glm::min(before.min, after.min), glm::max(before.max, after.max)});
  free_.exclude(after);
}

void ContactWorld::setNearPose(PartId part, const Pose& worldFromPart, const Twist& twist) {
  ASSERT(has(part));
  poses_[part] = worldFromPart;
  parts_[part].twist = twist;
  if (loose_.widened()) loose_.renew(part, worldBox(data_->colliders[part], worldFromPart));
}

void ContactWorld::findNear(const assets::Bounds& box) const {
  loose_.widen(
      box, [this](PartId part) { return poses_[part].position; },
      [this](PartId part) { loose_.addNear(part, worldBox(data_->colliders[part], poses_[part])); });
}

void ContactWorld::endMotions() {
  if (!loose_.anyAtRest()) return;
  int settled = 0;
  loose_.forEachAtRest([&](PartId part) {
    if (settled++ < kSettleATick) {
      loose_.drop(part);
      broad_.update(part, worldBox(data_->colliders[part], poses_[part]));
    } else if (loose_.within(part, poses_[part].position)) {
      loose_.addNear(part, worldBox(data_->colliders[part], poses_[part]));
    }
  });
}

bool ContactWorld::mayCollide(PartId a, PartId b) const {
  ASSERT(has(a) && has(b));
  return assets::mayCollide(scene().parts[a].filter, scene().parts[b].filter);
}

void ContactWorld::setSections(const Sections& sections) {
  free_.forget();
  sections_ = sections;
}

/// A section in the frame of a part, a skin further off: it leaves faces that lie in its plane, whatever
/// rounding makes of them.
Section ContactWorld::ofPart(const Section& section, PartId part) const {
  const Pose& pose = poses_[part];
  return {glm::conjugate(pose.orientation) * section.normal,
          section.offset - glm::dot(section.normal, pose.position) + skin(part, pose.position)};
}

Sections ContactWorld::sectionsOf(PartId part) const {
  Sections cut;
  const Collider& collider = data_->colliders[part];
  for (const Section& section : sections_) {
    const Section local = ofPart(section, part);
    if (glm::dot(local.normal, collider.centre) + collider.radius > local.offset) cut.push_back(local);
  }
  return cut;
}

/// Finds those that may cut a part within `reach` of a path, in its frame. False if they leave nothing there.
bool ContactWorld::cutNear(PartId part, const glm::dvec3& from, const glm::dvec3& to, double reach,
                           Sections& cut) const {
  for (const Section& section : sections_) {
    const double a = glm::dot(section.normal, from) - section.offset,
                 b = glm::dot(section.normal, to) - section.offset;
    if (std::min(a, b) - reach > 2.0 * skin(part, from)) return false;
    if (std::max(a, b) + reach > 0.0) cut.push_back(ofPart(section, part));
  }
  return true;
}

double ContactWorld::skin(PartId part, const glm::dvec3& p) const {
  return data_->colliders[part].skin + 0x1p-42 * (glm::length(p) + glm::length(poses_[part].position));
}

double ContactWorld::margin(PartId part, const glm::dvec3& p, double radius) const {
  return std::max(skin(part, p), 2.0 * (data_->colliders[part].leastTool - radius));
}

bool ContactWorld::sweepPart(PartId part, const glm::dvec3& p, const glm::dvec3& motion, double radius,
                             WorldHit& hit) const {
  ASSERT(has(part) && data_->colliders[part].tree != nullptr);
  const Pose& pose = poses_[part];
  const glm::dquat partFromWorld = glm::conjugate(pose.orientation);
  const double off = margin(part, p, radius);
  Sections cut;
  if (!sections_.empty() && !cutNear(part, p, p + motion, radius + off, cut)) return false;
  MeshBallHit local;
  local.t = hit.t;
  if (!fronts_.of(part).sweepBall(*data_->colliders[part].tree, toPart(pose, p), partFromWorld * motion,
                                  radius + 0.5 * off, 0.125 * off, local, cut.empty() ? nullptr : &cut)) {
    return false;
  }
  hit.t = local.t;
  hit.point = transformPoint(pose, local.point);
  hit.normal = transformVector(pose, local.normal);
  hit.onFace = local.onFace;
  hit.part = part;
  hit.triangle = local.triangle;
  return true;
}

bool ContactWorld::sweep(const glm::dvec3& p, const glm::dvec3& motion, double radius, PartId except,
                         WorldHit& hit) const {
  if (free_.contains(p, radius) && free_.contains(p + motion, radius)) return false;
  const glm::dvec3 grow(radius);
  const assets::Bounds box{glm::min(p, p + motion) - grow, glm::max(p, p + motion) + grow};
  bool found = false;
  forEachNear(box, [&](PartId part) {
    if (part == except || !touchable(part)) return;
    // Of two simultaneous hits the one with the steeper incidence counts, as within a part.
    WorldHit candidate;
    candidate.t = hit.t;
    if (!sweepPart(part, p, motion, radius, candidate)) return;
    if (found && candidate.t == hit.t && glm::dot(candidate.normal, motion) >= glm::dot(hit.normal, motion))
      return;
    hit = candidate;
    found = true;
  });
  return found;
}

double ContactWorld::sweepOne(const glm::dvec3& p, const glm::dvec3& motion, double radius, PartId part,
                              std::uint32_t triangle) const {
  if (!has(part) || !touchable(part)) return 1.0;
  if (free_.contains(p, radius) && free_.contains(p + motion, radius)) return 1.0;
  const TriangleBvh& tree = *data_->colliders[part].tree;
  if (triangle >= tree.mesh().triangles.size()) return 1.0;
  const Pose& pose = poses_[part];
  const double off = margin(part, p, radius);
  BallHit hit;
  const glm::dvec3 from = toPart(pose, p), path = glm::conjugate(pose.orientation) * motion;
  Sections cut;
  if (!sections_.empty() && !cutNear(part, p, p + motion, radius + off, cut)) return 1.0;
  if (cut.empty()) {
    haptics::sweepBall(from, path, radius + 0.5 * off, 0.125 * off, tree.triangle(triangle), hit);
  } else {
    sweepBallOnCut(from, path, radius + 0.5 * off, 0.125 * off, tree.triangle(triangle), cut, hit);
  }
  return hit.t;
}

bool ContactWorld::sweepAgainstMoved(PartId part, const Pose& before, const glm::dvec3& p, double radius,
                                     WorldHit& hit, glm::dvec3& carried) const {
  ASSERT(has(part));
  const Collider& collider = data_->colliders[part];
  if (!touchable(part)) return false;
  const Pose& now = poses_[part];
  const double off = margin(part, p, radius);
  const double reach = collider.radius + radius + 2.0 * off;
  const glm::dvec3 c0 = transformPoint(before, collider.centre), c1 = transformPoint(now, collider.centre);
  if (glm::length(p - closestPointOnSegment(p, c0, c1)) > reach) return false;

  // Seen from the part the ball moves along an arc. Chords of at most 3 degrees follow it, and the end points
  // are exact.
  const double turn = glm::length(rotationVector(now.orientation * glm::conjugate(before.orientation)));
  const int pieces = std::clamp(static_cast<int>(std::ceil(turn / 0.05)), 1, 64);
  Sections cut;
  if (!sections_.empty() && !cutNear(part, p, p, radius + off, cut)) return false;
  // They stand still while the part moves, so that they leave all of it that was behind them on the way.
  for (Section& section : cut) section.offset += glm::length(c1 - c0) + turn * collider.radius;
  glm::dvec3 from = toPart(before, p);
  for (int i = 1; i <= pieces; ++i) {
    const glm::dvec3 to =
        toPart(i == pieces ? now : interpolate(before, now, static_cast<double>(i) / pieces), p);
    MeshBallHit local;
    if (collider.tree->sweepBall(from, to - from, radius + 0.5 * off, 0.125 * off, local,
                                 cut.empty() ? nullptr : &cut)) {
      hit.t = (i - 1 + local.t) / pieces;
      hit.point = transformPoint(now, local.point);
      hit.normal = transformVector(now, local.normal);
      hit.onFace = local.onFace;
      hit.part = part;
      hit.triangle = local.triangle;
      carried = transformPoint(now, from + (to - from) * local.t);
      return true;
    }
    from = to;
  }
  return false;
}

Triangle ContactWorld::triangle(PartId part, std::uint32_t triangle) const {
  const Pose& pose = poses_[part];
  ASSERT(triangle < data_->colliders[part].tree->mesh().triangles.size());
  const Triangle t = data_->colliders[part].tree->triangle(triangle);
  return {transformPoint(pose, t.a), transformPoint(pose, t.b), transformPoint(pose, t.c)};
}

CutFace ContactWorld::face(PartId part, std::uint32_t triangle) const {
  const Triangle whole = data_->colliders[part].tree->triangle(triangle);
  CutFace left = cutTriangle(whole, sections_.empty() ? sections_ : sectionsOf(part));
  for (glm::dvec3& corner : left) corner = transformPoint(poses_[part], corner);
  return left;
}

SurfacePoint ContactWorld::surfaceAt(PartId part, std::uint32_t triangle, const glm::dvec3& p) const {
  const Pose& pose = poses_[part];
  const glm::dvec3 local = toPart(pose, p);
  ASSERT(triangle < data_->colliders[part].tree->mesh().triangles.size());
  const Triangle t = data_->colliders[part].tree->triangle(triangle);
  TrianglePoint closest;
  if (sections_.empty()) {
    closest = closestPointOnTriangle(local, t);
  } else {
    const std::optional<TrianglePoint> left = closestPointOnCut(local, t, sectionsOf(part));
    constexpr glm::dvec3 kAnyNormal(0.0, 0.0, 1.0);
    if (!left) return {part, triangle, p - kGone * kAnyNormal, kAnyNormal, kGone, false};
    closest = *left;
  }
  const glm::dvec3 normal = contactNormal(local, t, closest);
  return {part,
          triangle,
          transformPoint(pose, closest.point),
          transformVector(pose, normal),
          glm::dot(local - closest.point, normal),
          closest.onFace};
}

bool ContactWorld::nearest(PartId part, const glm::dvec3& p, double reach, SurfacePoint& found) const {
  ASSERT(has(part));
  MeshPoint local;
  const Collider& collider = data_->colliders[part];
  Sections cut;
  if (!sections_.empty() && !cutNear(part, p, p, reach, cut)) return false;
  if (collider.tree == nullptr ||
      !collider.tree->closestPoint(toPart(poses_[part], p), reach, local, cut.empty() ? nullptr : &cut)) {
    return false;
  }
  found = surfaceAt(part, local.triangle, p);
  return true;
}

NearLeaf ContactWorld::nearestLeaf(PartId part, const glm::dvec3& p, double reach) const {
  ASSERT(has(part));
  const Collider& collider = data_->colliders[part];
  if (collider.tree == nullptr) return {reach, kNoTriangle};
  return collider.tree->nearestLeaf(toPart(poses_[part], p), reach);
}

bool ContactWorld::overlaps(PartId part, const glm::dvec3& p, double radius) const {
  ASSERT(has(part));
  const Collider& collider = data_->colliders[part];
  if (collider.tree == nullptr) return false;
  const glm::dvec3 local = toPart(poses_[part], p);
  const double margin = radius + skin(part, p);
  if (glm::length(local - collider.centre) > collider.radius + margin) return false;
  return reaches(part, p, margin) || encloses(part, p);
}

bool ContactWorld::reaches(PartId part, const glm::dvec3& p, double distance) const {
  ASSERT(has(part));
  const Collider& collider = data_->colliders[part];
  Sections cut;
  if (collider.tree == nullptr || (!sections_.empty() && !cutNear(part, p, p, distance, cut))) return false;
  MeshPoint near;
  return collider.tree->closestPoint(toPart(poses_[part], p), distance, near, cut.empty() ? nullptr : &cut);
}

bool ContactWorld::encloses(PartId part, const glm::dvec3& p) const {
  ASSERT(has(part) && data_->colliders[part].tree != nullptr);
  const Collider& collider = data_->colliders[part];
  const glm::dvec3 local = toPart(poses_[part], p);
  // Directions without zero or equal components, because CAD faces are axis-parallel and their edges often at
  // 45 degrees. From inside a solid every ray leaves once more often than it enters; in front of an open
  // surface the rays that hit it enter.
  static constexpr double kRays[7][3] = {{1.0, 0.137, 0.271}, {-0.193, 1.0, -0.311}, {0.229, -0.173, -1.0},
                                         {0.61, 0.57, 0.55},  {-0.53, 0.63, 0.59},   {0.58, -0.62, 0.54},
                                         {0.56, 0.59, -0.64}};
  const double length = 2.5 * collider.radius + glm::length(local - collider.centre);
  const Sections cut = sections_.empty() ? sections_ : sectionsOf(part);
  const Sections* const left = cut.empty() ? nullptr : &cut;
  const bool closed = collider.tree->mesh().closed && cut.empty();
  const int rays = closed ? 3 : 7;
  int missing = 0;
  for (int i = 0; i < rays; ++i) {
    const glm::dvec3 path = glm::dvec3(kRays[i][0], kRays[i][1], kRays[i][2]) * length;
    missing += collider.tree->signedCrossings(local, local + path, left) > 0 ? 0 : 1;
    missing += collider.tree->signedCrossings(local, local - path, left) > 0 ? 0 : 1;
    if (missing > (closed ? 1 : 0)) return false;
  }
  return true;
}

const assets::Material& ContactWorld::material(PartId part, std::uint32_t triangle) const {
  ASSERT(has(part) && data_->colliders[part].tree != nullptr);
  const assets::Mesh& mesh = data_->colliders[part].tree->mesh();
  if (triangle >= mesh.triangleMaterial.size()) return kDefaultMaterial;
  const std::uint16_t index = mesh.triangleMaterial[triangle];
  return index < scene().materials.size() ? scene().materials[index] : kDefaultMaterial;
}

}  // namespace tandem::haptics
