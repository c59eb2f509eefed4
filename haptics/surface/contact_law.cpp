#include "haptics/surface/contact_law.h"

#include <algorithm>
#include <cmath>

namespace tandem::haptics {

double viscoelasticForce(double k, double k2, double tau, double depth, double dt,
                         ViscoelasticMemory& memory) {
  if (!(tau > 0.0) || !(k2 > 0.0) || !(k > 0.0)) {
    memory = {depth, 0.0};
    return std::max(0.0, k * depth);
  }
  const double decay = std::exp(-dt / tau);
  const double arm = memory.arm * decay - k2 * (depth - memory.depth) * (tau / dt) * std::expm1(-dt / tau);
  const double force = k * depth + arm;
  if (force >= 0.0) {
    memory = {depth, arm};
    return force;
  }
  // Unloaded, the springs first share the remaining deformation (k d + q = 0 at once), then creep back
  // together.
  const double freed = (k2 * memory.depth - memory.arm) / (k + k2);
  const double left = freed * std::exp(-dt / (tau * (1.0 + k2 / k)));
  memory = {left, -k * left};
  return 0.0;
}

double plasticForce(double k, double yield, double hardening, double depth, double& set) {
  if (!(depth > set)) return 0.0;
  const double excess = k * (depth - set) - yield - hardening * set;
  if (excess > 0.0) set += excess / (k + hardening);
  return k * (depth - set);
}

}  // namespace tandem::haptics
