#include "server/session_database.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "assets/base/assert.h"
#include "sync/wire/limits.h"

namespace tandem::server {
namespace {

constexpr const char* kApplicationId = "1414417741";  // "TNDM"
constexpr const char* kSchemaVersion = "2";
constexpr std::uintmax_t kFrameBytes = 4096 + 24, kLogHeaderBytes = 32;

constexpr const char* kSchema = R"(
PRAGMA application_id = 1414417741;
PRAGMA user_version = 2;
CREATE TABLE head (id INTEGER PRIMARY KEY, session BLOB NOT NULL, scene TEXT NOT NULL,
  sequence INTEGER NOT NULL, chain BLOB NOT NULL, previous INTEGER NOT NULL, previous_chain BLOB NOT NULL,
  sum BLOB NOT NULL, session_time INTEGER NOT NULL, epoch_floor INTEGER NOT NULL,
  last_site INTEGER NOT NULL, checksum BLOB NOT NULL);
CREATE TABLE parts (part INTEGER PRIMARY KEY, owner INTEGER NOT NULL, epoch INTEGER NOT NULL,
  px REAL NOT NULL, py REAL NOT NULL, pz REAL NOT NULL,
  qw REAL NOT NULL, qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL,
  sequence INTEGER NOT NULL, checksum BLOB NOT NULL);
CREATE TABLE sites (site INTEGER PRIMARY KEY, role INTEGER NOT NULL, name TEXT NOT NULL,
  red INTEGER NOT NULL, green INTEGER NOT NULL, blue INTEGER NOT NULL, gone INTEGER NOT NULL,
  sequence INTEGER NOT NULL, checksum BLOB NOT NULL);
CREATE TABLE nonces (nonce TEXT PRIMARY KEY, expires INTEGER NOT NULL,
  sequence INTEGER NOT NULL, checksum BLOB NOT NULL) WITHOUT ROWID;
)";
// Tables of later versions are made here, IF NOT EXISTS, at every start: they are outside the chain, and the
// version stays.
constexpr const char* kAddedTables = "";

constexpr const char* kSelectParts =
    "SELECT part, owner, epoch, px, py, pz, qw, qx, qy, qz, sequence, checksum FROM parts ORDER BY part";
constexpr const char* kSelectSites =
    "SELECT site, role, name, red, green, blue, gone, sequence, checksum FROM sites ORDER BY site";
constexpr const char* kSelectNonces = "SELECT nonce, expires, sequence, checksum FROM nonces";

bool within(std::int64_t value, std::int64_t least, std::int64_t most) {
  return value >= least && value <= most;
}

std::optional<sync::PartRecord> partOf(const SqliteStatement& row) {
  if (!within(row.integer(0), 0, kNoPart - 1) || !within(row.integer(1), 0, 0xffff) ||
      !within(row.integer(2), 0, 0xffffffff))
    return std::nullopt;
  sync::PartRecord part;
  part.part = static_cast<PartId>(row.integer(0));
  part.owner = static_cast<SiteId>(row.integer(1));
  part.epoch = static_cast<Epoch>(row.integer(2));
  part.worldFromPart.position = glm::dvec3(row.real(3), row.real(4), row.real(5));
  part.worldFromPart.orientation = glm::dquat(row.real(6), row.real(7), row.real(8), row.real(9));
  if (!isValid(part.worldFromPart)) return std::nullopt;
  return part;
}

std::optional<SiteRecord> siteOf(const SqliteStatement& row) {
  if (!within(row.integer(0), 1, 0xffff) ||
      !within(row.integer(1), 0, static_cast<int>(sync::Role::instructor)))
    return std::nullopt;
  SiteRecord site;
  site.info.site = static_cast<SiteId>(row.integer(0));
  site.info.role = static_cast<sync::Role>(row.integer(1));
  site.info.name = row.text(2);
  for (int i = 0; i < 3; ++i) {
    if (!within(row.integer(3 + i), 0, 255)) return std::nullopt;
    site.info.colour[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(row.integer(3 + i));
  }
  site.info.connected = false;
  site.left = row.integer(6) != 0;
  if (site.info.name.size() > sync::kMaxNameLength) return std::nullopt;
  return site;
}

std::optional<UsedNonce> nonceOf(const SqliteStatement& row) {
  return UsedNonce{row.text(0), row.integer(1)};
}

Digest digestIn(const SqliteStatement& row, int column) {
  Digest digest{};
  const std::string bytes = row.text(column);
  if (bytes.size() == digest.size()) std::copy(bytes.begin(), bytes.end(), digest.begin());
  return digest;
}

std::string headBytes(const DatabaseHead& head) {
  Bytes bytes;
  bytes.text("head").digest(head.session).text(head.scene).number(head.sequence).digest(head.chain);
  bytes.number(head.previous).digest(head.previousChain).digest(head.sum.value());
  bytes.number(static_cast<std::uint64_t>(head.sessionTime)).number(head.epochFloor).number(head.lastSite);
  return bytes.view();
}

/// Whether it is a journal of this program and version, and its pages hang together.
Status checkForm(SqliteDatabase& database) {
  const Result<std::string> id = database.ask("PRAGMA application_id");
  if (!id) return id.error();
  if (*id != kApplicationId) return Error{"damaged, or a database of another program"};
  const Result<std::string> version = database.ask("PRAGMA user_version");
  if (!version) return version.error();
  if (*version != kSchemaVersion)
    return Error{"schema version " + *version + ", this server knows version " + kSchemaVersion};
  const Result<std::string> sound = database.ask("PRAGMA quick_check(1)");
  if (!sound) return sound.error();
  if (*sound != "ok") return Error{"damaged: " + *sound};
  return {};
}

Status setUp(SqliteDatabase& database, std::uint32_t maxPages) {
  const std::string settings =
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA busy_timeout = 2000;" +
      (maxPages == 0 ? std::string() : "PRAGMA max_page_count = " + std::to_string(maxPages) + ";");
  if (Status set = database.run(settings.c_str()); !set) return set;
  const Result<std::string> mode = database.ask("PRAGMA journal_mode");
  if (!mode || *mode != "wal") return Error{"the file system does not support a write-ahead log"};
  return {};
}

/// Hands each row to `read(row)`, which returns an error text, empty if the row is sound.
template <typename Read>
Status readRows(SqliteDatabase& database, const char* sql, Read read) {
  Result<SqliteStatement> rows = SqliteStatement::prepare(database, sql);
  if (!rows) return rows.error();
  for (;;) {
    const auto row = rows->next();
    if (row == SqliteStatement::Row::end) return {};
    if (row == SqliteStatement::Row::failed) return Error{database.error()};
    if (const std::string bad = read(*rows); !bad.empty()) return Error{bad};
  }
}

}  // namespace

/// The statements by which records are written.
struct SessionDatabase::Statements {
  SqliteStatement begin, commit, rollback, part, site, nonce, head;

  bool write(const sync::PartRecord& r, std::uint64_t sequence, const Digest& check) {
    const auto& p = r.worldFromPart.position;
    const auto& q = r.worldFromPart.orientation;
    part.bind(0, std::int64_t{r.part}).bind(1, std::int64_t{r.owner}).bind(2, std::int64_t{r.epoch});
    part.bind(3, p.x).bind(4, p.y).bind(5, p.z).bind(6, q.w).bind(7, q.x).bind(8, q.y).bind(9, q.z);
    return part.bind(10, static_cast<std::int64_t>(sequence)).bindBytes(11, check.data(), check.size()).run();
  }
  bool write(const SiteRecord& r, std::uint64_t sequence, const Digest& check) {
    site.bind(0, std::int64_t{r.info.site}).bind(1, static_cast<std::int64_t>(r.info.role));
    site.bind(2, r.info.name);
    for (int i = 0; i < 3; ++i) site.bind(3 + i, std::int64_t{r.info.colour[static_cast<std::size_t>(i)]});
    site.bind(6, std::int64_t{r.left}).bind(7, static_cast<std::int64_t>(sequence));
    return site.bindBytes(8, check.data(), check.size()).run();
  }
  bool write(const UsedNonce& r, std::uint64_t sequence, const Digest& check) {
    nonce.bind(0, r.nonce).bind(1, r.expires).bind(2, static_cast<std::int64_t>(sequence));
    return nonce.bindBytes(3, check.data(), check.size()).run();
  }
};

SessionDatabase::SessionDatabase(SqliteDatabase database) : database_(std::move(database)) {}
SessionDatabase::SessionDatabase(SessionDatabase&&) noexcept = default;
SessionDatabase::~SessionDatabase() = default;

Status SessionDatabase::prepareStatements() {
  statements_ = std::make_unique<Statements>();
  const struct {
    SqliteStatement* statement;
    const char* sql;
  } all[] = {
      {&statements_->begin, "BEGIN IMMEDIATE"},
      {&statements_->commit, "COMMIT"},
      {&statements_->rollback, "ROLLBACK"},
      {&statements_->part, "INSERT OR REPLACE INTO parts VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"},
      {&statements_->site, "INSERT OR REPLACE INTO sites VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"},
      {&statements_->nonce, "INSERT OR REPLACE INTO nonces VALUES (?, ?, ?, ?)"},
      {&statements_->head, "INSERT OR REPLACE INTO head VALUES (0, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"},
  };
  for (const auto& each : all) {
    Result<SqliteStatement> prepared = SqliteStatement::prepare(database_, each.sql);
    if (!prepared) return prepared.error();
    *each.statement = std::move(*prepared);
  }
  return {};
}

Result<SessionDatabase> SessionDatabase::create(const std::string& path, const DatabaseHead& head,
                                                const std::vector<JournalRecord>& records,
                                                std::uint32_t maxPages) {
  const auto failed = [&](const Error& error) { return Error{path + ": " + error.message}; };
  Result<SqliteDatabase> file = SqliteDatabase::open(path);
  if (!file) return failed(file.error());
  SessionDatabase database(std::move(*file));
  const Result<std::string> tables = database.database_.ask("SELECT count(*) FROM sqlite_schema");
  if (!tables) return failed(tables.error());
  if (*tables != "0") return failed(Error{"is there already"});
  if (Status set = setUp(database.database_, maxPages); !set) return failed(set.error());
  if (Status made = database.database_.run((std::string("BEGIN;") + kSchema + "COMMIT;").c_str()); !made)
    return failed(made.error());
  if (Status ready = database.prepareStatements(); !ready) return failed(ready.error());
  database.head_ = head;
  if (Status written = database.commit(records, 0); !written) return failed(written.error());
  for (const JournalRecord& record : records) apply(database.contents_, record);
  database.contents_.epochFloor = head.epochFloor;
  database.contents_.lastSite = head.lastSite;
  database.contents_.sessionTime = head.sessionTime;
  return database;
}

Result<SessionDatabase> SessionDatabase::open(const std::string& path, std::uint32_t maxPages) {
  const auto failed = [&](const Error& error) { return Error{path + ": " + error.message}; };
  Result<SqliteDatabase> file = SqliteDatabase::openExisting(path);
  if (!file) return failed(file.error());
  SessionDatabase database(std::move(*file));
  if (Status form = checkForm(database.database_); !form) return failed(form.error());
  if (Status set = setUp(database.database_, maxPages); !set) return failed(set.error());
  if (Status read = database.readHead(); !read) return failed(read.error());
  if (Status read = database.readTables(); !read) return failed(read.error());
  if (*kAddedTables != '\0')
    if (Status added = database.database_.run(kAddedTables); !added) return failed(added.error());
  if (Status ready = database.prepareStatements(); !ready) return failed(ready.error());
  database.attempted_ = database.head_;
  return database;
}

Status SessionDatabase::readHead() {
  int count = 0;
  Digest sum{};
  Status read =
      readRows(database_,
               "SELECT session, scene, sequence, chain, previous, previous_chain, session_time, epoch_floor, "
               "last_site, sum, checksum FROM head",
               [&](const SqliteStatement& row) {
                 ++count;
                 head_.session = digestIn(row, 0);
                 head_.scene = row.text(1);
                 head_.sequence = static_cast<std::uint64_t>(row.integer(2));
                 head_.chain = digestIn(row, 3);
                 head_.previous = static_cast<std::uint64_t>(row.integer(4));
                 head_.previousChain = digestIn(row, 5);
                 head_.sessionTime = row.integer(6);
                 head_.epochFloor = static_cast<Epoch>(row.integer(7));
                 head_.lastSite = static_cast<SiteId>(row.integer(8));
                 sum = digestIn(row, 9);
                 head_.sum = DigestSum();
                 head_.sum.add(sum);
                 const bool sound = digestOf(headBytes(head_)) == digestIn(row, 10) && head_.sessionTime >= 0;
                 return sound ? std::string() : "damaged: the row of table head has a wrong checksum";
               });
  if (read && count != 1) return Error{"damaged: table head has " + std::to_string(count) + " rows, not 1"};
  return read;
}

Status SessionDatabase::readTables() {
  DigestSum sum;
  const auto check = [&](const SqliteStatement& row, auto value, int at, const char* table,
                         const std::string& name) {
    const std::string where = std::string("damaged: row ") + name + " of table " + table;
    if (!value) return where + " holds a value out of range";
    const Digest digest = digestOf(*value, static_cast<std::uint64_t>(row.integer(at)), head_.session);
    if (digest != digestIn(row, at + 1)) return where + " has a wrong checksum";
    sum.add(digest);
    return std::string();
  };
  Status read = readRows(database_, kSelectParts, [&](const SqliteStatement& row) {
    const auto part = partOf(row);
    std::string bad = check(row, part, 10, "parts", std::to_string(row.integer(0)));
    if (!bad.empty()) return bad;
    rows_.parts[part->part] = digestIn(row, 11);
    contents_.parts.push_back(*part);
    return bad;
  });
  if (!read) return read;
  read = readRows(database_, kSelectSites, [&](const SqliteStatement& row) {
    const auto site = siteOf(row);
    std::string bad = check(row, site, 7, "sites", std::to_string(row.integer(0)));
    if (!bad.empty()) return bad;
    rows_.sites[site->info.site] = digestIn(row, 8);
    contents_.sites.push_back(*site);
    return bad;
  });
  if (!read) return read;
  read = readRows(database_, kSelectNonces, [&](const SqliteStatement& row) {
    const auto nonce = nonceOf(row);
    std::string bad = check(row, nonce, 2, "nonces", nonce->nonce.substr(0, 32));
    if (!bad.empty()) return bad;
    rows_.nonces[nonce->nonce] = digestIn(row, 3);
    contents_.nonces.push_back(*nonce);
    return bad;
  });
  if (!read) return read;
  if (!(sum == head_.sum))
    return Error{"damaged: rows are missing or older than commit " + std::to_string(head_.sequence)};
  contents_.sessionTime = head_.sessionTime;
  contents_.epochFloor = head_.epochFloor;
  contents_.lastSite = head_.lastSite;
  return {};
}

Status SessionDatabase::write(const JournalRecord& record, std::uint64_t sequence, Rows& staged,
                              DatabaseHead& next) {
  const Digest check = digestOf(record, sequence, head_.session);
  const auto replace = [&](auto& committed, auto& changed, const auto& key) {
    if (const auto at = changed.find(key); at != changed.end())
      next.sum.remove(at->second);
    else if (const auto old = committed.find(key); old != committed.end())
      next.sum.remove(old->second);
    next.sum.add(check);
    changed[key] = check;
  };
  if (const auto* part = std::get_if<sync::PartRecord>(&record))
    replace(rows_.parts, staged.parts, std::uint32_t{part->part});
  else if (const auto* site = std::get_if<SiteRecord>(&record))
    replace(rows_.sites, staged.sites, std::uint32_t{site->info.site});
  else if (const auto* nonce = std::get_if<UsedNonce>(&record))
    replace(rows_.nonces, staged.nonces, nonce->nonce);
  if (!std::visit([&](const auto& r) { return statements_->write(r, sequence, check); }, record))
    return Error{database_.error()};
  return {};
}

Status SessionDatabase::writeHead(DatabaseHead& next, const std::string& written) {
  Bytes link;
  link.digest(head_.chain).text(written).number(static_cast<std::uint64_t>(next.sessionTime));
  next.previous = head_.sequence;
  next.previousChain = head_.chain;
  next.chain = digestOf(link.view());
  attempted_ = next;
  const Digest check = digestOf(headBytes(next)), sum = next.sum.value();
  SqliteStatement& head = statements_->head;
  head.bindBytes(0, next.session.data(), next.session.size()).bind(1, next.scene);
  head.bind(2, static_cast<std::int64_t>(next.sequence)).bindBytes(3, next.chain.data(), next.chain.size());
  head.bind(4, static_cast<std::int64_t>(next.previous));
  head.bindBytes(5, next.previousChain.data(), next.previousChain.size());
  head.bindBytes(6, sum.data(), sum.size()).bind(7, std::int64_t{next.sessionTime});
  head.bind(8, std::int64_t{next.epochFloor}).bind(9, std::int64_t{next.lastSite});
  if (!head.bindBytes(10, check.data(), check.size()).run() || !statements_->commit.run())
    return Error{database_.error()};
  return {};
}

Status SessionDatabase::commit(const std::vector<JournalRecord>& records, sync::Micros sessionTime) {
  DatabaseHead next = head_;
  attempted_ = head_;
  Rows staged;
  ++next.sequence;
  if (sessionTime != 0) next.sessionTime = sessionTime;
  const auto write = [&]() -> Status {
    if (!statements_->begin.run()) return Error{database_.error()};
    for (const JournalRecord& record : records)
      if (Status written = this->write(record, next.sequence, staged, next); !written) return written;
    Bytes link;
    link.digest(next.sum.value()).number(next.sequence);
    return writeHead(next, link.view());
  };
  if (Status written = write(); !written) {
    statements_->rollback.run();
    return written;
  }
  head_ = next;
  for (const auto& [part, digest] : staged.parts) rows_.parts[part] = digest;
  for (const auto& [site, digest] : staged.sites) rows_.sites[site] = digest;
  for (auto& [nonce, digest] : staged.nonces) rows_.nonces[nonce] = digest;
  return {};
}

Status SessionDatabase::prepare(const std::string& scene, std::int64_t unixNow) {
  if (!head_.scene.empty() && head_.scene != scene)
    return Error{"belongs to another scene (" + head_.scene.substr(0, 12) + "..., this one is " +
                 scene.substr(0, 12) + "...): choose another --data"};
  const auto expired = [&](const UsedNonce& nonce) { return nonce.expires <= unixNow; };
  if (head_.scene == scene && std::none_of(contents_.nonces.begin(), contents_.nonces.end(), expired))
    return {};
  DatabaseHead next = head_;
  next.scene = scene;
  ++next.sequence;
  if (!statements_->begin.run()) return Error{database_.error()};
  for (const UsedNonce& nonce : contents_.nonces)
    if (expired(nonce)) next.sum.remove(rows_.nonces[nonce.nonce]);
  const std::string sql = "DELETE FROM nonces WHERE expires <= " + std::to_string(unixNow);
  Status written = database_.run(sql.c_str());
  Bytes link;
  link.digest(next.sum.value()).number(next.sequence).text(scene);
  if (written) written = writeHead(next, link.view());
  if (!written) {
    statements_->rollback.run();
    return written;
  }
  head_ = next;
  for (const UsedNonce& nonce : contents_.nonces)
    if (expired(nonce)) rows_.nonces.erase(nonce.nonce);
  std::erase_if(contents_.nonces, expired);
  return {};
}

Salvage SessionDatabase::salvage(const std::string& path) {
  Salvage found;
  const auto note = [&](const std::string& damage) {
    if (found.damage.empty()) found.damage = damage;
  };
  Result<SqliteDatabase> file = SqliteDatabase::openExisting(path);
  if (!file) {
    note(path + ": " + file.error().message);
    return found;
  }
  SessionDatabase database(std::move(*file));
  if (Status form = checkForm(database.database_); !form) note(path + ": " + form.error().message);
  const Status head = database.readHead();
  if (!head) note(path + ": " + head.error().message);
  found.headSound = head.ok();
  found.session = database.head_.session;
  if (found.headSound) {
    found.scene = database.head_.scene;
    found.contents.sessionTime = database.head_.sessionTime;
    found.contents.epochFloor = database.head_.epochFloor;
    found.contents.lastSite = database.head_.lastSite;
  }
  // A row is taken only if its own checksum holds; for that the session's identity must be known.
  const auto take = [&](const SqliteStatement& row, auto value, int at, auto& into) {
    const bool sound =
        value && found.headSound &&
        digestOf(*value, static_cast<std::uint64_t>(row.integer(at)), found.session) == digestIn(row, at + 1);
    if (sound)
      into.push_back(*value);
    else
      ++found.damagedRows;
    return std::string();
  };
  const auto parts = [&](const SqliteStatement& row) {
    return take(row, partOf(row), 10, found.contents.parts);
  };
  const auto sites = [&](const SqliteStatement& row) {
    return take(row, siteOf(row), 7, found.contents.sites);
  };
  if (Status read = readRows(database.database_, kSelectParts, parts); !read) note(read.error().message);
  if (Status read = readRows(database.database_, kSelectSites, sites); !read) note(read.error().message);
  if (found.damagedRows > 0) note(path + ": " + std::to_string(found.damagedRows) + " rows are damaged");
  return found;
}

/// Writes zeros behind the log's end, once, so that a commit finds its blocks in place: fdatasync then has no
/// new file size or block map to write, which would be a second access to the disk. SQLite reads zeros as the
/// end of the log (they have no valid checksum), and its locks are on other files.
Status SessionDatabase::growLog(const std::string& path, int frames) {
  const int file = ::open((path + "-wal").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) return Error{std::strerror(errno)};
  struct stat now {};
  bool good = ::fstat(file, &now) == 0;
  const std::vector<char> zeros(std::size_t{64} * 1024, 0);
  const auto wanted = static_cast<off_t>(kLogHeaderBytes + static_cast<std::uintmax_t>(frames) * kFrameBytes);
  for (off_t at = now.st_size; good && at < wanted;) {
    const auto size = std::min(zeros.size(), static_cast<std::size_t>(wanted - at));
    const ssize_t written = ::pwrite(file, zeros.data(), size, at);
    good = written > 0;
    at += written;
  }
  good = good && ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  return good ? Status{} : Error{std::string("write-ahead log: ") + std::strerror(error)};
}

}  // namespace tandem::server
