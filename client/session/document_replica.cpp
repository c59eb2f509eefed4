#include "client/session/document_replica.h"

#include <utility>

namespace tandem::client {

void DocumentReplica::handle(const sync::DocumentChunk& chunk) {
  if (chunk.first) {
    // What has changed since the whole was asked for was told already, and is in no chunk.
    document::Document newer;
    for (auto at = document_.after(chunk.revision); at != document_.byRevision().end(); ++at)
      newer.put(*document_.find(at->second));
    document_ = std::move(newer);
    complete_ = false;
  }
  for (const document::Entry& entry : chunk.entries) document_.put(entry);
  complete_ = complete_ || chunk.last;
}

void DocumentReplica::connectionLost() {
  whole_ = complete_;
  complete_ = false;
}

}  // namespace tandem::client
