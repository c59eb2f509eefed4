#include "client/picture/camera.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "assets/base/assert.h"

namespace tandem::client {
namespace {

constexpr double kFitMargin = 1.12;
// The least near plane as a share of the far plane: a 24-bit depth buffer stays useful inside the scene.
constexpr double kNearestShareOfFar = 2e-4;

bool isEmpty(const assets::Bounds& bounds) {
  return !(bounds.min.x <= bounds.max.x && bounds.min.y <= bounds.max.y && bounds.min.z <= bounds.max.z);
}

}  // namespace

Camera fitView(const assets::Bounds& bounds, double aspect) { return fitFrom(Camera{}, bounds, aspect); }

Camera fitFrom(const Camera& from, const assets::Bounds& bounds, double aspect) {
  Camera camera = from;
  if (isEmpty(bounds)) return camera;
  camera.target = 0.5 * (bounds.min + bounds.max);
  const glm::dquat cameraFromWorld = glm::conjugate(worldFromCamera(camera).orientation);
  const double tanY = std::tan(0.5 * camera.fieldOfView);
  const double tanX = tanY * std::max(aspect, 1e-3);
  double distance = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 point((corner & 1) ? bounds.max.x : bounds.min.x,
                           (corner & 2) ? bounds.max.y : bounds.min.y,
                           (corner & 4) ? bounds.max.z : bounds.min.z);
    const glm::dvec3 p = cameraFromWorld * (point - camera.target);
    distance = std::max({distance, p.z + std::abs(p.x) / tanX, p.z + std::abs(p.y) / tanY});
  }
  camera.distance = distance > 0.0 ? distance * kFitMargin : 1.0;
  return camera;
}

Camera cameraAt(const Pose& worldFromEye, const Camera& like) {
  Camera camera = like;
  const glm::dvec3 back = worldFromEye.orientation * glm::dvec3(0.0, 0.0, 1.0);
  camera.pitch = std::asin(std::clamp(back.y, -1.0, 1.0));
  camera.yaw = std::atan2(back.x, back.z);
  camera.target = worldFromEye.position - back * camera.distance;
  return camera;
}

View makeView(const Camera& camera, const glm::dvec2& size, const Sphere& content) {
  ASSERT(content.radius >= 0.0);
  View view;
  view.camera = camera;
  view.size = glm::max(size, glm::dvec2(1.0));
  view.worldFromEye = worldFromCamera(camera);
  view.eyeFromWorld = inverse(view.worldFromEye);
  const double depth = -transformPoint(view.eyeFromWorld, content.centre).z;
  const double radius = std::max(content.radius, 1e-3 * camera.distance);
  view.far = std::max(depth + radius, camera.distance) * 1.01;
  view.near = std::max((depth - radius) * 0.99, view.far * kNearestShareOfFar);
  view.eyeToClip = glm::perspective(camera.fieldOfView, view.size.x / view.size.y, view.near, view.far);
  return view;
}

double View::depthOf(const glm::dvec3& world) const { return -transformPoint(eyeFromWorld, world).z; }

double View::metresPerPixel(double depth) const {
  return 2.0 * depth * std::tan(0.5 * camera.fieldOfView) / size.y;
}

double View::pixelAt(const glm::dvec3& point) const { return metresPerPixel(std::max(depthOf(point), near)); }

glm::dvec3 View::pointAt(const glm::dvec2& pixel, double depth) const {
  const double scale = metresPerPixel(depth);
  const glm::dvec3 eye((pixel.x - 0.5 * size.x) * scale, (0.5 * size.y - pixel.y) * scale, -depth);
  return transformPoint(worldFromEye, eye);
}

std::optional<glm::dvec2> View::project(const glm::dvec3& world) const {
  const glm::dvec3 eye = transformPoint(eyeFromWorld, world);
  if (eye.z > -near) return std::nullopt;
  const double scale = metresPerPixel(-eye.z);
  return glm::dvec2(0.5 * size.x + eye.x / scale, 0.5 * size.y - eye.y / scale);
}

void orbit(Camera& camera, const glm::dvec2& pixels, const glm::dvec3& pivot) {
  constexpr double kRadPerPixel = 0.007;
  const glm::dquat before = worldFromCamera(camera).orientation;
  camera.yaw = std::remainder(camera.yaw - pixels.x * kRadPerPixel, glm::two_pi<double>());
  camera.pitch =
      std::clamp(camera.pitch + pixels.y * kRadPerPixel, -glm::half_pi<double>(), glm::half_pi<double>());
  const glm::dquat turn = worldFromCamera(camera).orientation * glm::conjugate(before);
  camera.target = pivot + turn * (camera.target - pivot);
}

void pan(Camera& camera, const glm::dvec2& pixels, double metresPerPixel) {
  camera.target +=
      worldFromCamera(camera).orientation * glm::dvec3(-pixels.x, pixels.y, 0.0) * metresPerPixel;
}

void zoom(Camera& camera, double steps, const glm::dvec3& towards) {
  const double factor = std::pow(0.87, steps);
  camera.target = towards + (camera.target - towards) * factor;
  camera.distance *= factor;
}

void look(Camera& camera, StandardView view) {
  camera.pitch = view == StandardView::top ? glm::half_pi<double>() : 0.0;
  camera.yaw = view == StandardView::right ? glm::half_pi<double>() : 0.0;
}

}  // namespace tandem::client
