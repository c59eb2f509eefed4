#pragma once

// The messages of the session's document: changes that sites want, and the whole of it for who joins.
//
// 1. A change is durable before anybody learns of it: its author, the others, or a site that joins.
// 2. While the journal fails every change is refused as "not now"; what was accepted before that is told
//    once the journal is well again.
// 3. A site that asks gets the entries by revision, in chunks. What changes meanwhile it is told as everybody
//    is, so that the last chunk completes what it has.

#include <cstdint>
#include <deque>
#include <vector>

#include "server/document.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/session_config.h"
#include "server/session_context.h"
#include "server/sites.h"

namespace tandem::server {

class DocumentService {
 public:
  DocumentService(const SessionConfig& config, SessionContext& context, const sync::Transport& transport,
                  const Sites& sites, Publisher& publisher);

  void restore(const JournalContents& contents);
  const document::Document& content() const { return document_.content(); }

  void onPut(const Peer& peer, const sync::PutEntry& request);
  void onRequest(Peer& peer, const sync::DocumentRequest& request);
  /// Sends chunks to everybody who waits for some, until the connection's backlog is full.
  void sendChunks(Peers& peers);
  bool anyActive() const { return !active_.empty(); }

 private:
  struct Kept {
    std::uint64_t number = 0;  // of the journal's record
    document::Revision revision = 0;
  };
  void takeDurable();
  void sendChunks(Peer& peer);
  /// The next chunk for a site; without entries and not the last if nothing may be told yet.
  sync::DocumentChunk nextChunk(DocumentProgress& progress) const;

  SharedDocument document_;
  document::Revision durable_ = 0;  // of the last change that is safe
  std::deque<Kept> undurable_;
  std::vector<PeerSerial> active_;  // who asked and has not got all
  std::size_t maxBacklogBytes_;
  SessionContext& context_;
  const sync::Transport& transport_;
  const Sites& sites_;
  Publisher& publisher_;
};

}  // namespace tandem::server
