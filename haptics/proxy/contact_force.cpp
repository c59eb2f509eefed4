#include "haptics/proxy/contact_force.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/base/six_axes.h"

namespace tandem::haptics {
namespace {

// Between two nearly coplanar faces of different stiffness the potential changes within a sliver of a normal
// cone, where the force across is k d / angle. That force is capped at this multiple of the stiffest spring's
// force.
constexpr double kSteepest = 4.0;

double determinant(const std::array<glm::dvec3, 3>& c) { return glm::dot(c[0], glm::cross(c[1], c[2])); }

/// The vector F in the span of `count` unit normals with normal[i] . F = wanted[i]; zero if the normals are
/// dependent.
glm::dvec3 spanned(const std::array<glm::dvec3, 3>& n, const std::array<double, 3>& wanted, int count) {
  if (count == 1) return wanted[0] * n[0];
  if (count == 2) {
    const double c = glm::dot(n[0], n[1]), square = 1.0 - c * c;
    if (!(square > 0.0)) return glm::dvec3(0.0);
    return ((wanted[0] - c * wanted[1]) * n[0] + (wanted[1] - c * wanted[0]) * n[1]) / square;
  }
  const double volume = determinant(n);
  if (volume == 0.0) return glm::dvec3(0.0);
  return (wanted[0] * glm::cross(n[1], n[2]) + wanted[1] * glm::cross(n[2], n[0]) +
          wanted[2] * glm::cross(n[0], n[1])) /
         volume;
}

/// Components of a vector along unit normals that span it.
std::array<double, 3> shares(const std::array<glm::dvec3, 3>& n, const glm::dvec3& v, int count) {
  if (count == 1) return {glm::dot(n[0], v), 0.0, 0.0};
  if (count == 2) {
    const double c = glm::dot(n[0], n[1]), square = 1.0 - c * c;
    if (!(square > 0.0)) return {};
    const double a = glm::dot(n[0], v), b = glm::dot(n[1], v);
    return {(a - c * b) / square, (b - c * a) / square, 0.0};
  }
  const double volume = determinant(n);
  if (volume == 0.0) return {};
  return {glm::dot(v, glm::cross(n[1], n[2])) / volume, glm::dot(v, glm::cross(n[2], n[0])) / volume,
          glm::dot(v, glm::cross(n[0], n[1])) / volume};
}

}  // namespace

NormalForces normalForces(const std::array<glm::dvec3, 3>& normals, const std::array<double, 3>& depths,
                          const std::array<double, 3>& stiffnesses, int count) {
  ASSERT(count >= 0 && count <= 3);
  glm::dvec3 lag(0.0);
  double squares = 0.0, weighted = 0.0, stiffest = 0.0, softest = stiffnesses[0];
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const double square = depths[i] * depths[i];
    lag += depths[i] * normals[i];
    squares += square;
    weighted += stiffnesses[i] * square;
    stiffest = std::max(stiffest, stiffnesses[i]);
    softest = std::min(softest, stiffnesses[i]);
  }
  NormalForces result;
  if (!(squares > 0.0)) return result;
  const double mean = softest == stiffest ? stiffest : weighted / squares;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) result.along[i] = mean * depths[i];
  if (softest == stiffest) return result;

  // dU/dlambda_i = mean (N^T N lambda)_i + lambda_i (k_i - mean) |N lambda|^2 / sum lambda^2; result.along
  // already holds the first term.
  std::array<double, 3> wanted{};
  const double share = glm::dot(lag, lag) / squares;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    wanted[i] = depths[i] * (stiffnesses[i] - mean) * share;
  }
  const glm::dvec3 across =
      shortened(spanned(normals, wanted, count), kSteepest * stiffest * glm::length(lag));
  const std::array<double, 3> more = shares(normals, across, count);
  for (std::size_t i = 0; i < 3; ++i) result.along[i] += more[i];
  return result;
}

glm::dvec3 contactForce(const ContactWorld& world, const Proxy& proxy, const DeviceSample& device,
                        const TickParameters& parameters, TickOutput& out) {
  std::array<glm::dvec3, 3> normals{};
  std::array<double, 3> depths{}, stiffnesses{}, dampings{};
  std::array<const SurfacePoint*, 3> surfaces{};
  int count = 0;
  for (const ProxyPlane& plane : proxy.planes) {
    if (count == kMaxContacts) break;
    if (!isFelt(plane)) continue;
    const assets::Material& material = world.material(plane.surface.part, plane.surface.triangle);
    const auto at = static_cast<std::size_t>(count++);
    surfaces[at] = &plane.surface;
    normals[at] = plane.surface.normal;
    depths[at] = plane.depth;
    stiffnesses[at] =
        limitedStiffness(material.stiffness > 0.0 ? material.stiffness : parameters.stiffness, parameters);
    dampings[at] = contactDamping(material, parameters);
  }
  if (count == 0) return glm::dvec3(0.0);

  ASSERT(count <= kMaxContacts);
  ASSERT(out.contactCount >= 0 && out.contactCount + count <= kMaxContacts);
  const NormalForces springs = normalForces(normals, depths, stiffnesses, count);
  glm::dvec3 force(0.0);
  glm::dvec3 rest = proxy.position - device.worldFromDevice.position;
  for (const ProxyPlane& plane : proxy.planes) {
    if (presses(plane)) rest -= plane.multiplier * plane.surface.normal;
  }
  double depthSum = 0.0, springSum = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const SurfacePoint& surface = *surfaces[i];
    const glm::dvec3 surfaceVelocity =
        velocityAt(world.pose(surface.part), world.twist(surface.part), surface.point);
    const double leaving = glm::dot(device.twist.linear - surfaceVelocity, surface.normal);
    const double spring = springs.along[i];
    // Damping alone must not pull, but a component of the gradient may point inwards.
    const double along = std::max(std::min(0.0, spring), spring - dampings[i] * leaving);
    force += along * surface.normal;
    depthSum += depths[i];
    springSum += spring;
    out.contacts[static_cast<std::size_t>(out.contactCount++)] = {surface.part, surface.point, surface.normal,
                                                                  along};
  }
  // The remainder is the lag held by friction. Its reach is mu times the depths, so this stiffness makes the
  // friction force mu times the normal forces.
  return force + rest * std::max(0.0, springSum / depthSum);
}

}  // namespace tandem::haptics
