#pragma once

// The tables of a session's database, and how they are read. For session_database.cpp only.

namespace tandem::server {

inline constexpr const char* kSchema = R"(
PRAGMA application_id = 1414417741;
PRAGMA user_version = 5;
CREATE TABLE head (id INTEGER PRIMARY KEY, session BLOB NOT NULL, scene TEXT NOT NULL,
  sequence INTEGER NOT NULL, previous_chain BLOB NOT NULL, sum BLOB NOT NULL, session_time INTEGER NOT NULL,
  epoch_floor INTEGER NOT NULL, last_site INTEGER NOT NULL, chain BLOB NOT NULL);
CREATE TABLE parts (part INTEGER PRIMARY KEY, owner INTEGER NOT NULL, epoch INTEGER NOT NULL,
  px REAL NOT NULL, py REAL NOT NULL, pz REAL NOT NULL,
  qw REAL NOT NULL, qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL,
  sequence INTEGER NOT NULL, checksum BLOB NOT NULL, head BLOB NOT NULL);
CREATE TABLE sites (site INTEGER PRIMARY KEY, role INTEGER NOT NULL, name TEXT NOT NULL,
  red INTEGER NOT NULL, green INTEGER NOT NULL, blue INTEGER NOT NULL, gone INTEGER NOT NULL,
  sequence INTEGER NOT NULL, checksum BLOB NOT NULL, head BLOB NOT NULL);
CREATE TABLE nonces (nonce TEXT PRIMARY KEY, expires INTEGER NOT NULL,
  sequence INTEGER NOT NULL, checksum BLOB NOT NULL, head BLOB NOT NULL) WITHOUT ROWID;
)";
// Version 4 added the document, version 5 what was said; `parts` has two bytes a part, the low one first.
inline constexpr const char* kDocumentSchema =
    "CREATE TABLE document (entry INTEGER PRIMARY KEY, bytes BLOB NOT NULL, "
    "sequence INTEGER NOT NULL, checksum BLOB NOT NULL, head BLOB NOT NULL);";
inline constexpr const char* kSaidSchema =
    "CREATE TABLE said (slot INTEGER PRIMARY KEY, number INTEGER NOT NULL, at INTEGER NOT NULL, "
    "site INTEGER NOT NULL, name TEXT NOT NULL, words TEXT NOT NULL, parts BLOB NOT NULL, "
    "sequence INTEGER NOT NULL, checksum BLOB NOT NULL, head BLOB NOT NULL);";
inline constexpr int kVersionWithoutDocument = 3, kVersionWithoutSaid = 4;
inline constexpr const char* kSelectParts =
    "SELECT part, owner, epoch, px, py, pz, qw, qx, qy, qz, sequence, checksum, head FROM parts ORDER BY "
    "part";
inline constexpr const char* kSelectSites =
    "SELECT site, role, name, red, green, blue, gone, sequence, checksum, head FROM sites ORDER BY site";
inline constexpr const char* kSelectNonces = "SELECT nonce, expires, sequence, checksum, head FROM nonces";
inline constexpr const char* kSelectDocument =
    "SELECT entry, bytes, sequence, checksum, head FROM document ORDER BY entry";
inline constexpr const char* kSelectSaid =
    "SELECT slot, number, at, site, name, words, parts, sequence, checksum, head FROM said ORDER BY slot";

}  // namespace tandem::server
