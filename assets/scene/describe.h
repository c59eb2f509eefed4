#pragma once

// The numbers of a scene's records, each written down once: its property in the file, its range and its unit.
// The codec, the check of ranges, the loader and the writer of sample scenes go over a record by its
// describe(), so that a new number is one line here beside the member itself, whose initialiser is its
// default.
//
// describe(visitor, record) calls, in the order in which the codec writes the members,
//   number(property, value, range, applies)  for a double; `applies` is false where the record's kind does not use it,
//   bound(property, value, range)            for a double that may be unbounded (beyond +-1e299),
//   vector(property, value, range)           for a glm::dvec3; the range is that of each coordinate,
//   choice(property, value, names)           for an enumeration, with the names of its values in the file,
//   index(property, value)                   for a place in another list,
//   record(property, value)                  for a record within the record, which has a describe() too.
// A property "stickSlip.force" is the member "force" of the object "stickSlip". Values are const where the
// record is.
//
// The ranges are far wider than anything a hand can feel and far narrower than what arithmetic can bear: they
// catch wrong units and hostile files, not taste. README.md lists them.

#include <concepts>
#include <numbers>
#include <type_traits>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// m, of any coordinate of a mesh, a shape or a pose. Beyond, it is a mistake in the file's units, and
/// squares and products of it lose their meaning.
inline constexpr double kMaxCoordinate = 1e9;

/// From `least` to `most`, both included; the unit is empty for a plain number.
struct Range {
  double least, most;
  const char* unit;
};

inline constexpr Range kForceRange{0.0, 1e4, "N"};
inline constexpr Range kSignedForceRange{-1e4, 1e4, "N"};
inline constexpr Range kStiffnessRange{0.0, 1e6, "N/m"};
inline constexpr Range kDampingRange{0.0, 1e3, "N*s/m"};
inline constexpr Range kCoefficientRange{0.0, 1e3,
                                         ""};  // of friction: files write large ones for what never slides
inline constexpr Range kShareRange{0.0, 1.0, ""};
inline constexpr Range kAngleRange{0.0, 2.0 * std::numbers::pi, "rad"};
inline constexpr Range kFrequencyRange{0.0, 1e4, "Hz"};
inline constexpr Range kReliefRange{0.0, 1.0, "m"};
inline constexpr Range kWavelengthRange{1e-6, 1e3, "m"};
inline constexpr Range kReachRange{0.0, 1e3, "m"};
inline constexpr Range kTimeRange{0.0, 1e6, "s"};
inline constexpr Range kLengthRange{0.0, kMaxCoordinate, "m"};
inline constexpr Range kPlaceRange{-kMaxCoordinate, kMaxCoordinate, "m"};
// The same of what turns, about its axis.
inline constexpr Range kTorqueRange{0.0, 1e4, "N*m"};
inline constexpr Range kTurnStiffnessRange{0.0, 1e6, "N*m/rad"};
inline constexpr Range kTurnDampingRange{0.0, 1e3, "N*m*s/rad"};
inline constexpr Range kTurnRange{-1e3, 1e3, "rad"};
inline constexpr Range kTurnWidthRange{0.0, 1e3, "rad"};
// Beside a joint's first axis, where whole turns are not counted.
inline constexpr Range kHalfTurnRange{-std::numbers::pi, std::numbers::pi, "rad"};
inline constexpr Range kFieldRateRange{1e-6, kMaxFieldFrequency, "Hz"};
inline constexpr Range kSweepRange{1e-6, 1e6, "s"};
inline constexpr Range kPhaseRange{-1e3, 1e3, "rad"};
inline constexpr Range kStartRange{0.0, 1e9, "s"};
inline constexpr Range kStopRange{0.0, 1e300, "s"};  // 1e300: never
// An inertia that is tinier than any part's would turn a force into a speed that is not finite.
inline constexpr Range kMassRange{1e-30, 1e9, "kg"};
inline constexpr Range kInertiaRange{1e-30, 1e9, "kg*m^2"};

// The names of enumerations in a file, by their values; empty where a value has none.
inline constexpr const char* kPatternNames[] = {"", "", "sine", "grid", "bumps", "noise"};
inline constexpr const char* kLawNames[] = {"elastic", "viscoelastic", "plastic"};
inline constexpr const char* kWaveformNames[] = {"sine", "square", "chirp", "pulses"};
inline constexpr const char* kRegionNames[] = {"", "box", "sphere"};

/// Matches T and const T.
template <typename Record, typename T>
concept Is = std::same_as<std::remove_const_t<Record>, T>;

template <typename Visitor, Is<SurfaceTexture> Record>
void describe(Visitor& v, Record& t) {
  const bool procedural = t.pattern > SurfaceTexture::Pattern::image;
  v.choice("texture.function", t.pattern, kPatternNames);
  v.index("texture.image", t.image);
  v.number("texture.amplitude", t.amplitude, kReliefRange);
  v.number("textureAmplitude", t.amplitudeForce, kForceRange);
  v.number(t.amplitudeForce > 0.0 ? "textureWavelength" : "texture.wavelength", t.wavelength,
           procedural ? kWavelengthRange : kReachRange);
  v.number("texture.frictionScale", t.frictionScale, kCoefficientRange);
}

template <typename Visitor, Is<Surface> Record>
void describe(Visitor& v, Record& s) {
  v.number("creaseAngle", s.creaseAngle, kAngleRange);
  v.number("viscosity", s.viscosity, kDampingRange);
  v.record("texture", s.texture);
  v.number("vibration.frequency", s.vibrationFrequency, kFrequencyRange);
  v.number("vibration.amplitude", s.vibrationAmplitude, kForceRange);
  v.number("stickSlip.force", s.stickSlipForce, kForceRange);
  v.number("stickSlip.stiffness", s.stickSlipStiffness, kStiffnessRange);
  v.number("magnetic.force", s.magneticForce, kForceRange);
  v.number("magnetic.distance", s.magneticDistance, kReachRange);
  v.number("popThrough.force", s.popThroughForce, kForceRange);
  v.choice("law.type", s.law, kLawNames);
  const bool viscoelastic = s.law == Surface::Law::viscoelastic, plastic = s.law == Surface::Law::plastic;
  v.number("law.stiffness2", s.stiffness2, kStiffnessRange, viscoelastic);
  v.number("law.relaxation", s.relaxation, kTimeRange, viscoelastic);
  v.number("law.yield", s.yieldForce, kForceRange, plastic);
  v.number("law.hardening", s.hardening, kStiffnessRange, plastic);
}

/// What a material says about contact; its look is not described.
template <typename Visitor, Is<Material> Record>
void describe(Visitor& v, Record& m) {
  v.number("stiffness", m.stiffness, kStiffnessRange);
  v.number("damping", m.damping, kDampingRange);
  v.number("staticFriction", m.staticFriction, kCoefficientRange);
  v.number("dynamicFriction", m.dynamicFriction, kCoefficientRange);
  v.number("restitution", m.restitution, kShareRange);
}

template <typename Visitor, Is<FieldRegion> Record>
void describe(Visitor& v, Record& r) {
  v.choice("region.shape", r.kind, kRegionNames);
  v.vector("region.size", r.halfSize, kLengthRange);
  v.number("region.radius", r.radius, kLengthRange);
  v.number("region.fade", r.fade, kLengthRange);
}

template <typename Visitor, Is<FieldWaveform> Record>
void describe(Visitor& v, Record& w) {
  v.choice("waveform.shape", w.kind, kWaveformNames);
  v.number("waveform.frequency", w.frequency, kFieldRateRange);
  v.number("waveform.endFrequency", w.endFrequency, kFieldRateRange);
  v.number("waveform.sweep", w.sweep, kSweepRange);
  v.number("waveform.phase", w.phase, kPhaseRange);
  v.number(w.kind == FieldWaveform::Kind::square ? "waveform.edge" : "waveform.width", w.width, kTimeRange);
  v.number("waveform.start", w.start, kStartRange);
  v.number("waveform.stop", w.stop, kStopRange);
}

/// The numbers of a control; its frame, its detents' places and its lists are not described.
template <typename Visitor, Is<Control> Record>
void describe(Visitor& v, Record& c) {
  const bool dial = turns(c);
  const Range& place = dial ? kTurnRange : kPlaceRange;
  const Range& width = dial ? kTurnWidthRange : kLengthRange;
  const Range& force = dial ? kTorqueRange : kForceRange;
  v.number("min", c.min, place);
  v.number("max", c.max, place);
  v.number("value", c.initial, place);
  v.number("inertia", c.inertia, dial ? kInertiaRange : kMassRange);
  v.number("spring.stiffness", c.springStiffness, dial ? kTurnStiffnessRange : kStiffnessRange);
  v.number("spring.rest", c.springRest, place);
  v.number("damping", c.damping, dial ? kTurnDampingRange : kDampingRange);
  v.number("friction", c.friction, force);
  v.number("detents.force", c.detents.force, force);
  v.number("detents.width", c.detents.width, width);
  v.number("click.at", c.click.at, place);
  v.number("click.drop", c.click.drop, force);
  v.number("click.width", c.click.width, width);
  v.number("threshold", c.threshold, place);
}

/// The numbers of a limit; which axes it holds is not described.
template <typename Visitor, Is<JointLimit> Record>
void describe(Visitor& v, Record& l) {
  const Range& place = l.angular ? kTurnRange : kPlaceRange;
  v.bound("limits.min", l.min, place);
  v.bound("limits.max", l.max, place);
  v.number("limits.stiffness", l.stiffness, l.angular ? kTurnStiffnessRange : kStiffnessRange);
  v.number("limits.damping", l.damping, l.angular ? kTurnDampingRange : kDampingRange);
}

/// The sizes of a shape; its kind and its place are not described.
template <typename Visitor, Is<ImplicitShape> Record>
void describe(Visitor& v, Record& s) {
  const bool sphere = s.kind == ImplicitShape::Kind::sphere;
  v.vector("size", s.size, kLengthRange);
  v.number("height", s.height, kLengthRange);
  v.number(sphere ? "radius" : "radiusTop", s.radiusTop, kLengthRange);
  v.number(sphere ? "radius" : "radiusBottom", s.radiusBottom, kLengthRange);
}

}  // namespace tandem::assets
