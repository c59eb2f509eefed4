#include "client/picture/field_glyphs.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

#include "haptics/fields/field_path.h"

namespace tandem::client {
namespace {

using assets::FieldRegion;
using assets::ForceField;

constexpr double kArrowLength = 54.0, kHead = 13.0, kHeadRadius = 5.5;  // pixels
constexpr double kCentreRadius = 4.5, kRingRadius = 16.0;
const GlyphColour kFieldColour(0.24f, 0.07f, 0.42f, 0.75f);
const GlyphColour kRegionColour(0.24f, 0.07f, 0.42f, 0.30f);

/// Draws the mark of one field.
struct Mark {
  GlyphBatch& batch;
  const ForceField& field;
  Pose worldFromField;
  double px;  // m per pixel at the field's origin

  glm::dvec3 at(const glm::dvec3& x) const { return transformPoint(worldFromField, x); }

  void arrow(const glm::dvec3& along) const {
    const double length = glm::length(along);
    if (!(length > 0.0)) return;
    const glm::dvec3 tip = along * (kArrowLength * px / length), neck = tip * (1.0 - kHead / kArrowLength);
    batch.line(at({}), at(neck), 2.2, kFieldColour);
    batch.cone(at(neck), at(tip), kHeadRadius * px, 0.0, kFieldColour);
  }
  void polyline(const std::vector<glm::dvec3>& points, const GlyphColour& colour) const {
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      batch.line(at(points[i]), at(points[i + 1]), 1.6, colour);
  }
  /// Draws the path that is felt as short segments.
  void path() const {
    const haptics::FieldPath curve(field.points, field.smooth, field.closed);
    const int pieces = static_cast<int>(curve.pieces()), steps = field.smooth ? 8 : 1;
    std::vector<glm::dvec3> points;
    for (int i = 0; i <= pieces * steps; ++i) points.push_back(curve.point(static_cast<double>(i) / steps));
    polyline(points, kFieldColour);
  }
  /// Draws a ring and its axis, so that the mark is visible from the side too.
  void ring(const glm::dvec3& axis) const {
    ringAbout(transformVector(worldFromField, axis));
    batch.line(at({}), at(axis * (kRingRadius * px)), 1.6, kFieldColour);
  }
  /// Draws the ring of a field without direction, facing the eye.
  void ringTowardsEye() const {
    ringAbout(batch.view().worldFromEye.orientation * glm::dvec3(0.0, 0.0, 1.0));
  }
  void ringAbout(const glm::dvec3& normal) const {
    batch.ring(at({}), normal, 0.8 * kRingRadius * px, kRingRadius * px, kFieldColour);
  }
  void centre() const { batch.sphere(at({}), kCentreRadius * px, kFieldColour); }

  void region() const {
    const FieldRegion& region = field.region;
    if (region.kind == FieldRegion::Kind::box) {
      for (int edge = 0; edge < 12; ++edge) {
        const int axis = edge / 4, a = (axis + 1) % 3, b = (axis + 2) % 3;
        glm::dvec3 from = region.halfSize;
        if (edge & 1) from[a] = -from[a];
        if (edge & 2) from[b] = -from[b];
        glm::dvec3 to = from;
        to[axis] = -to[axis];
        batch.line(at(from), at(to), 1.2, kRegionColour);
      }
    } else if (region.kind == FieldRegion::Kind::sphere) {
      circles(region.radius);
    }
  }
  void circles(double radius) const {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<glm::dvec3> points;
      for (int i = 0; i <= 48; ++i) {
        glm::dvec3 x(0.0);
        x[(axis + 1) % 3] = radius * std::cos(glm::two_pi<double>() * i / 48);
        x[(axis + 2) % 3] = radius * std::sin(glm::two_pi<double>() * i / 48);
        points.push_back(x);
      }
      polyline(points, kRegionColour);
    }
  }
};

void addMark(const Mark& mark) {
  const ForceField& field = mark.field;
  switch (field.kind) {
    case ForceField::Kind::waveform:
      mark.arrow(-field.force);
      [[fallthrough]];
    case ForceField::Kind::constant:
      mark.arrow(field.force);
      break;
    case ForceField::Kind::spring:
    case ForceField::Kind::guide:
      if (field.anchor == ForceField::Anchor::path)
        mark.path();
      else if (field.anchor == ForceField::Anchor::point)
        mark.centre();
      else
        mark.ring(field.axis);
      break;
    case ForceField::Kind::gravity:
    case ForceField::Kind::potential:
      mark.centre();
      break;
    case ForceField::Kind::damper:
    case ForceField::Kind::viscosity:
      mark.ringTowardsEye();
      break;
  }
  mark.region();
}

}  // namespace

void addFields(const ViewModel& model, GlyphBatch& batch) {
  const View& view = batch.view();
  for (const ForceField& field : model.scene->fields) {
    const bool moves = field.part < model.worldFromPart.size();
    const Pose worldFromField =
        moves ? model.worldFromPart[field.part] * field.partFromField : field.partFromField;
    const double depth = std::max(view.depthOf(worldFromField.position), view.near);
    addMark({batch, field, worldFromField, view.metresPerPixel(depth)});
  }
}

}  // namespace tandem::client
