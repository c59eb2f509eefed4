#include "haptics/link/replica_mass.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

namespace tandem::haptics {
namespace {

/// The smallest eigenvalue of a symmetric matrix by the trigonometric formula (Smith 1961).
double leastEigenvalue(const glm::dmat3& a) {
  const double mean = (a[0][0] + a[1][1] + a[2][2]) / 3.0;
  const glm::dmat3 rest = a - glm::dmat3(mean);
  double square = 0.0;
  for (int c = 0; c < 3; ++c) square += glm::dot(rest[c], rest[c]);
  const double p = std::sqrt(square / 6.0);
  if (!(p > 0.0)) return mean;
  const double r = std::clamp(glm::determinant(rest) / (2.0 * p * p * p), -1.0, 1.0);
  return mean + 2.0 * p * std::cos((std::acos(r) + 2.0 * std::numbers::pi) / 3.0);
}

double spinEnergy(const glm::dmat3& inertia, const glm::dvec3& spin) {
  return 0.5 * glm::dot(spin, inertia * spin);
}

/// The spin after a change of inertia: the same angular momentum, or the same spin if that has less energy.
glm::dvec3 spinAfter(const glm::dmat3& before, const glm::dmat3& after, const glm::dvec3& spin) {
  const double had = spinEnergy(before, spin);
  const glm::dvec3 slowed = glm::inverse(after) * (before * spin);
  if (spinEnergy(after, slowed) <= had) return slowed;
  const double has = spinEnergy(after, spin);
  return has <= had ? spin : std::sqrt(had / has) * spin;
}

}  // namespace

assets::MassProperties replicaMass(const assets::MassProperties& part, int sites, double linkMass,
                                   double lever) {
  const double share = 1.0 / sites, mass = share * part.mass;
  const double minimum = std::min(mass, std::max(kMinReplicaMass, 0.1 * mass));
  const double given = std::min(linkMass, mass - minimum);
  const double inertia = std::min(given * lever * lever, 0.8 * share * leastEigenvalue(part.inertia));
  return {mass - given, part.centreOfMass, share * part.inertia - glm::dmat3(inertia)};
}

void changeMass(RigidBody& body, const assets::MassProperties& target, double limit) {
  const double change = target.mass - body.mass;
  const double share = std::abs(change) <= limit ? 1.0 : limit / std::abs(change);
  const double mass = body.mass + share * change;
  const glm::dmat3 inertia = body.inertia + share * (target.inertia - body.inertia);
  const glm::dmat3 rotation = glm::mat3_cast(body.worldFromBody.orientation);
  const glm::dvec3 com = transformPoint(body.worldFromBody, body.centreOfMass);
  const glm::dvec3 velocity =
      std::min(1.0, body.mass / mass) * velocityAt(body.worldFromBody, body.twist, com);
  const glm::dvec3 spin =
      rotation * spinAfter(body.inertia, inertia, glm::transpose(rotation) * body.twist.angular);
  body.mass = mass;
  body.inertia = inertia;
  setVelocity(body, velocity, spin);
}

void MassRamp::advance(RigidBody& body, const assets::MassProperties& target, double dt) {
  const double change = target.mass - body.mass;
  if (change * rate_ <= 0.0) rate_ = 0.0;
  rate_ = std::clamp(rate_ + std::copysign(dt * kGrowing / kRise, change), -kFalling, kGrowing);
  changeMass(body, target, std::abs(rate_) * dt);
}

}  // namespace tandem::haptics
