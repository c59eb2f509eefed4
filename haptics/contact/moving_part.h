#pragma once

// Input and output of a contact tick: the parts that move, and where they rest.

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

#include "haptics/base/fault.h"
#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/contact/grip_pace.h"
#include "haptics/scene/contact_world.h"
#include "haptics/solver/contact_rows.h"

namespace tandem::haptics {

/// What bounds the motion of a part that has one axis only, a control, beside the inertia of its step, which
/// holds it across the axis.
struct AxisLimits {
  glm::dvec3 linear{0.0, 0.0, 0.0};   // unit, world, of a part that slides; else zero
  glm::dvec3 angular{0.0, 0.0, 0.0};  // unit, world, of a part that turns; else zero
  double below = 0.0, above = 0.0;    // m or rad, how far it may go in this tick; infinite without stops
  double friction = 0.0;              // N or N·m, dry
  double inertia = 0.0;               // kg or kg·m^2, of the step, along or about the axis
};

/// A part that moves in this tick, with the step that it would take without contacts and joints.
struct MovingPart {
  PartId part = kNoPart;
  CoupledStep step;
  RigidBody* body = nullptr;
  Displacement displacement{};            // output: of its centre of mass, and its rotation
  std::optional<AxisLimits> axis{};       // of a control: it touches nothing but other moving parts
  FixedVector<GripPace, kHands> grips{};  // how far hands let a slipping part go
  bool slips = false;                     // output: a GripPace made its motion shorter
  bool cutShort = false;                  // output: it lags because the step's iterations ran out
};

/// A place where a moving part rests on another.
struct PartTouch {
  PartId of = kNoPart;               // the moving part
  PartId part = kNoPart;             // the other one, which may move too
  glm::dvec3 point{0.0, 0.0, 0.0};   // m, world
  glm::dvec3 normal{0.0, 0.0, 0.0};  // unit, world, away from `part`
  double force = 0.0;                // N along the normal
};

/// The touches of one tick. Those that do not fit are left out.
class PartTouches {
 public:
  static constexpr std::size_t kMax = 24;

  void clear() { touches_.clear(); }
  bool full() const { return touches_.full(); }
  /// The list must not be full.
  void add(const PartTouch& touch, FaultLatch& fault) {
    if (!TICK_ASSERT(fault, !full())) return;
    touches_.push_back(touch);
  }
  void sortStrongestFirst() {
    std::sort(touches_.begin(), touches_.end(),
              [](const PartTouch& a, const PartTouch& b) { return a.force > b.force; });
  }
  std::span<const PartTouch> all() const { return {touches_.data(), touches_.size()}; }

 private:
  FixedVector<PartTouch, kMax> touches_;
};

}  // namespace tandem::haptics
