#include "client/viewer/still_pictures.h"

#include <epoxy/gl.h>

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "client/picture/glyphs.h"
#include "client/picture/png.h"
#include "client/picture/scene_picture.h"
#include "client/picture/scene_renderer.h"
#include "client/viewer/surface.h"
#include "client/viewer/theme.h"

namespace tandem::client {
namespace {

const glm::vec3 kMarkTint(0.90f, 0.30f, 0.04f);  // linear
constexpr GlyphColour kPlaceColour(0.85f, 0.08f, 0.03f, 1.0f);
constexpr double kPlacePixels = 5.0, kLinePixels = 3.0;

class OffscreenStills final : public StillPictures {
 public:
  OffscreenStills(const assets::Scene& scene, std::unique_ptr<Surface> surface,
                  std::unique_ptr<SceneRenderer> parts, std::unique_ptr<GlyphRenderer> glyphs)
      : scene_(scene), surface_(std::move(surface)), parts_(std::move(parts)), glyphs_(std::move(glyphs)) {}
  ~OffscreenStills() override { surface_->makeCurrent(); }

  std::vector<std::uint8_t> draw(const Still& still, std::span<const Pose> worldFromPart) override {
    ASSERT(worldFromPart.size() == scene_.parts.size());
    surface_->makeCurrent();
    const glm::ivec2 size = surface_->framebufferSize();
    const View view = viewOf(still, worldFromPart);
    const std::vector<PartLook> looks = looksOf(still);
    parts_->setSections(still.sections);
    GlyphBatch batch(view);
    addMarks(still, batch);
    picture_.update({view, worldFromPart, looks, batch, theme::kBackground}, size, *parts_, *glyphs_);
    picture_.show(surface_->framebuffer(), {0, 0});
    std::vector<std::uint8_t> rgb(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * 3);
    glBindFramebuffer(GL_FRAMEBUFFER, surface_->framebuffer());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.x, size.y, GL_RGB, GL_UNSIGNED_BYTE, rgb.data());
    return encodePng(size.x, size.y, rgb);
  }

 private:
  /// The still's own eye: unlike the camera of a window it may roll.
  View viewOf(const Still& still, std::span<const Pose> worldFromPart) const {
    Sphere content{0.5 * (scene_.bounds.min + scene_.bounds.max), 0.0};
    content.radius = parts_->reachFrom(content.centre, worldFromPart);
    Camera camera;
    camera.fieldOfView = still.fieldOfView;
    camera.distance = std::max(glm::length(still.worldFromEye.position - content.centre), 1e-3);
    View view = makeView(cameraAt(still.worldFromEye, camera), glm::dvec2(surface_->size()), content);
    view.worldFromEye = still.worldFromEye;
    view.eyeFromWorld = inverse(view.worldFromEye);
    return view;
  }

  std::vector<PartLook> looksOf(const Still& still) const {
    std::vector<PartLook> looks(scene_.parts.size());
    for (PartLook& look : looks) look.visible = !still.onlyThese;
    for (const PartId part : still.parts) looks.at(part).visible = still.onlyThese;
    for (std::size_t i = 0; i < still.marked.size(); ++i) {
      PartLook& look = looks.at(still.marked[i]);
      look.tint = i == 0 ? kMarkTint : glm::vec3(0.03f, 0.25f, 0.75f);  // two that clash are told apart
      look.tintAmount = 0.55f;
    }
    return looks;
  }

  static void addMarks(const Still& still, GlyphBatch& batch) {
    const View& view = batch.view();
    for (const glm::dvec3& place : still.places) {
      const double depth = std::max(view.depthOf(place), view.near);
      batch.sphere(place, kPlacePixels * view.metresPerPixel(depth), kPlaceColour);
    }
    for (const auto& [start, end] : still.lines) batch.line(start, end, kLinePixels, kPlaceColour);
  }

  const assets::Scene& scene_;
  std::unique_ptr<Surface> surface_;
  std::unique_ptr<SceneRenderer> parts_;
  std::unique_ptr<GlyphRenderer> glyphs_;
  ScenePicture picture_;
};

}  // namespace

Result<std::unique_ptr<StillPictures>> StillPictures::open(const assets::Scene& scene, int width,
                                                           int height) {
  ViewerOptions options;
  options.width = width;
  options.height = height;
  Result<std::unique_ptr<Surface>> surface = openOffscreenSurface(options);
  if (!surface) return surface.error();
  (*surface)->makeCurrent();
  auto parts = SceneRenderer::make(scene);
  if (!parts) return parts.error();
  auto glyphs = GlyphRenderer::make();
  if (!glyphs) return glyphs.error();
  return std::unique_ptr<StillPictures>(
      std::make_unique<OffscreenStills>(scene, std::move(*surface), std::move(*parts), std::move(*glyphs)));
}

}  // namespace tandem::client
