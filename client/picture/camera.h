#pragma once

// The camera, and the arithmetic between pixels and the world. Pure functions; no GL.
//
// Pixels count from the top left corner of the view, y down. Depth is the distance from the eye along its
// viewing direction, in m. World +y is up.

#include <optional>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include "client/session/view_model.h"

namespace tandem::client {

/// A sphere that holds everything drawn, world, m.
struct Sphere {
  glm::dvec3 centre{0.0, 0.0, 0.0};
  double radius = 0.0;
};

/// One camera on one viewport: everything needed to draw and to pick.
struct View {
  Camera camera;
  glm::dvec2 size{1.0, 1.0};  // pixels
  Pose worldFromEye, eyeFromWorld;
  double near = 0.01, far = 1.0;  // m
  glm::dmat4 eyeToClip{1.0};

  double depthOf(const glm::dvec3& world) const;
  /// Size of one pixel, in m, at a depth.
  double metresPerPixel(double depth) const;
  /// The same at a point, which counts as on the near plane if it is nearer.
  double pixelAt(const glm::dvec3& point) const;
  /// The world point under a pixel at a depth.
  glm::dvec3 pointAt(const glm::dvec2& pixel, double depth) const;
  /// The pixel of a world point; nothing if it lies behind the near plane.
  std::optional<glm::dvec2> project(const glm::dvec3& world) const;
};

/// `content` sets the near and far planes.
View makeView(const Camera& camera, const glm::dvec2& size, const Sphere& content);

/// A camera that sees all of the box.
Camera fitView(const assets::Bounds& bounds, double aspect);
/// Moves a camera until it sees all of the box, without turning it. An empty box changes nothing.
Camera fitFrom(const Camera& from, const assets::Bounds& bounds, double aspect);
/// A camera with the eye at this pose (roll is dropped); distance and field of view as in `like`.
Camera cameraAt(const Pose& worldFromEye, const Camera& like);

/// Turns the camera about a world point by a mouse motion in pixels.
void orbit(Camera& camera, const glm::dvec2& pixels, const glm::dvec3& pivot);
/// Shifts the camera so that points at a depth where a pixel spans `metresPerPixel` follow the mouse.
void pan(Camera& camera, const glm::dvec2& pixels, double metresPerPixel);
/// Zooms in (positive steps) so that the world point stays under its pixel.
void zoom(Camera& camera, double steps, const glm::dvec3& towards);

enum class StandardView { front, right, top };
void look(Camera& camera, StandardView view);

}  // namespace tandem::client
