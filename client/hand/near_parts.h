#pragma once

// Which parts of other sites come so near to a part that is held here that this site is to simulate them too,
// before the two touch: a replica that is only played out, in contact at both sites, creates energy, and a
// coordination link that is asked for at contact comes too late.

#include <vector>

#include "assets/scene/scene.h"
#include "haptics/base/tick_types.h"

namespace tandem::client {

class NearParts {
 public:
  /// The scene must outlive this.
  explicit NearParts(const assets::Scene& scene);

  struct Moving {
    PartId part = kNoPart;
    Pose worldFromPart;
    Twist twist;
  };
  /// Whether the boxes of two parts are nearer than `near` m, or will be by the time at which a request has
  /// been answered and a link has faded in. `playOutDelay` s, of what others move.
  bool meet(const Moving& held, const Moving& other, double playOutDelay, double near) const;

  static constexpr double kNear = 0.02, kStillNear = 0.03;  // m: to begin, and to go on
  static constexpr double kFadeTime = 0.5;                  // s, of a link
  static constexpr double kSetOut = 0.02;                   // m/s: a part at rest may set out
  static constexpr double kMaxClosing = 0.5;                // m/s, of the approach that is foreseen

 private:
  const assets::Scene& scene_;
  std::vector<assets::Bounds> boxes_;  // by part, in its frame
};

}  // namespace tandem::client
