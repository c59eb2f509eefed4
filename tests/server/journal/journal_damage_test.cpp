// What a start makes of damaged files of a session. A family of damages is drawn by seed; whatever it is, the
// start refuses with one line, or continues with no epoch lower than any that was told, no token good twice,
// and no owner that was not. What was told is noted here, beside the code under test.

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>

#include "server/data_directory.h"
#include "server/journal/sqlite_database.h"
#include "server/journal/sqlite_journal.h"
#include "server/session_recovery.h"
#include "tests/server/journal/told_session.h"
#include "tests/support/full_size.h"
#include "tests/support/temporary_folder.h"

namespace tandem::server {
namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
void writeFile(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

constexpr const char* kFiles[] = {"session.db", "session.db-wal", "session.db-shm", "session.mark"};

void copyFiles(const fs::path& from, const fs::path& to) {
  fs::create_directories(to);
  for (const char* name : kFiles) {
    fs::remove(to / name);
    if (fs::exists(from / name)) fs::copy_file(from / name, to / name);
  }
}

/// A session whose process died after some commits; with copies of its files from before.
class DeadSession {
 public:
  DeadSession(const fs::path& folder, unsigned seed) : live(folder / "live"), random_(seed) {
    fs::create_directories(live);
    auto opened = DataDirectory::open((folder / "dead").string());
    EXPECT_TRUE(opened.ok());
    directory = std::make_unique<DataDirectory>(std::move(*opened));
    EXPECT_TRUE(directory->keepSigningKey().ok());
    key_ = directory->fingerprint();
    auto journal = SqliteJournal::open((live / "session.db").string(), options());
    EXPECT_TRUE(journal.ok()) << journal.error().message;
    run(**journal, 12 + random_() % 20);
    copyFiles(live, folder / "early");
    run(**journal, 12 + random_() % 20);
    if (random_() % 2 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    // A crash: the files as they are while the journal is open.
    copyFiles(live, dead = folder / "dead");
    early = folder / "early";
  }
  SqliteJournalOptions options() const { return {"scene", 0, key_, mustExist_, {}}; }
  SqliteJournalOptions asBefore() {
    mustExist_ = true;
    return options();
  }
  Told told;
  fs::path live, early, dead;
  std::unique_ptr<DataDirectory> directory;  // of the dead session

 private:
  void run(Journal& journal, unsigned commits) {
    for (unsigned i = 0; i < commits; ++i) {
      std::uint64_t number = 0;
      const auto part = static_cast<PartId>(random_() % 200);
      auto& [epoch, owner] = told.parts[part];
      sync::PartRecord record;
      record.part = part;
      record.epoch = epoch + 1;
      record.owner = static_cast<SiteId>(1 + random_() % 9);
      record.worldFromPart.position.x = 0.001 * record.epoch;
      number = journal.append(record);
      if (random_() % 4 == 0)
        number = journal.append(UsedNonce{"nonce" + std::to_string(random_()), 1 << 30});
      if (random_() % 4 == 0)
        number = journal.append(SaidRecord{{++lines_, 1000, 1, "ada", {"a line", {1}}}});
      const std::string nonce = "used" + std::to_string(i) + "-" + std::to_string(told.nonces.size());
      if (random_() % 4 == 0) {
        number = journal.append(UsedNonce{nonce, 1 << 30});
        told.nonces.insert(nonce);
      }
      while (journal.durableUpTo() < number && journal.failure().empty())
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      EXPECT_EQ(journal.failure(), "");
      epoch = record.epoch;
      owner = record.owner;
      told.highest = std::max(told.highest, epoch);
    }
  }
  std::mt19937 random_;
  std::uint64_t lines_ = 0;
  Digest key_{};
  bool mustExist_ = false;
};

/// Why a recovery was not safe; empty if it was.
std::string wrongAfterRecovery(DeadSession& session) {
  const SigningKey links = session.directory->linkKey(), tickets = session.directory->signingKey();
  const auto report = recoverSession(*session.directory, 1'790'000'000);
  if (!report) return report.error().message;
  if (session.directory->linkKey().seed() == links.seed() ||
      session.directory->signingKey().seed() == tickets.seed())
    return "links and tickets from before are good";
  auto journal = SqliteJournal::open((session.dead / "session.db").string(), session.asBefore());
  if (!journal) return journal.error().message;
  const JournalContents now = (*journal)->contents();
  if (now.epochFloor <= session.told.highest) return "a new epoch may be one that was told";
  for (const auto& part : now.parts) {
    if (part.owner != kNoSite) return "a part has an owner";
    if (part.epoch <= session.told.highest) return "a part is back in an older epoch";
    if (!session.told.parts.contains(part.part)) return "a part is invented";
  }
  return {};
}

constexpr int kDamages = 15;
const char* damage(DeadSession& session, const fs::path& other, unsigned kind, std::mt19937& random) {
  const fs::path d = session.dead;
  const char* name = kFiles[std::array{0, 1, 3}[random() % 3]];
  std::string bytes = contentOf(d / name);
  const auto at = [&] { return bytes.empty() ? 0 : random() % bytes.size(); };
  switch (kind) {
    case 0:
      writeFile(d / name, bytes.substr(0, at()));
      return "truncated";
    case 1: {
      const std::size_t from = at();
      for (std::size_t i = from; i < std::min(bytes.size(), from + 1 + random() % 8192); ++i) bytes[i] = 0;
      writeFile(d / name, bytes);
      return "zeroed";
    }
    case 2:
      for (unsigned i = 0, n = 1 + random() % 8; i < n && !bytes.empty(); ++i)
        bytes[at()] ^= static_cast<char>(1 << random() % 8);
      writeFile(d / name, bytes);
      return "bits flipped";
    case 3: {  // in the log's used part
      bytes = contentOf(d / "session.db-wal");
      bytes[32 + random() % std::min<std::size_t>(bytes.size() - 32, 40 * 4120)] ^= 1;
      writeFile(d / "session.db-wal", bytes);
      return "a bit of the log flipped";
    }
    case 4: {
      bytes = contentOf(d / "session.db");
      const std::size_t pages = bytes.size() / 4096;
      if (pages < 2) return "no pages to swap";
      const std::size_t a = 4096 * (random() % pages), b = 4096 * (random() % pages);
      std::swap_ranges(bytes.begin() + static_cast<long>(a), bytes.begin() + static_cast<long>(a + 4096),
                       bytes.begin() + static_cast<long>(b));
      writeFile(d / "session.db", bytes);
      return "pages swapped";
    }
    case 5:
      fs::remove(d / "session.db-wal");
      return "log removed";
    case 6:
      fs::remove(d / "session.db-wal");
      fs::remove(d / "session.db-shm");
      return "log and its index removed";
    case 7:
      fs::copy_file(session.early / "session.db", d / "session.db", fs::copy_options::overwrite_existing);
      fs::remove(d / "session.db-wal");
      return "database rolled back";
    case 8:
      fs::copy_file(session.early / "session.db-wal", d / "session.db-wal",
                    fs::copy_options::overwrite_existing);
      return "log rolled back";
    case 9:
      for (const char* file : {"session.db", "session.db-wal"})
        fs::copy_file(session.early / file, d / file, fs::copy_options::overwrite_existing);
      return "database and log rolled back";
    case 10:
      for (const char* file : {"session.db", "session.db-wal", "session.db-shm"}) fs::remove(d / file);
      return "database removed";
    case 11:
      fs::remove(d / "session.mark");
      return "mark removed";
    case 12:
      for (const char* file : kFiles) fs::remove(d / file);
      return "all removed";
    case 13:
      copyFiles(other, d);
      return "another session's files";
    default:
      for (const char* file : {"session.db", "session.db-wal"})
        fs::copy_file(other / file, d / file, fs::copy_options::overwrite_existing);
      return "another session's database";
  }
}

struct JournalDamage : testing::Test {
  test::TemporaryFolder temporary{test::folderInMemory()};
  const fs::path& folder = temporary.path();
};

TEST_F(JournalDamage, IsRefusedOrHarmless) {
  const int sessions = test::atFullSize() ? 60 : 4;
  int refused = 0, continued = 0, wouldBeWrong = 0;
  std::mt19937 random(7);
  for (int s = 0; s < sessions; ++s) {
    const fs::path home = folder / std::to_string(s);
    DeadSession session(home / "a", random()), other(home / "b", random());
    const fs::path whole = home / "whole";
    copyFiles(session.dead, whole);
    {
      auto sound = SqliteJournal::open((session.dead / "session.db").string(), session.asBefore());
      ASSERT_TRUE(sound.ok()) << sound.error().message;
      EXPECT_EQ(wrong((*sound)->contents(), session.told), "") << "what is whole is continued";
    }
    for (unsigned seed = 0; seed < 75; ++seed) {
      copyFiles(whole, session.dead);
      const char* what = damage(session, other.dead, seed % kDamages, random);
      copyFiles(session.dead, home / "unchecked");
      if (!wrongWithoutChecks(home / "unchecked", session.told).empty()) ++wouldBeWrong;
      auto journal = SqliteJournal::open((session.dead / "session.db").string(), session.asBefore());
      if (!journal) {
        ++refused;
        EXPECT_EQ(journal.error().message.find('\n'), std::string::npos);
        EXPECT_NE(journal.error().message.find("session."), std::string::npos) << journal.error().message;
        if (seed % 4 == 0) {
          EXPECT_EQ(wrongAfterRecovery(session), "") << what << ", seed " << s << "/" << seed;
        }
        continue;
      }
      ++continued;
      EXPECT_EQ(wrong((*journal)->contents(), session.told), "") << what << ", seed " << s << "/" << seed;
    }
    fs::remove_all(home);
  }
  std::printf("%d damages refused, %d harmless; %d go unnoticed without checks\n", refused, continued,
              wouldBeWrong);
  EXPECT_GT(wouldBeWrong, sessions * 10) << "the control: the damages must do harm where nothing is checked";
}

TEST_F(JournalDamage, OfTheDirectoryStopsTheJournalUntilItIsBack) {
  const fs::path home = folder / "home", away = folder / "away";
  fs::create_directories(home);
  auto journal = SqliteJournal::open((home / "session.db").string(), {"scene", 0, {}, false, {}});
  ASSERT_TRUE(journal.ok()) << journal.error().message;
  const auto appended = [&](Epoch epoch) { return (*journal)->append(sync::PartRecord{1, 2, epoch, {}}); };
  const auto waitFor = [&](auto condition) {
    for (int i = 0; i < 1000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return condition();
  };
  const auto first = appended(1);
  ASSERT_TRUE(waitFor([&] { return (*journal)->durableUpTo() >= first; }));
  for (const bool another : {false, true}) {
    fs::rename(home, away);
    if (another) copyFiles(away, home);
    // Noticed though nothing is written.
    ASSERT_TRUE(waitFor([&] { return !(*journal)->failure().empty(); }));
    EXPECT_NE((*journal)->failure().find("under the running server"), std::string::npos);
    const auto number = appended(another ? 3 : 2);
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    EXPECT_LT((*journal)->durableUpTo(), number) << "what is not durable is not reported";
    if (another) fs::remove_all(home);
    fs::rename(away, home);
    ASSERT_TRUE(waitFor([&] { return (*journal)->failure().empty(); })) << (*journal)->failure();
    EXPECT_GE((*journal)->durableUpTo(), number);
  }
  journal->reset();
  auto again = SqliteJournal::open((home / "session.db").string(), {"scene", 0, {}, true, {}});
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ((*again)->contents().parts.at(0).epoch, 3u);
}

TEST_F(JournalDamage, RestoringAnOldBackupGoesBeyondWhatWasTold) {
  DeadSession session(folder / "a", 3);
  const std::string data = session.dead.string(), backup = (folder / "backup").string();
  Epoch told = 0;
  {
    auto journal = SqliteJournal::open(data + "/session.db", session.asBefore());
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    const auto report = backUpSession(data, backup);  // while it is open
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_FALSE(backUpSession(data, backup).ok()) << "nothing is written over";
    const auto number = (*journal)->append(sync::PartRecord{1, 2, told = session.told.highest + 5000, {}});
    for (int i = 0; i < 1000 && (*journal)->durableUpTo() < number; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ASSERT_GE((*journal)->durableUpTo(), number);
  }
  const SigningKey links = session.directory->linkKey();
  const auto report = restoreSession(*session.directory, backup, 1'790'000'000);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_NE(session.directory->linkKey().seed(), links.seed());
  auto journal = SqliteJournal::open(data + "/session.db", session.asBefore());
  ASSERT_TRUE(journal.ok()) << journal.error().message;
  EXPECT_EQ((*journal)->contents().parts.size(), session.told.parts.size());
  for (const auto& part : (*journal)->contents().parts) EXPECT_GT(part.epoch, told);
  journal->reset();
  std::string bytes = contentOf(backup + "/session.db");
  // One bit in every 64 bytes after the first page: some of them are in a record, not in unused space.
  for (std::size_t i = 4096; i < bytes.size(); i += 64) bytes[i] ^= 1;
  writeFile(backup + "/session.db", bytes);
  EXPECT_FALSE(restoreSession(*session.directory, backup, 1'790'000'000).ok()) << "a damaged backup";
}

}  // namespace
}  // namespace tandem::server
