#include "haptics/virtual_coupling.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

namespace tandem::haptics {
namespace {

/// A symmetric positive definite 6 x 6 system, solved in place by Cholesky's factorisation.
struct System6 {
  std::array<std::array<double, 6>, 6> a{};
  std::array<double, 6> b{};

  void solve() {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = a[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
        a[i][j] = i == j ? std::sqrt(sum) : sum / a[j][j];
      }
    }
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

}  // namespace

Wrench stepCoupledBody(RigidBody& body, const Pose& bodyFromGrip, const Pose& worldFromDevice,
                       const Twist& device, const CouplingGains& gains, const glm::dvec3& acceleration,
                       double dt) {
  const Pose worldFromGrip = body.worldFromBody * bodyFromGrip;
  const glm::dmat3 turn = glm::mat3_cast(body.worldFromBody.orientation);
  const glm::dmat3 inertia = turn * body.inertia * glm::transpose(turn);
  const glm::dvec3 com = transformPoint(body.worldFromBody, body.centreOfMass);
  const glm::dvec3 arm = worldFromGrip.position - com;
  const glm::dvec3 comVelocity = velocityAt(body.worldFromBody, body.twist, com);
  const glm::dvec3 spin = body.twist.angular;

  const glm::dvec3 gap = worldFromDevice.position - worldFromGrip.position;
  const glm::dvec3 angle =
      rotationVector(worldFromDevice.orientation * glm::conjugate(worldFromGrip.orientation));
  // What the coupling gives if the body stood still, and what each unit of the body's new velocity takes off
  // that.
  const glm::dvec3 force = gains.stiffness * gap + gains.damping * device.linear;
  const glm::dvec3 torque = gains.rotStiffness * angle + gains.rotDamping * device.angular;
  const double drag = gains.damping + dt * gains.stiffness;
  const double rotDrag = gains.rotDamping + dt * gains.rotStiffness;

  // Grip velocity = v - [arm] w. With G = (1, -[arm]): (M + dt G^T drag G) (v, w) = M (v0, w0) + dt (forces
  // at rest).
  const glm::dmat3 across = crossMatrix(arm);
  System6 system;
  setBlock(system, 0, 0, glm::dmat3(body.mass + dt * drag));
  setBlock(system, 0, 3, -dt * drag * across);
  setBlock(system, 3, 0, dt * drag * across);
  setBlock(system, 3, 3, inertia + glm::dmat3(dt * rotDrag) - dt * drag * across * across);
  const glm::dvec3 momentum = body.mass * (comVelocity + dt * acceleration) + dt * force;
  const glm::dvec3 angular = inertia * spin + dt * (torque + glm::cross(arm, force));
  for (int i = 0; i < 3; ++i) {
    system.b[static_cast<std::size_t>(i)] = momentum[i];
    system.b[static_cast<std::size_t>(i) + 3] = angular[i];
  }
  system.solve();
  const glm::dvec3 velocity(system.b[0], system.b[1], system.b[2]);
  const glm::dvec3 newSpin(system.b[3], system.b[4], system.b[5]);

  const glm::dvec3 newCom = com + dt * velocity;
  body.worldFromBody.orientation =
      glm::normalize(fromRotationVector(dt * newSpin) * body.worldFromBody.orientation);
  body.worldFromBody.position = newCom - body.worldFromBody.orientation * body.centreOfMass;
  body.twist.angular = newSpin;
  body.twist.linear = velocity - glm::cross(newSpin, newCom - body.worldFromBody.position);
  return {drag * (velocity + glm::cross(newSpin, arm)) - force, rotDrag * newSpin - torque};
}

double stiffestStable(double deviceDamping, double period, double delay, double couplingDamping) {
  return std::min(2.0 * deviceDamping / period, (deviceDamping + couplingDamping) / (0.5 * period + delay));
}

double stiffestContact(const DeviceLimits& device, double dt, double delay) {
  if (!(device.maxForce > 0.0) || !(device.damping > 0.0) || !(dt > 0.0)) return 0.0;
  // A device that reads more slowly than the loop runs holds each force for longer.
  const double period = device.rate > 0.0 ? std::max(dt, 1.0 / device.rate) : dt;
  return stiffestStable(device.damping, period, std::max(delay, 0.0), 0.0);
}

}  // namespace tandem::haptics
