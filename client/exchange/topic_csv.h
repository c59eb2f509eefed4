#pragma once

// Topics as a table for spreadsheets: RFC 4180, UTF-8, a row a topic. Places, cameras and their directions
// are in world axes (+y up), m.

#include <string>
#include <vector>

#include "client/exchange/topic.h"

namespace tandem::client {

/// A text that a spreadsheet would take for a formula gets an apostrophe before it, which makes it a text.
std::string topicCsv(const std::vector<Topic>& topics);

}  // namespace tandem::client
