#include "client/viewer/stylus_control.h"

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include <cmath>

namespace tandem::client {
namespace {

constexpr double kSurfaceDepth = 0.9;  // m

void press(Input& input, int key) { input.keysPressed.push_back(key); }
void hold(Input& input, int key) { input.keysDown[static_cast<std::size_t>(key)] = true; }

/// A stylus over a plane that faces the camera.
class StylusTest : public testing::Test {
 protected:
  StylusTest() : view_(makeView(Camera{}, {800.0, 600.0}, {{0.0, 0.0, 0.0}, 0.5})) {
    stylus_.place(view_, kSurfaceDepth);
  }

  bool frame(const Input& input, const glm::dvec2& cursor) {
    StylusControl::Situation now{view_, input};
    now.cursor = cursor;
    now.cursorInView = inView_;
    now.holding = holding_;
    now.cameraMoving = cameraMoving_;
    now.mayGrasp = mayGrasp_;
    if (overSurface_) now.surface = Hit{0, view_.pointAt(cursor, kSurfaceDepth), kSurfaceDepth};
    return stylus_.update(now);
  }
  void frames(int count, const Input& input, const glm::dvec2& cursor) {
    for (int i = 0; i < count; ++i) frame(input, cursor);
  }
  double depth() const { return view_.depthOf(stylus_.worldFromStylus().position); }
  glm::dvec2 pixel() const {
    return view_.project(stylus_.worldFromStylus().position).value_or(glm::dvec2(-1.0));
  }

  View view_;
  StylusControl stylus_;
  bool inView_ = true, holding_ = false, cameraMoving_ = false, mayGrasp_ = true, overSurface_ = true;
};

TEST_F(StylusTest, HoversUnderTheMouseJustBeforeTheSurface) {
  frames(60, Input{}, {200.0, 450.0});
  EXPECT_NEAR(pixel().x, 200.0, 1e-6);
  EXPECT_NEAR(pixel().y, 450.0, 1e-6);
  EXPECT_LT(depth(), kSurfaceDepth);
  EXPECT_GT(depth(), kSurfaceDepth - 10.0 * view_.metresPerPixel(kSurfaceDepth));
}

TEST_F(StylusTest, PushingGoesThroughTheSurfaceAndPullingComesBack) {
  frames(60, Input{}, {400.0, 300.0});
  Input push;
  hold(push, GLFW_KEY_W);
  frames(60, push, {400.0, 300.0});
  frames(60, Input{}, {400.0, 300.0});
  EXPECT_GT(depth(), kSurfaceDepth);
  Input pull;
  hold(pull, GLFW_KEY_S);
  frames(60, pull, {400.0, 300.0});
  frames(60, Input{}, {400.0, 300.0});
  EXPECT_LT(depth(), kSurfaceDepth);
}

TEST_F(StylusTest, ControlAndWheelPushToo) {
  frames(60, Input{}, {400.0, 300.0});
  const double before = depth();
  Input wheel;
  wheel.ctrl = true;
  wheel.wheel = 1.0;
  frames(4, wheel, {400.0, 300.0});
  frames(60, Input{}, {400.0, 300.0});
  EXPECT_NEAR(depth() - before, 12.0 * view_.metresPerPixel(kSurfaceDepth),
              0.5 * view_.metresPerPixel(kSurfaceDepth));
}

TEST_F(StylusTest, AnIdleMouseReportsNoMotion) {
  frames(120, Input{}, {400.0, 300.0});
  EXPECT_FALSE(frame(Input{}, {400.0, 300.0}));
  EXPECT_TRUE(frame(Input{}, {401.0, 300.0}));
}

TEST_F(StylusTest, GraspsWhileTheButtonIsDownOnly) {
  Input input;
  input.down[0] = input.pressed[0] = true;
  frame(input, {400.0, 300.0});
  EXPECT_TRUE(stylus_.grasping());
  input.pressed[0] = false;
  frame(input, {400.0, 300.0});
  EXPECT_TRUE(stylus_.grasping());
  frame(Input{}, {400.0, 300.0});
  EXPECT_FALSE(stylus_.grasping());
}

TEST_F(StylusTest, AButtonPressedOverAPanelGraspsNothing) {
  inView_ = false;
  Input input;
  input.down[0] = input.pressed[0] = true;
  frame(input, {400.0, 300.0});
  EXPECT_FALSE(stylus_.grasping());
}

TEST_F(StylusTest, TheLatchHoldsUntilPressedAgain) {
  Input latch;
  press(latch, GLFW_KEY_G);
  frame(latch, {400.0, 300.0});
  frames(5, Input{}, {400.0, 300.0});
  EXPECT_TRUE(stylus_.grasping());
  frame(latch, {400.0, 300.0});
  EXPECT_FALSE(stylus_.grasping());
}

TEST_F(StylusTest, AnObserverGraspsNothing) {
  mayGrasp_ = false;
  Input input;
  input.down[0] = input.pressed[0] = true;
  press(input, GLFW_KEY_G);
  frame(input, {400.0, 300.0});
  EXPECT_FALSE(stylus_.grasping());
}

TEST_F(StylusTest, AHeldPartIgnoresTheSurfaceUnderTheMouse) {
  frames(60, Input{}, {400.0, 300.0});
  const double before = depth();
  holding_ = true;
  Input input;
  input.down[0] = true;
  input.pressed[0] = true;
  frame(input, {400.0, 300.0});
  input.pressed[0] = false;
  overSurface_ = false;
  frames(30, input, {500.0, 300.0});
  EXPECT_NEAR(depth(), before, 1e-9);
  EXPECT_NEAR(pixel().x, 500.0, 1e-6);
}

TEST_F(StylusTest, MovingTheCameraNeverMovesAHeldPart) {
  frames(60, Input{}, {400.0, 300.0});
  holding_ = true;
  Input latch;
  press(latch, GLFW_KEY_G);
  frame(latch, {400.0, 300.0});
  const Pose before = stylus_.worldFromStylus();
  cameraMoving_ = true;
  Camera camera = view_.camera;
  for (int i = 0; i < 20; ++i) {
    orbit(camera, {8.0, 3.0}, camera.target);
    view_ = makeView(camera, view_.size, {{0.0, 0.0, 0.0}, 0.5});
    EXPECT_FALSE(frame(Input{}, {400.0 + 8.0 * i, 300.0 + 3.0 * i}));
  }
  cameraMoving_ = false;
  frame(Input{}, {560.0, 360.0});  // the mouse is elsewhere now: the part must not jump to it
  const Pose after = stylus_.worldFromStylus();
  EXPECT_LT(glm::length(after.position - before.position), 1e-9);
  EXPECT_NEAR(std::abs(glm::dot(after.orientation, before.orientation)), 1.0, 1e-9);
  frame(Input{}, {570.0, 360.0});  // and then follows it
  EXPECT_GT(glm::length(stylus_.worldFromStylus().position - before.position), 1e-3);
}

TEST_F(StylusTest, KeysTurnTheStylusAboutTheViewsAxes) {
  frames(2, Input{}, {400.0, 300.0});
  const glm::dquat before = stylus_.worldFromStylus().orientation;
  Input roll;
  hold(roll, GLFW_KEY_Q);
  frames(30, roll, {400.0, 300.0});
  const glm::dvec3 turned =
      rotationVector(glm::normalize(stylus_.worldFromStylus().orientation * glm::conjugate(before)));
  const glm::dvec3 back = view_.worldFromEye.orientation * glm::dvec3(0.0, 0.0, 1.0);
  EXPECT_GT(glm::dot(turned, back), 0.4);
  EXPECT_LT(glm::length(turned - back * glm::dot(turned, back)), 1e-9);
}

}  // namespace
}  // namespace tandem::client
