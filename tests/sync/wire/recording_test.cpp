#include "sync/wire/recording.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

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

  void write(int entries) {
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
  /// How many entries can be read; all of them must be the first ones that were written.
  std::size_t readable(std::string* damaged = nullptr) {
    auto reader = RecordingReader::open(path);
    if (!reader.ok()) return 0;
    std::size_t n = 0;
    while (const auto entry = reader->next()) EXPECT_EQ(entry->time, times.at(n++));
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

TEST_F(Recording, GivesTheReasonWhyItCannotBeOpenedOrWritten) {
  EXPECT_FALSE(RecordingReader::open("/nowhere/at/all").ok());
  EXPECT_FALSE(RecordingWriter::create("/nowhere/at/all", header).ok());
  auto full = RecordingWriter::create("/dev/full", header);
  EXPECT_FALSE(full.ok());
}

}  // namespace
}  // namespace tandem::sync
