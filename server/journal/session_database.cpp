#include "server/journal/session_database.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "server/journal/session_rows.h"
#include "server/journal/session_schema.h"
#include "sync/wire/document_codec.h"

namespace tandem::server {
namespace {

constexpr const char* kApplicationId = "1414417741";  // "TNDM"
constexpr std::uintmax_t kFrameBytes = 4096 + 24, kLogHeaderBytes = 32;

Result<int> versionOf(SqliteDatabase& database) {
  const Result<std::string> id = database.ask("PRAGMA application_id");
  if (!id) return id.error();
  if (*id != kApplicationId) return Error{"damaged, or a database of another program"};
  const Result<std::string> version = database.ask("PRAGMA user_version");
  if (!version) return version.error();
  return std::atoi(version->c_str());
}

Status checkPages(SqliteDatabase& database) {
  const Result<std::string> sound = database.ask("PRAGMA quick_check(1)");
  if (!sound) return sound.error();
  if (*sound != "ok") return Error{"damaged: " + *sound};
  return {};
}

/// Whether it is a journal of this program and a version that it reads, and its pages hang together.
Status checkForm(SqliteDatabase& database) {
  const Result<int> version = versionOf(database);
  if (!version) return version.error();
  if (*version > SessionDatabase::kSchemaVersion || *version < kVersionWithoutDocument)
    return Error{"schema version " + std::to_string(*version) + ", this server knows version " +
                 std::to_string(SessionDatabase::kSchemaVersion)};
  return checkPages(database);
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

Salvage salvageVersion1(SqliteDatabase& database, Salvage found) {
  const Result<Version1> old = readVersion1(database);
  if (!old) {
    found.damage += "; " + old.error().message;
    return found;
  }
  found.contents = old->contents;
  found.scene = old->scene;
  found.headSound = true;
  return found;
}

}  // namespace

/// The statements by which records are written.
struct SessionDatabase::Statements {
  SqliteStatement begin, commit, rollback, part, site, nonce, entry, forget, said, head;

  /// What the rows of all tables end with.
  struct Ending {
    std::uint64_t sequence = 0;
    Digest check{};
    std::string head;
  };
  static bool finish(SqliteStatement& row, int column, const Ending& ending) {
    row.bind(column, static_cast<std::int64_t>(ending.sequence));
    row.bindBytes(column + 1, ending.check.data(), ending.check.size());
    return row.bindBytes(column + 2, ending.head.data(), ending.head.size()).run();
  }
  bool write(const sync::PartRecord& r, const Ending& ending) {
    const auto& p = r.worldFromPart.position;
    const auto& q = r.worldFromPart.orientation;
    part.bind(0, std::int64_t{r.part}).bind(1, std::int64_t{r.owner}).bind(2, std::int64_t{r.epoch});
    part.bind(3, p.x).bind(4, p.y).bind(5, p.z).bind(6, q.w).bind(7, q.x).bind(8, q.y).bind(9, q.z);
    return finish(part, 10, ending);
  }
  bool write(const SiteRecord& r, const Ending& ending) {
    site.bind(0, std::int64_t{r.info.site}).bind(1, static_cast<std::int64_t>(r.info.role));
    site.bind(2, r.info.name);
    for (int i = 0; i < 3; ++i) site.bind(3 + i, std::int64_t{r.info.colour[static_cast<std::size_t>(i)]});
    return finish(site.bind(6, std::int64_t{r.left}), 7, ending);
  }
  bool write(const UsedNonce& r, const Ending& ending) {
    return finish(nonce.bind(0, r.nonce).bind(1, r.expires), 2, ending);
  }
  bool write(const DocumentRecord& r, const Ending& ending) {
    const auto id = [](document::EntryId value) { return static_cast<std::int64_t>(value); };
    if (r.forgotten != 0 && !forget.bind(0, id(r.forgotten)).run()) return false;
    const std::vector<std::uint8_t> bytes = sync::encodeEntry(r.entry);
    return finish(entry.bind(0, id(r.entry.id)).bindBytes(1, bytes.data(), bytes.size()), 2, ending);
  }
  bool write(const SaidRecord& r, const Ending& ending) {
    const sync::SaidLine& line = r.line;
    const std::string parts = partBytesOf(line);
    said.bind(0, static_cast<std::int64_t>(r.slot())).bind(1, static_cast<std::int64_t>(line.number));
    said.bind(2, line.at).bind(3, std::int64_t{line.site}).bind(4, line.name).bind(5, line.said.text);
    return finish(said.bindBytes(6, parts.data(), parts.size()), 7, ending);
  }
  bool write(const DatabaseHead& h) {
    const Digest sum = h.sum.value();
    head.bindBytes(0, h.session.data(), h.session.size()).bind(1, h.scene);
    head.bind(2, static_cast<std::int64_t>(h.sequence));
    head.bindBytes(3, h.previousChain.data(), h.previousChain.size()).bindBytes(4, sum.data(), sum.size());
    head.bind(5, std::int64_t{h.sessionTime}).bind(6, std::int64_t{h.epochFloor});
    return head.bind(7, std::int64_t{h.lastSite}).bindBytes(8, h.chain.data(), h.chain.size()).run();
  }
};

/// The row of the last commit that holds its head.
struct SessionDatabase::LastRow {
  std::uint64_t sequence = 0;
  std::string head;

  void meet(std::uint64_t rowSequence, const std::string& rowHead) {
    if (rowSequence < sequence || (rowSequence == sequence && rowHead.empty())) return;
    sequence = rowSequence;
    head = rowHead;
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
      {&statements_->part, "INSERT OR REPLACE INTO parts VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"},
      {&statements_->site, "INSERT OR REPLACE INTO sites VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"},
      {&statements_->nonce, "INSERT OR REPLACE INTO nonces VALUES (?, ?, ?, ?, ?)"},
      {&statements_->entry, "INSERT OR REPLACE INTO document VALUES (?, ?, ?, ?, ?)"},
      {&statements_->forget, "DELETE FROM document WHERE entry = ?"},
      {&statements_->said, "INSERT OR REPLACE INTO said VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"},
      {&statements_->head, "INSERT OR REPLACE INTO head VALUES (0, ?, ?, ?, ?, ?, ?, ?, ?, ?)"},
  };
  for (const auto& each : all) {
    Result<SqliteStatement> prepared = SqliteStatement::prepare(database_, each.sql);
    if (!prepared) return prepared.error();
    *each.statement = std::move(*prepared);
  }
  return {};
}

/// Makes the tables and writes them full, within a transaction that is open.
Status SessionDatabase::fill(const DatabaseHead& head, const std::vector<JournalRecord>& records) {
  const std::string schema = std::string(kSchema) + kDocumentSchema + kSaidSchema;
  if (Status made = database_.run(schema.c_str()); !made) return made;
  if (Status ready = prepareStatements(); !ready) return ready;
  head_ = head;
  DatabaseHead next = successor();
  Rows staged;
  for (const JournalRecord& record : records)
    if (Status written = write(record, count(record, staged, next), next.sequence, {}); !written)
      return written;
  next.chain = chainOf(next);
  if (!statements_->write(next) || !statements_->commit.run()) return Error{database_.error()};
  adopt(next, staged);
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
  if (Status begun = database.database_.run("BEGIN IMMEDIATE"); !begun) return failed(begun.error());
  if (Status filled = database.fill(head, records); !filled) return failed(filled.error());
  for (const JournalRecord& record : records) apply(database.contents_, record);
  database.takeContentsOfHead();
  return database;
}

Result<int> SessionDatabase::versionOf(const std::string& path) {
  Result<SqliteDatabase> file = SqliteDatabase::openExisting(path);
  Result<int> version = file ? server::versionOf(*file) : Result<int>(file.error());
  if (!version) return Error{path + ": " + version.error().message};
  return version;
}

Result<Version1> SessionDatabase::readVersion1(const std::string& path) {
  const auto failed = [&](const Error& error) { return Error{path + ": " + error.message}; };
  Result<SqliteDatabase> file = SqliteDatabase::openExisting(path);
  if (!file) return failed(file.error());
  if (Status sound = checkPages(*file); !sound) return failed(sound.error());
  Result<Version1> found = server::readVersion1(*file);
  if (!found) return failed(found.error());
  return found;
}

Status SessionDatabase::migrate(const std::string& path, const DatabaseHead& head,
                                const std::vector<JournalRecord>& records) {
  const auto failed = [&](const Error& error) { return Error{path + ": not migrated: " + error.message}; };
  Result<SqliteDatabase> file = SqliteDatabase::openExisting(path);
  if (!file) return failed(file.error());
  SessionDatabase database(std::move(*file));
  if (Status set = setUp(database.database_, 0); !set) return failed(set.error());
  constexpr const char* kDrop =
      "BEGIN IMMEDIATE; DROP TABLE meta; DROP TABLE parts; DROP TABLE sites; DROP TABLE nonces;";
  if (Status dropped = database.database_.run(kDrop); !dropped) return failed(dropped.error());
  if (Status filled = database.fill(head, records); !filled) return failed(filled.error());
  return {};
}

Result<SessionDatabase> SessionDatabase::open(const std::string& path, std::uint32_t maxPages) {
  const auto failed = [&](const Error& error) { return Error{path + ": " + error.message}; };
  Result<SqliteDatabase> file = SqliteDatabase::openExisting(path);
  if (!file) return failed(file.error());
  SessionDatabase database(std::move(*file));
  if (Status form = checkForm(database.database_); !form) return failed(form.error());
  if (Status set = setUp(database.database_, maxPages); !set) return failed(set.error());
  LastRow last;
  if (Status read = database.readHead(); !read) return failed(read.error());
  DigestSum sum;
  if (Status read = database.readTables(last, sum); !read) return failed(read.error());
  if (Status taken = database.takeHeadOf(last); !taken) return failed(taken.error());
  if (!(sum == database.head_.sum))
    return failed(
        Error{"damaged: rows are missing or older than commit " + std::to_string(database.head_.sequence)});
  database.takeContentsOfHead();
  if (Status added = database.addTables(); !added) return failed(added.error());
  if (Status ready = database.prepareStatements(); !ready) return failed(ready.error());
  database.attempted_ = database.head_;
  return database;
}

/// Gives a sound database of an older version the tables that it lacks, empty, in one transaction.
Status SessionDatabase::addTables() {
  const Result<int> version = server::versionOf(database_);
  if (!version) return version.error();
  if (*version == kSchemaVersion) return {};
  const std::string sql = std::string("BEGIN IMMEDIATE;") +
                          (*version == kVersionWithoutDocument ? kDocumentSchema : "") + kSaidSchema +
                          "PRAGMA user_version = 5; COMMIT;";
  static_assert(kSchemaVersion == 5);
  return database_.run(sql.c_str());
}

void SessionDatabase::takeContentsOfHead() {
  contents_.sessionTime = head_.sessionTime;
  contents_.epochFloor = head_.epochFloor;
  contents_.lastSite = head_.lastSite;
}

Status SessionDatabase::readHead() {
  int count = 0;
  const auto take = [&](const SqliteStatement& row) {
    ++count;
    head_.session = digestIn(row, 0);
    head_.scene = row.text(1);
    head_.sequence = static_cast<std::uint64_t>(row.integer(2));
    head_.previousChain = digestIn(row, 3);
    head_.sum = sumOf(digestIn(row, 4));
    head_.sessionTime = row.integer(5);
    head_.epochFloor = static_cast<Epoch>(row.integer(6));
    head_.lastSite = static_cast<SiteId>(row.integer(7));
    head_.chain = digestIn(row, 8);
    const bool sound = chainOf(head_) == head_.chain && head_.sessionTime >= 0;
    return sound ? std::string() : "damaged: the row of table head has a wrong checksum";
  };
  Status read = readRows(database_,
                         "SELECT session, scene, sequence, previous_chain, sum, session_time, epoch_floor, "
                         "last_site, chain FROM head",
                         take);
  if (read && count != 1) return Error{"damaged: table head has " + std::to_string(count) + " rows, not 1"};
  return read;
}

Status SessionDatabase::readTables(LastRow& last, DigestSum& sum) {
  const auto check = [&](const SqliteStatement& row, const auto& value, int at, const char* table,
                         const std::string& name) {
    const std::string where = std::string("damaged: row ") + name + " of table " + table;
    if (!value) return where + " holds a value out of range";
    const auto sequence = static_cast<std::uint64_t>(row.integer(at));
    const Digest digest = digestOf(*value, sequence, head_.session);
    if (digest != digestIn(row, at + 1)) return where + " has a wrong checksum";
    sum.add(digest);
    last.meet(sequence, row.text(at + 2));
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
  const Result<int> version = server::versionOf(database_);
  if (!read || !version || *version == kVersionWithoutDocument) return read;
  read = readRows(database_, kSelectDocument, [&](const SqliteStatement& row) {
    const auto change = entryOf(row);
    std::string bad = check(row, change, 2, "document", std::to_string(row.integer(0)));
    if (!bad.empty()) return bad;
    rows_.document[change->entry.id] = digestIn(row, 3);
    contents_.document[change->entry.id] = change->entry;
    return bad;
  });
  if (!read || *version == kVersionWithoutSaid) return read;
  return readRows(database_, kSelectSaid, [&](const SqliteStatement& row) {
    const auto said = saidOf(row);
    std::string bad = check(row, said, 7, "said", std::to_string(row.integer(0)));
    if (!bad.empty()) return bad;
    rows_.said[said->slot()] = digestIn(row, 8);
    apply(contents_, *said);
    return bad;
  });
}

/// The head of the last commit is in table `head` or in the last row written.
Status SessionDatabase::takeHeadOf(const LastRow& last) {
  if (last.sequence <= head_.sequence) return {};
  DatabaseHead found = head_;
  found.sequence = last.sequence;
  const std::string commit = "commit " + std::to_string(last.sequence);
  if (!takeFromRow(last.head, found)) return Error{"damaged: the last row of " + commit + " is missing"};
  if (chainOf(found) != found.chain || found.sessionTime < 0)
    return Error{"damaged: the head of " + commit + " has a wrong checksum"};
  head_ = found;
  return {};
}

DatabaseHead SessionDatabase::successor() const {
  DatabaseHead next = head_;
  ++next.sequence;
  next.previousChain = head_.chain;
  return next;
}

/// Takes out of the sum what an entry's row replaces, and the row of the entry that is forgotten with it.
void SessionDatabase::countEntry(const DocumentRecord& change, const Digest& check, Rows& staged,
                                 DatabaseHead& next) const {
  const auto takeOut = [&](document::EntryId id) {
    const auto written = staged.document.find(id);
    const auto old = rows_.document.find(id);
    if (written != staged.document.end())
      next.sum.remove(written->second);
    else if (old != rows_.document.end())
      next.sum.remove(old->second);
  };
  takeOut(change.entry.id);
  staged.document[change.entry.id] = check;
  if (change.forgotten == 0) return;
  takeOut(change.forgotten);
  staged.document.erase(change.forgotten);
  staged.forgotten.push_back(change.forgotten);
}

/// Puts a record into the sum in place of its older one, and returns its checksum.
Digest SessionDatabase::count(const JournalRecord& record, Rows& staged, DatabaseHead& next) const {
  const Digest check = digestOf(record, next.sequence, next.session);
  const auto replace = [&](const auto& committed, auto& changed, const auto& key) {
    if (const auto at = changed.find(key); at != changed.end())
      next.sum.remove(at->second);
    else if (const auto old = committed.find(key); old != committed.end())
      next.sum.remove(old->second);
    changed[key] = check;
  };
  if (const auto* part = std::get_if<sync::PartRecord>(&record))
    replace(rows_.parts, staged.parts, std::uint32_t{part->part});
  else if (const auto* site = std::get_if<SiteRecord>(&record))
    replace(rows_.sites, staged.sites, std::uint32_t{site->info.site});
  else if (const auto* nonce = std::get_if<UsedNonce>(&record))
    replace(rows_.nonces, staged.nonces, nonce->nonce);
  else if (const auto* said = std::get_if<SaidRecord>(&record))
    replace(rows_.said, staged.said, said->slot());
  else if (const auto* change = std::get_if<DocumentRecord>(&record))
    countEntry(*change, check, staged, next);
  next.sum.add(check);
  return check;
}

Status SessionDatabase::write(const JournalRecord& record, const Digest& check, std::uint64_t sequence,
                              const std::string& head) {
  const Statements::Ending ending{sequence, check, head};
  if (!std::visit([&](const auto& r) { return statements_->write(r, ending); }, record))
    return Error{database_.error()};
  return {};
}

namespace {

bool forgetsEntry(const std::vector<JournalRecord>& records) {
  return std::any_of(records.begin(), records.end(), [](const JournalRecord& record) {
    const auto* change = std::get_if<DocumentRecord>(&record);
    return change != nullptr && change->forgotten != 0;
  });
}

}  // namespace

Status SessionDatabase::commit(const std::vector<JournalRecord>& records, sync::Micros sessionTime) {
  DatabaseHead next = successor();
  if (sessionTime != 0) next.sessionTime = sessionTime;
  Rows staged;
  std::vector<Digest> checks;
  checks.reserve(records.size());
  for (const JournalRecord& record : records) checks.push_back(count(record, staged, next));
  next.chain = chainOf(next);
  attempted_ = next;
  // One statement is a transaction of its own.
  const bool several = records.size() > 1 || forgetsEntry(records);
  const auto writeAll = [&]() -> Status {
    if (several && !statements_->begin.run()) return Error{database_.error()};
    for (std::size_t i = 0; i < records.size(); ++i) {
      const bool isLast = i + 1 == records.size();
      Status written = write(records[i], checks[i], next.sequence, isLast ? inRow(next) : std::string());
      if (!written) return written;
    }
    const bool closed = records.empty() ? statements_->write(next) : !several || statements_->commit.run();
    return closed ? Status{} : Error{database_.error()};
  };
  if (Status written = writeAll(); !written) {
    if (several) statements_->rollback.run();
    return written;
  }
  adopt(next, staged);
  return {};
}

void SessionDatabase::adopt(const DatabaseHead& next, const Rows& staged) {
  head_ = attempted_ = next;
  for (const auto& [part, digest] : staged.parts) rows_.parts[part] = digest;
  for (const auto& [site, digest] : staged.sites) rows_.sites[site] = digest;
  for (const auto& [nonce, digest] : staged.nonces) rows_.nonces[nonce] = digest;
  for (const auto& [entry, digest] : staged.document) rows_.document[entry] = digest;
  for (const auto& [slot, digest] : staged.said) rows_.said[slot] = digest;
  for (const document::EntryId entry : staged.forgotten) rows_.document.erase(entry);
}

Status SessionDatabase::takeScene(const std::string& scene) {
  if (head_.scene == scene) return {};
  if (!head_.scene.empty())
    return Error{"belongs to another scene (" + head_.scene.substr(0, 12) + "..., this one is " +
                 scene.substr(0, 12) + "...): choose another --data"};
  DatabaseHead next = successor();
  next.scene = scene;
  next.chain = chainOf(next);
  if (!statements_->begin.run() || !statements_->write(next) || !statements_->commit.run()) {
    const Error error{database_.error()};
    statements_->rollback.run();
    return error;
  }
  adopt(next, {});
  return {};
}

Salvage SessionDatabase::salvage(const std::string& path) {
  Salvage found;
  const auto note = [&](const std::string& damage) {
    if (found.damage.empty()) found.damage = path + ": " + damage;
  };
  Result<SqliteDatabase> file = SqliteDatabase::openExisting(path);
  if (!file) {
    note(file.error().message);
    return found;
  }
  SessionDatabase database(std::move(*file));
  if (Status form = checkForm(database.database_); !form) note(form.error().message);
  const Result<int> version = server::versionOf(database.database_);
  if (version && *version == 1) return salvageVersion1(database.database_, std::move(found));
  const Status head = database.readHead();
  if (!head) note(head.error().message);
  found.headSound = head.ok();
  found.newer = !head && version && *version > kSchemaVersion;
  found.session = database.head_.session;
  LastRow last;
  // A row is taken only if its own checksum holds; for that the session's identity must be known.
  const auto take = [&](const SqliteStatement& row, const auto& value, int at, auto& into) {
    const auto sequence = static_cast<std::uint64_t>(row.integer(at));
    const bool sound =
        value && found.headSound && digestOf(*value, sequence, found.session) == digestIn(row, at + 1);
    if (sound) {
      into.push_back(*value);
      last.meet(sequence, row.text(at + 2));
    } else {
      ++found.damagedRows;
    }
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
  const auto entries = [&](const SqliteStatement& row) {
    std::vector<DocumentRecord> sound;
    std::string bad = take(row, entryOf(row), 2, sound);
    for (const DocumentRecord& change : sound) found.contents.document[change.entry.id] = change.entry;
    return bad;
  };
  const auto lines = [&](const SqliteStatement& row) {
    std::vector<SaidRecord> sound;
    std::string bad = take(row, saidOf(row), 7, sound);
    for (const SaidRecord& said : sound) apply(found.contents, said);
    return bad;
  };
  if (version && *version > kVersionWithoutDocument && *version <= kSchemaVersion)
    if (Status read = readRows(database.database_, kSelectDocument, entries); !read)
      note(read.error().message);
  if (version && *version == kSchemaVersion)
    if (Status read = readRows(database.database_, kSelectSaid, lines); !read) note(read.error().message);
  if (found.damagedRows > 0) note(std::to_string(found.damagedRows) + " rows are damaged");
  if (!found.headSound) return found;
  (void)database.takeHeadOf(last);  // a later session time, if it is sound
  found.scene = database.head_.scene;
  found.contents.sessionTime = database.head_.sessionTime;
  found.contents.epochFloor = database.head_.epochFloor;
  found.contents.lastSite = database.head_.lastSite;
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
