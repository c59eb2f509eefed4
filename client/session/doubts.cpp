#include "client/session/doubts.h"

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;

void Doubts::enter() {
  checks_.clear();
  doubted_.clear();
}

void Doubts::observe(SiteId owner, const PartState& state, Micros time, Micros now) {
  ASSERT(scene_ != nullptr);
  // A control is set from a window, too, and goes there at once.
  if (assets::controlOf(*scene_, state.part) != nullptr) return;
  const glm::dvec3& centre = scene_->parts[state.part].massProperties.centreOfMass;
  if (checks_[state.part].observe(state, centre, time, limits_.motion)) note(owner, now);
}

void Doubts::note(SiteId site, Micros now) {
  ASSERT(limits_.enough > 0 && static_cast<std::size_t>(limits_.enough) <= kMostOddities);
  const auto enough = static_cast<std::size_t>(limits_.enough);
  Doubted& doubted = doubted_[site];
  doubted.oddities[doubted.count++ % enough] = now;
  // The next place in the ring holds the oldest of so many.
  if (doubted.count < enough || now - doubted.oddities[doubted.count % enough] > kWindow) return;
  accuse(site, now);
}

void Doubts::accuse(SiteId site, Micros now) {
  Doubted& doubted = doubted_[site];
  if (now < doubted.nextAt) return;
  doubted.nextAt = now + kSayPeriod;
  sender_.send(Doubt{kNoSite, site, true});
  if (watchers_.observer) watchers_.observer->onDoubt(site);
}

}  // namespace tandem::client
