#pragma once

// What must survive a crash of the server: epochs, owners, poses, sites, used tokens, the document, what was
// said. Written before the reply that depends on it (S1, S7, S8).
//
// One thread calls; a journal may write in a thread of its own. An append is durable once durableUpTo() has
// reached its number; replies wait for that, the network thread does not.

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "assets/document/entry.h"
#include "sync/wire/limits.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/presentation_messages.h"
#include "sync/wire/time.h"

namespace tandem::server {

/// A site that was admitted; it may come back with its ticket unless it sent a Goodbye. Its number is never
/// used again.
struct SiteRecord {
  sync::SiteInfo info;
  bool left = false;
};
/// A token's nonce that was used. None is ever forgotten: a wall clock that ran ahead and is put back makes
/// expired tokens good again. There are no more of them than numbers of sites.
struct UsedNonce {
  std::string nonce;
  std::int64_t expires = 0;  // Unix time in s
};
/// An entry of the document as a change has left it.
struct DocumentRecord {
  document::Entry entry;
  document::EntryId forgotten = 0;  // a removed entry that is kept no longer; 0: none
};
/// A line that somebody said. The newest kMaxSaidLines are kept: a line takes the place of the one that many
/// before it.
struct SaidRecord {
  sync::SaidLine line;
  std::uint64_t slot() const { return line.number % sync::kMaxSaidLines; }
};
using JournalRecord = std::variant<sync::PartRecord, SiteRecord, UsedNonce, DocumentRecord, SaidRecord>;

/// Everything that a journal held when it was opened.
struct JournalContents {
  std::vector<sync::PartRecord> parts;
  std::vector<SiteRecord> sites;
  std::vector<UsedNonce> nonces;
  std::map<document::EntryId, document::Entry> document;
  std::map<std::uint64_t, sync::SaidLine> said;  // by slot
  sync::Micros sessionTime = 0;                  // at least as late as any time given out before the crash
  Epoch epochFloor = 0;  // at least as high as any epoch told that the records may have lost
  SiteId lastSite = 0;   // at least as high as any number of a site that they may have lost
};

/// Puts a record into what a journal holds: the latest of each part, site, nonce, entry and
/// slot wins.
void apply(JournalContents& contents, const JournalRecord& record);

class Journal {
 public:
  virtual ~Journal() = default;
  virtual JournalContents contents() const = 0;
  /// Queues a record; returns its number, counted from 1.
  virtual std::uint64_t append(const JournalRecord& record) = 0;
  /// Session time has reached this: on reopening it continues from no earlier. Called often; a journal that
  /// writes to a disk keeps a time a little ahead instead and writes seldom.
  virtual void noteTime(sync::Micros sessionTime) = 0;
  /// The number of the last record that is safe.
  virtual std::uint64_t durableUpTo() = 0;
  /// Why nothing becomes durable (disk full, directory gone, ...), in one line; empty while all is well. A
  /// journal that is well again has first written everything that was appended, also while it had failed.
  virtual std::string failure() const { return {}; }
};

}  // namespace tandem::server
