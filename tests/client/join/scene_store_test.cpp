#include "client/join/scene_store.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace tandem::client {
namespace {

namespace fs = std::filesystem;

class SceneStoreTest : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }
  static std::vector<std::byte> bytes(std::size_t count) {
    std::vector<std::byte> out(count);
    for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<std::byte>(i * 7);
    return out;
  }
  fs::path folder_ = fs::temp_directory_path() / ("tandem-store-" + std::to_string(::getpid()));
  SceneStore store_{folder_.string()};
};

TEST_F(SceneStoreTest, FindsWhatItKept) {
  const auto package = bytes(1000);
  const auto hash = assets::contentHash(package);
  EXPECT_TRUE(store_.find(hash).empty());
  store_.keep(hash, package);
  EXPECT_EQ(store_.find(hash), package);
}

TEST_F(SceneStoreTest, ADamagedPackageIsNotFound) {
  const auto package = bytes(1000);
  const auto hash = assets::contentHash(package);
  store_.keep(hash, package);
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    if (entry.is_regular_file()) std::ofstream(entry.path(), std::ios::app) << "x";
  EXPECT_TRUE(store_.find(hash).empty());
}

TEST_F(SceneStoreTest, ABeginningIsKeptUntilTheWholeIsThereOrItIsForgotten) {
  const auto package = bytes(1000);
  const auto hash = assets::contentHash(package);
  store_.keepBeginning(hash, bytes(400));
  EXPECT_EQ(store_.beginning(hash).size(), 400u);
  store_.keep(hash, package);
  EXPECT_TRUE(store_.beginning(hash).empty());
  store_.keepBeginning(hash, bytes(400));
  store_.forgetBeginning(hash);
  EXPECT_TRUE(store_.beginning(hash).empty());
}

TEST_F(SceneStoreTest, WithoutAFolderNothingIsKept) {
  const SceneStore none("");
  const auto package = bytes(10);
  none.keep(assets::contentHash(package), package);
  none.keepBeginning(assets::contentHash(package), package);
  EXPECT_TRUE(none.find(assets::contentHash(package)).empty());
  EXPECT_TRUE(none.beginning(assets::contentHash(package)).empty());
}

}  // namespace
}  // namespace tandem::client
