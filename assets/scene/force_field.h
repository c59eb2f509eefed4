#pragma once

// A force that a scene exerts on a hand without any contact: springs, guides, drag, gravity, vibration. Plain
// data in SI units; haptics/fields/force_fields.h gives it its force and haptics/README.md its equations.
//
// 1. All geometry stands in the field's own frame, which moves with `part` if that part moves.
// 2. Nothing depends on acceleration: the second difference of a position quantised at 0.055 mm and read at
//    1 kHz is worth 55 m/s^2 of noise, so that inertia cannot be felt this way. The loader refuses it.
// 3. No field exceeds its own maxForce, and every number is finite.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/base/ids.h"
#include "assets/base/pose.h"

namespace tandem::assets {

inline constexpr std::size_t kMaxForceFields = 64;
inline constexpr std::size_t kMaxPathPoints = 256;
inline constexpr std::size_t kMaxPotentialTerms = 32;
inline constexpr int kMaxPotentialPower = 4;         // of one coordinate
inline constexpr double kMaxFieldFrequency = 500.0;  // Hz: half of the rate of the haptic loop

/// The region in which a field acts. Its weight falls to zero at the border over `fade`, with a continuous
/// first derivative.
struct FieldRegion {
  enum class Kind : std::uint8_t { everywhere, box, sphere };
  Kind kind = Kind::everywhere;
  glm::dvec3 halfSize{0.0, 0.0, 0.0};  // m, of the box about the field's origin
  double radius = 0.0;                 // m, of the sphere about it
  double fade = 0.0;                   // m, > 0 unless everywhere
};

/// A function of time with values in -1..1, times the force that goes with it.
struct FieldWaveform {
  enum class Kind : std::uint8_t { sine, square, chirp, pulses };
  Kind kind = Kind::sine;
  double frequency = 1.0;     // Hz; chirp: at its start
  double endFrequency = 1.0;  // Hz; chirp: at the end of each sweep
  double sweep = 1.0;         // s; chirp: of one sweep, which then begins anew
  double phase = 0.0;         // rad
  double width = 0.0;         // s; pulses: of one pulse; square: of each edge
  double start = 0.0;         // s of the session's clock
  double stop = 1e300;        // s
};

/// coefficient * x^i y^j z^k, J with lengths in m.
struct PotentialTerm {
  double coefficient = 0.0;
  std::array<std::uint8_t, 3> powers{};
};

struct ForceField {
  enum class Kind : std::uint8_t {
    constant,   // force
    spring,     // stiffness towards the anchor, beyond `radius` of it; damping
    guide,      // a spring to a path, with `drive` along it
    damper,     // -damping * velocity, each axis of the frame its own
    viscosity,  // the same, within a region
    waveform,   // force * waveform(t)
    gravity,    // strength / d^2 towards the origin, linear inside `radius`
    potential,  // minus the gradient of a potential
  };
  enum class Anchor : std::uint8_t { point, line, plane, path };
  enum class Potential : std::uint8_t { gaussian, ripple, polynomial };

  std::string name;
  Kind kind = Kind::constant;
  PartId part = kNoPart;  // the movable part that it goes with; kNoPart: it stands in the world
  Pose partFromField;     // worldFromField where there is no part
  double maxForce = 3.0;  // N
  FieldRegion region;

  glm::dvec3 force{0.0, 0.0, 0.0};  // N; of constant and waveform
  FieldWaveform waveform;

  Anchor anchor = Anchor::point;       // spring, guide
  glm::dvec3 axis{0.0, 1.0, 0.0};      // unit; line: along it, plane: its normal, ripple: across the waves
  bool oneSided = false;               // plane: acts below it only
  std::vector<glm::dvec3> points;      // m; path
  bool closed = false, smooth = true;  // path; smooth: Catmull-Rom, else straight lines
  double stiffness = 0.0;              // N/m
  double radius = 0.0;                 // m; spring, guide: free play; gravity: of the body
  double range = 0.0;                  // m from anchor or centre, beyond which there is no force; 0 = none
  double fade = 0.0;                   // m, over which the force falls to zero before `range`
  double drive = 0.0;                  // N along the path; guide
  glm::dvec3 damping{0.0, 0.0, 0.0};   // N·s/m; springs use x alone

  double strength = 0.0;  // N·m^2; gravity; negative repels

  Potential potential = Potential::gaussian;
  double depth = 0.0;                // J; gaussian: of the well, negative for a hill; ripple: amplitude
  glm::dvec3 sigma{0.0, 0.0, 0.0};   // m; gaussian: widths along the axes; ripple: wavelength in x
  std::vector<PotentialTerm> terms;  // polynomial
};

/// The effect of a field on the energy of the hand.
enum class Passivity : std::uint8_t {
  conservative,  // no net work around a closed loop
  dissipative,   // takes energy from the hand, apart from what it stores
  source,        // can do unlimited work on the hand
};

Passivity passivity(const ForceField& field);
/// The largest gradient of a field's force, N/m, of springs, gravity and wells without regard to borders and
/// fades; 0 for other laws.
double steepest(const ForceField& field);
const char* nameOf(ForceField::Kind kind);
const char* nameOf(Passivity passivity);

}  // namespace tandem::assets
