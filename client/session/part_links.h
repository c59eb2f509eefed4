#pragma once

// The network's side of the links that tie this site's replicas of parts to other sites' (haptics/link/tied_parts.h): who is
// tied to whom, by what ownership says; and their packets, to and from the wire.
//
// 1. The owner of a part begins a line to each site that is engaged in it, and chooses its terms and its epoch. The
//    guest takes both from the first packet that it hears.
// 2. Epochs follow the session's clock, so that a later line has a larger one whoever begins it. A line of which nothing
//    is heard for kSilence begins anew: one of its ends may have forgotten it.
// 3. Orders to the hand leave in the order in which they were decided, as events.
//
// Network thread.

#include <cstdint>
#include <optional>
#include <vector>

#include "assets/scene/scene.h"
#include "client/session/exchange.h"
#include "sync/replica/ownership.h"
#include "sync/wire/link_stream.h"

namespace tandem::client {

class PartLinks {
 public:
  /// The scene must outlive this. `packetPeriod` s, of the lines that this site begins.
  PartLinks(const assets::Scene& scene, double packetPeriod);

  /// A state of `peer` was `age` old when it came.
  void heard(SiteId peer, sync::Micros age);
  /// Ends the lines of a part to who does not share it any more; as its owner begins those that are missing. `now`:
  /// session time.
  void follow(const sync::OwnershipView& view, PartId part, sync::Micros now);
  /// Lines that have fallen silent, as their owner.
  void beginSilentAnew(const sync::OwnershipView& view, sync::Micros now);

  /// For the hand; nothing if the datagram is of no use: anything may come.
  std::optional<haptics::TiedPacket> receive(const sync::LinkUpdate& update, const sync::OwnershipView& view,
                                             sync::Micros now);
  /// For the wire; nothing if there is no such line any more.
  std::optional<sync::LinkUpdate> toWire(const haptics::TiedPacket& packet) const;

  /// Whether what the peer does to the part is felt here: there is a line, and its way is not too long for a link.
  bool felt(PartId part, SiteId peer) const;

  /// What the hand is to be told, drained by the caller.
  std::vector<NetworkEvent> takeEvents();

  static constexpr sync::Micros kSilence = 1500 * sync::kMillisecond;

 private:
  struct Line {
    PartId part = kNoPart;
    SiteId peer = kNoSite;
    std::uint32_t epoch = 0;
    sync::LineTerms terms;
    sync::LinkReceiver receiver;
    sync::Micros heardAt = 0;
    bool felt = false;  // as the peer measures the way
  };
  struct Age {
    SiteId site = kNoSite;
    double seconds = 0.0;  // low-passed
  };

  Line* find(PartId part, SiteId peer);
  const Line* find(PartId part, SiteId peer) const;
  double ageOf(SiteId peer) const;
  std::uint32_t newEpoch(PartId part, sync::Micros now);
  sync::LineTerms termsFor(SiteId peer, std::size_t lines) const;
  void begin(Line& line, sync::Micros now, bool guest);
  void tellSimulators(const sync::OwnershipView& view, PartId part);
  Line* lineOfOwner(const sync::LinkUpdate& update, sync::Micros now);

  const assets::Scene& scene_;
  double packetPeriod_;
  std::vector<Line> lines_;
  std::vector<Age> ages_;
  std::vector<std::uint32_t> lastEpoch_;  // by part, of any line of it here
  std::vector<NetworkEvent> events_;
};

}  // namespace tandem::client
