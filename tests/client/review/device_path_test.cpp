#include "client/review/device_path.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace tandem::client {
namespace {

class DevicePath : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    std::ofstream(path_) << text;
    return path_;
  }
  void TearDown() override { std::filesystem::remove(path_); }
  std::string path_ =
      (std::filesystem::temp_directory_path() / ("tandem-path-" + std::to_string(::getpid()) + ".csv"))
          .string();
};

TEST_F(DevicePath, ReadsPositionsAndTurns) {
  const auto rows = loadDevicePath(write("t,x,y,z,qw,qx,qy,qz\n0,1,2,3,1,0,0,0\n0.001,1,2,4,0,1,0,0\n"));
  ASSERT_TRUE(rows.ok());
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[1].pose.position.z, 4.0);
  EXPECT_EQ((*rows)[1].pose.orientation.x, 1.0);
}

TEST_F(DevicePath, ANanCellMakesTheReadingInvalid) {
  const auto rows = loadDevicePath(write("t,x,y,z\n0,1,2,3\n0.001,nan,2,3\n0.002,inf,2,3\n0.003,1,2,3\r\n"));
  ASSERT_TRUE(rows.ok());
  EXPECT_TRUE((*rows)[0].valid);
  EXPECT_FALSE((*rows)[1].valid);
  EXPECT_FALSE((*rows)[2].valid);
  EXPECT_TRUE((*rows)[3].valid);
}

TEST_F(DevicePath, LetsTimeStandStill) {
  EXPECT_TRUE(loadDevicePath(write("t,x,y,z\n0,1,2,3\n0,1,2,3\nnan,1,2,3\n0,1,2,3\n0.001,1,2,3\n")).ok());
}

TEST_F(DevicePath, RefusesOtherFilesAndNamesTheLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "header"},
      {"x,y,z\n", "header"},
      {"t,x,y,z\n", "no rows"},
      {"t,x,y,z\n0,1,2,3\n0,1,two,3\n", "line 3"},
      {"t,x,y,z\n0,1,2\n", "line 2"},
      {"t,x,y,z\n1,0,0,0\n2,0,0,0\n1.5,0,0,0\n", "line 4"},
      {"t,x,y,z\n1,0,0,0\nnan,0,0,0\n0,0,0,0\n", "backwards"},
      {"t,x,y,z,qw,qx,qy,qz\n0,1,2,3,3,0,0,0\n", "unit"}};
  for (const auto& [text, word] : cases) {
    const auto rows = loadDevicePath(write(text));
    ASSERT_FALSE(rows.ok()) << text;
    EXPECT_NE(rows.error().message.find(word), std::string::npos) << rows.error().message;
  }
  EXPECT_FALSE(loadDevicePath("/nonexistent/path.csv").ok());
}

}  // namespace
}  // namespace tandem::client
