#pragma once

// The database of a session on a disk: tables of parts, sites, used tokens, entries of the document and what
// was said, with checksums.
//
// 1. Every row has the number of the commit that wrote it, and a checksum over that number, its values and
//    the session's identity: a page of another session is found.
// 2. Every commit ends in a head: the sum of all checksums, the session's time, and a hash over these and the
//    hash of the head before. A page that is older than the others is found by the sum, another history by
//    the chain of hashes.
// 3. The head of a commit stands in the last row that it wrote, so that a grant changes one page. The table
//    `head` holds what seldom changes, and the head of a commit that wrote no row.
// 4. open() verifies all of it, and names the table and the row that is damaged.

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "assets/base/result.h"
#include "server/journal/database_head.h"
#include "server/journal/journal.h"
#include "server/journal/record_digest.h"
#include "server/journal/session_rows.h"
#include "server/journal/sqlite_database.h"

namespace tandem::server {

/// What a damaged database still holds.
struct Salvage {
  JournalContents contents;
  std::string scene;
  std::size_t damagedRows = 0;
  std::string damage;  // the first that was met; empty: none
  bool headSound = false;
  bool newer = false;  // of a later schema version
  Digest session{};
};

class SessionDatabase {
 public:
  static constexpr int kSchemaVersion = 5;

  static Result<SessionDatabase> create(const std::string& path, const DatabaseHead& head,
                                        const std::vector<JournalRecord>& records,
                                        std::uint32_t maxPages = 0);
  /// Opens a database that must be there, and verifies it.
  static Result<SessionDatabase> open(const std::string& path, std::uint32_t maxPages = 0);
  /// The schema version of a database that must be there; an error where it is none of this program.
  static Result<int> versionOf(const std::string& path);
  /// Reads a database of schema version 1.
  static Result<Version1> readVersion1(const std::string& path);
  /// Puts tables of this version in place of those of version 1, in one transaction.
  static Status migrate(const std::string& path, const DatabaseHead& head,
                        const std::vector<JournalRecord>& records);
  /// Reads what is sound in a database that may be damaged, also one of version 1.
  static Salvage salvage(const std::string& path);

  const DatabaseHead& head() const { return head_; }
  /// The head that the last commit() meant to leave, also where it failed.
  const DatabaseHead& attempted() const { return attempted_; }
  /// What it held when it was opened.
  const JournalContents& contents() const { return contents_; }
  /// Writes records, and a time unless it is 0, as one transaction. Any failure undoes all of it.
  Status commit(const std::vector<JournalRecord>& records, sync::Micros sessionTime);
  /// Takes the scene if it has none; an error if it has another.
  Status takeScene(const std::string& scene);
  /// Grows the write-ahead log once, so that commits find their blocks in place.
  Status growLog(const std::string& path, int frames);
  SqliteDatabase& sqlite() { return database_; }

 private:
  struct Rows {
    std::unordered_map<std::uint32_t, Digest> parts, sites;
    std::unordered_map<std::string, Digest> nonces;
    std::unordered_map<document::EntryId, Digest> document;
    std::unordered_map<std::uint64_t, Digest> said;  // by slot
    std::vector<document::EntryId> forgotten;        // rows that a commit removes
  };
  struct Statements;
  struct LastRow;
  explicit SessionDatabase(SqliteDatabase database);

 public:
  SessionDatabase(SessionDatabase&&) noexcept;
  SessionDatabase& operator=(SessionDatabase&&) = delete;
  ~SessionDatabase();

 private:
  Status fill(const DatabaseHead& head, const std::vector<JournalRecord>& records);
  Status readHead();
  Status readTables(LastRow& last, DigestSum& sum);
  Status takeHeadOf(const LastRow& last);
  void takeContentsOfHead();
  Status addTables();
  DatabaseHead successor() const;
  void countEntry(const DocumentRecord& change, const Digest& check, Rows& staged, DatabaseHead& next) const;
  Digest count(const JournalRecord& record, Rows& staged, DatabaseHead& next) const;
  Status write(const JournalRecord& record, const Digest& check, std::uint64_t sequence,
               const std::string& head);
  void adopt(const DatabaseHead& next, const Rows& staged);
  Status prepareStatements();

  SqliteDatabase database_;
  std::unique_ptr<Statements> statements_;
  DatabaseHead head_, attempted_;
  Rows rows_;
  JournalContents contents_;
};

}  // namespace tandem::server
