#pragma once

// Topics as one HTML page that needs nothing else: style and pictures are inside. It runs no script and loads
// nothing, which its content security policy makes sure of.

#include <string>
#include <vector>

#include "client/exchange/topic.h"

namespace tandem::client {

std::string topicPage(const std::string& title, const std::vector<Topic>& topics);

}  // namespace tandem::client
