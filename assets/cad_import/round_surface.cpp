#include "assets/cad_import/round_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Geom_CylindricalSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <glm/geometric.hpp>

namespace tandem::cad_import {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::size_t kSamples = 17;  // around
constexpr double kExact = 1e-5;       // of the radius
constexpr double kLeastAngle = 1e-2;  // rad; what is flatter is a plane

glm::dvec3 vectorOf(const gp_XYZ& v) { return {v.X(), v.Y(), v.Z()}; }

}  // namespace

glm::dvec3 RoundSurface::point(double around, double along) const {
  return vectorOf((roundIsU_ ? surface_->Value(around, along) : surface_->Value(along, around)).XYZ());
}

bool RoundSurface::readExact() {
  const Handle(Geom_CylindricalSurface) cylinder = Handle(Geom_CylindricalSurface)::DownCast(surface_);
  if (cylinder.IsNull()) return false;
  const gp_Ax3 frame = cylinder->Position();
  origin_ = vectorOf(frame.Location().XYZ());
  zero_ = vectorOf(frame.XDirection().XYZ());
  axis_ = glm::cross(zero_, vectorOf(frame.YDirection().XYZ()));
  radius_ = cylinder->Radius();
  rise_ = frame.Direct() ? 1.0 : -1.0;
  outward_ = frame.Direct();
  return true;
}

/// The circle through three of the points, if all others lie on it.
bool RoundSurface::fitCircle(const std::vector<glm::dvec3>& points) {
  const glm::dvec3 a = points[0], ab = points[5] - a, ac = points[10] - a;
  const glm::dvec3 normal = glm::cross(ab, ac);
  const double size = glm::dot(normal, normal);
  if (!(size > 0.0)) return false;
  const glm::dvec3 toCentre =
      (glm::dot(ab, ab) * glm::cross(ac, normal) + glm::dot(ac, ac) * glm::cross(normal, ab)) / (2.0 * size);
  origin_ = a + toCentre;
  radius_ = glm::length(toCentre);
  zero_ = -toCentre / radius_;
  axis_ = normal / std::sqrt(size);
  if (!std::isfinite(radius_)) return false;
  return std::all_of(points.begin(), points.end(), [&](const glm::dvec3& p) {
    return std::abs(glm::length(p - origin_) - radius_) < kExact * radius_ &&
           std::abs(glm::dot(p - origin_, axis_)) < kExact * radius_;
  });
}

bool RoundSurface::readSamples(const ParameterBox& box, bool roundIsU) {
  roundIsU_ = roundIsU;
  const double from = roundIsU ? box.uFrom : box.vFrom, to = roundIsU ? box.uTo : box.vTo;
  const double low = roundIsU ? box.vFrom : box.uFrom, high = roundIsU ? box.vTo : box.uTo;
  std::vector<glm::dvec3> base;
  glm::dvec3 along(0.0);
  double off = 0.0;
  parameters_.clear();
  angles_.clear();
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double p = from + (to - from) * static_cast<double>(i) / static_cast<double>(kSamples - 1);
    const glm::dvec3 bottom = point(p, low), middle = point(p, 0.5 * (low + high)), top = point(p, high);
    if (i == 0) along = top - bottom;
    off = std::max({off, glm::length(top - bottom - along), glm::length(middle - 0.5 * (bottom + top))});
    base.push_back(bottom);
    parameters_.push_back(p);
  }
  if (!fitCircle(base) || off > kExact * radius_) return false;
  const double length = glm::length(along);
  if (glm::length(glm::cross(along, axis_)) > kExact * length) return false;
  for (const glm::dvec3& p : base) {
    const glm::dvec3 arm = p - origin_;
    double angle = std::atan2(glm::dot(arm, glm::cross(axis_, zero_)), glm::dot(arm, zero_));
    const double before = angles_.empty() ? 0.0 : angles_.back();
    angle += std::round((before - angle) / kTurn + 0.25) * kTurn;  // a quarter behind to three ahead
    if (!angles_.empty() && !(angle > before)) return false;
    angles_.push_back(angle);
  }
  rise_ = glm::dot(along, axis_) / (high - low);
  height_ = -rise_ * low;
  return angles_.back() > kLeastAngle && angles_.back() < kTurn * (1.0 + kExact);
}

std::optional<RoundSurface> RoundSurface::recognise(const Handle(Geom_Surface) & surface,
                                                    const ParameterBox& box) {
  RoundSurface round;
  round.surface_ = surface;
  if (const auto part = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface); !part.IsNull())
    round.surface_ = part->BasisSurface();
  if (round.readExact()) return round;
  if (!(box.uTo > box.uFrom && box.vTo > box.vFrom)) return std::nullopt;
  if (!round.readSamples(box, true) && !round.readSamples(box, false)) return std::nullopt;
  gp_Pnt at;
  gp_Vec du, dv;
  round.surface_->D1(0.5 * (box.uFrom + box.uTo), 0.5 * (box.vFrom + box.vTo), at, du, dv);
  const glm::dvec3 arm = vectorOf(at.XYZ()) - round.origin_;
  const glm::dvec3 radial = arm - glm::dot(arm, round.axis_) * round.axis_;
  round.outward_ = glm::dot(vectorOf(du.Crossed(dv).XYZ()), radial) > 0.0;
  return round;
}

double RoundSurface::angleAt(double parameter) const {
  if (angles_.empty()) return parameter;
  const auto above = std::upper_bound(parameters_.begin(), parameters_.end(), parameter);
  const auto i = std::clamp<std::ptrdiff_t>(above - parameters_.begin() - 1, 0,
                                            static_cast<std::ptrdiff_t>(kSamples) - 2);
  const auto at = static_cast<std::size_t>(i);
  const double middle = 0.5 * (angles_[at] + angles_[at + 1]);
  const glm::dvec3 arm = point(parameter, parameterAtHeight(0.0)) - origin_;
  const double angle = std::atan2(glm::dot(arm, glm::cross(axis_, zero_)), glm::dot(arm, zero_));
  return angle + std::round((middle - angle) / kTurn) * kTurn;
}

double RoundSurface::parameterAtAngle(double angle) const {
  if (angles_.empty()) return angle;
  const auto above = std::upper_bound(angles_.begin(), angles_.end(), angle);
  const auto i =
      std::clamp<std::ptrdiff_t>(above - angles_.begin() - 1, 0, static_cast<std::ptrdiff_t>(kSamples) - 2);
  double low = parameters_[static_cast<std::size_t>(i)], high = parameters_[static_cast<std::size_t>(i) + 1];
  for (int halving = 0; halving < 52; ++halving) {
    const double middle = 0.5 * (low + high);
    (angleAt(middle) < angle ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace tandem::cad_import
