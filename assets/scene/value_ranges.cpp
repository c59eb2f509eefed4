#include "assets/scene/value_ranges.h"

#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <numbers>

namespace tandem::assets {
namespace {

struct Range {
  double least, most;
  const char* unit;
};

constexpr Range kForce{0.0, 1e4, "N"};
constexpr Range kSignedForce{-1e4, 1e4, "N"};
constexpr Range kStiffness{0.0, 1e6, "N/m"};
constexpr Range kDamping{0.0, 1e3, "N*s/m"};
constexpr Range kCoefficient{0.0, 1e3, ""};  // of friction: files write large ones for what never slides
constexpr Range kShare{0.0, 1.0, ""};
constexpr Range kAngle{0.0, 2.0 * std::numbers::pi, "rad"};
constexpr Range kFrequency{0.0, 1e4, "Hz"};
constexpr Range kReliefHeight{0.0, 1.0, "m"};
constexpr Range kWavelength{1e-6, 1e3, "m"};
constexpr Range kReach{0.0, 1e3, "m"};
constexpr Range kTime{0.0, 1e6, "s"};
constexpr Range kLength{0.0, kMaxCoordinate, "m"};
constexpr Range kPlace{-kMaxCoordinate, kMaxCoordinate, "m"};
// Of a dial: the same numbers about an axis.
constexpr Range kTorque{0.0, 1e4, "N*m"};
constexpr Range kTurnStiffness{0.0, 1e6, "N*m/rad"};
constexpr Range kTurnDamping{0.0, 1e3, "N*m*s/rad"};
constexpr Range kTurn{-1e3, 1e3, "rad"};
// About an axis beside the joint's first one, where whole turns are not counted.
constexpr Range kHalfTurn{-std::numbers::pi, std::numbers::pi, "rad"};
constexpr Range kTurnWidth{0.0, 1e3, "rad"};

struct Ranged {
  const char* property;
  double value;
  Range range;
};

std::optional<RangeFault> firstOutside(std::initializer_list<Ranged> all) {
  for (const auto& [property, value, range] : all) {
    if (value >= range.least && value <= range.most) continue;
    const char* space = *range.unit == '\0' ? "" : " ";
    char reason[160];
    std::snprintf(reason, sizeof reason, "is %.6g%s%s; it must lie between %.6g and %.6g%s%s", value, space,
                  range.unit, range.least, range.most, space, range.unit);
    return RangeFault{property, reason};
  }
  return std::nullopt;
}

std::optional<RangeFault> firstOutside(const char* property, const glm::dvec3& v, const Range& range) {
  return firstOutside({{property, v.x, range}, {property, v.y, range}, {property, v.z, range}});
}

std::optional<RangeFault> regionFault(const FieldRegion& r) {
  if (auto fault = firstOutside("region.size", r.halfSize, kLength)) return fault;
  return firstOutside({{"region.radius", r.radius, kLength}, {"region.fade", r.fade, kLength}});
}

std::optional<RangeFault> waveformFault(const FieldWaveform& w) {
  constexpr Range kRate{1e-6, kMaxFieldFrequency, "Hz"};
  constexpr Range kSweep{1e-6, 1e6, "s"};
  constexpr Range kPhase{-1e3, 1e3, "rad"};
  constexpr Range kStart{0.0, 1e9, "s"};
  constexpr Range kStop{0.0, 1e300, "s"};  // 1e300: never
  return firstOutside(
      {{"waveform.frequency", w.frequency, kRate},
       {"waveform.endFrequency", w.endFrequency, kRate},
       {"waveform.sweep", w.sweep, kSweep},
       {"waveform.phase", w.phase, kPhase},
       {w.kind == FieldWaveform::Kind::square ? "waveform.edge" : "waveform.width", w.width, kTime},
       {"waveform.start", w.start, kStart},
       {"waveform.stop", w.stop, kStop}});
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

std::optional<RangeFault> outOfRange(const Material& m) {
  return firstOutside({{"stiffness", m.stiffness, kStiffness},
                       {"damping", m.damping, kDamping},
                       {"staticFriction", m.staticFriction, kCoefficient},
                       {"dynamicFriction", m.dynamicFriction, kCoefficient},
                       {"restitution", m.restitution, kShare}});
}

std::optional<RangeFault> outOfRange(const Surface& s) {
  const SurfaceTexture& t = s.texture;
  const bool procedural = t.pattern > SurfaceTexture::Pattern::image;
  return firstOutside({{"creaseAngle", s.creaseAngle, kAngle},
                       {"viscosity", s.viscosity, kDamping},
                       {"texture.amplitude", t.amplitude, kReliefHeight},
                       {"textureAmplitude", t.amplitudeForce, kForce},
                       {t.amplitudeForce > 0.0 ? "textureWavelength" : "texture.wavelength", t.wavelength,
                        procedural ? kWavelength : kReach},
                       {"texture.frictionScale", t.frictionScale, kCoefficient},
                       {"vibration.frequency", s.vibrationFrequency, kFrequency},
                       {"vibration.amplitude", s.vibrationAmplitude, kForce},
                       {"stickSlip.force", s.stickSlipForce, kForce},
                       {"stickSlip.stiffness", s.stickSlipStiffness, kStiffness},
                       {"magnetic.force", s.magneticForce, kForce},
                       {"magnetic.distance", s.magneticDistance, kReach},
                       {"popThrough.force", s.popThroughForce, kForce},
                       {"law.stiffness2", s.stiffness2, kStiffness},
                       {"law.relaxation", s.relaxation, kTime},
                       {"law.yield", s.yieldForce, kForce},
                       {"law.hardening", s.hardening, kStiffness}});
}

std::optional<RangeFault> outOfRange(const ForceField& f) {
  constexpr Range kStrength{-1e12, 1e12, "N*m^2"};
  constexpr Range kEnergy{-1e6, 1e6, "J"};
  constexpr Range kTerm{-1e12, 1e12, "J/m^n"};
  if (auto fault = firstOutside("position", f.partFromField.position, kPlace)) return fault;
  if (auto fault = firstOutside("force", f.force, kSignedForce)) return fault;
  if (auto fault = firstOutside("damping", f.damping, kDamping)) return fault;
  const bool ripple = f.potential == ForceField::Potential::ripple;
  if (auto fault = firstOutside(ripple ? "wavelength" : "sigma", f.sigma, kLength)) return fault;
  for (const glm::dvec3& point : f.points)
    if (auto fault = firstOutside("points", point, kPlace)) return fault;
  for (const PotentialTerm& term : f.terms)
    if (auto fault = firstOutside({{"terms.coefficient", term.coefficient, kTerm}})) return fault;
  if (auto fault = firstOutside({{"maxForce", f.maxForce, kForce},
                                 {"stiffness", f.stiffness, kStiffness},
                                 {"radius", f.radius, kLength},
                                 {"range", f.range, kLength},
                                 {"fade", f.fade, kLength},
                                 {"drive", f.drive, kSignedForce},
                                 {"strength", f.strength, kStrength},
                                 {"depth", f.depth, kEnergy}}))
    return fault;
  if (auto fault = regionFault(f.region)) return fault;
  return waveformFault(f.waveform);
}

std::optional<RangeFault> outOfRange(const Control& c) {
  const bool dial = turns(c);
  const Range place = dial ? kTurn : kPlace, width = dial ? kTurnWidth : kLength;
  const Range force = dial ? kTorque : kForce;
  // An inertia that is tinier than any part's would turn a force into a speed that is not finite.
  const Range inertia{1e-30, 1e9, dial ? "kg*m^2" : "kg"};
  for (const double well : c.detents.places)
    if (auto fault = firstOutside({{"detents.positions", well, place}})) return fault;
  if (auto fault = firstOutside("origin", c.worldFromAxis.position, kPlace)) return fault;
  // From one place to another: further than each may lie from the origin.
  if (auto fault = firstOutside("origin", c.axisFromPart.position, {-1e10, 1e10, "m"})) return fault;
  return firstOutside({{"min", c.min, place},
                       {"max", c.max, place},
                       {"value", c.initial, place},
                       {"inertia", c.inertia, inertia},
                       {"spring.stiffness", c.springStiffness, dial ? kTurnStiffness : kStiffness},
                       {"spring.rest", c.springRest, place},
                       {"damping", c.damping, dial ? kTurnDamping : kDamping},
                       {"friction", c.friction, force},
                       {"detents.force", c.detents.force, force},
                       {"detents.width", c.detents.width, width},
                       {"click.at", c.click.at, place},
                       {"click.drop", c.click.drop, force},
                       {"click.width", c.click.width, width},
                       {"threshold", c.threshold, place}});
}

std::optional<RangeFault> outOfRange(const Joint& j) {
  const auto unbounded = [](double bound) { return std::abs(bound) >= 1e299; };
  for (const JointLimit& l : j.limits) {
    const Range place = l.angular ? kTurn : kPlace;
    if (auto fault = firstOutside({{"limits.min", unbounded(l.min) ? 0.0 : l.min, place},
                                   {"limits.max", unbounded(l.max) ? 0.0 : l.max, place},
                                   {"limits.stiffness", l.stiffness, l.angular ? kTurnStiffness : kStiffness},
                                   {"limits.damping", l.damping, l.angular ? kTurnDamping : kDamping}}))
      return fault;
  }
  for (const JointDrive& d : j.drives) {
    const Range speed{-1e6, 1e6, d.angular ? "rad/s" : "m/s"};
    const Range place = !d.angular ? kPlace : d.axis == 0 ? kTurn : kHalfTurn;
    if (auto fault = firstOutside({{"drives.positionTarget", d.positionTarget, place},
                                   {"drives.velocityTarget", d.velocityTarget, speed},
                                   {"drives.maxForce", unbounded(d.maxForce) ? 0.0 : d.maxForce, kForce},
                                   {"drives.stiffness", d.stiffness, d.angular ? kTurnStiffness : kStiffness},
                                   {"drives.damping", d.damping, d.angular ? kTurnDamping : kDamping}}))
      return fault;
  }
  const Range place = j.detentsTurn ? kTurn : kPlace;
  for (const double well : j.detents.places)
    if (auto fault = firstOutside({{"detents.positions", well, place}})) return fault;
  return firstOutside({{"pitch", j.pitch, kPlace},
                       {"detents.force", j.detents.force, j.detentsTurn ? kTorque : kForce},
                       {"detents.width", j.detents.width, j.detentsTurn ? kTurnWidth : kLength}});
}

std::optional<RangeFault> outOfRange(const ImplicitShape& s) {
  if (auto fault = firstOutside("position", s.partFromShape.position, kPlace)) return fault;
  if (auto fault = firstOutside("size", s.size, kLength)) return fault;
  return firstOutside(
      {{"height", s.height, kLength},
       {s.kind == ImplicitShape::Kind::sphere ? "radius" : "radiusTop", s.radiusTop, kLength},
       {s.kind == ImplicitShape::Kind::sphere ? "radius" : "radiusBottom", s.radiusBottom, kLength}});
}

}  // namespace tandem::assets
