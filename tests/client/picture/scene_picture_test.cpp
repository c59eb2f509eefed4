#include "client/picture/scene_picture.h"

#include <gtest/gtest.h>

#include "client/viewer/surface.h"
#include "tests/support/shapes.h"

namespace tandem::client {
namespace {

using Pixels = std::vector<std::uint8_t>;

/// Two boxes, and a ball over them.
class ScenePictureTest : public testing::Test {
 protected:
  void SetUp() override {
    auto surface = openOffscreenSurface({});
    if (!surface) GTEST_SKIP() << surface.error().message;
    surface_ = std::move(*surface);
    test::SceneBuilder builder;
    builder.addPart(test::boxMesh({0.2, 0.1, 0.15}));
    builder.addPart(test::boxMesh({0.1, 0.2, 0.1}), {{0.15, 0.05, 0.1}, {1.0, 0.0, 0.0, 0.0}});
    scene_ = builder.scene;
    for (const assets::Part& part : scene_.parts) poses_.push_back(part.worldFromPart);
    looks_.resize(scene_.parts.size());
    auto parts = SceneRenderer::make(scene_);
    ASSERT_TRUE(parts.ok());
    parts_ = std::move(*parts);
    auto glyphs = GlyphRenderer::make();
    ASSERT_TRUE(glyphs.ok());
    glyphs_ = std::move(*glyphs);
    kept_ = std::make_unique<ScenePicture>();
  }
  void TearDown() override {
    kept_.reset();
    glyphs_.reset();
    parts_.reset();
  }

  Pixels drawnBy(ScenePicture& picture, double yaw, double ballAt, const glm::ivec2& size) {
    Camera camera;
    camera.yaw = yaw;
    camera.distance = 1.0;
    const View view = makeView(camera, glm::dvec2(size), {{0.0, 0.0, 0.0}, 0.4});
    GlyphBatch ball(view);
    ball.sphere({ballAt, 0.0, 0.15}, 0.04, {0.9f, 0.2f, 0.1f, 1.0f});
    picture.update({view, poses_, looks_, ball, {glm::vec3(0.9f), glm::vec3(0.5f)}}, size, *parts_, *glyphs_);
    // The size of a target cannot be other than that of the picture.
    GlTarget target;
    target.resize(size, 0, GL_RGBA8);
    picture.show(target.framebuffer(), {0, 0});
    Pixels pixels(4 * static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
    target.bind();
    glReadPixels(0, 0, size.x, size.y, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
  }

  /// What the picture that has been drawn before shows next, and one that has not.
  void expectAsIfNew(double yaw, double ballAt, const glm::ivec2& size) {
    ScenePicture fresh;
    const Pixels found = drawnBy(*kept_, yaw, ballAt, size);
    EXPECT_EQ(found, drawnBy(fresh, yaw, ballAt, size)) << yaw << ' ' << ballAt << ' ' << size.x;
    EXPECT_NE(found, drawnBy(fresh, yaw + 0.1, ballAt, size));
    EXPECT_NE(found, drawnBy(fresh, yaw, ballAt + 0.05, size));
  }

  std::unique_ptr<Surface> surface_;
  assets::Scene scene_;
  std::vector<Pose> poses_;
  std::vector<PartLook> looks_;
  std::unique_ptr<SceneRenderer> parts_;
  std::unique_ptr<GlyphRenderer> glyphs_;
  std::unique_ptr<ScenePicture> kept_;
};

TEST_F(ScenePictureTest, ShowsWhatIsThereWhileTheCameraTurnsAndWhileItRests) {
  const glm::ivec2 size(160, 120);
  for (const double yaw : {0.0, 0.1, 0.2, 0.3}) expectAsIfNew(yaw, 0.0, size);  // turns
  for (const double ballAt : {0.02, 0.04, 0.06}) expectAsIfNew(0.3, ballAt, size);
  for (const double yaw : {0.4, 0.5}) {  // turns in every second picture
    expectAsIfNew(yaw, 0.06, size);
    expectAsIfNew(yaw, 0.08, size);
  }
}

TEST_F(ScenePictureTest, ShowsWhatIsThereWhenItsSizeChangesAndChangesBack) {
  const glm::ivec2 size(160, 120), other(100, 90);
  for (const double ballAt : {0.0, 0.02}) expectAsIfNew(0.3, ballAt, size);
  for (const double yaw : {0.4, 0.5}) expectAsIfNew(yaw, 0.02, other);
  for (const double ballAt : {0.02, 0.04}) expectAsIfNew(0.3, ballAt, size);
}

}  // namespace
}  // namespace tandem::client
