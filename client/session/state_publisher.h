#pragma once

// When a site publishes its parts, hand and camera: as rarely as receivers can extrapolate without a
// noticeable error. Pure: time comes in as an argument. state_publishing.h sends what is due.
//
// 1. A part that another site's hand touches is published at the full rate: states that are felt are never
//    left out.
// 2. Any other moving part is published when what receivers extrapolate from its last state
//    (sync/replica/play_out.h) is wrong by more than a share of its displacement since then: the perceptual
//    deadband of Hinterseer et al., "Perception-based data reduction and transmission of haptic data", IEEE
//    Trans. Signal Processing 56 (2008), applied to the motion. At least 60 times a second.
// 3. A part that has come to rest, and a hand that is still, are repeated ever less often, down to twice a
//    second: datagrams get lost, and sites join.

#include <span>
#include <vector>

#include "assets/scene/scene.h"
#include "sync/wire/state_update.h"
#include "sync/wire/wire_frame.h"

namespace tandem::client {

struct PublishRates {
  double max = 250.0;      // Hz, of updates
  double min = 60.0;       // Hz, of a part that moves
  double presence = 60.0;  // Hz at most, about, of hand and camera; less where there are few updates
  /// Weber fraction: the noticeable error as a share of the displacement. 0: no error is tolerated, and
  /// everything is published at the full rate.
  double deadband = 0.1;
};

/// A part that the site owns, as it is now.
struct OfferedPart {
  sync::PartState state;
  bool coHeld = false;  // another site's hand touches it
};

class StatePublisher {
 public:
  StatePublisher(const assets::Scene& scene, const sync::WireFrame& frame, const PublishRates& rates);

  /// A new connection: the server has no state yet.
  void reset();
  /// Whether an update may leave at `now`; if not, there is no need to ask due().
  bool mayBeDue(sync::Micros now) const { return now >= next_; }
  /// Whether an update is to leave now, with these parts, which hold at local time `time`. If so the update
  /// counts as sent, and `newPresence` is whether it includes presence.
  bool due(sync::Micros now, sync::Micros time, std::span<const OfferedPart> parts,
           const sync::Presence& presence, bool& newPresence);

 private:
  /// When something was published that is repeated ever less often while it does not change.
  struct Repeated {
    sync::Micros sentAt = 0;
    int unchanged = -1;  // repeats since it changed; -1: never published
    bool due(sync::Micros now, double least) const;
    void sent(sync::Micros now, bool changed);
  };
  struct Sent {
    sync::PartState state;
    sync::Micros time = 0;
  };

  bool partsDue(sync::Micros now, sync::Micros time, std::span<const OfferedPart> parts) const;
  bool partDue(const OfferedPart& part, sync::Micros now, sync::Micros time) const;
  const Sent* lastOf(const sync::PartState& state) const;
  double distance(const Pose& a, const Pose& b, PartId part) const;
  bool presenceChanged(const sync::Presence& presence) const;
  bool moved(const Pose& from, const Pose& to) const;

  std::vector<double> reach_;  // m, of each part from its origin
  sync::WireFrame frame_;
  PublishRates rates_;
  sync::Micros next_ = 0;
  std::vector<Sent> sent_;  // of the parts in the last update
  Repeated parts_, presence_;
  sync::Presence lastPresence_;
};

}  // namespace tandem::client
