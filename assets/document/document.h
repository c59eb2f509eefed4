#pragma once

// The document of a session, and how a change acts on it: no clock, no network, no person's role. The server
// decides by apply(); a replica takes what was decided by put().
//
// 1. A change names the revision of the entry that its author saw. Where another change has come since, it is
//    refused and nothing changes; so no undo takes back what another has changed.
// 2. An entry that others refer to cannot be removed.
// 3. What apply() refuses leaves the document as it was.
// 4. The newest kMaxRemoved removed entries are kept, so that a removal can be taken back.

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "assets/base/result.h"
#include "assets/document/entry.h"

namespace tandem::document {

inline constexpr std::size_t kMaxEntries = 16384;  // that are not removed
inline constexpr std::size_t kMaxRemoved = 1024;
inline constexpr std::size_t kMaxBytes = std::size_t{32} << 20;  // of all bodies

enum class Refusal : std::uint8_t {
  none,
  roleForbids,
  noSuchEntry,
  changedSince,  // by another change than the one that the author saw
  referredTo,    // a removal of what another entry refers to
  full,
  unsound,  // outside the limits of its kind
  notNow    // the server cannot write its journal
};
const char* toString(Refusal refusal);

/// Who changes the document, and when.
struct By {
  SiteId site = kNoSite;
  std::string name;
  std::uint32_t request = 0;
  std::int64_t time = 0;  // Unix time, s
};

class Document {
 public:
  /// The entry, also one that was removed; null if it is not known. Valid until the next change.
  const Entry* find(EntryId id) const;
  /// By id; removed ones among them.
  const std::map<EntryId, Entry>& entries() const { return entries_; }
  /// The entries changed after `revision`, oldest change first.
  std::map<Revision, EntryId>::const_iterator after(Revision revision) const {
    return byRevision_.upper_bound(revision);
  }
  const std::map<Revision, EntryId>& byRevision() const { return byRevision_; }

  std::size_t size() const { return entries_.size() - removed_.size(); }  // that are not removed
  std::size_t bytes() const { return bytes_; }
  Revision revision() const { return revision_; }  // of the last change
  EntryId lastId() const { return lastId_; }

  struct Outcome {
    Refusal refusal = Refusal::none;
    std::string reason;     // for a person, if it was refused
    Entry entry;            // as it is now, if it was changed
    EntryId forgotten = 0;  // a removed entry that gave way to the new one
  };
  Outcome apply(const Change& change, const By& by);

  /// Takes an entry as the server has it. False if that is not newer than what is known of it.
  bool put(const Entry& entry);
  void clear() { *this = {}; }

 private:
  Outcome refuse(Refusal refusal, std::string reason) const { return {refusal, std::move(reason), {}, 0}; }
  Outcome judge(const Change& change) const;
  void store(const Entry& entry);
  void forget(EntryId id);

  std::map<EntryId, Entry> entries_;
  std::map<Revision, EntryId> byRevision_;
  std::set<Revision> removed_;             // revisions of removed entries
  std::map<EntryId, std::size_t> refers_;  // how many entries refer to one
  std::size_t bytes_ = 0;
  Revision revision_ = 0;
  EntryId lastId_ = 0;
};

}  // namespace tandem::document
