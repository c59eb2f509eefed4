#pragma once

// What a connection to the server is started with.

#include <cstdint>
#include <string>

#include "client/session/doubts.h"
#include "client/session/state_publisher.h"
#include "sync/replica/lease_rules.h"
#include "sync/wire/site_colours.h"

namespace tandem::client {

struct ConnectionOptions {
  std::string name = "site";
  sync::SiteColour colour = sync::kAnyColour;
  std::string token;  // of the join link
  PublishRates rates;
  DoubtLimits doubts;
  sync::Micros pingInterval = 100 * sync::kMillisecond;
  sync::Micros retryFirst = 100 * sync::kMillisecond, retryLongest = 2 * sync::kSecond;
  std::uint64_t maxSceneBytes = std::uint64_t{2} << 30;  // of the scene package; a larger one is not fetched
  sync::LeaseRules lease;                                // the length is replaced by the server's
};

}  // namespace tandem::client
