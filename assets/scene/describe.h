#pragma once

// The members of a scene's records, each written down once: its property in the file, its range and its unit.
// The codec, the check of ranges, the loader and the writer of sample scenes visit a record by its
// describe(), so that a new member is one line here beside the member itself, whose initialiser is its
// default.
//
// describe(visitor, record) calls, in the order in which the codec writes the members,
//   number(property, value, range, applies)  for a double; `applies`: whether the record uses it,
//   bound(property, value, range)            for a double that may be unbounded (beyond +-1e299),
//   vector(property, value, range)           for a glm::dvec3; the range is that of each coordinate,
//   direction(property, value), flag(..)     for a glm::dvec3 of length 1; for a bool,
//   numbers(property, values, range)         for a list of double or of glm::dvec3,
//   choice(property, value, names)           for an enumeration, with the names of its values in the file,
//   whole(property, value), wholes(..)       for bits, powers and indices, which scene_check.cpp checks,
//   record(property, value), records(..)     for records within the record, which have a describe() too.
// A property "stickSlip.force" is the member "force" of the object "stickSlip".

#include <concepts>
#include <type_traits>

#include "assets/scene/ranges.h"
#include "assets/scene/scene.h"

namespace tandem::assets {

/// Matches T and const T.
template <typename Record, typename T>
concept Is = std::same_as<std::remove_const_t<Record>, T>;

template <typename Visitor, Is<SurfaceTexture> Record>
void describe(Visitor& v, Record& t) {
  const bool procedural = t.pattern > SurfaceTexture::Pattern::image;
  v.choice("texture.function", t.pattern, kPatternNames);
  v.whole("texture.image", t.image);
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

/// The contact properties of a material; its name and its colours are not described.
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

/// What the coefficient of a term multiplies is checked with the field (field_check.cpp).
template <typename Visitor, Is<PotentialTerm> Record>
void describe(Visitor& v, Record& t) {
  v.number("terms.coefficient", t.coefficient, kTermRange);
  v.whole("terms.powers", t.powers);
}

/// A field without its name, its kind, its part and its frame.
template <typename Visitor, Is<ForceField> Record>
void describe(Visitor& v, Record& f) {
  v.number("maxForce", f.maxForce, kForceRange);
  v.record("region", f.region);
  v.vector("force", f.force, kSignedForceRange);
  v.record("waveform", f.waveform);
  v.choice("to", f.anchor, kAnchorNames);
  v.direction("axis", f.axis);
  v.flag("oneSided", f.oneSided);
  v.numbers("points", f.points, kPlaceRange);
  v.flag("closed", f.closed);
  v.flag("curve", f.smooth);
  v.number("stiffness", f.stiffness, kStiffnessRange);
  v.number("radius", f.radius, kLengthRange);
  v.number("range", f.range, kLengthRange);
  v.number("fade", f.fade, kLengthRange);
  v.number("drive", f.drive, kSignedForceRange);
  v.vector("damping", f.damping, kDampingRange);
  v.number("strength", f.strength, kStrengthRange);
  v.choice("function", f.potential, kPotentialNames);
  v.number("depth", f.depth, kEnergyRange);
  v.vector(f.potential == ForceField::Potential::ripple ? "wavelength" : "sigma", f.sigma, kLengthRange);
  v.records("terms", f.terms);
}

/// A control without its name, its part, its kind and its frames.
template <typename Visitor, Is<Control> Record>
void describe(Visitor& v, Record& c) {
  const bool dial = turns(c);
  const Range& place = dial ? kTurnRange : kPlaceRange;
  const Range& width = dial ? kTurnWidthRange : kLengthRange;
  const Range& force = dial ? kTorqueRange : kForceRange;
  v.flag("endless", c.endless);
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
  v.numbers("detents.positions", c.detents.places, place);
  v.whole("roles", c.roles);
  v.wholes("shows", c.shows);
}

template <typename Visitor, Is<JointLimit> Record>
void describe(Visitor& v, Record& l) {
  v.flag("limits.angularAxes", l.angular);
  v.whole("limits.axes", l.axes);
  const Range& place = l.angular ? kTurnRange : kPlaceRange;
  v.bound("limits.min", l.min, place);
  v.bound("limits.max", l.max, place);
  v.number("limits.stiffness", l.stiffness, l.angular ? kTurnStiffnessRange : kStiffnessRange);
  v.number("limits.damping", l.damping, l.angular ? kTurnDampingRange : kDampingRange);
}

template <typename Visitor, Is<JointDrive> Record>
void describe(Visitor& v, Record& d) {
  v.flag("drives.type", d.angular);
  v.flag("drives.mode", d.acceleration);
  v.whole("drives.axis", d.axis);
  const Range& place = !d.angular ? kPlaceRange : d.axis == 0 ? kTurnRange : kHalfTurnRange;
  v.bound("drives.maxForce", d.maxForce, kForceRange);
  v.number("drives.positionTarget", d.positionTarget, place);
  v.number("drives.velocityTarget", d.velocityTarget, d.angular ? kTurnRateRange : kSpeedRange);
  v.number("drives.stiffness", d.stiffness, d.angular ? kTurnStiffnessRange : kStiffnessRange);
  v.number("drives.damping", d.damping, d.angular ? kTurnDampingRange : kDampingRange);
}

/// A joint without its name, its parts and its frames.
template <typename Visitor, Is<Joint> Record>
void describe(Visitor& v, Record& j) {
  v.records("limits", j.limits);
  v.records("drives", j.drives);
  v.number("pitch", j.pitch, kPlaceRange);
  v.numbers("detents.positions", j.detents.places, j.detentsTurn ? kTurnRange : kPlaceRange);
  v.number("detents.force", j.detents.force, j.detentsTurn ? kTorqueRange : kForceRange);
  v.number("detents.width", j.detents.width, j.detentsTurn ? kTurnWidthRange : kLengthRange);
  v.flag("detents.type", j.detentsTurn);
  v.flag("enableCollision", j.collide);
}

/// A shape without its kind and its place.
template <typename Visitor, Is<ImplicitShape> Record>
void describe(Visitor& v, Record& s) {
  const bool sphere = s.kind == ImplicitShape::Kind::sphere;
  v.vector("size", s.size, kLengthRange);
  v.number("height", s.height, kLengthRange);
  v.number(sphere ? "radius" : "radiusTop", s.radiusTop, kLengthRange);
  v.number(sphere ? "radius" : "radiusBottom", s.radiusBottom, kLengthRange);
}

}  // namespace tandem::assets
