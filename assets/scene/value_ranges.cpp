#include "assets/scene/value_ranges.h"

#include <cmath>
#include <cstdio>

#include "assets/scene/describe.h"

namespace tandem::assets {
namespace {

std::optional<RangeFault> outside(const char* property, double value, const Range& range) {
  if (value >= range.min && value <= range.max) return std::nullopt;
  const char* space = *range.unit == '\0' ? "" : " ";
  char reason[160];
  std::snprintf(reason, sizeof reason, "is %.6g%s%s; it must lie between %.6g and %.6g%s%s", value, space,
                range.unit, range.min, range.max, space, range.unit);
  return RangeFault{property, reason};
}

std::optional<RangeFault> outside(const char* property, const glm::dvec3& value, const Range& range) {
  for (int i = 0; i < 3; ++i)
    if (auto fault = outside(property, value[i], range)) return fault;
  return std::nullopt;
}

bool isUnbounded(double bound) { return std::abs(bound) >= 1e299; }

/// Finds the first number of a described record that is outside of its range.
struct FirstFault {
  std::optional<RangeFault> fault;

  void number(const char* property, double value, const Range& range, bool = true) {
    if (!fault) fault = outside(property, value, range);
  }
  void bound(const char* property, double value, const Range& range) {
    number(property, isUnbounded(value) ? 0.0 : value, range);
  }
  void vector(const char* property, const glm::dvec3& value, const Range& range) {
    if (!fault) fault = outside(property, value, range);
  }
  void numbers(const char* property, const auto& values, const Range& range) {
    for (const auto& value : values)
      if (!fault) fault = outside(property, value, range);
  }
  void record(const char*, const auto& value) { describe(*this, value); }
  void records(const char*, const auto& values) {
    for (const auto& value : values) describe(*this, value);
  }
  // scene_check.cpp and field_check.cpp check these together with what they refer to.
  void direction(const char*, const auto&) {}
  void choice(const char*, const auto&, const auto&) {}
  void flag(const char*, const auto&) {}
  void whole(const char*, const auto&) {}
  void wholes(const char*, const auto&) {}
};

template <typename Record>
std::optional<RangeFault> rangeFaultOf(const Record& record) {
  FirstFault first;
  describe(first, record);
  return first.fault;
}

}  // namespace

bool nearOrigin(const glm::dvec3& p) {
  return std::abs(p.x) < kMaxCoordinate && std::abs(p.y) < kMaxCoordinate && std::abs(p.z) < kMaxCoordinate;
}

std::optional<RangeFault> gravityFault(const glm::dvec3& gravity) {
  constexpr Range kGravity{-1e3, 1e3, "m/s^2"};
  return outside("gravity", gravity, kGravity);
}

std::optional<RangeFault> gravityFactorFault(double factor) {
  constexpr Range kFactor{-1e3, 1e3, ""};
  return outside("gravityFactor", factor, kFactor);
}

std::optional<RangeFault> toleranceFault(double tolerance) {
  constexpr Range kTolerance{1e-9, 1e3, "m"};
  return outside("tolerance", tolerance, kTolerance);
}

std::optional<RangeFault> outOfRange(const Material& m) { return rangeFaultOf(m); }

std::optional<RangeFault> outOfRange(const Surface& s) { return rangeFaultOf(s); }

std::optional<RangeFault> outOfRange(const ForceField& f) {
  if (auto fault = outside("position", f.partFromField.position, kPlaceRange)) return fault;
  return rangeFaultOf(f);
}

std::optional<RangeFault> outOfRange(const Control& c) {
  if (auto fault = outside("origin", c.worldFromAxis.position, kPlaceRange)) return fault;
  // The distance between two places can be larger than that of each from the origin.
  constexpr Range kOffset{-1e10, 1e10, "m"};
  if (auto fault = outside("origin", c.axisFromPart.position, kOffset)) return fault;
  return rangeFaultOf(c);
}

std::optional<RangeFault> outOfRange(const Joint& j) { return rangeFaultOf(j); }

std::optional<RangeFault> outOfRange(const ImplicitShape& s) {
  if (auto fault = outside("position", s.partFromShape.position, kPlaceRange)) return fault;
  return rangeFaultOf(s);
}

}  // namespace tandem::assets
