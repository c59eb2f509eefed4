#pragma once

// The parts as one hand's tick knows them: where they are now, which of them the tool may touch. All
// geometric questions of the proxy go through here, in world coordinates.
//
// 1. setPose() and every query are free of allocation; the constructor allocates.
// 2. Not shared between threads: each TickState owns one.

#include <cstdint>
#include <vector>

#include "assets/base/pose.h"
#include "haptics/geometry/scene_bvh.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/loose_parts.h"

namespace tandem::haptics {

/// First touch of the moving tool with any part, world frame.
struct WorldHit : BallHit {
  PartId part = kNoPart;
  std::uint32_t triangle = kNoTriangle;
};

/// A point of a part's surface, world frame.
struct SurfacePoint {
  PartId part = kNoPart;
  std::uint32_t triangle = kNoTriangle;
  glm::dvec3 point{0.0, 0.0, 0.0};
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit, towards the asker
  double distance = 0.0;             // m
  bool onFace = false;               // inside the triangle, neither on an edge nor a corner
};

class ContactWorld {
 public:
  explicit ContactWorld(const ContactScene& scene);

  const assets::Scene& scene() const { return *data_->scene; }
  /// Null where no material has a surface of its own kind.
  const SurfaceScene* surfaces() const { return data_->surfaces.get(); }
  const Collider& collider(PartId part) const { return data_->colliders[part]; }
  /// Null where parts in the hand pass through it.
  const PartModel* model(PartId part) const { return data_->colliders[part].model; }
  const Pose& pose(PartId part) const { return poses_[part]; }
  const Twist& twist(PartId part) const { return parts_[part].twist; }
  bool has(PartId part) const { return part < parts_.size(); }

  /// Puts a part somewhere and into the scene tree: O(depth).
  void setPose(PartId part, const Pose& worldFromPart, const Twist& twist);
  void setTwist(PartId part, const Twist& twist) { parts_[part].twist = twist; }
  /// After a mesh of the ContactScene has changed in place: measures the parts that use it anew. Free of
  /// allocation; a comparison for each part of the scene, a refit of the scene tree for each of those parts.
  void meshChanged(std::uint32_t mesh);
  /// Takes the geometry from another ContactScene of the same Scene, measuring the parts that differ; the one
  /// before must still be there. Costs the same.
  void adopt(const ContactScene& scene);

  // Many parts that move in one tick: beginMotions(); noteMotion() for each; endMotions(); then setNearPose()
  // for each that noteMotion() found near. Queries are right at every time, fastest within `region`.

  /// `region`: where this tick is going to ask, m, world.
  void beginMotions(const assets::Bounds& region) { loose_.begin(region); }
  /// True if the part may come into the region on its way; its pose is then still the old one. If not, it has
  /// moved.
  bool noteMotion(PartId part, const Pose& worldFromPart) {
    if (loose_.note(part, poses_[part].position, worldFromPart.position)) {
      noteNear(part, worldFromPart);
      return true;
    }
    poses_[part] = worldFromPart;
    return false;
  }
  /// Puts some of the parts that no longer move back into the tree.
  void endMotions();
  void setNearPose(PartId part, const Pose& worldFromPart, const Twist& twist);
  bool anyLoose() const { return loose_.any(); }

  /// Whether the collision filters of two parts let them touch. Both must allow it.
  bool mayCollide(PartId a, PartId b) const;
  /// Whether the tool may touch a part: it has geometry, its filter lets anything at all touch it, it is
  /// neither ignored nor hidden.
  bool touchable(PartId part) const {
    return parts_[part].solid && !parts_[part].ignored && !parts_[part].hidden;
  }
  /// A part that a layer hides is not there: nothing touches it.
  void setHidden(PartId part, bool hidden) { parts_[part].hidden = hidden; }
  bool hidden(PartId part) const { return parts_[part].hidden; }
  void setIgnored(PartId part, bool ignored) { parts_[part].ignored = ignored; }
  bool ignored(PartId part) const { return parts_[part].ignored; }

  /// Distance that the tool keeps from a part near p, m: the part's own skin plus the rounding of world
  /// coordinates.
  double skin(PartId part, const glm::dvec3& p) const;

  /// First touch of a ball of `radius` moving from p by `motion` with any touchable part but `except`, at a
  /// distance of radius plus half a skin; earlier than hit.t.
  bool sweep(const glm::dvec3& p, const glm::dvec3& motion, double radius, PartId except,
             WorldHit& hit) const;

  /// The same against one part, which has geometry, touchable or not.
  bool sweepPart(PartId part, const glm::dvec3& p, const glm::dvec3& motion, double radius,
                 WorldHit& hit) const;
  /// An upper bound of the share of the way at which sweep() will find a touch, from one triangle alone; 1 if
  /// that is not met. It saves sweep() the look at most others when passed as its hit.t.
  double sweepOne(const glm::dvec3& p, const glm::dvec3& motion, double radius, PartId part,
                  std::uint32_t triangle) const;

  /// The same against one part that moves meanwhile from `before` to where it is now; the ball stands still
  /// in the world. hit.t is a share of the part's motion; point and normal are those at the part's present
  /// pose, and `carried` is where the ball's centre ends if it goes with the part from the touch on.
  bool sweepAgainstMoved(PartId part, const Pose& before, const glm::dvec3& p, double radius, WorldHit& hit,
                         glm::dvec3& carried) const;

  /// One triangle where it is now, world.
  Triangle triangle(PartId part, std::uint32_t triangle) const;

  /// Where one triangle is nearest to p, now.
  SurfacePoint surfaceAt(PartId part, std::uint32_t triangle, const glm::dvec3& p) const;

  /// The nearest point of one part within `reach` m of p; false if there is none.
  bool nearest(PartId part, const glm::dvec3& p, double reach, SurfacePoint& found) const;

  /// Whether p is inside the part's solid, or nearer than `radius` to its surface. Inside: at least five of
  /// six rays leave the solid, so that one ray through an edge or a small hole does not decide.
  bool overlaps(PartId part, const glm::dvec3& p, double radius) const;
  /// The second half of overlaps(): inside the solid of a part that has geometry.
  bool encloses(PartId part, const glm::dvec3& p) const;

  /// Calls visit(part) for every part whose box meets `box`; visit must not move parts nor ask forEachNear(),
  /// as sweep() does: beyond the region of the tick that draws up the list anew, and parts come twice.
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

  const ContactScene::Data* data_;
  std::vector<Pose> poses_;
  std::vector<PartState> parts_;
  SceneBvh broad_;            // of the parts that are not loose; boxes of loose ones are out of date
  mutable LooseParts loose_;  // a query outside the region widens it
};

}  // namespace tandem::haptics
