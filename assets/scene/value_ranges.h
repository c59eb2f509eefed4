#pragma once

// Checks the numbers of a record against the ranges of describe.h, both for the loader and for scenes from a
// network.

#include <optional>
#include <string>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// Whether all coordinates are nearer to the origin than kMaxCoordinate (ranges.h); false for NaN.
bool nearOrigin(const glm::dvec3& p);

/// A number that lies outside of its range.
struct RangeFault {
  std::string property;  // as the glTF property, from the object that holds it: "stickSlip.force"
  std::string reason;    // "is 1e+308 N; it must lie between 0 and 10000 N"
};

/// The first number that is outside of its range or not a number; nothing if all are good.
std::optional<RangeFault> outOfRange(const Material& material);
std::optional<RangeFault> outOfRange(const Surface& surface);
std::optional<RangeFault> outOfRange(const ForceField& field);
std::optional<RangeFault> outOfRange(const Control& control);
std::optional<RangeFault> outOfRange(const Joint& joint);
/// Checks the scene's gravity, m/s^2, and the factor of it for a part.
std::optional<RangeFault> gravityFault(const glm::dvec3& gravity);
std::optional<RangeFault> gravityFactorFault(double factor);
/// Checks the stated contact tolerance of a part, m.
std::optional<RangeFault> toleranceFault(double tolerance);
/// Checks sizes and place of a primitive, m.
std::optional<RangeFault> outOfRange(const ImplicitShape& shape);

}  // namespace tandem::assets
