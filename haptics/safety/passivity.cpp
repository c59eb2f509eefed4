#include "haptics/safety/passivity.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace tandem::haptics {

void EnergyObserver::add(const glm::dvec3& force, const glm::dvec3& velocity, double dt) {
  addWork(force, velocity * dt);
}

void EnergyObserver::add(const Wrench& toHand, const Twist& hand, double dt) {
  given_ += dt * glm::dot(toHand.torque, hand.angular);
  addWork(toHand.force, hand.linear * dt);
}

void EnergyObserver::addWork(const glm::dvec3& force, const glm::dvec3& displacement) {
  given_ += glm::dot(force, displacement);
  mostCreated_ = std::max(mostCreated_, given_);
}

}  // namespace tandem::haptics
