#pragma once

// Boxes in a row or a tree, each held by another site; some sites push and pull back. Scenes and scenarios
// are made in code.

#include <cstdint>
#include <string>
#include <vector>

#include "client/simulation/simulation.h"

namespace tandem::test {

struct Chain {
  enum class Shape : std::uint8_t {
    row,
    splitting,  // a tree: the first box pushes those next to it, and each of them what is next to it
    merging,    // the same tree, pushed from its ends towards the first box
  };
  Shape shape = Shape::row;
  std::vector<double> masses;       // kg, an owner each
  std::vector<std::size_t> nextTo;  // of a tree: each box is next to an earlier one; [0] is not used
  std::vector<std::size_t> pushers{0};
  double delay = 50.0;       // ms, one way
  double deviceForce = 3.3;  // N, the limit of each device
  bool wall = true;          // behind the last boxes; else they are free
  double toWall = 0.015;     // m, from the last boxes
  bool gravity = false;      // the boxes then slide on a table
  double friction = 0.0;     // of all surfaces
  haptics::ArmParameters arm;
  std::vector<haptics::ArmParameters> arms;  // a site each; empty: `arm`
  double push = 0.06, over = 2.0;            // m, s
};

/// A row of `owners` boxes of 0.05 and 5 kg in turn.
Chain unequalChain(int owners);
/// A row or tree drawn at random: 2 to 8 owners, 0.05 to 5 kg, 5 to 250 ms, relaxed to firm arms, with a wall
/// or free, some with gravity and friction, pushed by one or several.
Chain drawChain(std::uint64_t seed);
std::string describe(const Chain& chain);
client::SimulationResult run(const Chain& chain, const client::SimulationOptions& options);
/// One box and its hand alone, with the travel to the wall that the chain leaves them.
Chain aloneAtWall(const Chain& chain, std::size_t pusher);

/// What a chain is judged by.
struct ChainFigures {
  double created = 0.0;    // J
  double step = 0.0;       // N in 20 ms, of any hand while some push
  double apart = 0.0;      // m, between two replicas of a box
  std::size_t broken = 0;  // rules of the protocol
};
ChainFigures measure(const Chain& chain, std::uint64_t seed, client::Mistake mistake = client::Mistake::none);

}  // namespace tandem::test
