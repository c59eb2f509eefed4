#pragma once

// Energy that hands were given from nowhere: force times travel and torque times turn of all hands that act
// on each other, less what the scene's declared sources gave. It sees devices and sources only, so it is
// independent of the grips, contacts and links that it judges.
//
// Hands that have ever been coupled form a group from then on: what one of them puts in, the others may be
// given. Hands of different groups pay for nothing of each other.

#include <cstddef>
#include <span>
#include <vector>

#include "assets/base/disjoint_sets.h"

namespace tandem::client {

class CreatedEnergy {
 public:
  explicit CreatedEnergy(std::size_t hands) : groups_(hands), created_(hands, 0.0) {}

  /// These two hands act on each other from now on: their sites simulate one part.
  void couple(std::size_t a, std::size_t b) {
    groups_.join(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  }
  /// Ends a tick: the energy that each hand has been given so far less that of the scene's sources, J.
  void add(std::span<const double> given);
  /// J: each hand's part of what its group created, the most at any time. The sum over a group is the most by
  /// which its hands together were ever given more than they and the sources had put in; it goes to the hands
  /// that had been given something then, in proportion.
  const std::vector<double>& byHand() const { return created_; }

 private:
  DisjointSets groups_;          // of hands
  std::vector<double> created_;  // J, a hand each
};

}  // namespace tandem::client
