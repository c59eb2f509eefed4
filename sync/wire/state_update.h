#pragma once

// The states of parts, hands and cameras, as their owners publish them, and which of them have arrived.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "assets/base/ids.h"
#include "assets/base/pose.h"
#include "sync/wire/time.h"

namespace tandem::sync {

/// One part's state at one instant, by its owner.
struct PartState {
  PartId part = kNoPart;
  Epoch epoch = 0;
  std::uint32_t sequence = 0;  // grows within (part, epoch)
  Pose worldFromPart;
  Twist twist;
};

/// Where a site's hand and camera are, for display at the other sites.
struct Presence {
  SiteId site = kNoSite;  // filled in by the server on the way out
  Pose worldFromTool;     // proxy of the stylus
  Pose worldFromCamera;
  glm::dvec3 force{0.0, 0.0, 0.0};  // N on the hand
  PartId touched = kNoPart;
  std::optional<Pose> worldFromSecondTool{};  // of the same person's other hand, if there is one
};

/// The states of one site at one instant. Site to server, and relayed by the server to each other site.
struct StateUpdate {
  SiteId site = kNoSite;       // whose states; filled in by the server
  std::uint32_t sequence = 0;  // of the datagrams from this sender to this receiver: gaps are losses
  Micros time = 0;             // session time at which these states held, by the owning site's estimate
  Presence presence;
  bool newPresence = true;       // false: not in this datagram; `presence` is the newest known
  bool presenceKnown = true;     // false: none has arrived yet
  std::vector<PartState> parts;  // what fits into kMaxStateBytes; a part in it appears once
};

/// Which of the StateUpdates that were marked to be kept the receiver has (state_stream.h).
struct StateAck {
  static constexpr std::size_t kMax = 64;
  std::uint8_t count = 0;
  std::array<std::uint32_t, kMax> sequences{};  // the first `count`
};

}  // namespace tandem::sync
