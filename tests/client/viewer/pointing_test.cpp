// A click of the mouse as a hand takes the part that is seen under the cursor, wherever the tip is. What is
// seen is found here by brute force over all triangles, not by the renderer that is tested.

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <random>

#include "assets/gltf/load_gltf.h"
#include "client/picture/camera.h"
#include "client/viewer/viewer.h"
#include "tests/support/source_file.h"

namespace tandem::client {
namespace {

constexpr int kPointedWidth = 640, kPointedHeight = 400;

/// Distance along a ray to a triangle; nothing if it misses (Moeller & Trumbore 1997).
std::optional<double> distanceTo(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& a,
                                 const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 ab = b - a, ac = c - a, p = glm::cross(direction, ac);
  const double determinant = glm::dot(ab, p);
  if (determinant == 0.0) return std::nullopt;
  const glm::dvec3 s = origin - a, q = glm::cross(s, ab);
  const double u = glm::dot(s, p) / determinant, v = glm::dot(direction, q) / determinant;
  const double t = glm::dot(ac, q) / determinant;
  if (u < 0.0 || v < 0.0 || u + v > 1.0 || t <= 0.0) return std::nullopt;
  return t;
}

/// The part that a ray from the eye through a pixel meets first, or kNoPart.
PartId seenThrough(const assets::Scene& scene, const View& view, const glm::dvec2& pixel) {
  const glm::dvec3 eye = view.worldFromEye.position;
  const glm::dvec3 direction = glm::normalize(view.pointAt(pixel, 1.0) - eye);
  double nearest = 1e300;
  PartId seen = kNoPart;
  for (std::size_t p = 0; p < scene.parts.size(); ++p) {
    const assets::Part& part = scene.parts[p];
    const assets::Mesh& mesh = scene.meshes[part.mesh];
    for (const auto& corners : mesh.triangles) {
      const auto at = [&](int i) {
        return transformPoint(part.worldFromPart, mesh.positions[corners[static_cast<std::size_t>(i)]]);
      };
      const std::optional<double> t = distanceTo(eye, direction, at(0), at(1), at(2));
      if (!t || *t >= nearest) continue;
      nearest = *t;
      seen = static_cast<PartId>(p);
    }
  }
  return seen;
}

class PointingTest : public testing::Test {
 protected:
  void SetUp() override {
    Result<assets::Scene> loaded = assets::loadGltf(sourceFile("assets/scenes/pump.glb"), {});
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    scene_ = std::move(*loaded);
    ViewerOptions options;
    options.width = kPointedWidth;
    options.height = kPointedHeight;
    options.panels = false;
    auto opened = Viewer::openOffscreen(scene_, options);
    if (!opened) GTEST_SKIP() << opened.error().message;
    viewer_ = std::move(*opened);
    model_.scene = &scene_;
    for (const assets::Part& part : scene_.parts) model_.worldFromPart.push_back(part.worldFromPart);
    model_.owner.assign(scene_.parts.size(), kNoSite);
    model_.role = sync::Role::participant;
    viewer_->frame(model_);
  }

  View view() const {
    return makeView(viewer_->camera(), {kPointedWidth, kPointedHeight},
                    {0.5 * (scene_.bounds.min + scene_.bounds.max), 1.0});
  }

  /// Whether what is seen is the same over a few pixels: at an edge two right answers differ.
  PartId seenAround(const glm::dvec2& pixel) const {
    const PartId seen = seenThrough(scene_, view(), pixel);
    for (const glm::dvec2& offset :
         {glm::dvec2(1.5, 0.0), glm::dvec2(-1.5, 0.0), glm::dvec2(0.0, 1.5), glm::dvec2(0.0, -1.5)})
      if (seenThrough(scene_, view(), pixel + offset) != seen) return kNoPart;
    return seen;
  }

  /// One frame with the button up, one with it down.
  ViewActions click(const glm::dvec2& pixel) {
    viewer_->pointMouse(pixel, false);
    EXPECT_FALSE(viewer_->frame(model_).grasp);
    viewer_->pointMouse(pixel, true);
    return viewer_->frame(model_);
  }

  assets::Scene scene_;
  std::unique_ptr<Viewer> viewer_;
  ViewModel model_;
};

TEST_F(PointingTest, AClickTakesTheVisiblePartUnderTheCursor) {
  std::mt19937_64 random(7);
  const auto below = [&](int n) {
    return static_cast<double>(random() % static_cast<std::uint64_t>(n)) + 0.5;
  };
  int clicks = 0;
  for (int tries = 0; clicks < 50 && tries < 20000; ++tries) {
    const glm::dvec2 pixel(below(kPointedWidth), below(kPointedHeight));
    const PartId seen = seenAround(pixel);
    if (seen == kNoPart || !scene_.parts[seen].movable) continue;
    ++clicks;
    // The tip may be near to any other part: what the stylus touches does not decide.
    model_.hand.touched = static_cast<PartId>(random() % scene_.parts.size());
    const ViewActions actions = click(pixel);
    EXPECT_TRUE(actions.grasp);
    EXPECT_EQ(actions.graspedAt, seen) << pixel.x << ", " << pixel.y;
  }
  EXPECT_EQ(clicks, 50);
}

TEST_F(PointingTest, WhatWasUnderTheCursorIsKeptWhileTheButtonIsDown) {
  const glm::dvec2 middle(0.5 * kPointedWidth, 0.5 * kPointedHeight);
  const PartId taken = click(middle).graspedAt;
  ASSERT_NE(taken, kNoPart);
  viewer_->pointMouse({3.0, 3.0}, true);
  EXPECT_EQ(viewer_->frame(model_).graspedAt, taken);
  viewer_->pointMouse({3.0, 3.0}, false);
  const ViewActions lifted = viewer_->frame(model_);
  EXPECT_FALSE(lifted.grasp);
  EXPECT_EQ(lifted.graspedAt, kNoPart);
}

TEST_F(PointingTest, AClickBesideAllPartsLeavesTheChoiceToTheTip) {
  const ViewActions actions = click({3.0, 3.0});
  EXPECT_TRUE(actions.grasp);
  EXPECT_EQ(actions.graspedAt, kNoPart);
}

}  // namespace
}  // namespace tandem::client
