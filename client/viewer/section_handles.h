#pragma once

// Handles of section planes in the picture: a ball and an arrow in the middle of each, by which the mouse
// moves the plane along the arrow, or turns one of any direction with shift.

#include <optional>

#include "client/marks/section_set.h"
#include "client/picture/camera.h"
#include "client/picture/glyphs.h"
#include "client/viewer/surface.h"

namespace tandem::client {

class SectionHandles {
 public:
  /// True while the mouse is on a handle or drags one; then it is nobody else's. `cursor` in pixels of the
  /// view; `middle`: of the scene, m.
  bool update(const View& view, const Input& input, const glm::dvec2& cursor, bool cursorInView,
              const glm::dvec3& middle, SectionSet& sections);
  void draw(const SectionSet& sections, const glm::dvec3& middle, GlyphBatch& batch) const;

 private:
  std::optional<std::size_t> under(const View& view, const glm::dvec2& cursor, const glm::dvec3& middle,
                                   const SectionSet& sections) const;

  std::optional<std::size_t> hovered_;  // index into SectionSet::planes()
  bool dragging_ = false;
};

}  // namespace tandem::client
