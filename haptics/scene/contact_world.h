#pragma once

// The parts as one hand's tick sees them: their present poses, and which of them the tool may touch. All
// geometric queries of the proxy go through this class, in world coordinates.
//
// 1. setPose() and all queries are free of allocation; the constructor allocates.
// 2. Not shared between threads: each TickState owns one.

#include <cstdint>
#include <vector>

#include "assets/base/pose.h"
#include "haptics/geometry/cut_triangle.h"
#include "haptics/geometry/scene_bvh.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/free_ball.h"
#include "haptics/scene/loose_parts.h"
#include "haptics/scene/surface_point.h"
#include "haptics/scene/sweep_fronts.h"

namespace tandem::haptics {

class ContactWorld {
 public:
  explicit ContactWorld(const ContactScene& scene);

  const assets::Scene& scene() const { return *data_->scene; }
  /// Null if no material has a surface of its own.
  const SurfaceScene* surfaces() const { return data_->surfaces.get(); }
  const Collider& collider(PartId part) const { return data_->colliders[part]; }
  /// Null for a part that held parts pass through.
  const PartModel* model(PartId part) const { return data_->colliders[part].model; }
  const Pose& pose(PartId part) const { return poses_[part]; }
  const Twist& twist(PartId part) const { return parts_[part].twist; }
  bool has(PartId part) const { return part < parts_.size(); }

  /// Sets the pose of a part and refits the scene tree: O(depth).
  void setPose(PartId part, const Pose& worldFromPart, const Twist& twist);
  void setTwist(PartId part, const Twist& twist) { parts_[part].twist = twist; }
  /// Measures the parts that use a mesh again after the mesh has changed in place in the ContactScene. Free
  /// of allocation. Costs a comparison per part of the scene and a refit of the scene tree per part of the
  /// mesh.
  void meshChanged(std::uint32_t mesh);
  /// Takes the geometry from another ContactScene of the same Scene and measures the parts that differ; the
  /// previous scene must still exist. The cost is that of a mesh change.
  void adopt(const ContactScene& scene);
  /// Takes the models from a ContactScene that differs in them alone.
  void refine(const ContactScene& scene) { data_ = &scene.data(); }

  // Moves many parts in one tick: call beginMotions(), noteMotion() for each part, endMotions(), then
  // setNearPose() for each part that noteMotion() reported near. Queries are correct at any time, and fastest
  // within `region`.

  /// `region` is where this tick will query, m, world.
  void beginMotions(const assets::Bounds& region) {
    loose_.begin(region);
    free_.confineTo(region);
  }
  /// True if the part may enter the region on its path; it then still has its old pose. Otherwise it has
  /// moved.
  bool noteMotion(PartId part, const Pose& worldFromPart) {
    if (loose_.note(part, poses_[part].position, worldFromPart.position)) {
      noteNear(part, worldFromPart);
      return true;
    }
    poses_[part] = worldFromPart;
    return false;
  }
  /// Returns some of the parts that no longer move to the tree.
  void endMotions();
  void setNearPose(PartId part, const Pose& worldFromPart, const Twist& twist);
  bool anyLoose() const { return loose_.any(); }

  /// Whether the collision filters of two parts let them touch. Both must allow it.
  bool mayCollide(PartId a, PartId b) const;
  /// Whether the tool may touch a part: the part has geometry, its filter lets anything at all touch it, and
  /// it is neither ignored nor hidden.
  bool touchable(PartId part) const {
    return parts_[part].solid && !parts_[part].ignored && !parts_[part].hidden;
  }
  /// A part hidden by a layer does not exist for contact.
  void setHidden(PartId part, bool hidden) {
    if (!hidden) free_.forget();
    parts_[part].hidden = hidden;
  }
  bool hidden(PartId part) const { return parts_[part].hidden; }
  void setIgnored(PartId part, bool ignored) {
    if (!ignored) free_.forget();
    parts_[part].ignored = ignored;
  }
  bool ignored(PartId part) const { return parts_[part].ignored; }

  /// From now on what these cut away, world frame, is not there for any query of the tool.
  void setSections(const Sections& sections);
  const Sections& sections() const { return sections_; }
  Sections sectionsOf(PartId part) const;  // those that may cut it at its present pose, in its frame

  /// Keeps a ball that no touchable part's surface, with its margin, reaches into, so that sweep() in it
  /// needs no query. It shrinks as parts move, appear or change. A radius that is too large lets the tool
  /// through.
  void keepFree(const glm::dvec3& centre, double radius) { free_.keep(centre, radius); }
  const FreeBall& freeBall() const { return free_; }

  /// The skin near p, the distance that the tool keeps from a part, m: the part's own skin plus the rounding
  /// of world coordinates.
  double skin(PartId part, const glm::dvec3& p) const;
  /// The distance beyond its radius that a tool's centre keeps from a part near p, m: a skin. A tool smaller
  /// than the part's least one, such as a point, keeps twice what it lacks. A sweep stops it at half the
  /// margin, which is never less than that least tool.
  double margin(PartId part, const glm::dvec3& p, double radius) const;

  /// First contact, earlier than hit.t, of a ball of `radius` moving from p by `motion` with any touchable
  /// part but `except`, at a distance of radius plus half a margin.
  bool sweep(const glm::dvec3& p, const glm::dvec3& motion, double radius, PartId except,
             WorldHit& hit) const;

  /// sweep() against one part, which must have geometry and need not be touchable.
  bool sweepPart(PartId part, const glm::dvec3& p, const glm::dvec3& motion, double radius,
                 WorldHit& hit) const;
  /// An upper bound, from one triangle alone, of the fraction of the motion at which sweep() finds a contact;
  /// 1 if the triangle is not met. Passed as hit.t, it spares sweep() most other triangles.
  double sweepOne(const glm::dvec3& p, const glm::dvec3& motion, double radius, PartId part,
                  std::uint32_t triangle) const;

  /// sweep() against one part that moves from `before` to its present pose while the ball rests in the world.
  /// hit.t is a fraction of the part's motion; point and normal are those at the part's present pose, and
  /// `carried` is where the ball's centre ends if it moves with the part from the contact on.
  bool sweepAgainstMoved(PartId part, const Pose& before, const glm::dvec3& p, double radius, WorldHit& hit,
                         glm::dvec3& carried) const;

  /// One triangle at the part's present pose, world.
  Triangle triangle(PartId part, std::uint32_t triangle) const;

  /// What sections leave of it; empty if nothing.
  CutFace face(PartId part, std::uint32_t triangle) const;

  /// The point of one triangle nearest to p, at the part's present pose; kGone away if nothing is left of it.
  SurfacePoint surfaceAt(PartId part, std::uint32_t triangle, const glm::dvec3& p) const;

  /// The nearest point of one part within `reach` m of p; false if there is none.
  bool nearest(PartId part, const glm::dvec3& p, double reach, SurfacePoint& found) const;

  /// A lower bound of the distance from p to one part, `reach` if it is no nearer, and a triangle near there.
  NearLeaf nearestLeaf(PartId part, const glm::dvec3& p, double reach) const;

  /// Whether p is inside the part's solid, or nearer than `radius` to its surface. A point is inside a closed
  /// mesh if at least five of six rays leave it, so that a ray through an edge does not decide alone. A mesh
  /// that is not closed may be a sheet or a solid that lacks faces: a point is inside if all of fourteen
  /// rays leave it, so that a hole whose rim is seen more than some 40 degrees off its axis is a way out.
  bool overlaps(PartId part, const glm::dvec3& p, double radius) const;
  bool reaches(PartId part, const glm::dvec3& p, double distance) const;  // the first test of overlaps()
  /// Whether p is inside the solid of a part that has geometry; the second test of overlaps(). A part that
  /// sections have opened is a mesh that is not closed.
  bool encloses(PartId part, const glm::dvec3& p) const;

  /// Calls visit(part) for every part whose box meets `box`. visit must neither move parts nor call
  /// forEachNear() (as sweep() does): beyond the tick's region that rebuilds the list, and parts would be
  /// visited twice.
  template <typename Visit>
  void forEachNear(const assets::Bounds& box, Visit&& visit) const {
    if (!loose_.any()) return broad_.forEach(box, visit);
    broad_.forEach(box, [&](PartId part) {
      if (!loose_.isLoose(part)) visit(part);
    });
    if (!loose_.covers(box)) findNear(box);
    for (std::size_t i = 0; i < loose_.near().size(); ++i) {
      const PartId part = loose_.near()[i].part;
      if (SceneBvh::meet(loose_.near()[i].box, box) && loose_.isLoose(part)) visit(part);
    }
  }

  const assets::Material& material(PartId part, std::uint32_t triangle) const;

  static constexpr double kGone = 1e9;  // m

 private:
  struct PartState {
    Twist twist;
    bool solid = false;
    bool ignored = false;
    bool hidden = false;
  };

  void measure(PartId part);
  void noteNear(PartId part, const Pose& worldFromPart);
  void findNear(const assets::Bounds& box) const;
  Section ofPart(const Section& section, PartId part) const;
  bool cutNear(PartId part, const glm::dvec3& from, const glm::dvec3& to, double reach, Sections& cut) const;

  const ContactScene::Data* data_;
  std::vector<Pose> poses_;
  std::vector<PartState> parts_;
  Sections sections_;
  FreeBall free_;
  SceneBvh broad_;  // of the parts that are not loose; the boxes of loose parts are stale
  mutable SweepFronts fronts_;
  mutable LooseParts loose_;  // a query outside the region widens it
};

}  // namespace tandem::haptics
