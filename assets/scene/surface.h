#pragma once

// Surface effects beyond stiffness, damping and friction, as `extras.haptic` of a glTF material states
// them.
//
// Every effect is off at zero. A material without any effect has no Surface and costs nothing in a tick.
// haptics/surface/README.md states what each number does to the force.

#include <compare>
#include <cstdint>
#include <vector>

namespace tandem::assets {

inline constexpr std::uint32_t kNoTexture = 0xffffffffu;

/// Relief on a surface, as a height above it.
struct SurfaceTexture {
  enum class Pattern : std::uint8_t {
    none,
    image,  // through the mesh's texture coordinates; black is -amplitude, white +amplitude
    sine,   // waves along the part's x
    grid,   // waves along x, y and z at once
    bumps,  // round bumps in a cubic lattice
    noise,  // smooth noise with features of a wavelength
  };
  Pattern pattern = Pattern::none;
  std::uint32_t image = kNoTexture;  // into Scene::textures
  double amplitude = 0.0;            // m, of the height about the surface
  double amplitudeForce = 0.0;       // N, the same as a change of the contact force; divided by the stiffness
  double wavelength = 0.0;           // m; procedural patterns only
  double frictionScale = 1.0;  // friction is multiplied by this where the height is greatest, 1 where least

  auto operator<=>(const SurfaceTexture&) const = default;
};

/// One kind of surface.
struct Surface {
  enum class Law : std::uint8_t { elastic, viscoelastic, plastic };

  double creaseAngle = 0.0;  // rad; edges below it feel smooth
  double viscosity = 0.0;    // N·s/m, against the velocity of the tool while it touches
  SurfaceTexture texture;
  double vibrationFrequency = 0.0;  // Hz
  double vibrationAmplitude = 0.0;  // N
  double stickSlipForce = 0.0;      // N at which the tool slips
  double stickSlipStiffness = 0.0;  // N/m
  double magneticForce = 0.0;       // N, the strongest pull
  double magneticDistance = 0.0;    // m, where the pull begins
  double popThroughForce = 0.0;     // N at which the surface lets go
  Law law = Law::elastic;
  double stiffness2 = 0.0;  // N/m, viscoelastic: the spring that relaxes
  double relaxation = 0.0;  // s, viscoelastic: its time constant
  double yieldForce = 0.0;  // N, plastic: where the permanent set begins
  double hardening = 0.0;   // N/m, plastic: growth of the yield force with the set

  auto operator<=>(const Surface&) const = default;
};

/// A grey image for relief and friction, rows from the top as glTF counts v.
struct TextureImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> texels;  // width * height, 0..255
};

inline constexpr std::uint32_t kMaxTextureSide = 4096;

}  // namespace tandem::assets
