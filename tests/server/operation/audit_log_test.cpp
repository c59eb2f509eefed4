#include "server/operation/audit_log.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace tandem::server {
namespace {

struct Folder {
  std::filesystem::path path;
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "tandem-audit-XXXXXX").string();
    path = ::mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string file() const { return (path / "audit.db").string(); }
};

AuditEntry entry(int number) {
  return {AuditEvent::joined,
          1700000000 + number,
          static_cast<SiteId>(number % 65535 + 1),
          "s" + std::to_string(number),
          "observer",
          "127.0.0.1:1",
          ""};
}

std::vector<AuditRow> rowsOf(const std::string& file) {
  std::vector<AuditRow> rows;
  const Status read = readAudit(file, [&](const AuditRow& row) { rows.push_back(row); });
  EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
  return rows;
}

TEST(AuditLog, KeepsEveryEntryAcrossRunsInOrderAndIsPrivate) {
  const Folder folder;
  for (int run = 0; run < 3; ++run) {
    auto log = AuditLog::open(folder.file());
    ASSERT_TRUE(log.ok());
    for (int i = 0; i < 10; ++i) (*log)->note({entry(10 * run + i)});
  }
  const auto rows = rowsOf(folder.file());
  ASSERT_EQ(rows.size(), 30u);
  for (int i = 0; i < 30; ++i) {
    const AuditRow& row = rows[static_cast<std::size_t>(i)];
    EXPECT_EQ(row.number, i + 1);
    EXPECT_EQ(row.entry.name, entry(i).name);
    EXPECT_EQ(row.entry.unixTime, entry(i).unixTime);
  }
  struct stat file {};
  ASSERT_EQ(::stat(folder.file().c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777u, 0600u);
}

TEST(AuditLog, HoldsTheNewestRowsOnly) {
  const Folder folder;
  {
    auto log = AuditLog::open(folder.file(), 50);
    ASSERT_TRUE(log.ok());
    for (int i = 0; i < 500; ++i) (*log)->note({entry(i)});
  }
  const auto rows = rowsOf(folder.file());
  ASSERT_EQ(rows.size(), 50u);
  EXPECT_EQ(rows.front().number, 451);
  EXPECT_EQ(rows.back().entry.name, "s499");
}

TEST(AuditLog, ShowsNoCodeThatATerminalExecutesAndValidJson) {
  AuditRow row{3, entry(1)};
  row.entry.name = "\x1b[31mEve\n\"\xff";
  row.entry.detail = std::string("nul\0byte", 8);
  for (const char c : inWords(row)) EXPECT_TRUE(static_cast<unsigned char>(c) >= 32 && c != 127);
  const auto object = nlohmann::json::parse(inJson(row), nullptr, false);
  ASSERT_TRUE(object.is_object());
  EXPECT_EQ(object.at("event"), "joined");
  EXPECT_EQ(inJson(row).find('\n'), std::string::npos);
}

TEST(AuditLog, RefusesAForeignOrDamagedFileInOneLine) {
  const Folder folder;
  EXPECT_FALSE(readAudit(folder.file(), [](const AuditRow&) {}).ok());
  EXPECT_FALSE(std::filesystem::exists(folder.file())) << "reading makes no file";
  std::ofstream(folder.file()) << std::string(5000, 'x');
  EXPECT_FALSE(AuditLog::open(folder.file()).ok());
  const Status read = readAudit(folder.file(), [](const AuditRow&) {});
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message.find("audit.db"), std::string::npos);
}

}  // namespace
}  // namespace tandem::server
