#pragma once

// What a session has to say of who came, went, was refused or was made to go, for the audit log. It is
// bounded in every step, because the caller need not drain it and strangers decide how often they are
// refused.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/base/ids.h"
#include "sync/wire/time.h"

namespace tandem::server {

enum class AuditEvent : std::uint8_t {
  joined,
  returned,  // with its ticket
  refused,   // before it had a place
  left,
  lost,     // its connection ended; it may come back
  parted,   // the server ended its connection, with the reason
  revoked,  // a part was taken away from its owner
  reset,
  kicked,
  banned,
  invited,  // a link was made on request
  linksRevoked,
  ticketRevoked,
  keysRotated,
  doubted,  // another site does not believe its motion
};
inline constexpr int kAuditEvents = static_cast<int>(AuditEvent::doubted) + 1;
const char* toString(AuditEvent event);

struct AuditEntry {
  AuditEvent event = AuditEvent::joined;
  std::int64_t unixTime = 0;  // s
  SiteId site = kNoSite;      // kNoSite: a stranger, or the operator
  std::string name;           // as the site gave it; empty if it gave none
  std::string role;           // empty: not known
  std::string address;        // empty: not known
  std::string detail;         // one line
};

class AuditTrail {
 public:
  static constexpr double kRefusals = 100.0;         // entries of refusals at once
  static constexpr double kRefusalsPerSecond = 5.0;  // after that; others are counted

  void note(AuditEntry entry, sync::Micros now);
  /// The entries since the last call. Refusals that were only counted come as one entry, when there is room
  /// for refusals again.
  std::vector<AuditEntry> drain(sync::Micros now);

 private:
  void refill(sync::Micros now);

  std::vector<AuditEntry> entries_;
  double allowance_ = kRefusals;
  sync::Micros at_ = 0;         // when `allowance_` was right
  std::uint64_t unlisted_ = 0;  // without an entry of its own
  AuditEntry latestUnlisted_;
};

}  // namespace tandem::server
