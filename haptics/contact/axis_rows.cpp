#include "haptics/contact/axis_rows.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

// Dry friction sticks by a damper of this many times the inertia a tick: it hardly creeps.
constexpr double kSticking = 1e4;

/// Rows count angles as lengths at the body's radius.
class AxisRows {
 public:
  AxisRows(const ContactBody& body, std::uint16_t pair, ContactRows& rows)
      : axis_(*body.axis),
        lever_(axis_.angular != glm::dvec3(0.0) ? body.radius : 1.0),
        source_{pair, 0, assets::kNone},
        rows_(rows) {}

  /// Adds the half-space side q >= -room.
  void stop(double side, double room) {
    if (!std::isfinite(room)) return;
    ExactRow row = rowOf(side);
    row.gap = lever_ * std::max(room, 0.0);
    rows_.addExact(row);
  }

  /// The damper of dry friction: it yields at the friction's force, which a multiplier holds times dt^2.
  void friction(double dt) {
    if (!(axis_.friction > 0.0)) return;
    ExactRow row = rowOf(1.0);
    row.isEquality = true;
    row.compliance = lever_ * lever_ / (kSticking * axis_.inertia);
    row.maxMultiplier = axis_.friction / lever_ * dt * dt;
    rows_.addExact(row);
  }

 private:
  ExactRow rowOf(double side) const {
    ExactRow row;
    row.normal = side * axis_.linear;
    row.angular = side * lever_ * axis_.angular;
    row.source = source_;
    return row;
  }

  const AxisLimits& axis_;
  double lever_;
  RowSource source_;
  ContactRows& rows_;
};

}  // namespace

void addAxisRows(const ContactIsland& island, double dt, ContactRows& rows) {
  for (int i = 0; i < island.pairCount(); ++i) {
    const ContactPair& pair = island.pair(i);
    if (pair.joint != ContactPair::kAxis) continue;
    const ContactBody& body = island.first(pair);
    const AxisLimits& axis = *body.axis;
    const Displacement& applied = island.applied(pair.first);
    const double moved = glm::dot(axis.linear, applied.linear) + glm::dot(axis.angular, applied.angular);
    AxisRows made(body, static_cast<std::uint16_t>(i), rows);
    made.stop(1.0, axis.below + moved);
    made.stop(-1.0, axis.above - moved);
    made.friction(dt);
  }
}

}  // namespace tandem::haptics
