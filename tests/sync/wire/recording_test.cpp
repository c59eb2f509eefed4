#include "sync/wire/recording.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/sync/wire/random_messages.h"

namespace tandem::sync {
namespace {

class Recording : public ::testing::Test {
 protected:
  std::string path =
      (std::filesystem::temp_directory_path() / ("tandem_recording_" + std::to_string(getpid()))).string();
  RecordingHeader header{{1, 2, 3}, {{0.0, 1.0, 2.0}, 4.0}};
  std::vector<Micros> times;

  ~Recording() override { std::filesystem::remove(path); }

  /// Writes what content() then gives, in place of what was there.
  void write(int entries) {
    std::filesystem::remove(path);
    times.clear();
    testing::RandomMessages random(1);
    auto writer = RecordingWriter::create(path, header);
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < entries; ++i) {
      times.push_back(i * 4000);
      if (i % 3 == 0) {
        writer->write(times.back(), random.control(static_cast<std::size_t>(i % 22)));
      } else {
        writer->write(times.back(), StateMessage(random.update(3, header.frame)));
      }
    }
    ASSERT_TRUE(writer->flush().ok());
  }
  std::string content() {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void overwrite(const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }
  /// How many entries can be read; they must have been written, in this order.
  std::size_t readable(std::string* damaged = nullptr) {
    auto reader = RecordingReader::open(path);
    if (!reader.ok()) return 0;
    std::size_t n = 0;
    auto written = times.begin();
    for (; const auto entry = reader->next(); ++n) {
      written = std::find(written, times.end(), entry->time);
      EXPECT_NE(written, times.end());
      if (written == times.end()) break;
      ++written;
    }
    if (damaged != nullptr) *damaged = reader->damaged();
    return n;
  }
};

TEST_F(Recording, GivesBackWhatWasWritten) {
  write(60);
  std::string damaged = "?";
  EXPECT_EQ(readable(&damaged), 60u);
  EXPECT_EQ(damaged, "");
  const auto reader = RecordingReader::open(path);
  EXPECT_EQ(reader->header().sceneHash, header.sceneHash);
  EXPECT_EQ(reader->header().frame.centre, header.frame.centre);
}

TEST_F(Recording, IsReadableUpToAnyCut) {
  write(6);
  const std::string whole = content();
  std::size_t before = 0;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    overwrite(whole.substr(0, length));
    const std::size_t n = readable();
    EXPECT_GE(n, before);
    EXPECT_LT(n, 6u);
    before = n;
  }
  EXPECT_EQ(before, 5u);
}

TEST_F(Recording, NoticesEveryFlippedBit) {
  write(3);
  const std::string whole = content();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ (1 << (i % 8)));
    overwrite(bytes);
    EXPECT_LT(readable(), 3u) << "byte " << i;
  }
}

/// What was damaged is passed over, and nothing else: every record that no damage touched is read.
TEST_F(Recording, IsReadableBehindDamage) {
  write(60);
  const std::string whole = content();
  // Where each record begins: 4 bytes of length, 9 of kind and time, the payload, 4 of checksum.
  std::vector<std::size_t> begins{76};
  while (begins.back() < whole.size()) {
    std::uint32_t size = 0;
    std::memcpy(&size, whole.data() + begins.back(), sizeof size);
    begins.push_back(begins.back() + 17 + size);
  }
  ASSERT_EQ(begins.size(), 61u);
  std::mt19937 random(5);
  for (int round = 0; round < 300; ++round) {
    std::string bytes = whole;
    const std::size_t at = 76 + random() % (whole.size() - 76);
    const std::size_t length = std::min<std::size_t>(1 + random() % 200, whole.size() - at);
    const int kind = round % 3;  // other bytes, zeros, bytes that are gone
    for (std::size_t i = at; i < at + length; ++i)
      bytes[i] = kind == 0 ? static_cast<char>(whole[i] ^ static_cast<char>(1 + random() % 255)) : '\0';
    if (kind == 2) bytes.erase(at, length);
    if (bytes == whole) continue;
    std::size_t touched = 0;
    for (std::size_t i = 0; i < 60; ++i)
      touched += begins[i] < at + length && at < begins[i + 1] &&
                 (kind == 2 || bytes.compare(begins[i], begins[i + 1] - begins[i], whole, begins[i],
                                             begins[i + 1] - begins[i]) != 0);
    overwrite(bytes);
    std::string damaged;
    EXPECT_EQ(readable(&damaged), 60 - touched) << "round " << round << ", byte " << at << ", " << length;
    // Records that are gone without a trace are a gap, and no damage.
    if (kind != 2) {
      EXPECT_NE(damaged, "");
    }
  }
}

TEST_F(Recording, SearchesNoFileForever) {
  // A record of 2^20 - 1 bytes could begin at every sixteenth byte; to check them all takes 5e11 bytes.
  write(1);
  std::string slow;
  for (int i = 0; i < 1 << 19; ++i) slow += std::string("\xff\xff\x0f\0\1\0\0\0\0\0\0\0\0\0\0\0", 16);
  overwrite(content() + slow + content().substr(76));
  std::string damaged;
  EXPECT_EQ(readable(&damaged), 1u);
  EXPECT_NE(damaged, "");
}

TEST_F(Recording, IsNeverWrittenOver) {
  write(6);
  const std::string first = content();
  const std::string second = path + "-2", third = path + "-3";
  for (const std::string& expected : {second, third}) {
    auto writer = RecordingWriter::create(path, header);
    ASSERT_TRUE(writer.ok());
    EXPECT_EQ(writer->path(), expected);
    EXPECT_TRUE(RecordingReader::open(expected).ok());
  }
  EXPECT_EQ(content(), first);
  std::filesystem::remove(second);
  std::filesystem::remove(third);
  overwrite("");  // an empty file holds nothing to be kept
  EXPECT_EQ(RecordingWriter::create(path, header)->path(), path);
}

TEST_F(Recording, GivesTheReasonWhyItCannotBeOpenedOrWritten) {
  EXPECT_FALSE(RecordingReader::open("/nowhere/at/all").ok());
  EXPECT_FALSE(RecordingWriter::create("/nowhere/at/all", header).ok());
  auto full = RecordingWriter::create("/dev/full", header);
  EXPECT_FALSE(full.ok());
}

}  // namespace
}  // namespace tandem::sync
