#include "client/picture/glyphs.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

#include "assets/base/across.h"
#include "assets/base/assert.h"
#include "client/picture/shaders.h"

namespace tandem::client {
namespace {

constexpr int kSides = 20;
constexpr int kSphereRings = 10;
constexpr float kHiddenOpacity = 0.16f;  // of glyphs behind the scene's surfaces

glm::dvec3 around(const std::pair<glm::dvec3, glm::dvec3>& basis, int side) {
  const double angle = glm::two_pi<double>() * side / kSides;
  return basis.first * std::cos(angle) + basis.second * std::sin(angle);
}

glm::dvec3 onSphere(int ring, int side) {
  const double polar = glm::pi<double>() * ring / kSphereRings, angle = glm::two_pi<double>() * side / kSides;
  return {std::sin(polar) * std::cos(angle), std::cos(polar), std::sin(polar) * std::sin(angle)};
}

}  // namespace

void GlyphBatch::triangle(const glm::dvec3 (&points)[3], const glm::dvec3 (&normals)[3],
                          const GlyphColour& colour) {
  for (int k = 0; k < 3; ++k)
    triangles_.push_back({glm::vec3(transformPoint(view_.eyeFromWorld, points[k])),
                          glm::vec3(transformVector(view_.eyeFromWorld, normals[k])), colour});
}

void GlyphBatch::sphere(const glm::dvec3& centre, double radius, const GlyphColour& colour) {
  for (int ring = 0; ring < kSphereRings; ++ring)
    for (int side = 0; side < kSides; ++side) {
      const glm::dvec3 a = onSphere(ring, side), b = onSphere(ring + 1, side), c = onSphere(ring, side + 1),
                       d = onSphere(ring + 1, side + 1);
      const auto at = [&](const glm::dvec3& n) { return centre + radius * n; };
      if (ring > 0) triangle({at(a), at(b), at(c)}, {a, b, c}, colour);
      if (ring + 1 < kSphereRings) triangle({at(c), at(b), at(d)}, {c, b, d}, colour);
    }
}

void GlyphBatch::cone(const glm::dvec3& start, const glm::dvec3& end, double startRadius, double endRadius,
                      const GlyphColour& colour) {
  const double length = glm::length(end - start);
  if (!(length > 0.0)) return;
  const glm::dvec3 axis = (end - start) / length;
  const auto basis = acrossOf(axis);
  for (int side = 0; side < kSides; ++side) {
    const glm::dvec3 u = around(basis, side), v = around(basis, side + 1);
    const glm::dvec3 nu = glm::normalize(u * length + axis * (startRadius - endRadius));
    const glm::dvec3 nv = glm::normalize(v * length + axis * (startRadius - endRadius));
    const glm::dvec3 a = start + u * startRadius, b = start + v * startRadius;
    const glm::dvec3 c = end + u * endRadius, d = end + v * endRadius;
    if (startRadius > 0.0) triangle({a, b, d}, {nu, nv, nv}, colour);
    if (endRadius > 0.0) triangle({a, d, c}, {nu, nv, nu}, colour);
    if (endRadius <= 0.0) triangle({a, b, end}, {nu, nv, nu}, colour);
    if (startRadius > 0.0) triangle({start, b, a}, {-axis, -axis, -axis}, colour);
    if (endRadius > 0.0) triangle({end, c, d}, {axis, axis, axis}, colour);
  }
}

void GlyphBatch::ring(const glm::dvec3& centre, const glm::dvec3& normal, double innerRadius,
                      double outerRadius, const GlyphColour& colour) {
  ASSERT(innerRadius >= 0.0 && innerRadius <= outerRadius);
  const auto basis = acrossOf(normal);
  for (int side = 0; side < kSides; ++side) {
    const glm::dvec3 u = around(basis, side), v = around(basis, side + 1);
    const glm::dvec3 a = centre + u * innerRadius, b = centre + v * innerRadius;
    const glm::dvec3 c = centre + u * outerRadius, d = centre + v * outerRadius;
    triangle({a, c, d}, {normal, normal, normal}, colour);
    if (innerRadius > 0.0) triangle({a, d, b}, {normal, normal, normal}, colour);
  }
}

void GlyphBatch::disc(const glm::dvec3& centre, const glm::dvec3& normal, double radius,
                      const GlyphColour& colour) {
  ring(centre, normal, 0.0, radius, colour);
}

void GlyphBatch::line(const glm::dvec3& start, const glm::dvec3& end, double pixels,
                      const GlyphColour& colour) {
  const auto radiusAt = [&](const glm::dvec3& p) { return 0.5 * pixels * view_.pixelAt(p); };
  cone(start, end, radiusAt(start), radiusAt(end), colour);
}

Result<std::unique_ptr<GlyphRenderer>> GlyphRenderer::make() {
  std::string header = "#version 330 core\n";
  header += shaders::kLighting;
  auto program = GlProgram::make("glyph", shaders::kGlyphVertex, header + shaders::kGlyphFragment);
  if (!program) return program.error();
  return std::unique_ptr<GlyphRenderer>(new GlyphRenderer(std::move(*program)));
}

GlyphRenderer::GlyphRenderer(GlProgram program) : program_(std::move(program)) {
  glBindVertexArray(array_.id());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.id());
  using Vertex = GlyphBatch::Vertex;
  floatAttribute(0, 3, sizeof(Vertex), offsetof(Vertex, position));
  floatAttribute(1, 3, sizeof(Vertex), offsetof(Vertex, normal));
  floatAttribute(2, 4, sizeof(Vertex), offsetof(Vertex, colour));
  glBindVertexArray(0);
}

void GlyphRenderer::draw(const GlyphBatch& batch) const {
  const auto& triangles = batch.triangles();
  if (triangles.empty()) return;
  program_.use();
  program_.set("clipFromEye", glm::mat4(batch.view().eyeToClip));
  program_.set("upInEye", glm::vec3(batch.view().eyeFromWorld.orientation * glm::dvec3(0.0, 1.0, 0.0)));
  glBindVertexArray(array_.id());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.id());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles.size() * sizeof(GlyphBatch::Vertex)),
               triangles.data(), GL_STREAM_DRAW);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glEnable(GL_DEPTH_TEST);
  const auto count = static_cast<GLsizei>(triangles.size());
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  program_.set("opacity", kHiddenOpacity);
  glDrawArrays(GL_TRIANGLES, 0, count);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  program_.set("opacity", 1.0f);
  glDrawArrays(GL_TRIANGLES, 0, count);
  glDisable(GL_BLEND);
  glBindVertexArray(0);
}

}  // namespace tandem::client
