#pragma once

// The bare tool of one hand, a point or a ball: its proxy, what the touched surfaces remember of it, and
// the parts that it passes through.
//
// 1. A tick calls begin() first, then place() where there is a valid reading, then what moves parts, then
//    forgetIgnored(), and last touch(), carry() or withdraw().
// 2. A part that the tool cannot be kept out of is ignored until both the device and the proxy have left
//    it: then there is no depth, and so no force that begins with a step.
// 3. Only the thread that ticks uses it. Nothing here allocates.

#include <cstdint>

#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "haptics/proxy/mesh_change.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scene/contact_world.h"
#include "haptics/surface/apply_surface.h"
#include "haptics/tool/part_finder.h"

namespace tandem::haptics {

inline constexpr int kMaxIgnored = 16;

/// A change of the contact force in one tick that the hand did not make.
struct ForeignChange {
  bool any = false;
  double expected = 0.0;  // m, displacement of the surface under the proxy at the last tick's velocity
};

/// A contact force that ends, as a spring that is as deep as its contacts were.
struct EndedContact {
  Wrench wrench;
  double stiffness = 0.0;  // N/m
};

class Tool {
 public:
  /// The world and the latch must outlive this.
  Tool(ContactWorld& world, FaultLatch& fault);

  /// Begins a tick: no flag and no foreign change yet. Follows meshes that were exchanged since the last one.
  void begin(const TickParameters& parameters);
  /// Notes a valid reading of the device, m, world. `anew` puts the proxy onto it, as the first reading does.
  void place(const glm::dvec3& device, bool anew);
  /// Puts the proxy onto the device. What the device is inside of cannot be felt until it has come out.
  void reset();

  // What parts do to the tool. All but ignore() have no effect before the first place().

  /// A part has moved from `before`, where it had `twistBefore`, to its present pose: takes the proxy
  /// along. `byHand`: this hand pushed it.
  void follow(PartId part, const Pose& before, const Twist& twistBefore, bool byHand);
  /// Whether a part that has moved from `before` to its present pose has come against the tool, or left a
  /// surface that the tool presses on, by more than `most` m.
  bool outruns(PartId part, const Pose& before, double most) const;
  /// The work in J that the contacts of the last touch() with a part do along their normals as the part moves
  /// from `before` to its present pose: positive where it pushes the tool.
  double workOf(PartId part, const Pose& before) const;
  /// A part is passed through from now on; sets kFlagOverflow if the list is full.
  void ignore(PartId part);
  /// The same for every touchable part that overlaps the proxy.
  void ignoreOverlapping();
  /// The same for a part that appears over the device or the proxy.
  void ignoreIfOver(PartId part);
  /// Ends the ignoring of the parts that the tool has left; `held` stays ignored. Sets kFlagInside if any
  /// other part is still ignored.
  void forgetIgnored(PartId held);
  /// What its contacts would have been in the last tick as the scene is cut now. Moves the proxy, and leaves
  /// the surfaces' memory as it is. contactWrench() where the last tick did not end with touch().
  Wrench contactAnew(const TickParameters& parameters);
  /// Sections move. A part that they bring back over or around the proxy is passed through until it is left.
  void cut(const Sections& sections);
  /// The ground under the proxy has changed, which may be far from its place then.
  void noteNewGround() { proxy_.goal.reset(); }
  /// Others have changed the force; `expected` m of that displacement continue the motion of the last tick.
  void noteForeignChange(double expected);

  // How a tick ends for the tool.

  /// Moves the proxy towards the device and computes the wrench of its contacts, which it writes to `out`.
  /// `felt` is the reading, with no velocity where the hand is at rest.
  void touch(const DeviceSample& felt, const TickParameters& parameters, TickOutput& out);
  /// The tool moves with a part in the hand and touches nothing itself; `position` m, world.
  void carry(const glm::dvec3& position);
  /// There is no reading: no contact force.
  void withdraw() {
    contactWrench_ = Wrench{};
    felt_.valid = false;
    surface_.shading = {};
  }

  // What it touches.

  bool started() const { return started_; }
  const Proxy& proxy() const { return proxy_; }
  Proxy& proxy() { return proxy_; }
  /// Wrench of the contacts of the last touch(), before limits.
  const Wrench& contactWrench() const { return contactWrench_; }
  /// The share of contactWrench() that comes from one part.
  Wrench contactWrenchOf(PartId part) const;
  /// The same as a force that ends.
  EndedContact endedContactWith(PartId part) const;
  bool pressesOn(PartId part) const;
  /// The stiffest of the touched materials, N/m, but no less than `least`.
  double stiffest(double least) const;
  /// The part under a tool without contacts: what it is inside of, `held` aside, else the nearest within
  /// that part's reach.
  PartId partUnder(PartId held);
  /// Where the tool can come to in this tick with a margin, m, world.
  assets::Bounds reachInTick() const;
  const ForeignChange& foreignChange() const { return foreign_; }
  /// TickFlags of this tick that touch() did not write to its output.
  std::uint32_t flags() const { return flags_; }

  // Around an exchange of meshes, between ticks.

  /// Notes the sides on which it touches, while the old triangles exist.
  void beforeMeshesChange();
  void afterMeshesChange() { measureReach(); }
  /// For tests: the next tick does not follow the exchange, and the proxy stays where it is.
  void leaveMeshChange() { meshChange_.pending = false; }

 private:
  void followMeshChange();
  void moveTo(const glm::dvec3& device);
  void measureReach();
  bool isOver(PartId part) const;
  bool cannotLeave(PartId part) const;
  double expectedDisplacement(const Pose& before, const Twist& twist, const glm::dvec3& proxy) const;

  ContactWorld& world_;
  FaultLatch& fault_;
  Proxy proxy_;
  SurfaceState surface_;
  MeshChange meshChange_;                     // since the last tick
  FixedVector<PartId, kMaxIgnored> ignored_;  // parts that the tool passes through until it has left them
  Wrench contactWrench_;
  DeviceSample felt_;                 // of the last tick; valid if it ended with touch()
  glm::dvec3 device_{0.0, 0.0, 0.0};  // m, of the last valid reading
  bool started_ = false;              // there has been one
  PartFinder finder_;
  double touchReach_ = 0.0;         // m, the largest of all parts
  double radius_ = 0.0, dt_ = 0.0;  // m and s, of this tick
  ForeignChange foreign_;           // of this tick
  std::uint32_t flags_ = 0;         // of this tick
};

}  // namespace tandem::haptics
