#pragma once

// The document of the session at the server: who may change what, in which order, and that a request which
// is sent again has one effect.
//
// 1. An observer changes nothing. A participant makes and changes entries, and removes its own. An
//    instructor may do all.
// 2. A request that took effect is answered the same again as long as what it did stands (S7). The entry
//    itself remembers it, so that this holds across restarts too. Where another has changed the entry since,
//    a repeated change is refused as any that comes too late; a repeated creation makes no second entry.

#include <map>
#include <optional>
#include <utility>

#include "assets/document/document.h"
#include "server/journal/journal.h"
#include "sync/wire/document_messages.h"
#include "sync/wire/participant_messages.h"

namespace tandem::server {

class SharedDocument {
 public:
  void restore(const std::map<document::EntryId, document::Entry>& entries);
  const document::Document& content() const { return document_; }

  struct Answer {
    sync::PutReply reply;
    std::optional<DocumentRecord> record;  // what must be durable before the reply; none: nothing changed
  };
  /// Applies a change that a site wants, unless it may not.
  Answer put(const sync::PutEntry& request, sync::Role role, const document::By& by);

 private:
  using Creation = std::pair<SiteId, sync::RequestId>;

  /// The entry as this request has left it, if it took effect before; null if not.
  const document::Entry* doneBefore(const sync::PutEntry& request, SiteId site) const;
  bool mayChange(const document::Change& change, sync::Role role, SiteId site) const;

  document::Document document_;
  std::map<Creation, document::EntryId> created_;  // by whom, with which request
};

}  // namespace tandem::server
