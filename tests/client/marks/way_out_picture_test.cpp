// The way of a part out of its assembly in the picture of a window.

#include "client/marks/way_out_picture.h"

#include <gtest/gtest.h>

#include "client/viewer/viewer.h"
#include "tests/client/hand/box_row.h"
#include "tests/client/viewer/picture.h"

namespace tandem::client {
namespace {

Pose upTo(double y) { return {{0.0, y, 0.0}, {1.0, 0.0, 0.0, 0.0}}; }

TEST(WayOutPicture, PosesAreSpreadOverTheWayAndHaveItsEnd) {
  std::vector<Pose> path;
  for (int i = 0; i <= 100; ++i) path.push_back(upTo(0.001 * i));
  const std::vector<Pose> poses = posesAlong(path, 4);
  ASSERT_EQ(poses.size(), 4u);
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_NEAR(poses[i].position.y, 0.025 * static_cast<double>(i + 1), 0.0011);
  EXPECT_EQ(poses.back().position.y, path.back().position.y);
  EXPECT_TRUE(posesAlong({}, 4).empty());
  EXPECT_TRUE(posesAlong({upTo(0.0)}, 4).empty());
  EXPECT_EQ(posesAlong({upTo(0.0), upTo(1.0)}, 4).size(), 1u);
}

TEST(WayOutPicture, ShowsTheWayWhatIsInItAndNothingOfItWhileExplodedOrCleared) {
  assets::Scene scene = test::rowOfBoxes();
  scene.bounds = {{-0.05, -0.05, -0.05}, {0.45, 0.25, 0.05}};
  ViewModel model;
  model.scene = &scene;
  for (const assets::Part& part : scene.parts) model.worldFromPart.push_back(part.worldFromPart);
  model.owner.assign(scene.parts.size(), kNoSite);
  const auto drawn = [&](double explode, bool panels = false) {
    ViewerOptions options;
    options.width = 240;
    options.height = 160;
    options.panels = panels;
    options.style.explode = explode;
    auto viewer = Viewer::openOffscreen(scene, options);
    if (!viewer) return Picture{};
    for (int i = 0; i < 3; ++i) static_cast<void>((*viewer)->frame(model));
    const std::string path = testing::TempDir() + "way_out.png";
    EXPECT_TRUE((*viewer)->screenshot(path).ok());
    return readPng(path);
  };
  const Picture before = drawn(0.0), apart = drawn(0.5);
  if (before.width == 0) GTEST_SKIP() << "no OpenGL";
  model.wayOut.part = 0;
  model.wayOut.free = true;
  for (int i = 0; i <= 20; ++i) model.wayOut.path.push_back(upTo(0.01 * i));
  const Picture shown = drawn(0.0);
  EXPECT_GT(countDifferent(before, shown, 12), 200);
  EXPECT_EQ(countDifferent(apart, drawn(0.5), 12), 0);
  model.wayOut.blockedBy = {1};
  EXPECT_GT(countDifferent(shown, drawn(0.0), 12), 200);
  EXPECT_GT(drawn(0.0, true).width, 0) << "with its panel";
  model.wayOut = {};
  EXPECT_EQ(countDifferent(before, drawn(0.0), 12), 0);
}

}  // namespace
}  // namespace tandem::client
