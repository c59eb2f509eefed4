#include "server/audit_trail.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr std::size_t kMaxEntries = 4096;  // between two calls of drain()

}  // namespace

const char* toString(AuditEvent event) {
  constexpr const char* names[] = {"joined",  "returned",      "refused",        "left",         "lost",
                                   "parted",  "revoked",       "reset",          "kicked",       "banned",
                                   "invited", "links revoked", "ticket revoked", "keys rotated", "doubted"};
  static_assert(std::size(names) == kAuditEvents);
  ASSERT(static_cast<int>(event) < kAuditEvents);
  return names[static_cast<int>(event)];
}

void AuditTrail::refill(sync::Micros now) {
  ASSERT(now >= at_);
  allowance_ = std::min(kRefusals, allowance_ + sync::toSeconds(now - at_) * kRefusalsPerSecond);
  at_ = now;
}

void AuditTrail::note(AuditEntry entry, sync::Micros now) {
  refill(now);
  const bool refusal = entry.event == AuditEvent::refused;
  if ((refusal && allowance_ < 1.0) || entries_.size() >= kMaxEntries) {
    ++unlisted_;
    latestUnlisted_ = std::move(entry);
    return;
  }
  if (refusal) allowance_ -= 1.0;
  entries_.push_back(std::move(entry));
}

std::vector<AuditEntry> AuditTrail::drain(sync::Micros now) {
  refill(now);
  if (unlisted_ > 0 && allowance_ >= kRefusalsPerSecond) {
    allowance_ -= 1.0;
    latestUnlisted_.detail = std::to_string(unlisted_) + " more, the last: " + latestUnlisted_.detail;
    unlisted_ = 0;
    entries_.push_back(std::move(latestUnlisted_));
  }
  return std::exchange(entries_, {});
}

}  // namespace tandem::server
