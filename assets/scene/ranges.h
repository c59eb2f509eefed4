#pragma once

// The ranges of a scene's numbers and the names of its enumerations, for describe.h.
//
// The ranges are far wider than anything a hand can feel and far narrower than what arithmetic can bear. They
// catch wrong units and hostile files. README.md lists them.

#include <numbers>

#include "assets/scene/force_field.h"

namespace tandem::assets {

/// m, of any coordinate of a mesh, a shape or a pose. A larger one is a mistake in the file's units, and its
/// squares and products lose their meaning.
inline constexpr double kMaxCoordinate = 1e9;

/// From `min` to `max`, both included; the unit is empty for a plain number.
struct Range {
  double min, max;
  const char* unit;
};

inline constexpr Range kForceRange{0.0, 1e4, "N"};
inline constexpr Range kSignedForceRange{-1e4, 1e4, "N"};
inline constexpr Range kStiffnessRange{0.0, 1e6, "N/m"};
inline constexpr Range kDampingRange{0.0, 1e3, "N*s/m"};
// Of friction: files write large coefficients for what never slides.
inline constexpr Range kCoefficientRange{0.0, 1e3, ""};
inline constexpr Range kShareRange{0.0, 1.0, ""};
inline constexpr Range kAngleRange{0.0, 2.0 * std::numbers::pi, "rad"};
inline constexpr Range kFrequencyRange{0.0, 1e4, "Hz"};
inline constexpr Range kReliefRange{0.0, 1.0, "m"};
inline constexpr Range kWavelengthRange{1e-6, 1e3, "m"};
inline constexpr Range kReachRange{0.0, 1e3, "m"};
inline constexpr Range kTimeRange{0.0, 1e6, "s"};
inline constexpr Range kLengthRange{0.0, kMaxCoordinate, "m"};
inline constexpr Range kPlaceRange{-kMaxCoordinate, kMaxCoordinate, "m"};
// The same quantities of a rotation about an axis.
inline constexpr Range kTorqueRange{0.0, 1e4, "N*m"};
inline constexpr Range kTurnStiffnessRange{0.0, 1e6, "N*m/rad"};
inline constexpr Range kTurnDampingRange{0.0, 1e3, "N*m*s/rad"};
inline constexpr Range kTurnRange{-1e3, 1e3, "rad"};
inline constexpr Range kTurnWidthRange{0.0, 1e3, "rad"};
// About the second and third axis of a joint, where whole turns are not counted.
inline constexpr Range kHalfTurnRange{-std::numbers::pi, std::numbers::pi, "rad"};
inline constexpr Range kFieldRateRange{1e-6, kMaxFieldFrequency, "Hz"};
inline constexpr Range kSweepRange{1e-6, 1e6, "s"};
inline constexpr Range kPhaseRange{-1e3, 1e3, "rad"};
inline constexpr Range kStartRange{0.0, 1e9, "s"};
inline constexpr Range kStopRange{0.0, 1e300, "s"};  // 1e300: never
inline constexpr Range kStrengthRange{-1e12, 1e12, "N*m^2"};
inline constexpr Range kEnergyRange{-1e6, 1e6, "J"};
inline constexpr Range kTermRange{-1e12, 1e12, "J/m^n"};
inline constexpr Range kSpeedRange{-1e6, 1e6, "m/s"};
inline constexpr Range kTurnRateRange{-1e6, 1e6, "rad/s"};
// A smaller inertia than these would turn a force into a speed that is not finite.
inline constexpr Range kMassRange{1e-30, 1e9, "kg"};
inline constexpr Range kInertiaRange{1e-30, 1e9, "kg*m^2"};

// The names of enumerations in a file, by their values; empty where a value has none.
inline constexpr const char* kPatternNames[] = {"", "", "sine", "grid", "bumps", "noise"};
inline constexpr const char* kLawNames[] = {"elastic", "viscoelastic", "plastic"};
inline constexpr const char* kWaveformNames[] = {"sine", "square", "chirp", "pulses"};
inline constexpr const char* kFieldNames[] = {"constant",  "spring",   "guide",   "damper",
                                              "viscosity", "waveform", "gravity", "potential"};
inline constexpr const char* kRegionNames[] = {"", "box", "sphere"};
inline constexpr const char* kAnchorNames[] = {"point", "line", "plane", "path"};
inline constexpr const char* kPotentialNames[] = {"gaussian", "ripple", "polynomial"};
inline constexpr const char* kControlNames[] = {"button", "dial", "slider", "drawer", "layer"};

}  // namespace tandem::assets
