#pragma once

// What a file of topics that came back changes in the document. A topic is known again by its GUID; one of
// another program by its text, a verdict by its parts, a view by its name.
//
// 1. Nothing is removed. A topic or comment that is not in the file stays as it is.
// 2. What has changed in the session after the file's own date of change stays as it is, and is counted.
// 3. Who wrote a text elsewhere stands before it, in brackets: an entry's author is who brings it in.
// 4. The same file again changes nothing, unless it is dated later than it was brought in first.

#include <string>
#include <vector>

#include "client/exchange/document_topics.h"

namespace tandem::client {

struct TopicChanges {
  /// For a DocumentImport. Those with a revision are the session's, as they shall be; the others are new.
  std::vector<document::Entry> entries;
  std::size_t kept = 0;  // topics and comments that the session has changed since
};

/// `there`: the session as it is. `name`: who brings the topics in.
TopicChanges changesOf(const std::vector<Topic>& topics, const TopicSource& there, const std::string& name);

}  // namespace tandem::client
