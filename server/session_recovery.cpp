#include "server/session_recovery.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <system_error>

#include "server/journal/durable_file.h"
#include "server/journal/session_database.h"
#include "server/journal/session_mark.h"
#include "server/journal/sqlite_journal.h"

namespace tandem::server {
namespace {

namespace fs = std::filesystem;

constexpr Epoch kEpochJump = 1 << 20;
constexpr std::uint32_t kSiteJump = 1024, kMaxRecoveredSite = 0xfff0;
// Where nothing says how far epochs had come: no part changes hands once a second for years.
constexpr std::int64_t kFirstSession = 1704067200;  // Unix time of 2024-01-01

/// What is known about how far a session had come.
struct Extent {
  Epoch epoch = 0;
  std::uint32_t site = 0;
  bool certain = false;  // the mark is there, and is this session's
};

Epoch added(Epoch a, Epoch b) { return a + std::min(b, ~a); }

Extent extentOf(const Salvage& salvage, const DataDirectory& directory, std::int64_t unixNow) {
  Extent extent;
  extent.epoch = salvage.contents.epochFloor;
  extent.site = salvage.contents.lastSite;
  for (const auto& part : salvage.contents.parts) extent.epoch = std::max(extent.epoch, part.epoch);
  for (const auto& site : salvage.contents.sites)
    extent.site = std::max(extent.site, std::uint32_t{site.info.site});
  if (const auto mark = SessionMark::open(markPathOf(directory.journalPath())); mark && *mark) {
    const MarkState& state = (*mark)->state();
    extent.epoch = std::max(extent.epoch, state.epochCeiling);
    extent.site = std::max(extent.site, state.siteCeiling);
    extent.certain = state.key == directory.fingerprint();
  }
  if (!extent.certain) {
    const std::int64_t seconds = std::clamp<std::int64_t>(unixNow - kFirstSession, 0, 0x7fffffff);
    extent.epoch = std::max(extent.epoch, static_cast<Epoch>(seconds));
    extent.site += kSiteJump;
  }
  extent.epoch = added(extent.epoch, kEpochJump);
  extent.site = std::min(extent.site, kMaxRecoveredSite);
  return extent;
}

/// Whether the mark shows that the database is another session's, or is itself another server's.
bool isForeign(const Salvage& salvage, const DataDirectory& directory) {
  const auto mark = SessionMark::open(markPathOf(directory.journalPath()));
  if (!mark || !*mark) return false;
  const MarkState& state = (*mark)->state();
  return state.key != directory.fingerprint() || state.session != salvage.session;
}

/// Copies what is there into a new folder beside it, and returns that folder.
Result<std::string> setAside(const std::string& data, std::int64_t unixNow) {
  std::error_code error;
  std::string folder = data + "/before-" + std::to_string(unixNow);
  for (int i = 2; fs::exists(folder, error); ++i)
    folder = data + "/before-" + std::to_string(unixNow) + "-" + std::to_string(i);
  fs::create_directory(folder, error);
  for (const char* name : {"session.db", "session.db-wal", "session.mark", "signing.key", "links.key"})
    if (!error && fs::exists(data + "/" + name)) fs::copy_file(data + "/" + name, folder + "/" + name, error);
  if (error) return Error{folder + ": " + error.message()};
  return folder;
}

void removeDatabase(const std::string& path) {
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(path + suffix, ignored);
}

Status syncFile(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = file >= 0 && ::fsync(file) == 0;
  if (file >= 0) ::close(file);
  if (!synced) return Error{path + ": cannot be synced"};
  return syncDirectoryOf(path);
}

/// How many entries of the document and lines of what was said are kept, if there are any.
std::string entriesOf(const JournalContents& contents) {
  std::string words;
  if (!contents.document.empty())
    words += ", " + std::to_string(contents.document.size()) + " entries of the document";
  if (!contents.said.empty()) words += ", " + std::to_string(contents.said.size()) + " lines of chat";
  return words;
}

/// Writes a new session from what was salvaged.
Result<Report> renew(DataDirectory& directory, const Salvage& salvage, std::int64_t unixNow) {
  const Extent extent = extentOf(salvage, directory, unixNow);
  const Epoch floor = added(extent.epoch, 1);
  DatabaseHead head;
  head.session = randomDigest();
  head.scene = salvage.scene;
  head.sessionTime = salvage.contents.sessionTime;
  head.epochFloor = floor;
  head.lastSite = static_cast<SiteId>(extent.site);
  std::vector<JournalRecord> records;
  for (sync::PartRecord part : salvage.contents.parts) {
    part.owner = kNoSite;
    part.epoch = floor;
    records.push_back(part);
  }
  for (const auto& [id, entry] : salvage.contents.document) records.push_back(DocumentRecord{entry, 0});
  for (const auto& [slot, line] : salvage.contents.said) records.push_back(SaidRecord{line});
  const std::string path = directory.journalPath(), made = path + ".new";
  removeDatabase(made);
  Digest chain{};
  std::uint64_t sequence = 0;
  {
    auto database = SessionDatabase::create(made, head, records);
    if (!database) return database.error();
    chain = database->head().chain;
    sequence = database->head().sequence;
  }
  if (Status synced = syncFile(made); !synced) return synced.error();
  if (Status key = directory.replaceKeys(true); !key) return key.error();
  const MarkState mark{head.session, directory.fingerprint(), floor, extent.site, sequence, chain};
  if (auto written = SessionMark::create(markPathOf(path), mark); !written) return written.error();
  removeDatabase(path);
  std::error_code error;
  fs::rename(made, path, error);
  if (error) return Error{path + ": " + error.message()};
  if (Status synced = syncDirectoryOf(path); !synced) return synced.error();
  return Report{
      "kept: the poses of " + std::to_string(salvage.contents.parts.size()) + " parts" +
          entriesOf(salvage.contents) + (salvage.headSound ? ", session time" : "") +
          (salvage.scene.empty() ? "; the next start decides the scene" : ", the scene"),
      "not kept: owners (all parts are free), sites (they join anew), and all links and tickets from before",
      "epochs continue beyond " + std::to_string(floor) +
          (extent.certain ? ", which exceeds all that session.mark allows"
                          : ", a guess by the clock: no sound session.mark of this session was there")};
}

}  // namespace

Result<Report> recoverSession(DataDirectory& directory, std::int64_t unixNow) {
  const std::string data = fs::path(directory.journalPath()).parent_path().string();
  const Result<std::string> aside = setAside(data, unixNow);
  if (!aside) return aside.error();
  Salvage salvage;
  if (fs::exists(*aside + "/session.db"))
    salvage = SessionDatabase::salvage(*aside + "/session.db");
  else
    salvage.damage = directory.journalPath() + ": missing";
  if (salvage.newer)
    return Error{directory.journalPath() + ": of a newer tandem-server: recover it with that"};
  if (salvage.headSound && isForeign(salvage, directory)) {
    salvage = Salvage();
    salvage.damage = directory.journalPath() + ": belongs to another session than this directory's";
  }
  Result<Report> report = renew(directory, salvage, unixNow);
  if (!report) return report.error();
  report->insert(report->begin(), salvage.damage.empty() ? "the database is sound" : salvage.damage);
  report->push_back("what was there is in " + *aside);
  return report;
}

Result<Report> restoreSession(DataDirectory& directory, const std::string& backup, std::int64_t unixNow) {
  const std::string data = fs::path(directory.journalPath()).parent_path().string();
  const std::string copy = directory.journalPath() + ".restoring";
  removeDatabase(copy);
  std::error_code error;
  fs::copy_file(backup + "/session.db", copy, error);
  if (error) return Error{backup + "/session.db: " + error.message()};
  const auto verified = SessionDatabase::open(copy);
  if (!verified) {
    removeDatabase(copy);
    return Error{"backup " + backup + ": " + verified.error().message};
  }
  Salvage salvage;
  salvage.contents = verified->contents();
  salvage.scene = verified->head().scene;
  salvage.headSound = true;
  salvage.session = verified->head().session;
  const Result<std::string> aside = setAside(data, unixNow);
  if (!aside) return aside.error();
  Result<Report> report = renew(directory, salvage, unixNow);
  removeDatabase(copy);
  if (!report) return report.error();
  report->insert(report->begin(), "restored " + backup);
  report->push_back("what was there is in " + *aside);
  return report;
}

Result<Report> backUpSession(const std::string& data, const std::string& backup) {
  const std::string to = backup + "/session.db";
  std::error_code error;
  if (fs::exists(to, error)) return Error{to + ": is there already; choose another folder"};
  if (::mkdir(backup.c_str(), 0700) != 0 && errno != EEXIST)
    return Error{backup + ": " + std::generic_category().message(errno)};
  const std::string from = data + "/session.db";
  auto database = SqliteDatabase::openExisting(from);
  if (!database) return Error{from + ": " + database.error().message};
  if (Status copied = database->copyTo(to); !copied) {
    removeDatabase(to);
    return Error{from + ": " + copied.error().message};
  }
  std::size_t parts = 0;
  {
    const auto verified = SessionDatabase::open(to);
    if (!verified) {
      removeDatabase(to);
      return Error{from + ": not backed up: " + verified.error().message};
    }
    parts = verified->contents().parts.size();
  }
  if (Status synced = syncFile(to); !synced) return synced.error();
  if (Status taken = takeIdentity(backup, data); !taken) return taken.error();
  return Report{"backed up " + data + " to " + backup + ": " + std::to_string(parts) + " parts"};
}

Status takeIdentity(const std::string& data, const std::string& backup) {
  std::error_code error;
  fs::create_directories(data, error);
  if (fs::exists(data + "/tls.key", error) || fs::exists(data + "/tls.crt", error)) return {};
  for (const char* name : {"/tls.key", "/tls.crt"}) {
    const auto content = readSmallFile(backup + name);
    if (!content) return content.error();
    if (!content->has_value()) return {};
    if (Status written = writeDurably(data + name, **content); !written) return written;
  }
  return {};
}

}  // namespace tandem::server
