#pragma once

// Which sites say that they do not believe the motion of which others. The server judges nothing: it tells
// all who says what of whom, and notes it for the audit. Nobody loses a part or a place by it.
//
// 1. A doubt holds for kHolds after the site has said it last, or until one of the two sites leaves. The
//    others are told that it has begun and that it has ended, and nothing in between, however often the site
//    repeats it.
// 2. Those of observers, of oneself, of sites that are not listed and those beyond a site's rate or
//    kMostAtOnce are dropped and counted: whoever accuses everybody costs the others kMostAtOnce messages
//    in kHolds.

#include <cstddef>
#include <map>
#include <utility>

#include "server/message_rate.h"
#include "server/peers.h"
#include "server/session_context.h"
#include "server/sites.h"
#include "sync/transport/transport.h"
#include "sync/wire/doubt_messages.h"

namespace tandem::server {

class Doubts {
 public:
  static constexpr sync::Micros kHolds = 60 * sync::kSecond;
  static constexpr std::size_t kMostAtOnce = 8;  // sites that one site doubts
  static constexpr double kRate = 0.2, kBurst = 8.0;

  /// All outlive this.
  Doubts(SessionContext& context, sync::Transport& transport, Peers& peers, const Sites& sites)
      : context_(context), transport_(transport), peers_(peers), sites_(sites) {}

  void onDoubt(const Peer& peer, const sync::Doubt& message);
  /// At the end of a step: tells newcomers what is said, and all what is said no more.
  void flush();

  /// The number of sites that doubt this one.
  std::size_t about(SiteId site) const;

 private:
  struct Doubter {
    MessageRate rate{kRate, kBurst};
    std::map<SiteId, sync::Micros> about;  // when it was said last, session time
  };

  bool isListed(SiteId site) const;
  bool isSound(const Peer& peer, const sync::Doubt& message, const Doubter& doubter) const;
  void note(const Peer& peer, SiteId about);
  void endOld();
  void tellAll(const sync::Doubt& doubt);
  void send(const Peer& peer, const sync::Doubt& doubt);

  SessionContext& context_;
  sync::Transport& transport_;
  Peers& peers_;
  const Sites& sites_;
  std::map<SiteId, Doubter> doubters_;
  sync::Micros nextLook_ = 0;  // session time
};

}  // namespace tandem::server
