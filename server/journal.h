#pragma once

// What must survive a crash of the server: epochs, owners, poses, sites, used tokens. Written before the reply that
// depends on it (S1, S7, S8).
//
// One thread calls; a journal may write in a thread of its own. An append is durable once durableUpTo() has reached its
// number; replies wait for that, the network thread does not.

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "sync/messages.h"

namespace tandem::server {

/// A site that was admitted; it may come back with its ticket.
struct SiteRecord {
  sync::SiteInfo info;
};
/// A token's nonce that was used.
struct UsedNonce {
  std::string nonce;
  std::int64_t expires = 0;   // Unix time in s: forgotten after that
};
using JournalRecord = std::variant<sync::PartRecord, SiteRecord, UsedNonce>;

/// Everything that a journal held when it was opened.
struct JournalContents {
  std::vector<sync::PartRecord> parts;
  std::vector<SiteRecord> sites;
  std::vector<UsedNonce> nonces;
  sync::Micros sessionTime = 0;   // at least as late as any time given out before the crash
};

class Journal {
 public:
  virtual ~Journal() = default;
  virtual JournalContents contents() const = 0;
  /// Queues a record; returns its number, counted from 1.
  virtual std::uint64_t append(const JournalRecord& record) = 0;
  /// Session time has reached this: on reopening it continues from no earlier (kept a little ahead).
  virtual void noteTime(sync::Micros sessionTime) = 0;
  /// The number of the last record that is safe.
  virtual std::uint64_t durableUpTo() = 0;
};

}  // namespace tandem::server
