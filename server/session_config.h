#pragma once

// What a session is started with.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "server/admission.h"
#include "server/places.h"
#include "sync/replica/lease_rules.h"

namespace tandem::server {

struct SessionConfig {
  sync::LeaseRules lease;
  SigningKey key;                     // of resume tickets
  std::optional<SigningKey> linkKey;  // of join tokens; none: the same
  Places places;
  std::string voiceUrl;                       // told to all who join; empty: none
  std::size_t chunkBytes = 32 * 1024;         // of the scene transfer
  std::size_t maxBacklogBytes = 512 * 1024;   // queued to a loading site before the next chunk waits
  std::int64_t ticketLifetime_s = 24 * 3600;  // of resume tickets
};

}  // namespace tandem::server
