#include "haptics/solver/joint_rows.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "haptics/body/control_dynamics.h"

namespace tandem::haptics {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

struct Limits {
  double min, max, stiffness, damping;
};

/// One coordinate q of a joint and its Jacobian: dq = normal . (displacement at `arm`) + angular .
/// rotation, both of the pair. Angles are given in m at the lever.
struct Coordinate {
  double value = 0.0;
  glm::dvec3 normal{0.0, 0.0, 0.0}, angular{0.0, 0.0, 0.0};
};

class Rows {
 public:
  Rows(const PlacedJoint& placed, double maxCorrection, double dt, ContactRows& rows)
      : placed_(placed),
        maxCorrection_(maxCorrection),
        dt_(dt),
        rows_(rows),
        sign_(placed.firstIsB ? 1.0 : -1.0) {
    arm_ = placed.worldFromB.position - placed.centre;
    for (int i = 0; i < 3; ++i) {
      glm::dvec3 unit(0.0);
      unit[i] = 1.0;
      axis_[i] = placed.worldFromA.orientation * unit;
    }
    offset_ = placed.worldFromB.position - placed.worldFromA.position;
  }

  Coordinate along(const glm::dvec3& axis, double value) const {
    return {value, sign_ * axis, glm::dvec3(0.0)};
  }
  Coordinate about(const glm::dvec3& axis, double angle) const {
    return {placed_.lever * angle, glm::dvec3(0.0), sign_ * placed_.lever * axis};
  }

  void limit(const assets::JointLimit& limit, double angleAboutX) {
    if (limit.angular)
      angular(limit, angleAboutX);
    else
      linear(limit);
  }

  /// Adds the equation q = value.
  void lock(const Coordinate& q, double value) {
    ExactRow row = rowOf(q);
    row.gap = std::clamp(q.value - value, -maxCorrection_, maxCorrection_);
    row.isEquality = true;
    rows_.addExact(row);
  }

  /// Adds a spring and damper F = -k (q - target) - b (q' - rate), implicit in the step, of at most `force`
  /// (N). A soft constraint: with the multiplier l = F dt^2 and q' = J u / dt the implicit step is J u + l
  /// / (k dt^2 + b dt) = -(k (q - target) - b rate) dt^2 / (k dt^2 + b dt), a row of compliance 1 / (k dt^2
  /// + b dt).
  void spring(const Coordinate& q, double k, double b, double target, double rate, double force) {
    const double drag = dt_ * dt_ * k + dt_ * b;
    if (!(drag > 0.0)) return;
    ExactRow row = rowOf(q);
    row.compliance = 1.0 / drag;
    row.gap = row.compliance * dt_ * dt_ * (k * (q.value - target) - b * rate);
    row.isEquality = true;
    row.maxMultiplier = force * dt_ * dt_;
    rows_.addExact(row);
  }

  const glm::dvec3& axis(int i) const { return axis_[i]; }
  const glm::dvec3& offset() const { return offset_; }
  double lever() const { return placed_.lever; }

 private:
  ExactRow rowOf(const Coordinate& q) const {
    ExactRow row;
    row.normal = q.normal;
    row.arm = arm_;
    row.angular = q.angular;
    row.source = {placed_.pair, 0, assets::kNone};
    return row;
  }

  /// Adds min <= q <= max, with the limit's own spring where it has one.
  void within(const Coordinate& q, const Limits& limit) {
    const bool soft = limit.stiffness > 0.0;
    if (limit.min == limit.max) {
      if (soft)
        spring(q, limit.stiffness, limit.damping, limit.min, 0.0, 1e300);
      else
        lock(q, limit.min);
      return;
    }
    if (limit.min > -1e299) bound(q, 1.0, limit.min, limit);
    if (limit.max < 1e299) bound(q, -1.0, limit.max, limit);
  }

  /// Adds the half-space side q >= side at.
  void bound(const Coordinate& q, double side, double at, const Limits& limit) {
    const double gap = side * (q.value - at);
    ExactRow row = rowOf({0.0, side * q.normal, side * q.angular});
    row.gap = std::max(gap, -maxCorrection_);
    if (limit.stiffness > 0.0) {
      const double drag = dt_ * dt_ * limit.stiffness + dt_ * limit.damping;
      row.compliance = 1.0 / drag;
      // The spring acts behind the limit only.
      row.gap = gap < 0.0 ? gap * dt_ * dt_ * limit.stiffness / drag : gap;
    }
    rows_.addExact(row);
  }

  void linear(const assets::JointLimit& limit) {
    const Limits range{limit.min, limit.max, limit.stiffness, limit.damping};
    glm::dvec3 off(0.0);
    int count = 0, last = 0;
    for (int i = 0; i < 3; ++i) {
      if ((limit.axes >> i & 1) == 0) continue;
      off += glm::dot(axis_[i], offset_) * axis_[i];
      last = i;
      ++count;
    }
    if (count == 1) return within(along(axis_[last], glm::dot(axis_[last], offset_)), range);
    if (limit.max <= 0.0) {  // a maximum distance of 0 locks each axis
      const Limits none{0.0, 0.0, limit.stiffness, limit.damping};
      for (int i = 0; i < 3; ++i) {
        if ((limit.axes >> i & 1) != 0) within(along(axis_[i], glm::dot(axis_[i], offset_)), none);
      }
      return;
    }
    const double distance = glm::length(off);
    const glm::dvec3 direction = distance > 0.0 ? off / distance : axis_[last];
    within(along(direction, distance),
           {std::max(limit.min, 0.0) > 0.0 ? limit.min : -1e300, limit.max, limit.stiffness, limit.damping});
  }

  void angular(const assets::JointLimit& limit, double angleAboutX) {
    const double l = placed_.lever, scale = 1.0 / (l * l);
    const auto bounded = [&](double at) { return std::abs(at) < 1e299 ? l * at : at; };
    const Limits range{bounded(limit.min), bounded(limit.max), scale * limit.stiffness,
                       scale * limit.damping};
    const Limits none{0.0, 0.0, range.stiffness, range.damping};
    const glm::dquat q = glm::conjugate(placed_.worldFromA.orientation) * placed_.worldFromB.orientation;
    switch (limit.axes) {
      case 1:
        return within(about(axis_[0], angleAboutX), range);
      case 2:
        return within(about(axis_[1], twist(q.y, q.w)), range);
      case 4:
        return within(about(axis_[2], twist(q.z, q.w)), range);
      case 7: {
        const glm::dvec3 rotation = rotationVector(q);
        if (limit.max <= 0.0) {
          for (int i = 0; i < 3; ++i) within(about(axis_[i], rotation[i]), none);
          return;
        }
        const double angle = glm::length(rotation);
        const glm::dvec3 direction =
            angle > 0.0 ? placed_.worldFromA.orientation * (rotation / angle) : axis_[0];
        return within(about(direction, angle), {-1e300, range.max, range.stiffness, range.damping});
      }
      default:
        break;
    }
    // A limit of two axes constrains the angle between the third axes of the two frames.
    const int third = limit.axes == 6 ? 0 : limit.axes == 5 ? 1 : 2;
    glm::dvec3 unit(0.0);
    unit[third] = 1.0;
    const glm::dvec3 ofB = placed_.worldFromB.orientation * unit, cross = glm::cross(axis_[third], ofB);
    if (limit.max <= 0.0) {
      // Where the axes are opposite, |cross| is as small as where they agree; the sign of the cosine tells
      // which it is.
      const double size = glm::dot(axis_[third], ofB) >= 0.0 ? 1.0 : 1.0 / std::max(glm::length(cross), 1e-6);
      for (int i = 0; i < 3; ++i) {
        if (i != third) within(about(axis_[i], size * glm::dot(axis_[i], cross)), none);
      }
      return;
    }
    const double sine = glm::length(cross), angle = std::atan2(sine, glm::dot(axis_[third], ofB));
    const glm::dvec3 direction = sine > 0.0 ? cross / sine : axis_[(third + 1) % 3];
    within(about(direction, angle),
           {limit.min > 0.0 ? range.min : -1e300, range.max, range.stiffness, range.damping});
  }

  static double twist(double part, double w) {
    return part == 0.0 && w == 0.0 ? 0.0 : 2.0 * std::atan2(w < 0.0 ? -part : part, std::abs(w));
  }

  const PlacedJoint& placed_;
  double maxCorrection_, dt_;
  ContactRows& rows_;
  double sign_;  // of B's motion relative to A, in terms of the pair's
  glm::dvec3 arm_, offset_, axis_[3];
};

/// Twist of B about A's X axis, -pi..pi.
double twistAboutX(const PlacedJoint& placed) {
  const glm::dquat q = glm::conjugate(placed.worldFromA.orientation) * placed.worldFromB.orientation;
  return q.x == 0.0 && q.w == 0.0 ? 0.0 : 2.0 * std::atan2(q.w < 0.0 ? -q.x : q.x, std::abs(q.w));
}

double placeAlongX(const PlacedJoint& placed) {
  const glm::dvec3 x = placed.worldFromA.orientation * glm::dvec3(1.0, 0.0, 0.0);
  return glm::dot(x, placed.worldFromB.position - placed.worldFromA.position);
}

void addDrive(const assets::JointDrive& drive, const PlacedJoint& placed, double angleAboutX, Rows& rows) {
  const glm::dvec3& axis = rows.axis(drive.axis);
  const double l = rows.lever(),
               weight = drive.acceleration ? (drive.angular ? placed.inertia : placed.mass) : 1.0;
  if (!drive.angular) {
    rows.spring(rows.along(axis, glm::dot(axis, rows.offset())), weight * drive.stiffness,
                weight * drive.damping, drive.positionTarget, drive.velocityTarget, drive.maxForce);
    return;
  }
  double angle = angleAboutX;
  if (drive.axis != 0) {
    const glm::dquat q = glm::conjugate(placed.worldFromA.orientation) * placed.worldFromB.orientation;
    angle = rotationVector(q)[drive.axis];
  }
  rows.spring(rows.about(axis, angle), weight * drive.stiffness / (l * l), weight * drive.damping / (l * l),
              l * drive.positionTarget, l * drive.velocityTarget, drive.maxForce / l);
}

}  // namespace

JointState startJoint(const PlacedJoint& placed) {
  JointState state;
  state.angle = twistAboutX(placed);
  state.steepestDetent = steepestDetent(placed.joint->detents);
  state.thread = placeAlongX(placed) - placed.joint->pitch / kTurn * state.angle;
  return state;
}

void followAngle(const PlacedJoint& placed, JointState& state) {
  const double angle = twistAboutX(placed);
  state.angle = angle + kTurn * std::round((state.angle - angle) / kTurn);
}

double jointValue(const PlacedJoint& placed, const JointState& state, bool angular) {
  return angular ? state.angle : placeAlongX(placed);
}

void addJointRows(const PlacedJoint& placed, const JointState& state, double maxCorrection, double dt,
                  ContactRows& rows) {
  const assets::Joint& joint = *placed.joint;
  Rows made(placed, maxCorrection, dt, rows);
  for (const assets::JointLimit& limit : joint.limits) made.limit(limit, state.angle);
  if (joint.pitch != 0.0) {
    Coordinate q = made.along(made.axis(0), placeAlongX(placed) - joint.pitch / kTurn * state.angle);
    q.angular = -joint.pitch / kTurn * q.normal;
    made.lock(q, state.thread);
  }
  for (const assets::JointDrive& drive : joint.drives) addDrive(drive, placed, state.angle, made);
  if (!(state.steepestDetent > 0.0)) return;
  // A spring of the detents' steepest slope and of their force here gains no energy (control_dynamics.h).
  const double value = jointValue(placed, state, joint.detentsTurn);
  const double lever = joint.detentsTurn ? made.lever() : 1.0;
  const Coordinate q = joint.detentsTurn ? made.about(made.axis(0), value) : made.along(made.axis(0), value);
  const double steepest = state.steepestDetent / (lever * lever);
  const double force = -detentResistance(joint.detents, value) / lever;
  made.spring(q, steepest, 0.0, q.value + force / steepest, 0.0, 1e300);
}

}  // namespace tandem::haptics
