#include "server/journal/sqlite_journal.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "server/data_directory.h"
#include "tests/support/temporary_folder.h"

namespace tandem::server {
namespace {

namespace fs = std::filesystem;

struct SqliteJournalTest : testing::Test {
  test::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  std::string path() const { return (folder / "session.db").string(); }
};

sync::PartRecord record(PartId part, Epoch epoch) {
  sync::PartRecord r;
  r.part = part;
  r.owner = 3;
  r.epoch = epoch;
  r.worldFromPart.position.x = 0.001 * epoch;
  return r;
}

/// Waits until a record is durable; false after ten seconds.
bool durable(Journal& journal, std::uint64_t number) {
  for (int i = 0; i < 100000 && journal.durableUpTo() < number && journal.failure().empty(); ++i)
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  return journal.durableUpTo() >= number;
}

DocumentRecord noteRecord(document::EntryId id, document::Revision revision, const std::string& text) {
  document::Entry entry;
  entry.id = id;
  entry.revision = revision;
  entry.author = entry.editor = 3;
  entry.authorName = "Ann";
  entry.creation = entry.request = static_cast<std::uint32_t>(revision);
  document::Note note;
  note.text = text;
  entry.body = note;
  return {entry, 0};
}

TEST_F(SqliteJournalTest, HoldsTheDocumentWithoutTheEntriesThatItForgot) {
  for (const bool inOneCommit : {true, false}) {
    const fs::path own = folder / (inOneCommit ? "one" : "several");
    fs::create_directories(own);
    const std::string file = (own / "session.db").string();
    {
      auto journal = SqliteJournal::open(file, {"abc", 0, {}, false, {}});
      ASSERT_TRUE(journal.ok()) << journal.error().message;
      const auto settle = [&](std::uint64_t number) { return inOneCommit || durable(**journal, number); };
      ASSERT_TRUE(settle((*journal)->append(noteRecord(1, 1, "first"))));
      ASSERT_TRUE(settle((*journal)->append(noteRecord(2, 2, std::string(2000, 'x')))));
      ASSERT_TRUE(settle((*journal)->append(noteRecord(1, 3, "first, changed"))));
      DocumentRecord third = noteRecord(3, 4, "third");
      third.forgotten = 2;
      ASSERT_TRUE(settle((*journal)->append(third)));
    }
    auto journal = SqliteJournal::open(file, {"abc", 0, {}, false, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    const auto document = (*journal)->contents().document;
    ASSERT_EQ(document.size(), 2u);
    EXPECT_EQ(std::get<document::Note>(document.at(1).body).text, "first, changed");
    EXPECT_EQ(document.at(1).revision, 3u);
    EXPECT_EQ(document.at(3).authorName, "Ann");
    EXPECT_EQ(document.at(3).creation, 4u);
  }
}

SaidRecord saidRecord(std::uint64_t number) {
  return {{number, 1'790'000'000, 3, "Ann \xc3\xa9", {"line " + std::to_string(number), {0, 300, kNoPart}}}};
}

TEST_F(SqliteJournalTest, HoldsTheNewestLinesThatWereSaid) {
  constexpr std::uint64_t kLines = sync::kMaxSaidLines + 30;
  for (int start = 0; start < 3; ++start) {
    auto journal = SqliteJournal::open(path(), {"abc", 0, {}, false, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    const auto said = (*journal)->contents().said;
    if (start == 0)
      for (std::uint64_t number = 1; number <= kLines; ++number) (*journal)->append(saidRecord(number));
    if (start == 1) {
      ASSERT_EQ(said.size(), sync::kMaxSaidLines);
      for (const auto& [slot, line] : said) EXPECT_EQ(line, saidRecord(line.number).line);
      for (std::uint64_t number = 31; number <= kLines; ++number)
        EXPECT_TRUE(said.contains(number % sync::kMaxSaidLines));
      ASSERT_TRUE(durable(**journal, (*journal)->append(saidRecord(kLines + 1))));
    }
    if (start == 2) {
      EXPECT_EQ(said.size(), sync::kMaxSaidLines);
      EXPECT_EQ(said.at((kLines + 1) % sync::kMaxSaidLines).number, kLines + 1);
    }
  }
}

TEST_F(SqliteJournalTest, HoldsWhatWasWrittenWhenReopened) {
  {
    auto journal = SqliteJournal::open(path(), {"abc", 0, {}, false, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    (*journal)->append(record(4, 1));
    (*journal)->append(record(4, 9));
    (*journal)->append(SiteRecord{{7, sync::Role::instructor, "Ann \xc3\xa9", {1, 2, 255}, true}, true});
    (*journal)->append(UsedNonce{"expired", 1});
    (*journal)->append(UsedNonce{"new", std::int64_t{1} << 40});
    (*journal)->noteTime(5 * sync::kSecond);
  }
  auto journal = SqliteJournal::open(path(), {"abc", 0, {}, false, {}});
  ASSERT_TRUE(journal.ok()) << journal.error().message;
  const auto contents = (*journal)->contents();
  ASSERT_EQ(contents.parts.size(), 1u);
  EXPECT_EQ(contents.parts[0].epoch, 9u);
  EXPECT_EQ(contents.parts[0].worldFromPart.position.x, 0.001 * 9);
  ASSERT_EQ(contents.sites.size(), 1u);
  EXPECT_EQ(contents.sites[0].info.name, "Ann \xc3\xa9");
  EXPECT_TRUE(contents.sites[0].left);
  ASSERT_EQ(contents.nonces.size(), 2u) << "a clock that is put back makes the expired one good again";
  EXPECT_EQ(contents.nonces[0].nonce, "expired");
  EXPECT_EQ(contents.nonces[1].nonce, "new");
  EXPECT_EQ(contents.sessionTime, 5 * sync::kSecond);
}

TEST_F(SqliteJournalTest, LosesNothingReportedDurableWhenKilled) {
  for (int round = 0; round < 5; ++round) {
    int pipe[2];
    ASSERT_EQ(::pipe(pipe), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      auto journal = SqliteJournal::open(path(), {"abc", 0, {}, false, {}});
      if (!journal.ok()) ::_exit(1);
      const auto contents = (*journal)->contents();
      Epoch epoch = contents.parts.empty() ? 0 : contents.parts[0].epoch;
      const Epoch first = epoch;
      for (std::uint64_t reported = 0;;) {
        (*journal)->append(record(1, ++epoch));
        std::this_thread::sleep_for(std::chrono::microseconds(50));
        const std::uint64_t safe = (*journal)->durableUpTo();
        if (safe == reported) continue;
        reported = safe;
        const Epoch durableEpoch = first + static_cast<Epoch>(safe);
        if (::write(pipe[1], &durableEpoch, sizeof durableEpoch) != sizeof durableEpoch) ::_exit(2);
      }
    }
    ::close(pipe[1]);
    Epoch last = 0, next = 0;
    for (int i = 0; i < 40 + 10 * round && ::read(pipe[0], &next, sizeof next) == sizeof next; ++i)
      last = next;
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    while (::read(pipe[0], &next, sizeof next) == sizeof next) last = next;
    ::close(pipe[0]);
    EXPECT_TRUE(WIFSIGNALED(status));
    ASSERT_GT(last, 0u);
    auto journal = SqliteJournal::open(path(), {"abc", 0, {}, false, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    ASSERT_EQ((*journal)->contents().parts.size(), 1u);
    EXPECT_GE((*journal)->contents().parts[0].epoch, last);
  }
}

TEST_F(SqliteJournalTest, ReusesTheLogThatItMadeAtTheStart) {
  constexpr PartId kParts = 2000;  // about 45 pages, so that 60 rounds would make a log of 11 MB
  {
    auto journal = SqliteJournal::open(path(), {"abc", 0, {}, false, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    const auto made = fs::file_size(path() + "-wal");
    EXPECT_GT(made, 4'000'000u);
    for (Epoch epoch = 1; epoch <= 60; ++epoch) {
      std::uint64_t number = 0;
      for (PartId part = 0; part < kParts; ++part) number = (*journal)->append(record(part, epoch));
      ASSERT_TRUE(durable(**journal, number)) << (*journal)->failure();
    }
    EXPECT_LT(fs::file_size(path() + "-wal"), made + made / 4);
  }
  auto journal = SqliteJournal::open(path(), {"abc", 0, {}, false, {}});
  ASSERT_TRUE(journal.ok()) << journal.error().message;
  ASSERT_EQ((*journal)->contents().parts.size(), kParts);
  for (const auto& part : (*journal)->contents().parts) ASSERT_EQ(part.epoch, 60u);
}

TEST_F(SqliteJournalTest, RefusesWhatIsNotItsOwn) {
  std::ofstream(path()) << std::string(8192, 'x');
  EXPECT_FALSE(SqliteJournal::open(path(), {"abc", 0, {}, false, {}}).ok());
  fs::remove(path());
  { ASSERT_TRUE(SqliteJournal::open(path(), {"abc", 0, {}, false, {}}).ok()); }
  const auto other = SqliteJournal::open(path(), {"def", 0, {}, false, {}});
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.error().message.find("another scene"), std::string::npos);
  EXPECT_EQ(other.error().message.find('\n'), std::string::npos);
  EXPECT_FALSE(SqliteJournal::open((folder / "none" / "x.db").string(), {"abc", 0, {}, false, {}}).ok());
}

TEST_F(SqliteJournalTest, StopsAndReportsWhenTheDiskIsFull) {
  auto journal = SqliteJournal::open(path(), {"abc", 7, {}, false, {}});
  ASSERT_TRUE(journal.ok()) << journal.error().message;
  std::uint64_t number = 0;
  for (PartId part = 0; part < 2000; ++part) number = (*journal)->append(record(part, 1));
  EXPECT_FALSE(durable(**journal, number));
  EXPECT_NE((*journal)->failure().find("full"), std::string::npos) << (*journal)->failure();
  const std::uint64_t before = (*journal)->durableUpTo();
  (*journal)->append(record(0, 2));
  EXPECT_EQ((*journal)->durableUpTo(), before);
}

TEST_F(SqliteJournalTest, NotifiesWhenRecordsBecomeDurable) {
  auto journal = SqliteJournal::open(path(), {"abc", 0, {}, false, {}});
  ASSERT_TRUE(journal.ok());
  std::atomic<std::uint64_t> durable{0};
  (*journal)->onProgress([&] { durable = (*journal)->durableUpTo(); });
  std::vector<double> taken_ms;
  for (Epoch epoch = 1; epoch <= 300; ++epoch) {
    const auto start = std::chrono::steady_clock::now();
    const auto number = (*journal)->append(record(1, epoch));
    while (durable < number) std::this_thread::yield();
    taken_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(taken_ms.begin(), taken_ms.end());
  std::printf("append to durable: p50 %.2f ms, p99 %.2f ms, max %.2f ms\n", taken_ms[150], taken_ms[297],
              taken_ms[299]);
}

TEST_F(SqliteJournalTest, ADirectoryServesOneServerAndKeepsItsKeys) {
  const std::string data = (folder / "data").string();
  std::string certificate;
  SigningKey key;
  {
    auto first = DataDirectory::open(data);
    ASSERT_TRUE(first.ok()) << first.error().message;
    certificate = first->identity().certificate;
    key = first->signingKey();
    ASSERT_TRUE(first->keepSigningKey().ok());
    EXPECT_FALSE(DataDirectory::open(data).ok());
    EXPECT_EQ(fs::status(data).permissions(), fs::perms::owner_all);
    EXPECT_EQ(fs::status(data + "/signing.key").permissions(),
              fs::perms::owner_read | fs::perms::owner_write);
  }
  auto again = DataDirectory::open(data);
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->identity().certificate, certificate);
  EXPECT_EQ(again->signingKey().seed(), key.seed());
}

}  // namespace
}  // namespace tandem::server
