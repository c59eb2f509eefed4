#pragma once

// How a site changes the document of the session, and how it learns of it.

#include <string>
#include <vector>

#include "assets/document/document.h"
#include "sync/wire/ownership_messages.h"

namespace tandem::sync {

/// Wants a change of the document. Answered by a PutReply. A request that is sent again has one effect.
struct PutEntry {
  RequestId request = 0;
  document::Change change;
};
struct PutReply {
  RequestId request = 0;
  document::Refusal refusal = document::Refusal::none;
  std::string reason;               // for a person, if it was refused
  document::EntryId entry = 0;      // that was changed; 0 if it was refused
  document::Revision revision = 0;  // of the change
};

/// To every site, once the change is durable: an entry as it is now.
struct DocumentChanged {
  document::Entry entry;
};

/// Asks for the whole document, unless it is still at this revision; 0 asks in any case.
struct DocumentRequest {
  document::Revision known = 0;
};
/// A part of the document. Entries that change meanwhile come as DocumentChanged, before or after it.
struct DocumentChunk {
  bool first = false;                    // what was known before is void
  bool last = false;                     // all is there that was there when it was asked for
  document::Revision revision = 0;       // of the document when it was asked for
  std::vector<document::Entry> entries;  // by revision; kMaxChunkBytes or one entry
};

}  // namespace tandem::sync
