#include "client/levels/level_maker.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "assets/generate/large_assembly.h"
#include "tests/support/temporary_folder.h"

namespace tandem::client {
namespace {

const assets::Scene& threeMeshes() {
  static const assets::Scene scene = generate::largeAssembly(3, 4000);
  return scene;
}

LevelMaker::Made next(LevelMaker& maker) {
  for (;;) {
    if (std::optional<LevelMaker::Made> made = maker.take()) return std::move(*made);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

std::vector<LevelMaker::Source> sourcesOf(const assets::Scene& scene) {
  std::vector<LevelMaker::Source> sources;
  for (std::uint32_t m = 0; m < scene.meshes.size(); ++m)
    sources.push_back({m, levelContent(scene.meshes[m])});
  return sources;
}

TEST(LevelMaker, MakesFirstWhatIsFurthestOff) {
  LevelMaker maker(threeMeshes(), sourcesOf(threeMeshes()), "", 1);
  EXPECT_EQ(maker.left(), 3u);
  maker.setUrgency(1, 2.0f);
  maker.setUrgency(2, 5.0f);
  maker.begin();
  for (const std::uint32_t mesh : {2u, 1u, 0u}) {
    const LevelMaker::Made made = next(maker);
    EXPECT_EQ(made.mesh, mesh);
    EXPECT_FALSE(made.levels.empty());
  }
  EXPECT_EQ(maker.left(), 0u);
  maker.askExact(1);
  const LevelMaker::Made exact = next(maker);
  EXPECT_TRUE(exact.exact);
  EXPECT_EQ(exact.levels.front().mesh.indices.size(), 3 * threeMeshes().meshes[1].triangles.size());
}

TEST(LevelMaker, ReadsWhatIsKeptAndMakesAnewWhatIsDamaged) {
  const test::TemporaryFolder folder;
  const auto levelsOf = [&](std::size_t& made) {
    LevelMaker maker(threeMeshes(), sourcesOf(threeMeshes()), folder.path().string());
    maker.begin();
    std::vector<Level> levels;
    for (int i = 0; i < 3; ++i)
      if (LevelMaker::Made one = next(maker); one.mesh == 0) levels = std::move(one.levels);
    made = maker.made();
    return levels;
  };
  std::size_t made = 0;
  const std::vector<Level> first = levelsOf(made);
  EXPECT_EQ(made, 3u);
  const std::vector<Level> again = levelsOf(made);
  EXPECT_EQ(made, 0u);
  ASSERT_EQ(again.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(again[i].error, first[i].error);
    EXPECT_TRUE(first[i].facesOutward);
    EXPECT_EQ(again[i].facesOutward, first[i].facesOutward);
    EXPECT_EQ(again[i].mesh.indices, first[i].mesh.indices);
    EXPECT_EQ(again[i].mesh.vertices.size(), first[i].mesh.vertices.size());
  }
  for (const auto& file : std::filesystem::directory_iterator(folder.path()))
    std::filesystem::resize_file(file.path(), std::filesystem::file_size(file.path()) - 1);
  levelsOf(made);
  EXPECT_EQ(made, 3u);
}

TEST(LevelMaker, KeepsNothingHalfMadeWhenItIsLeft) {
  const test::TemporaryFolder folder;
  // Levels of this mesh take over a second of the processor.
  const assets::Scene scene = generate::largeAssembly(1, 60'000);
  auto maker = std::make_unique<LevelMaker>(scene, sourcesOf(scene), folder.path().string());
  maker->begin();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(maker->left(), 1u);
  maker.reset();
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "it waits for no mesh to be done";
}

}  // namespace
}  // namespace tandem::client
