#include "client/picture/scene_renderer.h"

#include <gtest/gtest.h>

#include <numbers>

#include "client/marks/part_display.h"
#include "client/viewer/surface.h"
#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

constexpr int kSize = 200;

assets::Part part(assets::ImplicitShape::Kind kind, const glm::dvec3& at) {
  assets::Part out;
  out.worldFromPart.position = at;
  assets::ImplicitShape shape;
  shape.kind = kind;
  shape.size = {0.2, 0.2, 0.2};
  shape.radiusBottom = 0.1;
  out.shapes.push_back(shape);
  return out;
}

/// A ball before a box, seen from the front, drawn on black.
class SceneRendererTest : public testing::Test {
 protected:
  void SetUp() override {
    using Kind = assets::ImplicitShape::Kind;
    scene_.materials.resize(1);
    scene_.parts = {part(Kind::box, {0.0, 0.0, 0.0}), part(Kind::sphere, {0.0, 0.0, 0.4})};
    scene_.bounds.min = {-0.1, -0.1, -0.1};
    scene_.bounds.max = {0.1, 0.1, 0.5};
    auto surface = openOffscreenSurface({});
    if (!surface) GTEST_SKIP() << surface.error().message;
    surface_ = std::move(*surface);
    auto renderer = SceneRenderer::make(scene_);
    ASSERT_TRUE(renderer.ok()) << renderer.error().message;
    renderer_ = std::move(*renderer);
    for (const assets::Part& p : scene_.parts) poses_.push_back(p.worldFromPart);
    looks_.resize(scene_.parts.size());
    Camera camera;
    camera.yaw = camera.pitch = 0.0;
    camera.distance = 1.5;
    view_ = makeView(camera, {kSize, kSize}, {{0.0, 0.0, 0.2}, 0.6});
    target_ = std::make_unique<GlTarget>();
  }
  void TearDown() override {
    target_.reset();
    renderer_.reset();
  }

  /// Pixels that are not black.
  int drawnPixels() {
    target_->resize({kSize, kSize}, 0, GL_RGBA8);
    target_->bind();
    glEnable(GL_DEPTH_TEST);
    glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    const std::vector<PartId> all = {0, 1};
    renderer_->draw(view_, poses_, looks_, all, false);
    std::vector<std::uint8_t> pixels(4 * kSize * kSize);
    glReadPixels(0, 0, kSize, kSize, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    int count = 0;
    for (std::size_t i = 0; i < pixels.size(); i += 4) count += pixels[i] > 5 ? 1 : 0;
    return count;
  }

  assets::Scene scene_;
  std::unique_ptr<Surface> surface_;
  std::unique_ptr<SceneRenderer> renderer_;
  std::unique_ptr<GlTarget> target_;
  std::vector<Pose> poses_;
  std::vector<PartLook> looks_;
  View view_;
};

TEST_F(SceneRendererTest, ASphereCoversTheDiscThatGeometryPredicts) {
  looks_[0].visible = false;
  // The silhouette of a sphere of radius r at distance d has the angle asin(r / d).
  const double d = 1.1, r = 0.1;
  const double pixels = std::tan(std::asin(r / d)) / view_.metresPerPixel(1.0);
  const double expected = std::numbers::pi * pixels * pixels;
  EXPECT_NEAR(drawnPixels(), expected, 0.03 * expected);
}

TEST_F(SceneRendererTest, HiddenPartsAreNeitherDrawnNorPicked) {
  EXPECT_GT(drawnPixels(), 100);
  for (PartLook& look : looks_) look.visible = false;
  EXPECT_EQ(drawnPixels(), 0);
  EXPECT_FALSE(renderer_->pick(view_, {100.0, 100.0}, poses_, looks_).has_value());
}

TEST_F(SceneRendererTest, PicksTheNearestPartAndItsDepth) {
  auto hit = renderer_->pick(view_, {100.0, 100.0}, poses_, looks_);
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->part, 1);
  EXPECT_NEAR(hit->point.z, 0.5, 2e-3);
  looks_[1].visible = false;
  hit = renderer_->pick(view_, {100.0, 100.0}, poses_, looks_);
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->part, 0);
  EXPECT_NEAR(hit->depth, 1.4, 1e-3);
  EXPECT_FALSE(renderer_->pick(view_, {3.0, 3.0}, poses_, looks_).has_value());
}

TEST_F(SceneRendererTest, PicksWhatIsDrawnAtEveryPixelTried) {
  poses_[1].position = {0.07, 0.03, 0.4};
  for (double x = 40.0; x < 160.0; x += 13.0)
    for (double y = 40.0; y < 160.0; y += 13.0) {
      const auto hit = renderer_->pick(view_, {x, y}, poses_, looks_);
      const glm::dvec3 origin = view_.worldFromEye.position;
      const glm::dvec3 direction = glm::normalize(view_.pointAt({x, y}, 1.0) - origin);
      const glm::dvec3 toCentre = poses_[1].position - origin;
      const double off = glm::length(glm::cross(toCentre, direction));
      if (off < 0.097) {
        ASSERT_TRUE(hit.has_value()) << x << ' ' << y;
        EXPECT_EQ(hit->part, 1);
      }
      if (off > 0.103 && hit) {
        EXPECT_EQ(hit->part, 0) << x << ' ' << y;
      }
    }
}

TEST_F(SceneRendererTest, WhatIsCutAwayIsNeitherDrawnNorPickedAndTheCutIsCovered) {
  // The ball is cut away whole, and half of the box; the eye looks at the cut from the front.
  const document::SectionPlane front{{0.0, 0.0, 0.05}, {0.0, 0.0, 1.0}};
  renderer_->setSections({&front, 1});
  const auto hit = renderer_->pick(view_, {100.0, 100.0}, poses_, looks_);
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->part, 0);
  EXPECT_NEAR(hit->point.z, 0.05, 2e-3) << "the cover of the cut";
  const double side = 0.2 / view_.metresPerPixel(view_.worldFromEye.position.z - 0.05);
  EXPECT_NEAR(drawnPixels(), side * side, 0.03 * side * side) << "the whole cut is covered";
  // Two planes leave a quarter of it.
  const document::SectionPlane both[] = {front, {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}};
  renderer_->setSections(both);
  EXPECT_FALSE(renderer_->pick(view_, {110.0, 100.0}, poses_, looks_).has_value());
  EXPECT_NEAR(drawnPixels(), 0.5 * side * side, 0.03 * side * side);
  renderer_->setSections({});
  EXPECT_EQ(renderer_->pick(view_, {100.0, 100.0}, poses_, looks_)->part, 1) << "whole again";
}

TEST_F(SceneRendererTest, TheCutIsCoveredFromWhereverItIsSeen) {
  const document::SectionPlane front{{0.0, 0.0, 0.05}, {0.0, 0.0, 1.0}};
  renderer_->setSections({&front, 1});
  for (const double yaw : {-1.1, -0.4, 0.3, 0.7, 1.2})
    for (const double pitch : {-0.9, -0.2, 0.5})
      for (const glm::dvec2& at :
           {glm::dvec2(-0.09, -0.09), glm::dvec2(0.09, -0.05), glm::dvec2(0.03, 0.08)}) {
        Camera camera;
        camera.yaw = yaw;
        camera.pitch = pitch;
        camera.distance = 1.5;
        const View view = makeView(camera, {kSize, kSize}, {{0.0, 0.0, 0.2}, 0.6});
        const glm::dvec3 onCut(at.x, at.y, 0.05);
        const auto pixel = view.project(onCut);
        ASSERT_TRUE(pixel.has_value());
        const auto hit = renderer_->pick(view, *pixel, poses_, looks_);
        ASSERT_TRUE(hit.has_value()) << yaw << ' ' << pitch;
        EXPECT_LT(glm::length(hit->point - onCut), 0.01) << yaw << ' ' << pitch;
      }
}

TEST(SectionSet, AreReadFromTextOrRefused) {
  SectionSet sections;
  EXPECT_FALSE(sections.any());
  ASSERT_TRUE(sections.add("x=0.05").ok());
  ASSERT_TRUE(sections.add("-z=-1e-3").ok());
  for (const char* wrong : {"", "x", "w=1", "x=", "x=1m", "x=nan", "x=1e9", "--x=1", "x=0.06"})
    EXPECT_FALSE(sections.add(wrong).ok()) << wrong;
  const std::vector<document::SectionPlane> planes = sections.planes();
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_EQ(planes[0].point.x, 0.05);
  EXPECT_EQ(planes[0].normal, glm::dvec3(1.0, 0.0, 0.0));
  EXPECT_EQ(planes[1].normal, glm::dvec3(0.0, 0.0, -1.0));
}

TEST(SectionSet, TakesPlanesOfAnyDirectionAndNoMoreThanEight) {
  SectionSet sections;
  ASSERT_TRUE(sections.add("0,3,4,-0.1").ok());
  for (const char* wrong : {"0,0,0,1", "1,2,3", "1,2,3,4,5", "1,2,3,x", "1,nan,0,1", "1,0,0,1e9", ","})
    EXPECT_FALSE(sections.add(wrong).ok()) << wrong;
  ASSERT_EQ(sections.planes().size(), 1u);
  EXPECT_LT(glm::length(sections.planes()[0].normal - glm::dvec3(0.0, 0.6, 0.8)), 1e-12);
  EXPECT_LT(glm::length(sections.planes()[0].point - glm::dvec3(0.0, -0.06, -0.08)), 1e-12);
  ASSERT_TRUE(sections.addAll({"x=1", "-x=0", "y=1", "-y=0", "z=1", "-z=0", "1,1,1,0"}).ok());
  EXPECT_TRUE(sections.full());
  EXPECT_FALSE(sections.add("1,0,1,0").ok());
}

TEST(PartDisplay, IsolatingTwiceShowsEverythingAgain) {
  PartDisplay display(3);
  display.setHidden(2, true);
  display.isolate({1, 2});
  EXPECT_FALSE(display.visible(0));
  EXPECT_TRUE(display.visible(1) && display.visible(2));
  display.isolate({1, 2});
  EXPECT_TRUE(display.visible(0) && display.visible(1) && display.visible(2));
  display.setHidden(0, true);
  display.setTransparent(1, true);
  display.showAll();
  EXPECT_TRUE(display.visible(0));
  EXPECT_FALSE(display.transparent(1));
}

TEST(PartDisplay, WhatIsHiddenMayBeAGhostThatNoClickTakes) {
  assets::Scene scene;
  ViewModel model;
  model.scene = &scene;
  model.worldFromPart.resize(2);
  PartDisplay display(2);
  display.isolate({1});
  std::vector<PartLook> looks;
  partLooks(model, display, looks);
  EXPECT_FALSE(looks[0].visible);
  display.style.ghosts = true;
  partLooks(model, display, looks);
  EXPECT_TRUE(looks[0].visible);
  EXPECT_FALSE(looks[0].pickable);
  EXPECT_LT(looks[0].alpha, 0.1f);
  EXPECT_EQ(looks[1], PartLook{});
}

TEST(PartDisplay, ColoursTellBodiesMaterialsAndOwnersApart) {
  test::SceneBuilder builder;
  const std::uint32_t box = builder.addMesh(test::boxMesh(glm::dvec3(0.1)));
  for (int i = 0; i < 2; ++i) builder.addPart(box);
  builder.addPart(test::boxMesh(glm::dvec3(0.2)));
  builder.scene.materials.emplace_back();
  for (auto& material : builder.scene.meshes[1].triangleMaterial) material = 1;
  ViewModel model;
  model.scene = &builder.scene;
  model.worldFromPart.resize(3);
  model.owner = {kNoSite, 5, kNoSite};
  SiteView site;
  site.info.site = 5;
  site.info.colour = {0, 0, 255};
  model.sites.push_back(site);
  PartDisplay display(3);
  std::vector<PartLook> looks;
  for (const PartColouring colouring : {PartColouring::byBody, PartColouring::byMaterial}) {
    display.style.colouring = colouring;
    partLooks(model, display, looks);
    EXPECT_NE(looks[0].tint, looks[2].tint);
    EXPECT_GT(looks[1].tint.z, 0.9f) << "who holds a part is told all the same";
  }
  EXPECT_EQ(colourOf(builder.scene, 0, PartColouring::byBody),
            colourOf(builder.scene, 1, PartColouring::byBody));
  display.style.colouring = PartColouring::byOwner;
  partLooks(model, display, looks);
  EXPECT_EQ(looks[0].tint, looks[2].tint);
  EXPECT_GT(looks[1].tint.z, 0.9f);
}

TEST(PartDisplay, MarksOwnedTouchedAndSelectedPartsApart) {
  assets::Scene scene;
  ViewModel model;
  model.scene = &scene;
  model.worldFromPart.resize(4);
  model.owner = {kNoSite, 5, kNoSite, kNoSite};
  SiteView site;
  site.info.site = 5;
  site.info.colour = {0, 0, 255};
  model.sites.push_back(site);
  model.hand.touched = 2;
  PartDisplay display(4);
  display.selected = 3;
  std::vector<PartLook> looks;
  partLooks(model, display, looks);
  EXPECT_EQ(looks[0], PartLook{});
  EXPECT_GT(looks[1].tintAmount, 0.0f);
  EXPECT_GT(looks[1].tint.z, 0.9f);
  EXPECT_GT(looks[2].edgeWidth, 0.0f);
  EXPECT_EQ(looks[2].tintAmount, 0.0f);
  EXPECT_GT(looks[3].edgeWidth, looks[2].edgeWidth);
}

}  // namespace
}  // namespace tandem::client
