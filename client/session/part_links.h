#pragma once

// The network's side of the coordination links that tie this site's replicas of parts to those of other sites
// (haptics/link/tied_parts.h). Ownership decides which links there are; a Line is this site's end of one of
// them.
//
// 1. The owner of a part begins a line to each site that is engaged in the part, and chooses its terms and
//    its epoch. The guest, which is the engaged site, takes both from the first packet that it receives.
// 2. Epochs follow the session's clock, so a later line has a larger epoch whichever site begins it. The
//    owner begins a line anew after kSilence without a packet: the other end may have forgotten it.
// 3. Orders to the hand leave as events, in the order in which they were decided.
//
// Network thread.

#include <cstdint>
#include <optional>
#include <vector>

#include "assets/scene/scene.h"
#include "client/session/exchange.h"
#include "sync/replica/ownership_view.h"
#include "sync/wire/link_stream.h"
#include "sync/wire/link_update.h"
#include "sync/wire/time.h"

namespace tandem::client {

class PartLinks {
 public:
  /// The scene must outlive this. `packetPeriod` s, of the lines that this site begins.
  PartLinks(const assets::Scene& scene, double packetPeriod);

  /// A state of `peer` was `age` old when it came.
  void heard(SiteId peer, sync::Micros age);
  /// Ends the lines of a part to sites that do not share it any more. The part's owner also begins those that
  /// are missing. `now`: session time.
  void follow(const sync::OwnershipView& view, PartId part, sync::Micros now);
  /// Begins anew the lines of this site's own parts that have fallen silent.
  void beginSilentAnew(const sync::OwnershipView& view, sync::Micros now);

  /// A packet for the hand; nothing if the datagram belongs to no line, or to an earlier epoch. `now`:
  /// session time.
  std::optional<haptics::TiedPacket> receive(const sync::LinkUpdate& update, const sync::OwnershipView& view,
                                             sync::Micros now);
  /// A packet for the wire; nothing if its line has ended.
  std::optional<sync::LinkUpdate> toWire(const haptics::TiedPacket& packet) const;

  /// Whether what the peer does to the part is felt here: there is a line, and its delay is not too long for
  /// a link.
  bool felt(PartId part, SiteId peer) const;

  /// The orders to the hand since the last call.
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
    bool felt = false;  // as the peer measures the delay
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
