// The journal on a disk with faults, drawn by seed: errors while it runs, a process that is killed, a loss of
// power, syncs that fail or lie, reads that are wrong. What was told is noted beside it.

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "server/journal/record_digest.h"
#include "server/journal/sqlite_journal.h"
#include "tests/server/journal/faulty_disk.h"
#include "tests/server/journal/told_session.h"
#include "tests/support/full_size.h"
#include "tests/support/temporary_folder.h"

namespace tandem::server {
namespace {

namespace fs = std::filesystem;
using Fault = FaultyDisk::Fault;

template <typename Condition>
bool waitFor(Condition condition) {
  for (int i = 0; i < 100000 && !condition(); ++i)
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  return condition();
}

/// A session in a folder that starts, is written to, and ends in some way; again and again.
struct DiskSession {
  DiskSession(const fs::path& home, unsigned seed) : folder(home), random(seed), disk(random()) {
    fs::create_directories(folder);
  }
  std::string path() const { return (folder / "session.db").string(); }
  Result<std::unique_ptr<SqliteJournal>> open() const {
    return SqliteJournal::open(path(), {"scene", 0, {}, started, {}});
  }
  /// Commits of one to four records, until one is not durable. Returns whether all were.
  bool write(Journal& journal, int commits) {
    for (int i = 0; i < commits; ++i) {
      std::vector<sync::PartRecord> parts;
      std::string nonce;
      std::uint64_t number = 0;
      for (unsigned n = 1 + random() % 3; n > 0; --n) {
        sync::PartRecord record;
        record.part = static_cast<PartId>(random() % 150);
        record.owner = static_cast<SiteId>(1 + random() % 9);
        record.epoch = ++asked[record.part];
        told.parts.try_emplace(record.part, Epoch{0}, kNoSite);
        number = journal.append(record);
        parts.push_back(record);
      }
      if (random() % 4 == 0)
        number = journal.append(UsedNonce{nonce = "n" + std::to_string(random()), 1 << 30});
      if (!waitFor([&] { return journal.durableUpTo() >= number || !journal.failure().empty(); }))
        return false;
      if (journal.durableUpTo() < number) return false;
      for (const auto& part : parts) {
        told.parts[part.part] = {part.epoch, part.owner};
        told.highest = std::max(told.highest, part.epoch);
      }
      if (!nonce.empty()) told.nonces.insert(nonce);
      const fs::path mark = markPathOf(path());
      fs::copy_file(mark, folder / ("mark" + std::to_string(marks++ % 4)),
                    fs::copy_options::overwrite_existing);
    }
    return true;
  }
  /// Writes until the fault comes, and then the process is dead: what is in memory is lost.
  void writeUntil(Fault fault, int commits) {
    auto journal = open();
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    started = true;
    ASSERT_TRUE(write(**journal, commits));
    disk.failAfter(static_cast<int>(random() % 12), fault);
    write(**journal, 12);
    disk.failAfter(0, Fault::dead);
    journal->reset();
    disk.heal();
  }
  /// The machine loses power: sectors that are not durable, notes of the mark, the log's index.
  void losePower() {
    disk.losePower();
    fs::remove(path() + "-shm");
    const fs::path mark = markPathOf(path());
    if (random() % 2 == 0)
      fs::copy_file(folder / ("mark" + std::to_string(random() % std::min(marks, 4u))), mark,
                    fs::copy_options::overwrite_existing);
    giveAnotherBoot(mark);
  }

  fs::path folder;
  std::mt19937 random;
  FaultyDisk disk;
  Told told;
  std::map<PartId, Epoch> asked;
  unsigned marks = 0;
  bool started = false;

 private:
  /// Writes another start of the machine into each slot of a mark (session_mark.h).
  static void giveAnotherBoot(const fs::path& mark) {
    constexpr std::size_t kSlot = 256, kBody = kSlot - sizeof(Digest), kBoot = 22 + 3 * sizeof(Digest);
    std::ifstream in(mark, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    in.close();
    for (std::size_t at = 0; at + kSlot <= text.size(); at += kSlot) {
      text[at + kBoot] ^= 1;
      const Digest check = digestOf(std::string_view(text).substr(at, kBody));
      std::copy(check.begin(), check.end(), text.begin() + static_cast<std::ptrdiff_t>(at + kBody));
    }
    std::ofstream(mark, std::ios::binary | std::ios::trunc) << text;
  }
};

struct JournalDisk : testing::Test {
  test::TemporaryFolder temporary{test::folderInMemory()};
  const fs::path& folder = temporary.path();
  const int seeds = test::atFullSize() ? 400 : 24;
  fs::path home(int seed) const { return folder / std::to_string(seed); }
};

TEST_F(JournalDisk, ErrorsStopTheJournalUntilTheyAreOver) {
  constexpr Fault kFaults[] = {Fault::ioError, Fault::full, Fault::shortWrite, Fault::syncFails};
  int failed = 0;
  for (int seed = 0; seed < seeds / 3; ++seed) {
    DiskSession session(home(seed), static_cast<unsigned>(seed));
    {
      auto journal = session.open();
      ASSERT_TRUE(journal.ok()) << journal.error().message;
      session.started = true;
      ASSERT_TRUE(session.write(**journal, 5));
      // Beside a backup the log is not copied into the database when the journal closes it.
      auto beside = SqliteDatabase::openExisting(session.path());
      ASSERT_TRUE(beside.ok() && (seed / 4 % 2 == 0 || beside->ask("SELECT count(*) FROM parts").ok()));
      session.disk.failAfter(static_cast<int>(session.random() % 6), kFaults[seed % 4]);
      const bool all = session.write(**journal, 20);
      ASSERT_FALSE(all) << "seed " << seed << ": a record counts as durable that is not";
      ++failed;
      EXPECT_NE((*journal)->failure(), "");
      session.disk.heal();
      ASSERT_TRUE(waitFor([&] { return (*journal)->failure().empty(); })) << (*journal)->failure();
      EXPECT_TRUE(session.write(**journal, 5)) << "seed " << seed;
      session.disk.failAfter(0, Fault::dead);
    }
    session.disk.heal();
    session.losePower();
    auto again = session.open();
    ASSERT_TRUE(again.ok()) << "seed " << seed << ": " << again.error().message;
    EXPECT_EQ(wrong((*again)->contents(), session.told), "") << "seed " << seed;
  }
  EXPECT_GT(failed, 0);
}

/// After a sync that failed the system has pages in memory that it takes for written. Who opens the files
/// anew reads them from there, and a loss of power takes them.
TEST_F(JournalDisk, WhatOnlyMemoryHoldsAfterASyncThatFailedIsNotDurable) {
  for (int seed = 0; seed < seeds / 4; ++seed) {
    DiskSession session(home(seed), static_cast<unsigned>(seed));
    {
      auto journal = session.open();
      ASSERT_TRUE(journal.ok()) << journal.error().message;
      session.started = true;
      ASSERT_TRUE(session.write(**journal, 5));
      session.disk.failAfter(0, Fault::syncFails);
      sync::PartRecord record;
      record.part = 7;
      record.owner = 3;
      record.epoch = ++session.asked[record.part];
      session.told.parts.try_emplace(record.part, Epoch{0}, kNoSite);
      const std::uint64_t number = (*journal)->append(record);
      ASSERT_TRUE(waitFor([&] { return !(*journal)->failure().empty(); }));
      // Two syncs fail in each attempt to go on: as the files are closed, and once they are open again.
      for (int sync = 0; sync < 2; ++sync) {
        session.disk.failAfter(0, Fault::syncFails);
        ASSERT_TRUE(waitFor([&] { return session.disk.hasFailed() || (*journal)->failure().empty(); }));
      }
      EXPECT_NE((*journal)->failure(), "") << "seed " << seed << ": no sync has succeeded";
      if (seed % 2 == 1) {
        session.disk.heal();
        ASSERT_TRUE(waitFor([&] { return (*journal)->failure().empty(); })) << (*journal)->failure();
        ASSERT_GE((*journal)->durableUpTo(), number);
      }
      if ((*journal)->durableUpTo() >= number) session.told.parts[record.part] = {record.epoch, record.owner};
      session.disk.failAfter(0, Fault::dead);
    }
    session.disk.heal();
    session.losePower();
    auto again = session.open();
    ASSERT_TRUE(again.ok()) << "seed " << seed << ": " << again.error().message;
    EXPECT_EQ(wrong((*again)->contents(), session.told), "") << "seed " << seed;
  }
}

TEST_F(JournalDisk, AKilledProcessLosesNothingAndItsFilesAreNotRefused) {
  for (int seed = 0; seed < seeds; ++seed) {
    DiskSession session(home(seed), static_cast<unsigned>(seed));
    for (int life = 0; life < 3; ++life) session.writeUntil(Fault::dead, 4);
    auto again = session.open();
    ASSERT_TRUE(again.ok()) << "seed " << seed << ": " << again.error().message;
    EXPECT_EQ(wrong((*again)->contents(), session.told), "") << "seed " << seed;
  }
}

TEST_F(JournalDisk, ALossOfPowerLosesNothingAndItsFilesAreNotRefused) {
  for (int seed = 0; seed < seeds; ++seed) {
    DiskSession session(home(seed), static_cast<unsigned>(seed));
    for (int life = 0; life < 3; ++life) {
      session.writeUntil(Fault::dead, 4);
      session.losePower();
    }
    auto again = session.open();
    ASSERT_TRUE(again.ok()) << "seed " << seed << ": " << again.error().message;
    EXPECT_EQ(wrong((*again)->contents(), session.told), "") << "seed " << seed;
    EXPECT_GE((*again)->contents().epochFloor, session.told.highest);
  }
}

/// A disk that says that it has synced what it has not can lose any commit. What was told of parts cannot be
/// known then; but no epoch is given twice.
TEST_F(JournalDisk, ASyncThatLiesNeverLetsAnEpochBeGivenTwice) {
  int refused = 0, lost = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    DiskSession session(home(seed), static_cast<unsigned>(seed));
    session.writeUntil(Fault::syncLies, 4);
    session.losePower();
    if (!wrongWithoutChecks(session.folder, session.told).empty()) ++lost;
    auto again = session.open();
    if (!again) {
      ++refused;
      continue;
    }
    EXPECT_GE((*again)->contents().epochFloor, session.told.highest) << "seed " << seed;
  }
  std::printf("%d refused, %d of %d lost what was told\n", refused, lost, seeds);
  EXPECT_GT(lost, 0) << "the control: a lie must do harm where nothing is checked";
}

TEST_F(JournalDisk, AWrongReadIsRefusedOrHarmless) {
  int refused = 0;
  DiskSession session(folder / "one", 5);
  session.writeUntil(Fault::dead, 60);
  for (int seed = 0; seed < 3 * seeds; ++seed) {
    session.disk.failAfter(static_cast<int>(session.random() % 60), Fault::rotsOnRead);
    const fs::path whole = session.folder / "whole";
    fs::remove_all(whole);
    fs::create_directories(whole);
    for (const char* name : {"session.db", "session.db-wal", "session.mark"})
      if (fs::exists(session.folder / name)) fs::copy_file(session.folder / name, whole / name);
    {
      auto again = session.open();
      if (!again)
        ++refused;
      else
        EXPECT_EQ(wrong((*again)->contents(), session.told), "") << "seed " << seed;
      session.disk.failAfter(0, Fault::dead);
    }
    session.disk.heal();
    fs::remove(session.path() + "-wal");
    fs::remove(session.path() + "-shm");
    for (const auto& file : fs::directory_iterator(whole))
      fs::copy_file(file.path(), session.folder / file.path().filename(),
                    fs::copy_options::overwrite_existing);
  }
  std::printf("%d of %d refused\n", refused, 3 * seeds);
  EXPECT_GT(refused, 0) << "the control: some reads must matter";
}

}  // namespace
}  // namespace tandem::server
