#pragma once

// A site's copy of the session's document: of each entry the newest revision that the server has told,
// whether it came with the whole or as a change. Network thread.

#include "assets/document/document.h"
#include "sync/wire/document_messages.h"

namespace tandem::client {

class DocumentReplica {
 public:
  void handle(const sync::DocumentChunk& chunk);
  void handle(const sync::DocumentChanged& change) { document_.put(change.entry); }
  /// What changes from now on is not told.
  void connectionLost();

  /// Whether everything is there that the server has told.
  bool complete() const { return complete_; }
  /// What to ask for when a connection begins.
  sync::DocumentRequest request() const { return {whole_ ? document_.revision() : 0}; }
  const document::Document& content() const { return document_; }

 private:
  document::Document document_;
  bool complete_ = false;
  bool whole_ = false;  // it was complete when the connection was lost
};

}  // namespace tandem::client
