#pragma once

// What people say. The newest lines are kept, also over a restart, for who joins or comes back.
//
// 1. Observers say nothing. What they send, what names an unknown part, and what is more than a site may say
//    is dropped and counted, and is not kept.
// 2. A line is told at once; it does not wait for the journal, so a crash can lose the last ones. While the
//    journal fails lines are told, and kept in memory alone.
// 3. A site gets the lines that are kept before it gets any other one.

#include <cstdint>
#include <deque>
#include <map>

#include "server/message_rate.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/session_context.h"
#include "server/sites.h"
#include "sync/transport/transport.h"
#include "sync/wire/presentation_messages.h"

namespace tandem::server {

class Chat {
 public:
  static constexpr double kRate = 1.0, kBurst = 5.0;     // lines of a site: a second, at once
  static constexpr std::size_t kMaxBacklog = 64 * 1024;  // bytes that wait for a slow line

  /// All outlive this.
  Chat(std::size_t partCount, SessionContext& context, sync::Transport& transport, Peers& peers,
       const Sites& sites, Publisher& publisher)
      : partCount_(partCount),
        context_(context),
        transport_(transport),
        peers_(peers),
        sites_(sites),
        publisher_(publisher) {}

  void restore(const JournalContents& contents);
  void onSay(const Peer& peer, const sync::Say& said);
  /// At the end of a step: tells newcomers what was said before, when there is room on the line.
  void flush();

 private:
  bool isSound(const sync::Say& said) const;
  void keep(const sync::SaidLine& line);

  std::size_t partCount_;
  SessionContext& context_;
  sync::Transport& transport_;
  Peers& peers_;
  const Sites& sites_;
  Publisher& publisher_;
  std::map<SiteId, MessageRate> rates_;
  std::deque<sync::SaidLine> lines_;  // at most kMaxSaidLines, by number
};

}  // namespace tandem::server
