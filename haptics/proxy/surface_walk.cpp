#include "haptics/proxy/surface_walk.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr double kGroundTurn = 0.98480775301220802;  // cos 10 degrees: a steeper turn ends the walk
constexpr int kMaxTriangles = 256;
constexpr int kMaxSeams = 4;  // seams at which a query must find the next triangle

/// A contact point on its path over the triangles of one part, in that part's frame.
class Walker {
 public:
  Walker(const ContactWorld& world, const SurfacePoint& from, const glm::dvec3& displacement,
         const WalkTolerance& tolerance)
      : world_(world),
        way_(displacement),
        upright_(from.normal),
        length_(glm::length(displacement)),
        tolerance_(tolerance) {
    enter(from.part, from.triangle, from.point);
  }

  SurfaceWalk run() {
    SurfaceWalk walk;
    walk.sharp = !stand();
    for (int i = 0; i < kMaxTriangles && !walk.sharp; ++i) {
      const int edge = leave();
      if (edge < 0) return arrived(1.0);
      SurfaceWalk before = arrived(walked_);
      const bool known = cross(edge);
      if (known && stand()) continue;
      if (known) before.beyond = triangle_;
      if (!(seams_++ < kMaxSeams && crossSeam(before.arrival) && stand())) return before;
    }
    return walk.sharp ? SurfaceWalk{0.0, {part_, triangle_, {}, {}, 0.0, false}, kNoTriangle, true}
                      : arrived(walked_);
  }

 private:
  static constexpr int kCut = 3;

  SurfaceWalk arrived(double share) const {
    return {share, {part_, triangle_, {}, {}, 0.0, false}, kNoTriangle, false};
  }

  void enter(PartId part, std::uint32_t triangle, const glm::dvec3& worldPoint) {
    ASSERT(world_.has(part) && world_.collider(part).tree != nullptr);
    ASSERT(triangle < world_.collider(part).tree->mesh().triangles.size());
    const Pose& pose = world_.pose(part);
    const glm::dquat partFromWorld = glm::conjugate(pose.orientation);
    part_ = part;
    triangle_ = triangle;
    mesh_ = &world_.collider(part).tree->mesh();
    at_ = partFromWorld * (worldPoint - pose.position);
    localWay_ = partFromWorld * way_;
    localUpright_ = partFromWorld * upright_;
    if (!world_.sections().empty()) cut_ = world_.sectionsOf(part);
  }

  /// Projects the displacement onto the present triangle; false if that is turned too far against the
  /// contact's normal.
  bool stand() {
    const Triangle t = world_.collider(part_).tree->triangle(triangle_);
    corners_[0] = t.a, corners_[1] = t.b, corners_[2] = t.c;
    normal_ = areaVector(t);
    const double square = glm::dot(normal_, normal_);
    if (!(square > 0.0)) return false;
    normal_ /= std::sqrt(square);
    const double cosine = glm::dot(normal_, localUpright_);
    step_ = localWay_ - normal_ * glm::dot(normal_, localWay_);
    return std::abs(cosine) >= kGroundTurn;
  }

  /// Goes to the edge through which the path leaves the triangle and returns that edge, kCut for that of a
  /// section; -1 if the path ends before it.
  int leave() {
    int first = -1;
    double earliest = 1.0;
    for (int e = 0; e < 3; ++e) {
      const glm::dvec3& a = corners_[e];
      const glm::dvec3 along = corners_[(e + 1) % 3] - a;
      const glm::dvec3 outwards = glm::cross(along, normal_);
      const double speed = glm::dot(outwards, step_);
      if (!(speed > 0.0)) continue;
      const double room = glm::dot(outwards, a - at_);
      // A path along an edge does not leave the triangle; it must end clearly beyond the edge.
      if (speed * (1.0 - walked_) - room <= 2.0 * tolerance_.edge * glm::length(along)) continue;
      const double when = walked_ + std::max(0.0, room) / speed;
      if (when >= earliest) continue;
      earliest = when;
      first = e;
    }
    for (const Section& section : cut_) {
      const double speed = glm::dot(section.normal, step_);
      if (!(speed > 0.0)) continue;
      const double room = section.offset - glm::dot(section.normal, at_);
      if (speed * (1.0 - walked_) - room <= 2.0 * tolerance_.edge) continue;
      const double when = walked_ + std::max(0.0, room) / speed;
      if (when >= earliest) continue;
      earliest = when;
      first = kCut;
    }
    if (first < 0) return -1;
    at_ += step_ * (earliest - walked_);
    walked_ = earliest;
    return first;
  }

  bool cross(int edge) {
    ASSERT(edge >= 0 && edge <= kCut);
    if (edge == kCut || triangle_ >= mesh_->neighbours.size()) return false;
    const std::uint32_t next = mesh_->neighbours[triangle_][static_cast<std::size_t>(edge)];
    if (next == assets::kNone) return false;
    ASSERT(next < mesh_->triangles.size());
    triangle_ = next;
    return true;
  }

  /// Looks for a surface just behind an edge at which the mesh ends or turns down: another part, or faces
  /// that share no vertices.
  bool crossSeam(const SurfacePoint& from) {
    if (!(length_ > 0.0)) return false;
    const Pose& pose = world_.pose(part_);
    const double ahead = 2.0 * tolerance_.seam / length_;
    if (walked_ + ahead >= 1.0) return false;  // the path ends before that place
    const glm::dvec3 ground = transformPoint(pose, at_), probe = ground + way_ * ahead;
    SurfacePoint nearest;
    double reach = 0.5 * tolerance_.seam;
    const glm::dvec3 grow(reach);
    bool found = false;
    world_.forEachNear({probe - grow, probe + grow}, [&](PartId part) {
      SurfacePoint candidate;
      if (!world_.touchable(part) || !world_.nearest(part, probe, reach, candidate)) return;
      if (found && std::abs(candidate.distance) >= reach) return;
      reach = std::min(reach, std::abs(candidate.distance));
      nearest = candidate;
      found = true;
    });
    if (!found || (nearest.part == from.part && nearest.triangle == from.triangle)) return false;
    walked_ += ahead;
    enter(nearest.part, nearest.triangle, probe);
    return true;
  }

  const ContactWorld& world_;
  const glm::dvec3 way_, upright_;
  const double length_;
  const WalkTolerance tolerance_;
  PartId part_ = kNoPart;
  std::uint32_t triangle_ = kNoTriangle;
  const assets::Mesh* mesh_ = nullptr;
  glm::dvec3 at_{0.0}, localWay_{0.0}, localUpright_{0.0}, normal_{0.0}, step_{0.0};
  glm::dvec3 corners_[3]{};
  Sections cut_;  // of the part
  double walked_ = 0.0;
  int seams_ = 0;
};

}  // namespace

SurfaceWalk walkSurface(const ContactWorld& world, const SurfacePoint& from, const glm::dvec3& displacement,
                        const WalkTolerance& tolerance) {
  return Walker(world, from, displacement, tolerance).run();
}

}  // namespace tandem::haptics
