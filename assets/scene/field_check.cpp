#include "assets/scene/field_check.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

constexpr double kLeast = 1e-9;  // m: what a length that divides may be; far below any scene's

/// What is wrong beyond the ranges of single numbers, or null.
const char* faultOf(const FieldRegion& r) {
  if (r.kind > FieldRegion::Kind::sphere) return "a region of unknown shape";
  if (r.kind != FieldRegion::Kind::everywhere && !(r.fade >= kLeast)) return "a region's fade is too short";
  return nullptr;
}

const char* faultOf(const FieldWaveform& w) {
  if (w.kind > FieldWaveform::Kind::pulses) return "a waveform of unknown shape";
  if (!(w.stop > w.start)) return "a waveform stops before it starts";
  return nullptr;
}

const char* faultOfPath(const ForceField& f) {
  if (f.anchor != ForceField::Anchor::path) return f.points.empty() ? nullptr : "points without a path";
  if (f.points.size() < (f.closed ? 3u : 2u) || f.points.size() > kMaxPathPoints)
    return "a path has too few or too many points";
  for (std::size_t i = 0; i < f.points.size(); ++i) {
    const std::size_t next = i + 1 < f.points.size() ? i + 1 : 0;
    if ((next > 0 || f.closed) && f.points[i] == f.points[next]) return "two points of a path are the same";
  }
  return nullptr;
}

const char* faultOfPotential(const ForceField& f) {
  using Potential = ForceField::Potential;
  if (f.potential > Potential::polynomial) return "an unknown potential";
  if (f.kind != ForceField::Kind::potential) return nullptr;
  if (f.potential == Potential::gaussian && !(std::min({f.sigma.x, f.sigma.y, f.sigma.z}) >= kLeast))
    return "a width is too small";
  if (f.potential == Potential::ripple && !(f.sigma.x >= kLeast)) return "a wavelength is too small";
  return nullptr;
}

const char* faultOf(const ForceField& f, std::size_t parts) {
  if (f.kind > ForceField::Kind::potential || f.anchor > ForceField::Anchor::path) return "an unknown kind";
  if (f.part != kNoPart && f.part >= parts) return "a part is out of range";
  if (!isValid(f.partFromField)) return "the frame is not rigid";
  if (!(f.maxForce > 0.0)) return "maxForce is not positive";
  if (!(std::abs(glm::length(f.axis) - 1.0) < 1e-6)) return "the axis is not a unit vector";
  if (f.range > 0.0 && !(f.fade >= kLeast && f.fade <= f.range * (1.0 + 1e-9)))
    return "the fade does not fit the range";
  if (f.kind == ForceField::Kind::gravity && !(f.radius >= kLeast)) return "the radius is too small";
  if (f.kind == ForceField::Kind::guide && f.anchor != ForceField::Anchor::path)
    return "a guide without a path";
  if (f.terms.size() > kMaxPotentialTerms) return "too many terms";
  for (const PotentialTerm& term : f.terms) {
    if (std::max({term.powers[0], term.powers[1], term.powers[2]}) > kMaxPotentialPower)
      return "a power is too high";
  }
  if (const char* fault = faultOf(f.region)) return fault;
  if (const char* fault = faultOf(f.waveform)) return fault;
  if (const char* fault = faultOfPath(f)) return fault;
  return faultOfPotential(f);
}

}  // namespace

Status checkField(const ForceField& field, std::size_t parts, const std::string& place) {
  const bool printable =
      field.name.size() <= 4096 &&
      std::none_of(field.name.begin(), field.name.end(), [](unsigned char c) { return c < 32 || c == 127; });
  if (!printable) return Error{place + ": the name is not printable"};
  if (const auto fault = outOfRange(field))
    return Error{place + "." + fault->property + ": " + fault->reason};
  if (const char* fault = faultOf(field, parts)) return Error{place + ": " + fault};
  return {};
}

}  // namespace tandem::assets
