#pragma once

// How many sites a session has room for, by role.
//
// 1. A place belongs to a connection: it is free as soon as the connection ends, and a site that comes back
//    takes a free one. The newest connection of a site takes the place of the older one.
// 2. Observers take no place of those who may hold parts, and the reverse.
// 3. Participants and instructors share their places. One more is kept for an instructor, whoever else is
//    there, so that somebody can always come in who may revoke and reset.

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "sync/wire/limits.h"
#include "sync/wire/participant_messages.h"

namespace tandem::server {

/// Sites that are connected, by sync::Role.
using RoleCounts = std::array<std::size_t, 3>;

struct Places {
  static constexpr std::size_t kDefaultParticipants = 64;
  static constexpr std::size_t kForInstructor = 1;

  std::size_t participants = kDefaultParticipants;  // shared with instructors, without the one kept
  std::size_t observers = sync::kMaxSites - kForInstructor - kDefaultParticipants;

  /// Whether a session can list so many sites.
  bool fit() const { return participants + observers + kForInstructor <= sync::kMaxSites; }
  /// Why a site of this role cannot come in beside those who are there; nothing if it can.
  std::optional<std::string> refusal(sync::Role role, const RoleCounts& there) const;
};

}  // namespace tandem::server
