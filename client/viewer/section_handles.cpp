#include "client/viewer/section_handles.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace tandem::client {
namespace {

constexpr double kBall = 6.0, kArrow = 52.0, kTipLength = 14.0, kTipWidth = 6.0;  // pixels
constexpr double kNear = 11.0;   // pixels from the handle's line at which the mouse is on it
constexpr double kTurn = 0.006;  // rad a pixel
constexpr double kSteep =
    6.0;  // pixels: an arrow that looks shorter points at the eye and is not dragged along
const GlyphColour kColour(0.05f, 0.30f, 0.55f, 0.85f), kHovered(0.95f, 0.55f, 0.05f, 0.95f);

/// Where a handle stands and where its arrow ends, m.
struct Handle {
  glm::dvec3 foot, tip;

  Handle(const document::SectionPlane& plane, const glm::dvec3& middle, const View& view)
      : foot(middle - glm::dot(plane.normal, middle - plane.point) * plane.normal),
        tip(foot + kArrow * view.pixelAt(foot) * plane.normal) {}
};

double distanceToSegment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
  const glm::dvec2 ab = b - a;
  const double square = glm::dot(ab, ab);
  const double share = square > 0.0 ? std::clamp(glm::dot(p - a, ab) / square, 0.0, 1.0) : 0.0;
  return glm::distance(p, a + share * ab);
}

}  // namespace

std::optional<std::size_t> SectionHandles::under(const View& view, const glm::dvec2& cursor,
                                                 const glm::dvec3& middle, const SectionSet& sections) const {
  const std::vector<document::SectionPlane> planes = sections.planes();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Handle handle(planes[i], middle, view);
    const std::optional<glm::dvec2> foot = view.project(handle.foot), tip = view.project(handle.tip);
    if (foot && tip && distanceToSegment(cursor, *foot, *tip) < kNear) return i;
  }
  return std::nullopt;
}

bool SectionHandles::update(const View& view, const Input& input, const glm::dvec2& cursor, bool cursorInView,
                            const glm::dvec3& middle, SectionSet& sections) {
  const bool gone = hovered_ && *hovered_ >= sections.count();
  if (gone || !input.down[0] || input.pressed[0]) dragging_ = false;  // a release may go unseen
  if (!dragging_) hovered_ = cursorInView ? under(view, cursor, middle, sections) : std::nullopt;
  if (!hovered_) return false;
  if (input.pressed[0]) dragging_ = true;
  if (!dragging_ || input.pressed[0]) return true;
  const Handle handle(sections.planes()[*hovered_], middle, view);
  if (input.shift) {
    const glm::dvec2 turn = kTurn * input.cursorMove;
    const glm::dquat eye = view.worldFromEye.orientation;
    sections.turn(*hovered_,
                  glm::angleAxis(turn.x, eye * glm::dvec3(0.0, 1.0, 0.0)) *
                      glm::angleAxis(turn.y, eye * glm::dvec3(1.0, 0.0, 0.0)),
                  handle.foot);
    return true;
  }
  const std::optional<glm::dvec2> foot = view.project(handle.foot), tip = view.project(handle.tip);
  if (!foot || !tip || glm::distance(*foot, *tip) < kSteep) return true;
  const glm::dvec2 along = *tip - *foot;
  sections.move(*hovered_, glm::dot(input.cursorMove, along) / glm::dot(along, along) *
                               glm::distance(handle.foot, handle.tip));
  return true;
}

void SectionHandles::draw(const SectionSet& sections, const glm::dvec3& middle, GlyphBatch& batch) const {
  const std::vector<document::SectionPlane> planes = sections.planes();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Handle handle(planes[i], middle, batch.view());
    const double px = glm::distance(handle.foot, handle.tip) / kArrow;
    const GlyphColour& colour = hovered_ == i ? kHovered : kColour;
    const glm::dvec3 neck = glm::mix(handle.tip, handle.foot, kTipLength / kArrow);
    batch.sphere(handle.foot, kBall * px, colour);
    batch.line(handle.foot, neck, 2.5, colour);
    batch.cone(neck, handle.tip, kTipWidth * px, 0.0, colour);
  }
}

}  // namespace tandem::client
