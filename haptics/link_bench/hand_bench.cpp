#include "haptics/link_bench/hand_bench.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace tandem::bench {

using haptics::SixAxes;

HandBench::Site::Site(const BenchSite& given, const haptics::RigidBody& start)
    : bodyFromGrip{kCentreOfMass + given.grip, {1.0, 0.0, 0.0, 0.0}},
      arm(given.arm, start.worldFromBody * bodyFromGrip),
      body(start) {}

haptics::Coupling HandBench::Site::grip(const haptics::CouplingGains& gains) const {
  return {bodyFromGrip, arm.reading(), arm.readingVelocity(), gains};
}

double HandBench::Site::offGrip() const {
  return glm::length(arm.device().position - transformPoint(body.worldFromBody, bodyFromGrip.position));
}

HandBench::HandBench(const std::vector<BenchSite>& sites, const Block& block) {
  for (const BenchSite& given : sites) sites_.emplace_back(given, bodyOf(block));
}

void HandBench::step(const Intent& intent) {
  tick();
  account();
  for (std::size_t i = 0; i < sites_.size(); ++i) moveArm(i, intent);
  ++ticks_;
}

void HandBench::moveArm(std::size_t index, const Intent& intent) {
  constexpr double e = 1e-4;  // s, either way, for velocity and acceleration
  const int who = static_cast<int>(index);
  const double now = time();
  const SixAxes before = intent(now - e, who), at = intent(now, who), after = intent(now + e, who);
  sites_[index].arm.step(at, (0.5 / e) * (after - before), (1.0 / (e * e)) * (after - at - (at - before)),
                         sites_[index].onHand);
}

void HandBench::account() {
  double given = 0.0;
  for (Site& site : sites_) {
    given += site.arm.given();
    Wrench& oldest = site.before[static_cast<std::size_t>(ticks_) % site.before.size()];
    const bool full = ticks_ >= static_cast<long>(site.before.size());
    site.change = full ? glm::length(site.onHand.force - oldest.force) : 0.0;
    site.turnChange = full ? glm::length(site.onHand.torque - oldest.torque) : 0.0;
    oldest = site.onHand;
  }
  maxCreated = std::max(maxCreated, given);
}

bool HandBench::runTo(double until, const Intent& intent) {
  while (time() < until) {
    step(intent);
    if (astray()) return false;
  }
  return true;
}

double HandBench::gap(std::size_t i, std::size_t j) const {
  return glm::length(sites_[i].centre().position - sites_[j].centre().position);
}

double HandBench::turnGap(std::size_t i, std::size_t j) const {
  return glm::length(rotationVector(sites_[i].body.worldFromBody.orientation *
                                    glm::conjugate(sites_[j].body.worldFromBody.orientation)));
}

bool HandBench::astray() const {
  for (const Site& site : sites_)
    if (!(glm::length(site.centre().position) < 0.6)) return true;
  return false;
}

}  // namespace tandem::bench
