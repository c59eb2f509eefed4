#include "assets/scene/value_ranges.h"

#include <cmath>
#include <cstdio>
#include <initializer_list>

#include "assets/scene/describe.h"

namespace tandem::assets {
namespace {

struct Ranged {
  const char* property;
  double value;
  Range range;
};

std::optional<RangeFault> outside(const char* property, double value, const Range& range) {
  if (value >= range.least && value <= range.most) return std::nullopt;
  const char* space = *range.unit == '\0' ? "" : " ";
  char reason[160];
  std::snprintf(reason, sizeof reason, "is %.6g%s%s; it must lie between %.6g and %.6g%s%s", value, space,
                range.unit, range.least, range.most, space, range.unit);
  return RangeFault{property, reason};
}

std::optional<RangeFault> firstOutside(std::initializer_list<Ranged> all) {
  for (const auto& [property, value, range] : all)
    if (auto fault = outside(property, value, range)) return fault;
  return std::nullopt;
}

bool isUnbounded(double bound) { return std::abs(bound) >= 1e299; }

/// Finds the first number of a described record that is outside of its range.
struct FirstFault {
  std::optional<RangeFault> fault;

  void number(const char* property, double value, const Range& range, bool = true) {
    if (!fault) fault = outside(property, value, range);
  }
  void bound(const char* property, double value, const Range& range) {
    number(property, isUnbounded(value) ? 0.0 : value, range);
  }
  void vector(const char* property, const glm::dvec3& value, const Range& range) {
    for (int i = 0; i < 3; ++i) number(property, value[i], range);
  }
  void record(const char*, const auto& value) { describe(*this, value); }
  // Whether an enumeration and an index are good is checked with what they refer to (scene_check.cpp).
  void choice(const char*, const auto&, const auto&) {}
  void index(const char*, const auto&) {}
};

template <typename Record>
std::optional<RangeFault> faultOf(const Record& record) {
  FirstFault first;
  describe(first, record);
  return first.fault;
}

std::optional<RangeFault> firstOutside(const char* property, const glm::dvec3& v, const Range& range) {
  return firstOutside({{property, v.x, range}, {property, v.y, range}, {property, v.z, range}});
}

}  // namespace

bool nearOrigin(const glm::dvec3& p) {
  return std::abs(p.x) < kMaxCoordinate && std::abs(p.y) < kMaxCoordinate && std::abs(p.z) < kMaxCoordinate;
}

std::optional<RangeFault> gravityFault(const glm::dvec3& gravity) {
  constexpr Range kGravity{-1e3, 1e3, "m/s^2"};
  return firstOutside("gravity", gravity, kGravity);
}

std::optional<RangeFault> gravityFactorFault(double factor) {
  constexpr Range kFactor{-1e3, 1e3, ""};
  return firstOutside({{"gravityFactor", factor, kFactor}});
}

std::optional<RangeFault> toleranceFault(double tolerance) {
  constexpr Range kTolerance{1e-9, 1e3, "m"};
  return firstOutside({{"tolerance", tolerance, kTolerance}});
}

std::optional<RangeFault> outOfRange(const Material& m) { return faultOf(m); }

std::optional<RangeFault> outOfRange(const Surface& s) { return faultOf(s); }

std::optional<RangeFault> outOfRange(const ForceField& f) {
  constexpr Range kStrength{-1e12, 1e12, "N*m^2"};
  constexpr Range kEnergy{-1e6, 1e6, "J"};
  constexpr Range kTerm{-1e12, 1e12, "J/m^n"};
  if (auto fault = firstOutside("position", f.partFromField.position, kPlaceRange)) return fault;
  if (auto fault = firstOutside("force", f.force, kSignedForceRange)) return fault;
  if (auto fault = firstOutside("damping", f.damping, kDampingRange)) return fault;
  const bool ripple = f.potential == ForceField::Potential::ripple;
  if (auto fault = firstOutside(ripple ? "wavelength" : "sigma", f.sigma, kLengthRange)) return fault;
  for (const glm::dvec3& point : f.points)
    if (auto fault = firstOutside("points", point, kPlaceRange)) return fault;
  for (const PotentialTerm& term : f.terms)
    if (auto fault = firstOutside({{"terms.coefficient", term.coefficient, kTerm}})) return fault;
  if (auto fault = firstOutside({{"maxForce", f.maxForce, kForceRange},
                                 {"stiffness", f.stiffness, kStiffnessRange},
                                 {"radius", f.radius, kLengthRange},
                                 {"range", f.range, kLengthRange},
                                 {"fade", f.fade, kLengthRange},
                                 {"drive", f.drive, kSignedForceRange},
                                 {"strength", f.strength, kStrength},
                                 {"depth", f.depth, kEnergy}}))
    return fault;
  if (auto fault = faultOf(f.region)) return fault;
  return faultOf(f.waveform);
}

std::optional<RangeFault> outOfRange(const Control& c) {
  for (const double well : c.detents.places)
    if (auto fault = outside("detents.positions", well, turns(c) ? kTurnRange : kPlaceRange)) return fault;
  if (auto fault = firstOutside("origin", c.worldFromAxis.position, kPlaceRange)) return fault;
  // From one place to another: further than each may lie from the origin.
  if (auto fault = firstOutside("origin", c.axisFromPart.position, {-1e10, 1e10, "m"})) return fault;
  return faultOf(c);
}

std::optional<RangeFault> outOfRange(const Joint& j) {
  for (const JointLimit& l : j.limits)
    if (auto fault = faultOf(l)) return fault;
  for (const JointDrive& d : j.drives) {
    const Range speed{-1e6, 1e6, d.angular ? "rad/s" : "m/s"};
    const Range place = !d.angular ? kPlaceRange : d.axis == 0 ? kTurnRange : kHalfTurnRange;
    if (auto fault = firstOutside(
            {{"drives.positionTarget", d.positionTarget, place},
             {"drives.velocityTarget", d.velocityTarget, speed},
             {"drives.maxForce", isUnbounded(d.maxForce) ? 0.0 : d.maxForce, kForceRange},
             {"drives.stiffness", d.stiffness, d.angular ? kTurnStiffnessRange : kStiffnessRange},
             {"drives.damping", d.damping, d.angular ? kTurnDampingRange : kDampingRange}}))
      return fault;
  }
  const Range place = j.detentsTurn ? kTurnRange : kPlaceRange;
  for (const double well : j.detents.places)
    if (auto fault = firstOutside({{"detents.positions", well, place}})) return fault;
  return firstOutside({{"pitch", j.pitch, kPlaceRange},
                       {"detents.force", j.detents.force, j.detentsTurn ? kTorqueRange : kForceRange},
                       {"detents.width", j.detents.width, j.detentsTurn ? kTurnWidthRange : kLengthRange}});
}

std::optional<RangeFault> outOfRange(const ImplicitShape& s) {
  if (auto fault = firstOutside("position", s.partFromShape.position, kPlaceRange)) return fault;
  return faultOf(s);
}

}  // namespace tandem::assets
