#pragma once

// Rows of a session's tables as records. The first columns of a table are the same in every version of the
// schema; a row with a value out of range is no record.

#include <cstdint>
#include <optional>
#include <string>

#include "assets/base/result.h"
#include "server/journal/journal.h"
#include "server/journal/record_digest.h"
#include "server/journal/sqlite_database.h"

namespace tandem::server {

/// part, owner, epoch, px, py, pz, qw, qx, qy, qz.
std::optional<sync::PartRecord> partOf(const SqliteStatement& row);
/// site, role, name, red, green, blue, gone.
std::optional<SiteRecord> siteOf(const SqliteStatement& row);
/// nonce, expires.
std::optional<UsedNonce> nonceOf(const SqliteStatement& row);
/// entry, bytes.
std::optional<DocumentRecord> entryOf(const SqliteStatement& row);
/// slot, number, at, site, name, words, parts.
std::optional<SaidRecord> saidOf(const SqliteStatement& row);
/// The parts of a line as their column has them.
std::string partBytesOf(const sync::SaidLine& line);
/// Zeros if the column holds something else.
Digest digestIn(const SqliteStatement& row, int column);

/// Hands each row to `read(row)`, which returns an error text, empty if the row is sound.
template <typename Read>
Status readRows(const SqliteDatabase& database, const char* sql, Read read) {
  Result<SqliteStatement> rows = SqliteStatement::prepare(database, sql);
  if (!rows) return rows.error();
  for (;;) {
    const auto row = rows->next();
    if (row == SqliteStatement::Row::end) return {};
    if (row == SqliteStatement::Row::failed) return Error{database.error()};
    if (const std::string bad = read(*rows); !bad.empty()) return Error{bad};
  }
}

/// What a database of schema version 1 holds; its rows have no checksums.
struct Version1 {
  JournalContents contents;
  std::string scene;
};
Result<Version1> readVersion1(SqliteDatabase& database);

}  // namespace tandem::server
