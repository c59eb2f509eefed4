// Journals of other schema versions: one of the version before is migrated once, one of a later is refused.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>

#include "server/data_directory.h"
#include "server/journal/session_database.h"
#include "server/journal/session_mark.h"
#include "server/journal/sqlite_database.h"
#include "server/journal/sqlite_journal.h"
#include "server/session_recovery.h"
#include "tests/support/temporary_folder.h"

namespace tandem::server {
namespace {

namespace fs = std::filesystem;

/// As servers wrote it before rows had checksums.
constexpr const char* kVersion1 = R"(
PRAGMA journal_mode = WAL;
BEGIN IMMEDIATE;
PRAGMA application_id = 1414417741;
PRAGMA user_version = 1;
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE parts (part INTEGER PRIMARY KEY, owner INTEGER NOT NULL, epoch INTEGER NOT NULL,
  px REAL NOT NULL, py REAL NOT NULL, pz REAL NOT NULL,
  qw REAL NOT NULL, qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL);
CREATE TABLE sites (site INTEGER PRIMARY KEY, role INTEGER NOT NULL, name TEXT NOT NULL,
  red INTEGER NOT NULL, green INTEGER NOT NULL, blue INTEGER NOT NULL, gone INTEGER NOT NULL);
CREATE TABLE nonces (nonce TEXT PRIMARY KEY, expires INTEGER NOT NULL) WITHOUT ROWID;
INSERT INTO meta VALUES ('session_time', '7000000'), ('scene', 'abc');
INSERT INTO parts VALUES (4, 3, 5000, 0.5, 0, 0, 1, 0, 0, 0), (9, 0, 2, 0, 0.25, 0, 1, 0, 0, 0);
INSERT INTO sites VALUES (3, 1, 'Ann', 1, 2, 255, 0), (70, 0, 'Ben', 9, 9, 9, 1);
INSERT INTO nonces VALUES ('old', 50), ('used', 5000);
COMMIT;
)";

struct JournalMigration : testing::Test {
  test::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  std::string data, path;
  void SetUp() override {
    data = (folder / "data").string();
    fs::create_directories(data);
    path = data + "/session.db";
  }

  void writeVersion1() const { run(kVersion1, /*create=*/true); }
  void run(const char* sql, bool create = false) const {
    auto database = create ? SqliteDatabase::open(path) : SqliteDatabase::openExisting(path);
    ASSERT_TRUE(database.ok());
    const Status done = database->run(sql);
    ASSERT_TRUE(done.ok()) << done.error().message;
  }
  Result<std::unique_ptr<SqliteJournal>> open() const {
    return SqliteJournal::open(path, {"abc", 0, {}, true, {}});
  }
  std::string refusal() const {
    const auto journal = open();
    return journal ? "" : journal.error().message;
  }
};

void expectAll(const JournalContents& found) {
  ASSERT_EQ(found.parts.size(), 2u);
  EXPECT_EQ(found.parts[0].part, 4);
  EXPECT_EQ(found.parts[0].owner, 3);
  EXPECT_EQ(found.parts[0].epoch, 5000u);
  EXPECT_EQ(found.parts[0].worldFromPart.position.x, 0.5);
  EXPECT_EQ(found.parts[1].epoch, 2u);
  ASSERT_EQ(found.sites.size(), 2u);
  EXPECT_EQ(found.sites[0].info.name, "Ann");
  EXPECT_FALSE(found.sites[0].left);
  EXPECT_TRUE(found.sites[1].left);
  ASSERT_EQ(found.nonces.size(), 2u);
  EXPECT_EQ(found.nonces[0].nonce, "old");
  EXPECT_EQ(found.nonces[1].nonce, "used");
  EXPECT_GE(found.sessionTime, 7000000);
}

TEST_F(JournalMigration, KeepsAllOfVersion1AndIsDoneOnce) {
  writeVersion1();
  Digest session{};
  for (int start = 0; start < 3; ++start) {
    auto journal = open();
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    expectAll((*journal)->contents());
    const auto mark = SessionMark::open(markPathOf(path));
    ASSERT_TRUE(mark.ok() && mark->has_value());
    if (start > 0) {
      EXPECT_EQ((*mark)->state().session, session) << "migrated again";
    }
    session = (*mark)->state().session;
    EXPECT_GE((*mark)->state().epochCeiling, 5000u) << "no epoch beyond the mark was told";
    EXPECT_GE((*mark)->state().siteCeiling, 70u);
  }
}

TEST_F(JournalMigration, IsBegunAnewWhenItWasCutOff) {
  writeVersion1();
  const std::string before = folder / "before.db", mark = markPathOf(path);
  fs::copy_file(path, before);
  ASSERT_TRUE(open().ok());
  // As after a crash between the mark and the database.
  ASSERT_TRUE(SessionMark::create(mark, {randomDigest(), {}, 6024, 134, 0, {}}).ok());
  fs::copy_file(before, path, fs::copy_options::overwrite_existing);
  auto journal = open();
  ASSERT_TRUE(journal.ok()) << journal.error().message;
  expectAll((*journal)->contents());
}

TEST_F(JournalMigration, IsNotForAVersion1ThatWasPutBack) {
  writeVersion1();
  const std::string before = folder / "before.db";
  fs::copy_file(path, before);
  ASSERT_TRUE(open().ok());
  fs::copy_file(before, path, fs::copy_options::overwrite_existing);
  EXPECT_NE(refusal().find("rolled back"), std::string::npos) << refusal();
}

TEST_F(JournalMigration, ChangesNothingOfADamagedVersion1) {
  writeVersion1();
  run("UPDATE parts SET epoch = -1 WHERE part = 9");
  EXPECT_NE(refusal().find("table parts"), std::string::npos) << refusal();
  auto database = SqliteDatabase::openExisting(path);
  ASSERT_TRUE(database.ok());
  const auto version = database->ask("PRAGMA user_version");
  ASSERT_TRUE(version.ok());
  EXPECT_EQ(*version, "1");
  EXPECT_FALSE(fs::exists(markPathOf(path)));
}

TEST_F(JournalMigration, RecoversVersion1WithoutMigratingIt) {
  auto directory = DataDirectory::open(data);
  ASSERT_TRUE(directory.ok()) << directory.error().message;
  ASSERT_TRUE(directory->keepSigningKey().ok());
  writeVersion1();
  const auto report = recoverSession(*directory, 1'790'000'000);
  ASSERT_TRUE(report.ok()) << report.error().message;
  auto journal = SqliteJournal::open(path, {"abc", 0, directory->fingerprint(), true, {}});
  ASSERT_TRUE(journal.ok()) << journal.error().message;
  ASSERT_EQ((*journal)->contents().parts.size(), 2u);
  for (const auto& part : (*journal)->contents().parts) EXPECT_GT(part.epoch, 5000u);
}

TEST_F(JournalMigration, GivesVersion3AnEmptyDocumentAndKeepsTheRest) {
  {
    auto journal = SqliteJournal::open(path, {"abc", 0, {}, false, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    (*journal)->append(UsedNonce{"used", 5000});
  }
  run("DROP TABLE document; DROP TABLE said; PRAGMA user_version = 3");
  for (int start = 0; start < 2; ++start) {
    auto journal = SqliteJournal::open(path, {"abc", 0, {}, true, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    ASSERT_EQ((*journal)->contents().nonces.size(), 1u);
    ASSERT_EQ((*journal)->contents().document.size(), static_cast<std::size_t>(start));
    document::Entry entry;
    entry.id = 7;
    entry.revision = 9;
    entry.body = document::Group{"pumps", {1, 2}};
    if (start == 0) (*journal)->append(DocumentRecord{entry, 0});
  }
}

TEST_F(JournalMigration, GivesVersion4AnEmptyChatAndKeepsTheRest) {
  document::Entry entry;
  entry.id = 7;
  entry.revision = 9;
  entry.body = document::Group{"pumps", {1, 2}};
  {
    auto journal = SqliteJournal::open(path, {"abc", 0, {}, false, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    (*journal)->append(DocumentRecord{entry, 0});
  }
  run("DROP TABLE said; PRAGMA user_version = 4");
  const Salvage salvaged = SessionDatabase::salvage(path);
  EXPECT_TRUE(salvaged.damage.empty()) << salvaged.damage;
  EXPECT_EQ(salvaged.contents.document.size(), 1u);
  for (int start = 0; start < 2; ++start) {
    auto journal = SqliteJournal::open(path, {"abc", 0, {}, true, {}});
    ASSERT_TRUE(journal.ok()) << journal.error().message;
    EXPECT_EQ((*journal)->contents().document.size(), 1u);
    ASSERT_EQ((*journal)->contents().said.size(), static_cast<std::size_t>(start));
    if (start == 0) (*journal)->append(SaidRecord{{5, 1000, 2, "ada", {"hello", {1}}}});
  }
  EXPECT_EQ(SessionDatabase::salvage(path).contents.said.size(), 1u);
}

TEST_F(JournalMigration, OfALaterVersionIsRefusedInOneLine) {
  auto directory = DataDirectory::open(data);
  ASSERT_TRUE(directory.ok()) << directory.error().message;
  ASSERT_TRUE(directory->keepSigningKey().ok());
  run("PRAGMA application_id = 1414417741; PRAGMA user_version = 6; CREATE TABLE later (x)", /*create=*/true);
  const std::string said = refusal();
  EXPECT_NE(said.find("session.db: schema version 6 of a newer"), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos);
  EXPECT_EQ(said.find("--recover"), std::string::npos) << "which would throw it away";
  EXPECT_FALSE(recoverSession(*directory, 1'790'000'000).ok());
  EXPECT_EQ(refusal(), said) << "nothing was changed";
}

}  // namespace
}  // namespace tandem::server
