#pragma once

// What one person shows the others (sections, a view, a place that is pointed at). None of it is kept in the
// journal: it is relayed, and of what a site shows only the newest.
//
// 1. One site shares at a time. Who begins takes over from who shared before; a participant does not take
//    over from an instructor. A site whose sharing was ended is told so, and shares again only after it has
//    stopped.
// 2. Observers show nothing. What they send, what names an unknown part, and what is more than a site
//    may send is dropped and counted.
// 3. What a site shows goes to the others at most once in a period, which grows with their number. A newcomer
//    and a site whose line is slow get what is shown when there is room on the line.
// 4. A site that loses its connection shows nothing any more.

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>

#include "server/message_rate.h"
#include "server/peers.h"
#include "server/session_context.h"
#include "server/sites.h"
#include "sync/transport/transport.h"
#include "sync/wire/presentation_messages.h"

namespace tandem::server {

class Presentations {
 public:
  static constexpr sync::Micros kPeriod = 50 * sync::kMillisecond;
  static constexpr double kPeersPerPeriod = 32.0;  // of more the period grows
  static constexpr double kRate = 30.0, kBurst = 60.0;
  static constexpr std::size_t kMaxBacklog = 64 * 1024;  // bytes that wait for a slow line

  /// All outlive this.
  Presentations(std::size_t partCount, SessionContext& context, sync::Transport& transport, Peers& peers,
                const Sites& sites)
      : partCount_(partCount), context_(context), transport_(transport), peers_(peers), sites_(sites) {}

  void onPresentation(const Peer& peer, const sync::Presentation& shown);
  /// At the end of a step: sends what is due.
  void flush();

 private:
  struct Shown {
    sync::Presentation newest;
    MessageRate rate{kRate, kBurst};
    sync::Micros nextAt = 0;  // session time
    bool due = false;         // `newest` was not sent to the others
    bool tellOwner = false;   // the site is to hear that its sharing was ended
    bool stopped = false;     // its sharing was ended, and it has not stopped itself since
  };

  bool isSound(const sync::Presentation& shown) const;
  bool mayTakeOver(SiteId from, SiteId by) const;
  void takeOver(SiteId by);
  void endLost();
  void send(const Peer& peer, std::span<const std::byte> bytes);

  std::size_t partCount_;
  SessionContext& context_;
  sync::Transport& transport_;
  Peers& peers_;
  const Sites& sites_;
  std::map<SiteId, Shown> shown_;
  SiteId sharer_ = kNoSite;
  std::uint64_t peerChanges_ = 0;  // at the last endLost()
};

}  // namespace tandem::server
