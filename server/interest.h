#pragma once

// Which sites are near each other: whose motion one of them may come to feel, so that it needs every update.
//
// Hands and moved parts are balls. Two sites are near while the gap between any two of their balls is under a
// share of the scene's size, or could close within kForesight at their present speeds. Pure: the caller keeps
// the reaches and decides how often to compare them.

#include <array>
#include <cstddef>
#include <vector>

#include "assets/scene/scene.h"
#include "sync/wire/state_update.h"

namespace tandem::server {

/// What a site's hands and parts take up, as of its newest update.
struct Reach {
  struct Ball {
    glm::dvec3 centre{0.0, 0.0, 0.0};  // m, world
    double radius = 0.0;               // m
  };
  static constexpr std::size_t kMaxBalls = 6;  // the last one holds all further parts
  std::array<Ball, kMaxBalls> balls;
  std::size_t count = 0;
  double speed = 0.0;  // m/s, of the fastest of them
  sync::Micros time = 0;
};

class Interest {
 public:
  static constexpr double kShareOfScene = 1.0 / 16.0;  // of its longest side
  static constexpr double kForesight_s = 0.3;

  explicit Interest(const assets::Scene& scene);

  /// Where the site is now; `reach` is what it was before, for the speed of the hand.
  void observe(const sync::StateUpdate& update, Reach& reach) const;
  bool near(const Reach& a, const Reach& b) const;

 private:
  std::vector<Reach::Ball> parts_;  // of each part, in its frame
  double margin_;                   // m
};

}  // namespace tandem::server
