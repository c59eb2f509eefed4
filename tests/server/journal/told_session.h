#pragma once

// What was told of a session, noted beside the code under test, and whether a start continues with no less.

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "server/journal/journal.h"
#include "server/journal/sqlite_database.h"

namespace tandem::server {

/// All that sites could know of a session. A part that was asked for and never told has epoch 0.
struct Told {
  std::map<PartId, std::pair<Epoch, SiteId>> parts;
  std::set<std::string> nonces;
  SiteId lastSite = 0;
  Epoch highest = 0;
};

/// Why a start must not have continued as it did; empty if it may.
inline std::string wrong(const JournalContents& now, const Told& told) {
  std::map<PartId, sync::PartRecord> parts;
  for (const auto& part : now.parts) parts[part.part] = part;
  std::set<std::string> nonces;
  for (const auto& nonce : now.nonces) nonces.insert(nonce.nonce);
  for (const auto& [part, known] : told.parts) {
    if (known.first == 0) continue;
    const auto at = parts.find(part);
    if (at == parts.end()) return "part " + std::to_string(part) + " is forgotten";
    if (at->second.epoch < known.first) return "part " + std::to_string(part) + " is back in an older epoch";
    if (at->second.epoch == known.first && at->second.owner != known.second)
      return "part " + std::to_string(part) + " has another owner";
  }
  for (const auto& part : now.parts)
    if (!told.parts.contains(part.part)) return "part " + std::to_string(part.part) + " is invented";
  for (const std::string& nonce : told.nonces)
    if (!nonces.contains(nonce)) return "token " + nonce + " is good again";
  return {};
}

/// What a server would continue with that trusts its database, as one without checksums and mark does.
inline std::string wrongWithoutChecks(const std::filesystem::path& folder, const Told& told) {
  auto database = SqliteDatabase::openExisting((folder / "session.db").string());
  if (!database) return {};
  JournalContents contents;
  const auto read = [&](const char* sql, auto take) {
    auto rows = SqliteStatement::prepare(*database, sql);
    if (!rows) return false;
    auto row = rows->next();
    for (; row == SqliteStatement::Row::row; row = rows->next()) take(*rows);
    return row == SqliteStatement::Row::end;
  };
  const bool readable = read("SELECT part, owner, epoch FROM parts",
                             [&](const SqliteStatement& row) {
                               contents.parts.push_back({static_cast<PartId>(row.integer(0)),
                                                         static_cast<SiteId>(row.integer(1)),
                                                         static_cast<Epoch>(row.integer(2)),
                                                         {}});
                             }) &&
                        read("SELECT nonce FROM nonces", [&](const SqliteStatement& row) {
                          contents.nonces.push_back({row.text(0), 0});
                        });
  return readable ? wrong(contents, told) : std::string();
}

}  // namespace tandem::server
