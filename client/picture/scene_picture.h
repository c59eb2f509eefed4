#pragma once

// Keeps the picture of a scene between frames and redraws only what has changed. A layer holds the parts at
// rest; moving parts, transparent parts and glyphs are drawn over it. Redrawing everything while a hand moves
// would take a software renderer the cores that the haptic loop needs.

#include <cstdint>
#include <span>
#include <vector>

#include "client/picture/glyphs.h"
#include "client/picture/scene_renderer.h"

namespace tandem::client {

class ScenePicture {
 public:
  /// Everything that one picture shows.
  struct Content {
    const View& view;
    std::span<const Pose> worldFromPart;
    std::span<const PartLook> looks;
    const GlyphBatch& glyphs;
    Background background;
    bool edges = true;
    // A part that is drawn at further poses too.
    PartId again = kNoPart;
    std::span<const Pose> worldFromAgain{};
    PartLook lookAgain{};
  };

  /// Brings the picture up to date; `size` in pixels.
  void update(const Content& content, const glm::ivec2& size, const SceneRenderer& parts,
              const GlyphRenderer& glyphs);
  /// Copies the picture into the bound draw framebuffer, its lower left corner at `corner`.
  void show(unsigned framebuffer, const glm::ivec2& corner) const;

 private:
  void sortParts(const Content& content);
  std::uint64_t hashOfLayer(const Content& content, const glm::ivec2& size, const SceneRenderer& parts) const;
  std::uint64_t hashOfRest(const Content& content) const;
  void drawAgain(const Content& content, const SceneRenderer& parts);
  void drawResting(const Content& content, const SceneRenderer& parts, const GlTarget& target) const;

  GlTarget layer_, multisampled_, resolved_;
  std::vector<PartId> resting_, moving_;
  std::vector<Pose> lastPose_;
  std::vector<Pose> posesAgain_;
  std::vector<PartLook> looksAgain_;
  std::vector<std::uint32_t> framesAtRest_;
  std::uint64_t lastLayer_ = 0, lastRest_ = 0;
  bool layerKept_ = false;     // layer_ holds the parts at rest of the last picture
  bool layerChanges_ = false;  // they were not those of the picture before
};

}  // namespace tandem::client
