#include "haptics/body/virtual_coupling.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

/// A symmetric positive definite 6 x 6 system. factor() puts the Cholesky factor L into the lower triangle of
/// `a`; solve() puts the solution into `b`.
struct System6 {
  std::array<std::array<double, 6>, 6> a{};
  std::array<double, 6> b{};

  void factor() {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = a[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
        a[i][j] = i == j ? std::sqrt(sum) : sum / a[j][j];
      }
    }
  }
  void solve() {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
      b[i] /= a[i][i];
    }
    for (std::size_t i = 6; i-- > 0;) {
      for (std::size_t k = i + 1; k < 6; ++k) b[i] -= a[k][i] * b[k];
      b[i] /= a[i][i];
    }
  }
};

glm::dmat3 crossMatrix(const glm::dvec3& v) {
  return glm::dmat3(0.0, v.z, -v.y, -v.z, 0.0, v.x, v.y, -v.x, 0.0);  // columns
}

void setBlock(System6& system, std::size_t row, std::size_t column, const glm::dmat3& block) {
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) {
      system.a[row + static_cast<std::size_t>(r)][column + static_cast<std::size_t>(c)] = block[c][r];
    }
  }
}

/// Force of a virtual coupling on a body at rest, and the drag coefficients of the body's new velocity.
CouplingForce forceOf(const Pose& worldFromBody, const glm::dvec3& com, const Coupling& coupling, double dt) {
  const Pose worldFromGrip = worldFromBody * coupling.bodyFromGrip;
  const Pose& device = coupling.worldFromDevice;
  const CouplingGains& gains = coupling.gains;
  const glm::dvec3 gap = device.position - worldFromGrip.position;
  const glm::dvec3 angle = rotationVector(device.orientation * glm::conjugate(worldFromGrip.orientation));
  CouplingForce c;
  c.arm = worldFromGrip.position - com;
  c.force = gains.stiffness * gap + gains.damping * coupling.device.linear;
  c.torque = gains.rotStiffness * angle + gains.rotDamping * coupling.device.angular;
  c.damping = gains.damping;
  c.drag = gains.damping + dt * gains.stiffness;
  c.rotDrag = gains.rotDamping + dt * gains.rotStiffness;
  return c;
}

}  // namespace

CoupledStep coupleBody(const RigidBody& body, std::span<const Coupling> couplings, const Wrench& load,
                       const glm::dvec3& acceleration, double dt) {
  ASSERT(couplings.size() <= static_cast<std::size_t>(kMaxCouplings));
  const glm::dmat3 rotation = glm::mat3_cast(body.worldFromBody.orientation);
  const glm::dvec3 com = transformPoint(body.worldFromBody, body.centreOfMass);
  const glm::dvec3 comVelocity = velocityAt(body.worldFromBody, body.twist, com);
  const glm::dmat3 inertia = rotation * body.inertia * glm::transpose(rotation);
  CoupledStep step;
  // The velocity of the grip is v - [arm] w. With G = (1, -[arm]), the step solves (M + dt sum G^T drag G)
  // (v, w) = M (v0, w0) + dt (forces at rest).
  double linear = body.mass;
  glm::dmat3 lever(0.0), angular = inertia;
  glm::dvec3 momentum = body.mass * (comVelocity + dt * acceleration) + dt * load.force;
  glm::dvec3 spin = inertia * body.twist.angular + dt * load.torque;
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    CouplingForce& c = step.couplings[i];
    c = forceOf(body.worldFromBody, com, couplings[i], dt);
    const glm::dmat3 across = crossMatrix(c.arm);
    linear += dt * c.drag;
    lever += dt * c.drag * across;
    angular = angular + glm::dmat3(dt * c.rotDrag) - dt * c.drag * across * across;
    momentum += dt * c.force;
    spin += dt * (c.torque + glm::cross(c.arm, c.force));
  }
  System6 system;
  setBlock(system, 0, 0, glm::dmat3(linear));
  setBlock(system, 0, 3, -lever);
  setBlock(system, 3, 0, lever);
  setBlock(system, 3, 3, angular);
  for (int i = 0; i < 3; ++i) {
    system.b[static_cast<std::size_t>(i)] = momentum[i];
    system.b[static_cast<std::size_t>(i) + 3] = spin[i];
  }
  system.factor();
  system.solve();
  step.root = system.a;
  step.freeVelocity = {system.b[0], system.b[1], system.b[2]};
  step.freeSpin = {system.b[3], system.b[4], system.b[5]};
  return step;
}

CoupledStep coast(const RigidBody& body, double share) {
  const glm::dmat3 rotation = glm::mat3_cast(body.worldFromBody.orientation);
  const glm::dvec3 com = transformPoint(body.worldFromBody, body.centreOfMass);
  System6 system;
  setBlock(system, 0, 0, glm::dmat3(body.mass));
  setBlock(system, 3, 3, rotation * body.inertia * glm::transpose(rotation));
  system.factor();
  CoupledStep step;
  step.root = system.a;
  step.freeVelocity = share * velocityAt(body.worldFromBody, body.twist, com);
  step.freeSpin = share * body.twist.angular;
  return step;
}

CoupledStep guidedStep(const glm::dvec3& axis, bool turns, double rate, double inertia, double size) {
  constexpr double kHeavy = 1e6;  // a push of the same force moves it by that much less across the axis
  const double area = size * size;
  const double mass = kHeavy * (turns ? inertia / area : inertia), spin = mass * area;
  const glm::dmat3 across = glm::dmat3(1.0) - glm::outerProduct(axis, axis);
  const glm::dmat3 along = inertia * glm::outerProduct(axis, axis);
  System6 system;
  setBlock(system, 0, 0, turns ? glm::dmat3(mass) : mass * across + along);
  setBlock(system, 3, 3, turns ? spin * across + along : glm::dmat3(spin));
  system.factor();
  CoupledStep step;
  step.root = system.a;
  (turns ? step.freeSpin : step.freeVelocity) = rate * axis;
  return step;
}

void setVelocity(RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin) {
  const glm::dvec3 com = transformPoint(body.worldFromBody, body.centreOfMass);
  body.twist.angular = spin;
  body.twist.linear = velocity - glm::cross(spin, com - body.worldFromBody.position);
}

void moveBody(RigidBody& body, const glm::dvec3& velocity, const glm::dvec3& spin, double dt) {
  const glm::dvec3 com = transformPoint(body.worldFromBody, body.centreOfMass) + dt * velocity;
  body.worldFromBody.orientation =
      glm::normalize(fromRotationVector(dt * spin) * body.worldFromBody.orientation);
  body.worldFromBody.position = com - body.worldFromBody.orientation * body.centreOfMass;
  setVelocity(body, velocity, spin);
}

Wrench stepCoupledBody(RigidBody& body, const Pose& bodyFromGrip, const Pose& worldFromDevice,
                       const Twist& device, const CouplingGains& gains, const glm::dvec3& acceleration,
                       double dt) {
  const Coupling coupling{bodyFromGrip, worldFromDevice, device, gains};
  const CoupledStep step = coupleBody(body, {&coupling, 1}, {}, acceleration, dt);
  moveBody(body, step.freeVelocity, step.freeSpin, dt);
  return step.couplings[0].onHand(step.freeVelocity, step.freeSpin);
}

double stiffestStable(double deviceDamping, double period, double delay, double couplingDamping) {
  return std::min(2.0 * deviceDamping / period, (deviceDamping + couplingDamping) / (0.5 * period + delay));
}

namespace {

/// A device that updates more slowly than the loop holds each force for longer.
double periodOf(const DeviceLimits& device, double dt) {
  return device.rate > 0.0 ? std::max(dt, 1.0 / device.rate) : dt;
}

}  // namespace

double stiffestContact(const DeviceLimits& device, double dt, double delay) {
  if (!(device.maxForce > 0.0) || !(device.damping > 0.0) || !(dt > 0.0)) return 0.0;
  return stiffestStable(device.damping, periodOf(device, dt), std::max(delay, 0.0), 0.0);
}

CouplingGains stiffestGrasp(const DeviceLimits& device, double dt, double delay) {
  CouplingGains limits;
  if (!(dt > 0.0)) return limits;
  const double period = periodOf(device, dt), late = std::max(delay, 0.0);
  limits.stiffness = stiffestContact(device, dt, delay);
  if (device.maxForce > 0.0) limits.damping = std::max(device.mass, 0.0) / (period + late);
  if (!(device.maxTorque > 0.0)) return limits;
  if (device.rotDamping > 0.0) limits.rotStiffness = stiffestStable(device.rotDamping, period, late, 0.0);
  limits.rotDamping = std::max(device.inertia, 0.0) / (period + late);
  return limits;
}

}  // namespace tandem::haptics
