#include "assets/scene/force_field.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "assets/base/assert.h"
#include "assets/scene/describe.h"

namespace tandem::assets {

Passivity passivity(const ForceField& field) {
  using Kind = ForceField::Kind;
  const bool everywhere = field.region.kind == FieldRegion::Kind::everywhere;
  switch (field.kind) {
    case Kind::constant:
      // A wind within a border: going in against it and out beside it costs nothing, so a loop can gain.
      return everywhere ? Passivity::conservative : Passivity::source;
    case Kind::spring:
    case Kind::guide:
      if (field.drive != 0.0) return Passivity::source;
      // A path that is followed from where the hand was may hold two energies at one place; changing over
      // to the nearer branch loses the difference.
      return field.damping.x > 0.0 || field.anchor == ForceField::Anchor::path ? Passivity::dissipative
                                                                               : Passivity::conservative;
    case Kind::damper:
    case Kind::viscosity:
      return Passivity::dissipative;
    case Kind::waveform:
      return Passivity::source;
    case Kind::gravity:
    case Kind::potential:
      return Passivity::conservative;
  }
  return Passivity::source;
}

double steepest(const ForceField& field) {
  constexpr double kPi = std::numbers::pi;
  switch (field.kind) {
    case ForceField::Kind::spring:
    case ForceField::Kind::guide:
      return field.stiffness;
    case ForceField::Kind::gravity:
      // 2 k / R^3 just outside, unless the force is cut there.
      return 2.0 * std::abs(field.strength) / (field.radius * field.radius * field.radius);
    case ForceField::Kind::potential:
      if (field.potential == ForceField::Potential::gaussian) {
        const double least = std::min({field.sigma.x, field.sigma.y, field.sigma.z});
        return std::abs(field.depth) / (least * least);
      }
      if (field.potential == ForceField::Potential::ripple)
        return std::abs(field.depth) * std::pow(2.0 * kPi / field.sigma.x, 2.0);
      return 0.0;
    default:
      return 0.0;
  }
}

const char* nameOf(ForceField::Kind kind) {
  const auto index = static_cast<std::size_t>(kind);
  ASSERT(index < std::size(kFieldNames));
  return kFieldNames[index];
}

const char* nameOf(Passivity passivity) {
  constexpr const char* kNames[] = {"conservative", "dissipative", "source"};
  return kNames[static_cast<std::size_t>(passivity)];
}

}  // namespace tandem::assets
