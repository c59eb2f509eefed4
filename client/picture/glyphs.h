#pragma once

// Small solids and lines over a scene: styli, arrows, contact discs, camera frusta. Collected on the CPU each
// frame, drawn in two calls.

#include <memory>
#include <vector>

#include "client/picture/camera.h"
#include "client/picture/gl_objects.h"

namespace tandem::client {

/// Linear RGB and opacity.
using GlyphColour = glm::vec4;

/// Collects solids in eye space. Positions and directions given to it are in world coordinates.
class GlyphBatch {
 public:
  explicit GlyphBatch(const View& view) : view_(view) {}

  void sphere(const glm::dvec3& centre, double radius, const GlyphColour& colour);
  /// A truncated cone; equal radii make a cylinder, a zero radius a tip. Both ends are capped.
  void cone(const glm::dvec3& start, const glm::dvec3& end, double startRadius, double endRadius,
            const GlyphColour& colour);
  void disc(const glm::dvec3& centre, const glm::dvec3& normal, double radius, const GlyphColour& colour);
  void ring(const glm::dvec3& centre, const glm::dvec3& normal, double innerRadius, double outerRadius,
            const GlyphColour& colour);
  /// A thin cylinder about `pixels` wide at the depth of its start.
  void line(const glm::dvec3& start, const glm::dvec3& end, double pixels, const GlyphColour& colour);

  struct Vertex {
    glm::vec3 position{0.0f}, normal{0.0f};
    glm::vec4 colour{0.0f};
  };
  const std::vector<Vertex>& triangles() const { return triangles_; }
  const View& view() const { return view_; }

 private:
  void triangle(const glm::dvec3 (&points)[3], const glm::dvec3 (&normals)[3], const GlyphColour& colour);
  const View& view_;
  std::vector<Vertex> triangles_;
};

class GlyphRenderer {
 public:
  static Result<std::unique_ptr<GlyphRenderer>> make();
  /// Draws into the bound framebuffer; what the scene hides shows faintly through it.
  void draw(const GlyphBatch& batch) const;

 private:
  explicit GlyphRenderer(GlProgram program);
  GlProgram program_;
  GlVertexArray array_;
  GlBuffer buffer_;
};

}  // namespace tandem::client
