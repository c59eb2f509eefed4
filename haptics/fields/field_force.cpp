#include "haptics/fields/field_force.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/constants.h"

namespace tandem::haptics {
namespace {

using assets::FieldRegion;
using assets::FieldWaveform;
using assets::ForceField;
using Kind = ForceField::Kind;

/// 0 below 0, 1 above 1, between them a cubic whose slope is continuous.
double smoothStep(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

double smoothStepSlope(double u) { return u > 0.0 && u < 1.0 ? 6.0 * u * (1.0 - u) : 0.0; }

glm::dvec3 shortened(const glm::dvec3& v, double limit, bool& cut) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0.0)) return v;
  // Divides by the largest component first, because the squares of a distant polynomial overflow.
  const double length = largest * glm::length(v / largest);
  if (length <= limit * (1.0 + 1e-12)) return v;  // a law within the limit may exceed it by rounding
  cut = true;
  return v / largest * (limit / (length / largest));
}

double power(double x, unsigned n) {
  double value = 1.0;
  for (unsigned i = 0; i < n; ++i) value *= x;
  return value;
}

bool isRadial(Kind kind) { return kind == Kind::spring || kind == Kind::guide || kind == Kind::gravity; }

bool isStored(const ForceField& field) {
  return isRadial(field.kind) || field.kind == Kind::potential ||
         (field.kind == Kind::constant && field.region.kind == FieldRegion::Kind::everywhere);
}

}  // namespace

double regionWeight(const FieldRegion& region, const glm::dvec3& x, glm::dvec3& gradient) {
  gradient = glm::dvec3(0.0);
  if (region.kind == FieldRegion::Kind::everywhere) return 1.0;
  ASSERT(region.fade > 0.0);
  if (region.kind == FieldRegion::Kind::sphere) {
    const double r = glm::length(x), u = (region.radius - r) / region.fade;
    if (r > 0.0) gradient = x * (-smoothStepSlope(u) / (region.fade * r));
    return smoothStep(u);
  }
  glm::dvec3 weight, slope;
  for (int i = 0; i < 3; ++i) {
    const double u = (region.halfSize[i] - std::abs(x[i])) / region.fade;
    weight[i] = smoothStep(u);
    slope[i] = (x[i] < 0.0 ? 1.0 : -1.0) * smoothStepSlope(u) / region.fade;
  }
  gradient = {slope.x * weight.y * weight.z, weight.x * slope.y * weight.z, weight.x * weight.y * slope.z};
  return weight.x * weight.y * weight.z;
}

double waveformValue(const FieldWaveform& w, double time) {
  if (!(time >= w.start && time < w.stop)) return 0.0;
  const double t = time - w.start;
  const double cycles = w.frequency * t + w.phase / (2.0 * kPi);
  const double cycle = cycles - std::floor(cycles);
  switch (w.kind) {
    case FieldWaveform::Kind::sine:
      return std::sin(2.0 * kPi * cycle);
    case FieldWaveform::Kind::square: {
      // Rises and falls over `width` about 0, 1/2 and 1 of a period.
      const double edge = std::min(w.width * w.frequency, 0.5);
      if (!(edge > 0.0)) return cycle < 0.5 ? 1.0 : -1.0;
      const double up =
          smoothStep((cycle + 0.5 * edge) / edge) + smoothStep((cycle - 1.0 + 0.5 * edge) / edge);
      return 2.0 * (up - smoothStep((cycle - 0.5 + 0.5 * edge) / edge)) - 1.0;
    }
    case FieldWaveform::Kind::chirp: {
      const double s = std::fmod(t, w.sweep);
      const double phase = w.frequency * s + 0.5 * (w.endFrequency - w.frequency) / w.sweep * s * s;
      return std::sin(2.0 * kPi * phase + w.phase);
    }
    case FieldWaveform::Kind::pulses: {
      const double since = cycle / w.frequency;
      return since < w.width ? 0.5 - 0.5 * std::cos(2.0 * kPi * since / w.width) : 0.0;
    }
  }
  return 0.0;
}

FieldForce::FieldForce(const ForceField& field) : field_(&field) {
  if (field.anchor == ForceField::Anchor::path && !field.points.empty())
    path_.emplace(field.points, field.smooth, field.closed);
  if (isRadial(field.kind) && field.range > 0.0) {
    const double begin = field.range - field.fade;
    atRange_ = radialPotentialWithoutRange(begin) + integral(begin, field.range);
  }
  if (!isStored(field) || field.region.kind == FieldRegion::Kind::everywhere) return;
  // The gauge is the highest potential found on the border. The interior is then a well, which holds the hand
  // at its rim rather than expelling it.
  gauge_ = -1e300;
  const glm::dvec3 reach =
      field.region.kind == FieldRegion::Kind::box ? field.region.halfSize : glm::dvec3(field.region.radius);
  for (int i = 0; i < 27; ++i) {
    const glm::dvec3 side(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (glm::length(side) == 0.0) continue;
    const bool round = field.region.kind == FieldRegion::Kind::sphere;
    FieldQuery query;
    query.position = (round ? glm::normalize(side) : side) * reach;
    gauge_ = std::max(gauge_, raw(query, path_ ? path_->nearest(query.position) : 0.0).potential);
  }
}

double FieldForce::rangeWeight(double distance) const {
  return field_->range > 0.0 ? smoothStep((field_->range - distance) / field_->fade) : 1.0;
}

/// Force towards the anchor or centre, N, before the fade at the range.
double FieldForce::radialForce(double d) const {
  const ForceField& f = *field_;
  if (f.kind != Kind::gravity) return std::min(f.stiffness * std::max(0.0, d - f.radius), f.maxForce);
  const double k = std::abs(f.strength);
  const double bare = d < f.radius ? k * d / (f.radius * f.radius * f.radius) : k / (d * d);
  return std::copysign(std::min(bare, f.maxForce), f.strength);
}

/// Integral of the force over the distance, J.
double FieldForce::radialPotentialWithoutRange(double d) const {
  const ForceField& f = *field_;
  if (f.kind != Kind::gravity) {
    const double in = std::max(0.0, d - f.radius);
    const double soft = f.stiffness > 0.0 ? std::min(in, f.maxForce / f.stiffness) : in;
    return 0.5 * f.stiffness * soft * soft + f.maxForce * (in - soft);
  }
  const double k = std::abs(f.strength), sign = f.strength < 0.0 ? -1.0 : 1.0;
  if (!(k > 0.0)) return 0.0;
  // The force is maxForce from `inner` to `outer`; without a cut both equal the radius.
  const auto [inner, outer] = kinks();
  const double slope = k / (f.radius * f.radius * f.radius);
  if (d >= outer) return -sign * k / d;
  double potential = -k / outer - f.maxForce * (outer - std::clamp(d, inner, outer));
  if (d < inner) potential -= 0.5 * slope * (inner * inner - d * d);
  return sign * potential;
}

/// Distance at which the law without range changes its form, m.
std::array<double, 2> FieldForce::kinks() const {
  const ForceField& f = *field_;
  if (f.kind != Kind::gravity)
    return {f.radius, f.radius + (f.stiffness > 0.0 ? f.maxForce / f.stiffness : 0.0)};
  const double k = std::abs(f.strength), surface = k / (f.radius * f.radius);
  if (!(surface > f.maxForce)) return {f.radius, f.radius};
  return {f.radius * f.maxForce / surface, std::sqrt(k / f.maxForce)};
}

/// Integral of the faded force, between kinks by three-point Gauss quadrature on eight pieces: exact for
/// springs, whose force times the fade has degree four.
double FieldForce::integral(double from, double to) const {
  const std::array<double, 2> kink = kinks();
  const double ends[] = {from, std::clamp(kink[0], from, to), std::clamp(kink[1], from, to), to};
  constexpr int kPieces = 8;
  double sum = 0.0;
  for (int part = 0; part < 3; ++part) {
    const double half = 0.5 * (ends[part + 1] - ends[part]) / kPieces, node = std::sqrt(0.6) * half;
    if (!(half > 0.0)) continue;
    const auto force = [&](double at) { return radialForce(at) * rangeWeight(at); };
    for (int i = 0; i < kPieces; ++i) {
      const double middle = ends[part] + half * (2 * i + 1);
      sum += half * (5.0 / 9.0 * (force(middle - node) + force(middle + node)) + 8.0 / 9.0 * force(middle));
    }
  }
  return sum;
}

/// Potential, zero at the range and beyond. Without a range that of a spring is zero at its anchor and that
/// of gravity at infinity.
double FieldForce::radialPotential(double d) const {
  if (!(field_->range > 0.0)) return radialPotentialWithoutRange(d);
  if (d >= field_->range) return 0.0;
  if (d > field_->range - field_->fade) return -integral(d, field_->range);
  return radialPotentialWithoutRange(d) - atRange_;
}

FieldAction FieldForce::springAction(const FieldQuery& query, double at) const {
  const ForceField& f = *field_;
  ASSERT(f.anchor != ForceField::Anchor::path || path_);
  glm::dvec3 away = query.position,
             damped = query.velocity;  // from the anchor; the velocity that damping sees
  double along = 0.0;
  switch (f.anchor) {
    case ForceField::Anchor::point:
      break;
    case ForceField::Anchor::line:
      away -= f.axis * glm::dot(f.axis, away);
      damped -= f.axis * glm::dot(f.axis, damped);
      break;
    case ForceField::Anchor::plane:
      along = glm::dot(f.axis, away);
      if (f.oneSided && along >= 0.0) return {};
      away = f.axis * along;
      damped = f.axis * glm::dot(f.axis, damped);
      break;
    case ForceField::Anchor::path: {
      const glm::dvec3 tangent = path_->tangent(at);
      away -= path_->point(at);
      damped -= tangent * glm::dot(tangent, damped);
      break;
    }
  }
  const double d = glm::length(away), weight = rangeWeight(d);
  FieldAction out;
  out.potential = radialPotential(d);
  if (d > 0.0) out.stored = away * (-radialForce(d) * weight / d);
  // Damping rises over the first tenth of the free play's radius, so that a wall has no step.
  const double in = f.radius > 0.0 ? std::clamp((d - f.radius) / (0.1 * f.radius), 0.0, 1.0) : 1.0;
  out.dampingRate = f.damping.x * in * weight;
  out.damping = -out.dampingRate * damped;
  if (f.drive != 0.0 && path_) {
    // The drive along an open path fades over the last tenth of its length, by the straight distance that is
    // left.
    const double ahead = path_->closed()
                             ? 1.0
                             : smoothStep(glm::distance(path_->point(at),
                                                        path_->point(f.drive > 0.0 ? path_->pieces() : 0.0)) /
                                          (0.1 * path_->length()));
    out.source = path_->tangent(at) * (f.drive * ahead * weight);
  }
  return out;
}

FieldAction FieldForce::gravityAction(const glm::dvec3& x) const {
  const double d = glm::length(x);
  FieldAction out;
  out.potential = radialPotential(d);
  if (d > 0.0) out.stored = x * (-radialForce(d) * rangeWeight(d) / d);
  return out;
}

FieldAction FieldForce::potentialAction(const glm::dvec3& x) const {
  const ForceField& f = *field_;
  FieldAction out;
  switch (f.potential) {
    case ForceField::Potential::gaussian: {
      const glm::dvec3 u = x / f.sigma;
      out.potential = -f.depth * std::exp(-0.5 * glm::dot(u, u));
      out.stored = u / f.sigma * out.potential;
      return out;
    }
    case ForceField::Potential::ripple: {
      const double wave = 2.0 * kPi / f.sigma.x, phase = wave * glm::dot(f.axis, x);
      out.potential = -f.depth * std::cos(phase);
      out.stored = f.axis * (-f.depth * wave * std::sin(phase));
      return out;
    }
    case ForceField::Potential::polynomial:
      for (const assets::PotentialTerm& term : f.terms) {
        glm::dvec3 value, slope;
        for (int i = 0; i < 3; ++i) {
          const unsigned n = term.powers[static_cast<std::size_t>(i)];
          value[i] = power(x[i], n);
          slope[i] = n > 0 ? n * power(x[i], n - 1) : 0.0;
        }
        out.potential += term.coefficient * value.x * value.y * value.z;
        out.stored -= term.coefficient * glm::dvec3(slope.x * value.y * value.z, value.x * slope.y * value.z,
                                                    value.x * value.y * slope.z);
      }
      return out;
  }
  return out;
}

/// The action without the region.
FieldAction FieldForce::raw(const FieldQuery& query, double at) const {
  const ForceField& f = *field_;
  FieldAction out;
  switch (f.kind) {
    case Kind::constant:
      (isStored(f) ? out.stored : out.source) = f.force;
      if (isStored(f)) out.potential = -glm::dot(f.force, query.position);
      return out;
    case Kind::spring:
    case Kind::guide:
      return springAction(query, at);
    case Kind::damper:
    case Kind::viscosity:
      out.damping = -f.damping * query.velocity;
      out.dampingRate = std::max({f.damping.x, f.damping.y, f.damping.z});
      return out;
    case Kind::waveform:
      out.source = f.force * waveformValue(f.waveform, query.time);
      out.sourceChange = out.source - f.force * waveformValue(f.waveform, query.timeBefore);
      return out;
    case Kind::gravity:
      return gravityAction(query.position);
    case Kind::potential:
      return potentialAction(query.position);
  }
  return out;
}

FieldAction FieldForce::act(const FieldQuery& query, double at) const {
  glm::dvec3 gradient;
  const double weight = regionWeight(field_->region, query.position, gradient);
  if (weight == 0.0) return {};
  FieldAction out = raw(query, at);
  if (field_->region.kind != FieldRegion::Kind::everywhere) {
    // The region fades the potential rather than the force, so the field stays a gradient.
    out.potential -= gauge_;
    out.stored = weight * out.stored - out.potential * gradient;
    out.potential *= weight;
    out.source *= weight;
    out.sourceChange *= weight;
    out.damping *= weight;
    out.dampingRate *= weight;
  }
  bool cut = false;  // of forces without a potential, which loses no exactness
  out.stored = shortened(out.stored, field_->maxForce, out.limited);
  out.source = shortened(out.source, field_->maxForce, cut);
  out.sourceChange = shortened(out.sourceChange, 2.0 * field_->maxForce, cut);
  out.damping = shortened(out.damping, field_->maxForce, cut);
  return out;
}

}  // namespace tandem::haptics
