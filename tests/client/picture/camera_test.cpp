#include "client/picture/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/gtc/constants.hpp>

namespace tandem::client {
namespace {

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

Camera someCamera() {
  Camera camera;
  camera.target = {0.3, -0.2, 0.5};
  camera.distance = 2.0;
  camera.yaw = 0.4;
  camera.pitch = 0.3;
  return camera;
}

TEST(Camera, LooksAtItsTargetAlongMinusZ) {
  const Camera camera = someCamera();
  const Pose eye = worldFromCamera(camera);
  expectNear(transformPoint(eye, {0.0, 0.0, -camera.distance}), camera.target, 1e-12);
  EXPECT_GT(transformVector(eye, {0.0, 1.0, 0.0}).y, 0.0);
}

TEST(Camera, StandardViewsLookAlongTheAxes) {
  Camera camera = someCamera();
  look(camera, StandardView::front);
  expectNear(transformVector(worldFromCamera(camera), {0.0, 0.0, -1.0}), {0.0, 0.0, -1.0}, 1e-12);
  look(camera, StandardView::right);
  expectNear(transformVector(worldFromCamera(camera), {0.0, 0.0, -1.0}), {-1.0, 0.0, 0.0}, 1e-12);
  look(camera, StandardView::top);
  expectNear(transformVector(worldFromCamera(camera), {0.0, 0.0, -1.0}), {0.0, -1.0, 0.0}, 1e-12);
}

TEST(Camera, FittedViewHoldsEveryCornerAtEveryScaleAndAspect) {
  for (const double scale : {1e-3, 1.0, 20.0})
    for (const double aspect : {0.5, 1.0, 2.4}) {
      assets::Bounds bounds;
      bounds.min = glm::dvec3(-1.0, 2.0, -0.2) * scale;
      bounds.max = glm::dvec3(3.0, 2.5, 0.7) * scale;
      const Camera camera = fitView(bounds, aspect);
      const View view =
          makeView(camera, {600.0 * aspect, 600.0},
                   {0.5 * (bounds.min + bounds.max), 0.5 * glm::length(bounds.max - bounds.min)});
      double widest = 0.0;
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point((corner & 1) ? bounds.max.x : bounds.min.x,
                               (corner & 2) ? bounds.max.y : bounds.min.y,
                               (corner & 4) ? bounds.max.z : bounds.min.z);
        const auto pixel = view.project(point);
        ASSERT_TRUE(pixel.has_value());
        const glm::dvec2 ndc = *pixel / view.size * 2.0 - 1.0;
        widest = std::max({widest, std::abs(ndc.x), std::abs(ndc.y)});
        const double depth = view.depthOf(point);
        EXPECT_GT(depth, view.near);
        EXPECT_LT(depth, view.far);
      }
      EXPECT_LE(widest, 1.0);
      EXPECT_GT(widest, 0.75) << "the fit wastes the picture";
    }
}

TEST(Camera, AnEmptyBoxLeavesTheCameraAlone) {
  const Camera camera = someCamera();
  const Camera fitted = fitFrom(camera, assets::Bounds{}, 1.0);
  EXPECT_EQ(fitted.distance, camera.distance);
  expectNear(fitted.target, camera.target, 0.0);
}

TEST(Camera, PixelAndDepthAreTheInverseOfProjection) {
  const View view = makeView(someCamera(), {800.0, 500.0}, {{0.3, -0.2, 0.5}, 1.0});
  for (const glm::dvec2& pixel : {glm::dvec2(0.0, 0.0), glm::dvec2(400.0, 250.0), glm::dvec2(799.0, 13.0)}) {
    const glm::dvec3 world = view.pointAt(pixel, 1.7);
    EXPECT_NEAR(view.depthOf(world), 1.7, 1e-12);
    const auto back = view.project(world);
    ASSERT_TRUE(back.has_value());
    EXPECT_NEAR(back->x, pixel.x, 1e-9);
    EXPECT_NEAR(back->y, pixel.y, 1e-9);
  }
  EXPECT_FALSE(view.project(view.pointAt({400.0, 250.0}, -1.0)).has_value());
}

TEST(Camera, ZoomKeepsThePointUnderTheMouseWhereItIs) {
  Camera camera = someCamera();
  const Sphere content{{0.3, -0.2, 0.5}, 1.0};
  const View before = makeView(camera, {800.0, 500.0}, content);
  const glm::dvec2 pixel(650.0, 120.0);
  const glm::dvec3 point = before.pointAt(pixel, 1.5);
  zoom(camera, 3.0, point);
  const View after = makeView(camera, {800.0, 500.0}, content);
  const auto moved = after.project(point);
  ASSERT_TRUE(moved.has_value());
  EXPECT_NEAR(moved->x, pixel.x, 1e-9);
  EXPECT_NEAR(moved->y, pixel.y, 1e-9);
  EXPECT_LT(after.depthOf(point), 0.8 * before.depthOf(point));
}

TEST(Camera, OrbitKeepsThePivotWhereItIs) {
  Camera camera = someCamera();
  const Sphere content{{0.3, -0.2, 0.5}, 1.0};
  const glm::dvec3 pivot(0.5, 0.1, 0.4);
  const auto before = makeView(camera, {800.0, 500.0}, content).project(pivot);
  const double yaw = camera.yaw;
  orbit(camera, {57.0, -31.0}, pivot);
  const auto after = makeView(camera, {800.0, 500.0}, content).project(pivot);
  ASSERT_TRUE(before.has_value() && after.has_value());
  EXPECT_NEAR(before->x, after->x, 1e-9);
  EXPECT_NEAR(before->y, after->y, 1e-9);
  EXPECT_GT(std::abs(camera.yaw - yaw), 0.1);
}

TEST(Camera, OrbitStopsAtThePoles) {
  Camera camera = someCamera();
  orbit(camera, {0.0, 1e5}, camera.target);
  EXPECT_LE(camera.pitch, glm::half_pi<double>());
  orbit(camera, {0.0, -1e5}, camera.target);
  EXPECT_GE(camera.pitch, -glm::half_pi<double>());
}

TEST(Camera, PanMovesTheSceneWithTheMouse) {
  Camera camera = someCamera();
  const Sphere content{{0.3, -0.2, 0.5}, 1.0};
  const View before = makeView(camera, {800.0, 500.0}, content);
  const glm::dvec3 point = camera.target;
  pan(camera, {30.0, -20.0}, before.metresPerPixel(camera.distance));
  const auto after = makeView(camera, {800.0, 500.0}, content).project(point);
  ASSERT_TRUE(after.has_value());
  EXPECT_NEAR(after->x, 430.0, 1e-6);
  EXPECT_NEAR(after->y, 230.0, 1e-6);
}

TEST(Camera, SeesWhatAnotherCameraSees) {
  const Camera theirs = someCamera();
  Camera mine;
  mine.distance = 0.7;
  mine = cameraAt(worldFromCamera(theirs), mine);
  const Pose a = worldFromCamera(theirs), b = worldFromCamera(mine);
  expectNear(a.position, b.position, 1e-12);
  EXPECT_NEAR(std::abs(glm::dot(a.orientation, b.orientation)), 1.0, 1e-12);
}

}  // namespace
}  // namespace tandem::client
