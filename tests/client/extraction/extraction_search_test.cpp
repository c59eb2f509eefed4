// The search for a part's way out beside a window: it finds what `tandem extract` finds, and is cancelled.

#include "client/extraction/extraction_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include <glm/geometric.hpp>

#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

/// A block between four walls, on a floor and under a lid.
struct BlockSearch : testing::Test {
  assets::Scene scene;
  std::vector<Pose> poses;
  PartId block = add({0.0, 0.0, 0.0}, {0.02, 0.02, 0.02}, true);
  PartId lid = add({0.0, 0.014, 0.0}, {0.03, 0.004, 0.03}, true);

  BlockSearch() {
    add({0.0, -0.014, 0.0}, {0.03, 0.004, 0.03}, false);
    for (const double side : {-0.013, 0.013}) {
      add({side, 0.0, 0.0}, {0.004, 0.022, 0.022}, false);
      add({0.0, 0.0, side}, {0.022, 0.022, 0.004}, false);
    }
    scene.bounds = {{-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02}};
  }
  PartId add(const glm::dvec3& centre, const glm::dvec3& size, bool movable) {
    assets::Part part;
    part.mesh = static_cast<std::uint32_t>(scene.meshes.size());
    part.movable = movable;
    part.worldFromPart.position = centre;
    scene.meshes.push_back(test::boxMesh(size));
    if (scene.materials.empty()) scene.materials.emplace_back();
    scene.parts.push_back(part);
    poses.push_back(part.worldFromPart);
    return static_cast<PartId>(scene.parts.size() - 1);
  }
  static ExtractionSearch::State ended(const ExtractionSearch& search) {
    for (int i = 0; i < 30000 && search.state().running; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return search.state();
  }
};

TEST_F(BlockSearch, FindsWhatBlocksAndTheWayFromWherePartsStandNow) {
  ExtractionSearch search(scene, "");
  EXPECT_EQ(search.state().part, kNoPart);
  search.start(block, poses);
  EXPECT_EQ(search.state().part, block);
  ExtractionSearch::State state = ended(search);
  ASSERT_NE(state.found, nullptr);
  EXPECT_FALSE(state.found->free);
  EXPECT_NE(std::find(state.found->blockedBy.begin(), state.found->blockedBy.end(), lid),
            state.found->blockedBy.end());
  poses[lid].position.x += 1.0;
  search.start(block, poses);
  state = ended(search);
  ASSERT_NE(state.found, nullptr);
  EXPECT_TRUE(state.found->free);
  ASSERT_FALSE(state.found->path.empty());
  EXPECT_LT(glm::distance(state.found->path.front().position, poses[block].position), 1e-9);
  EXPECT_GT(state.found->path.back().position.y, 0.01);
  EXPECT_EQ(scene.parts[lid].worldFromPart.position.x, 0.0) << "nothing is moved";
}

TEST_F(BlockSearch, IsCancelledAndForgets) {
  ExtractionSearch search(scene, "");
  search.start(block, poses);
  search.clear();
  EXPECT_EQ(search.state().part, kNoPart);
  EXPECT_FALSE(search.state().running);
  search.start(lid, poses);
  EXPECT_EQ(search.state().part, lid) << "and searches anew";
}

TEST_F(BlockSearch, SaysThatAFixedPartCannotBeTaken) {
  scene.parts[lid].movable = false;
  ExtractionSearch search(scene, "");
  search.start(lid, poses);
  const ExtractionSearch::State state = ended(search);
  EXPECT_TRUE(state.cannot);
  EXPECT_EQ(state.found, nullptr);
}

}  // namespace
}  // namespace tandem::client
