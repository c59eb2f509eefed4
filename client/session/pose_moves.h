#pragma once

// Which parts this person has moved: from the grant of a part, which says where it stood, to its release.
// What a co-holder does to another's part counts as its owner's.
//
// Network thread.

#include <map>
#include <optional>

#include "client/session/document_undo.h"
#include "sync/wire/ownership_messages.h"

namespace tandem::client {

class PoseMoves {
 public:
  /// A record of a part, as it was applied; `self` is this site.
  void onOwnership(const sync::PartRecord& record, SiteId self);
  /// This site releases a part. The step by which that is taken back; nothing if the part stands where it
  /// stood.
  std::optional<DocumentUndo::Step> onRelease(const sync::Release& release);
  /// The newest record of the part; null if none has come.
  const sync::PartRecord* record(PartId part) const;

 private:
  std::map<PartId, sync::PartRecord> records_;
  std::map<PartId, sync::PartRecord> mine_;  // as granted: owned here, and not released yet
};

}  // namespace tandem::client
