#include "client/picture/drawn_levels.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>
#include <utility>

#include "assets/generate/bench_meshes.h"
#include "assets/generate/large_assembly.h"
#include "assets/scene/scene_package.h"
#include "client/picture/level_choice.h"
#include "client/picture/scene_renderer.h"
#include "client/viewer/surface.h"
#include "tests/support/temporary_folder.h"

namespace tandem::client {
namespace {

constexpr int kPictureSize = 240;

TEST(LevelChoice, TakesTheCoarsestWithinAPixelAndGoesCoarserOnlyWellWithin) {
  const double errors[] = {1e-5, 1e-4, 1e-3};
  EXPECT_EQ(chooseLevel(errors, 1e-6, 3), 0u) << "none is within a pixel: the finest";
  EXPECT_EQ(chooseLevel(errors, 1e-4, 3), 1u);
  EXPECT_EQ(chooseLevel(errors, 1e-2, 3), 2u);
  EXPECT_EQ(chooseLevel(errors, 1.1e-4, 0), 0u) << "0.9 pixels: no reason to change";
  EXPECT_EQ(chooseLevel(errors, 1.1e-4, 1), 1u);
  EXPECT_EQ(chooseLevel(errors, 1.4e-4, 0), 1u);
  EXPECT_EQ(chooseLevel(errors, 0.9e-4, 1), 0u) << "more than a pixel is never shown";
}

using Pixels = std::vector<std::uint8_t>;
using Depths = std::vector<double>;

constexpr double kBehind = 0.004;  // m; the parts are some 40 mm across

/// The share of what both pictures show that is in another place by more than kBehind.
double shareElsewhere(const Depths& exact, const Depths& drawn) {
  int both = 0, elsewhere = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    if (exact[i] <= 0.0 || drawn[i] <= 0.0) continue;
    ++both;
    elsewhere += std::abs(exact[i] - drawn[i]) > kBehind ? 1 : 0;
  }
  EXPECT_GT(both, 1000);
  return static_cast<double>(elsewhere) / both;
}

/// The same surface with its inside out.
void turnInsideOut(assets::Mesh& mesh) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    std::swap(mesh.neighbours[t][0], mesh.neighbours[t][2]);
    std::swap(mesh.edgeFlags[t][0], mesh.edgeFlags[t][2]);
  }
}

/// What is not black in one picture against another one.
struct Compared {
  int inBoth = 0;
  int holes = 0;     // black although the pixel and all its neighbours are not in `exact`
  int overhang = 0;  // not black although they all are in `exact`
};

Compared compare(const Pixels& exact, const Pixels& drawn) {
  const auto covered = [](const Pixels& p, int x, int y) {
    return p[4 * static_cast<std::size_t>(y * kPictureSize + x)] > 5;
  };
  Compared out;
  for (int y = 1; y + 1 < kPictureSize; ++y)
    for (int x = 1; x + 1 < kPictureSize; ++x) {
      int around = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) around += covered(exact, x + dx, y + dy) ? 1 : 0;
      const bool here = covered(drawn, x, y);
      out.inBoth += here && around == 9 ? 1 : 0;
      out.holes += !here && around == 9 ? 1 : 0;
      out.overhang += here && around == 0 ? 1 : 0;
    }
  return out;
}

/// Castings and gears of 9,000 triangles, drawn by levels and exactly.
class DrawnLevelsTest : public testing::Test {
 protected:
  static constexpr int kMeshes = 3;

  void SetUp() override {
    auto surface = openOffscreenSurface({});
    if (!surface) GTEST_SKIP() << surface.error().message;
    surface_ = std::move(*surface);
    // The third mesh is the first again, as files have it that repeat a mesh for each of its places.
    scene_ = generate::largeAssembly(kMeshes, 9000);
    if (insideOut_) turnInsideOut(scene_.meshes[0]);
    scene_.meshes[2] = scene_.meshes[0];
    const std::vector<assets::Part> parts = scene_.parts;
    while (scene_.parts.size() < 36) {  // enough triangles for levels, all in one place but the first three
      scene_.parts.push_back(parts[scene_.parts.size() % kMeshes]);
      scene_.parts.back().name += '_' + std::to_string(scene_.parts.size());
    }
    looks_.resize(scene_.parts.size());
    for (std::size_t p = 0; p < scene_.parts.size(); ++p) {
      poses_.push_back(scene_.parts[p].worldFromPart);
      looks_[p].visible = p < kMeshes;
      all_.push_back(static_cast<PartId>(p));
    }
    exact_ = make({});
    levels_ = make({true, folder_.path().string()});
    target_ = std::make_unique<GlTarget>();
  }
  void TearDown() override {
    target_.reset();
    levels_.reset();
    exact_.reset();
  }

  std::unique_ptr<SceneRenderer> make(const Detail& detail) const {
    auto renderer = SceneRenderer::make(scene_, detail);
    EXPECT_TRUE(renderer.ok());
    return std::move(*renderer);
  }

  View viewFrom(double distance, double yaw = 0.4) const {
    Camera camera;
    camera.yaw = yaw;
    camera.pitch = 0.3;
    camera.distance = distance;
    camera.target = 0.5 * (scene_.bounds.min + scene_.bounds.max);
    return makeView(camera, {kPictureSize, kPictureSize}, {camera.target, 0.1});
  }

  Pixels draw(SceneRenderer& renderer, const View& view) {
    renderer.receive();
    target_->resize({kPictureSize, kPictureSize}, 0, GL_RGBA8);
    target_->bind();
    glViewport(0, 0, kPictureSize, kPictureSize);
    glEnable(GL_DEPTH_TEST);
    glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    renderer.draw(view, poses_, looks_, all_, false);
    Pixels pixels(4 * kPictureSize * kPictureSize);
    glReadPixels(0, 0, kPictureSize, kPictureSize, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
  }

  /// Of each pixel of the last picture, m from the eye; 0: nothing.
  static Depths depthsOf(const View& view) {
    std::vector<float> values(kPictureSize * kPictureSize);
    glReadPixels(0, 0, kPictureSize, kPictureSize, GL_DEPTH_COMPONENT, GL_FLOAT, values.data());
    Depths depths;
    for (const float value : values) {
      const double clip = 2.0 * static_cast<double>(value) - 1.0;
      depths.push_back(value >= 1.0f ? 0.0
                                     : 2.0 * view.near * view.far /
                                           (view.far + view.near - clip * (view.far - view.near)));
    }
    return depths;
  }
  Depths exactDepths(const View& view) {
    draw(*exact_, view);
    return depthsOf(view);
  }
  Depths settledDepths(const View& view) {
    drawSettled(view);
    draw(*levels_, view);
    return depthsOf(view);
  }

  /// Leaves the processor for a while to those who make levels, which give way to all else.
  static void waitForLevels() { std::this_thread::sleep_for(std::chrono::milliseconds(50)); }

  /// Draws until what is drawn is within a pixel and nothing is being made.
  Pixels drawSettled(const View& view) {
    for (;;) {
      Pixels pixels = draw(*levels_, view);
      if (levels_->pixelsOff() <= kMostPixels && levels_->meshesLeft() == 0) return pixels;
      waitForLevels();
    }
  }

  bool insideOut_ = false;  // the first mesh, and so the third
  const test::TemporaryFolder folder_;
  std::unique_ptr<Surface> surface_;
  assets::Scene scene_;
  std::unique_ptr<SceneRenderer> exact_, levels_;
  std::unique_ptr<GlTarget> target_;
  std::vector<Pose> poses_;
  std::vector<PartLook> looks_;
  std::vector<PartId> all_;
};

TEST_F(DrawnLevelsTest, ShowsSomethingAtOnceAndSoonNoPixelThatIsFurtherOffThanOne) {
  const View near = viewFrom(0.2);
  const Compared first = compare(draw(*exact_, near), draw(*levels_, near));
  EXPECT_GT(levels_->pixelsOff(), kMostPixels) << "what stands in says how far it is off";
  EXPECT_GT(first.inBoth, 50 * first.holes);
  double most = 0.0;
  // From each distance another level is within a pixel.
  for (const double distance : {0.25, 0.4, 0.7, 1.2, 2.0})
    for (const double yaw : {-1.0, 0.1, 0.9}) {
      const View view = viewFrom(distance, yaw);
      const Compared found = compare(draw(*exact_, view), drawSettled(view));
      EXPECT_GT(found.inBoth, 10);
      EXPECT_EQ(found.holes, 0) << distance;
      EXPECT_EQ(found.overhang, 0) << distance;
      most = std::max(most, levels_->pixelsOff());
    }
  EXPECT_GT(most, 0.2) << "levels are drawn";
}

TEST_F(DrawnLevelsTest, TooCoarseALevelHasHolesAndOverhangs) {
  // The first picture shows what stands in.
  const View near = viewFrom(0.2);
  const Compared found = compare(draw(*exact_, near), draw(*levels_, near));
  EXPECT_GT(levels_->pixelsOff(), 2.0);
  EXPECT_GT(found.holes + found.overhang, 0);
}

TEST_F(DrawnLevelsTest, SkipsTheBacksOfFacesAndNothingThatIsSeen) {
  for (const double yaw : {-1.0, 0.1, 0.9}) {
    const View view = viewFrom(0.4, yaw);
    const Depths exact = exactDepths(view);
    EXPECT_LT(shareElsewhere(exact, settledDepths(view)), 0.01);
    // Told to skip the fronts instead, it shows what is behind them.
    glCullFace(GL_FRONT);
    EXPECT_GT(shareElsewhere(exact, settledDepths(view)), 0.5);
    glCullFace(GL_BACK);
  }
}

class InsideOutTest : public DrawnLevelsTest {
 protected:
  InsideOutTest() { insideOut_ = true; }
};

TEST_F(InsideOutTest, AMeshWhoseBacksAreSeenIsDrawnWhole) {
  looks_[1].visible = false;  // the gear, which is as it should be
  for (const double yaw : {-1.0, 0.1, 0.9}) {
    const View view = viewFrom(0.4, yaw);
    EXPECT_LT(shareElsewhere(exactDepths(view), settledDepths(view)), 0.01);
  }
}

TEST_F(DrawnLevelsTest, PicksTheExactSurface) {
  const View view = viewFrom(0.3);
  drawSettled(view);
  int hits = 0;
  for (double x = 20.0; x < kPictureSize; x += 19.0)
    for (double y = 20.0; y < kPictureSize; y += 19.0) {
      const auto expected = exact_->pick(view, {x, y}, poses_, looks_);
      const auto found = levels_->pick(view, {x, y}, poses_, looks_);
      ASSERT_EQ(found.has_value(), expected.has_value());
      if (!found) continue;
      EXPECT_EQ(found->part, expected->part);
      EXPECT_EQ(found->depth, expected->depth);
      ++hits;
    }
  EXPECT_GT(hits, 5);
}

TEST_F(DrawnLevelsTest, CutsTheExactMesh) {
  const document::SectionPlane plane{{0.0, 0.0, 0.004}, {0.0, 0.0, 1.0}};
  for (SceneRenderer* renderer : {exact_.get(), levels_.get()}) renderer->setSections({&plane, 1});
  const View view = viewFrom(0.3);
  const Pixels expected = draw(*exact_, view);
  while (levels_->pixelsOff() > 0.0 || levels_->meshesLeft() > 0) {
    draw(*levels_, view);
    waitForLevels();
  }
  // The first picture after the last mesh came.
  EXPECT_EQ(draw(*levels_, view), expected);
}

TEST_F(DrawnLevelsTest, MakesMeshesOfOneContentOnceAndLeavesTheSceneAlone) {
  const auto before = assets::contentHash(assets::packScene(scene_));
  drawSettled(viewFrom(0.3));
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator(folder_.path())) ++files;
  EXPECT_EQ(files, 2u) << "of three meshes two are equal";
  EXPECT_EQ(assets::contentHash(assets::packScene(scene_)), before) << "what is felt is the scene's meshes";
}

TEST(DrawnLevels, AreNotThereForManySmallMeshesOrAFewTriangles) {
  EXPECT_EQ(DrawnLevels::of(generate::smallParts(2000), {true, ""}), nullptr);
  EXPECT_EQ(DrawnLevels::of(generate::largeAssembly(2, 9000), {true, ""}), nullptr);
}

}  // namespace
}  // namespace tandem::client
