#include "client/viewer/stylus_control.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "assets/base/assert.h"

namespace tandem::client {
namespace {

constexpr double kClearance = 5.0;      // pixels before the surface where a hovering tip waits
constexpr double kPushSpeed = 45.0;     // pixels of depth a second with W or S
constexpr double kWheelStep = 3.0;      // pixels of depth a step with Ctrl + wheel
constexpr double kTurnSpeed = 1.3;      // rad/s
constexpr double kApproachTime = 0.02;  // s, time constant when the surface comes nearer
constexpr double kRetreatTime = 0.09;   // s, when it falls away
constexpr double kOffsetTime = 0.12;    // s, in which a free tip comes back under the mouse

/// The least distance of the tip from the eye, m. It is not the near plane, which follows the scene and the
/// hand.
double nearest(const View& view) { return 0.02 * view.camera.distance; }

bool moved(const Pose& a, const Pose& b, double tolerance) {
  return glm::length(a.position - b.position) > tolerance ||
         std::abs(glm::dot(a.orientation, b.orientation)) < 1.0 - 1e-10;
}

/// A pen in a right hand: the tip points into the picture, the barrel up, right and towards the person.
glm::dquat restingOrientation() {
  return glm::angleAxis(0.5, glm::dvec3(0.0, 1.0, 0.0)) * glm::angleAxis(-0.75, glm::dvec3(1.0, 0.0, 0.0));
}

}  // namespace

void StylusControl::place(const View& view, double depth) {
  ASSERT(depth > 0.0);
  eyeFromStylus_ = restingOrientation();
  depth_ = std::max(depth - kClearance * view.metresPerPixel(depth), nearest(view));
  worldFromStylus_.position = view.pointAt(0.5 * view.size, depth_);
  worldFromStylus_.orientation = view.worldFromEye.orientation * eyeFromStylus_;
  offset_ = glm::dvec2(0.0);
  placed_ = false;
}

double StylusControl::depthStep(const Situation& now) const {
  double pixels = now.cursorInView && now.input.ctrl ? kWheelStep * now.input.wheel : 0.0;
  if (now.keysFree) {
    if (now.input.keysDown[GLFW_KEY_W]) pixels += kPushSpeed * now.input.dt;
    if (now.input.keysDown[GLFW_KEY_S]) pixels -= kPushSpeed * now.input.dt;
  }
  return pixels * now.view.metresPerPixel(depth_);
}

void StylusControl::moveTip(const Situation& now) {
  const double step = depthStep(now);
  const bool follows = now.followSurface && !now.holding && !grasping() && now.surface.has_value();
  if (follows) {
    const double px = now.view.metresPerPixel(now.surface->depth);
    push_ = std::max(push_ + step, -60.0 * px);
    const double goal = now.surface->depth - now.toolRadius - kClearance * px + push_;
    const double time = goal < depth_ ? kApproachTime : kRetreatTime;
    depth_ += (goal - depth_) * (1.0 - std::exp(-now.input.dt / time));
  } else {
    push_ = 0.0;
    depth_ += step;
  }
  depth_ = std::max(depth_, nearest(now.view));
  if (!now.holding && !grasping()) offset_ *= std::exp(-now.input.dt / kOffsetTime);
  worldFromStylus_.position = now.view.pointAt(now.cursor + offset_, depth_);
}

void StylusControl::turn(const Situation& now) {
  const glm::dquat& eye = now.view.worldFromEye.orientation;
  if (now.holding) {
    eyeFromStylus_ = glm::conjugate(eye) * worldFromStylus_.orientation;
  }
  if (now.keysFree) {
    const auto axis = [&](int minus, int plus) {
      return (now.input.keysDown[static_cast<std::size_t>(plus)] ? 1.0 : 0.0) -
             (now.input.keysDown[static_cast<std::size_t>(minus)] ? 1.0 : 0.0);
    };
    const glm::dvec3 rate(axis(GLFW_KEY_UP, GLFW_KEY_DOWN), axis(GLFW_KEY_LEFT, GLFW_KEY_RIGHT),
                          axis(GLFW_KEY_E, GLFW_KEY_Q));
    eyeFromStylus_ = glm::normalize(fromRotationVector(rate * kTurnSpeed * now.input.dt) * eyeFromStylus_);
  }
  worldFromStylus_.orientation = glm::normalize(eye * eyeFromStylus_);
}

void StylusControl::updateGrasp(const Situation& now) {
  if (!now.mayGrasp) {
    mouseGrasp_ = latched_ = false;
    return;
  }
  if (now.input.pressed[0] && now.cursorInView && !now.cameraMoving) mouseGrasp_ = true;
  if (!now.input.down[0]) mouseGrasp_ = false;
  if (!now.keysFree) return;
  for (const int key : now.input.keysPressed)
    if (key == GLFW_KEY_G) latched_ = !latched_;
}

bool StylusControl::update(const Situation& now) {
  ASSERT(now.input.dt >= 0.0);
  const Pose before = worldFromStylus_;
  updateGrasp(now);
  turn(now);
  const bool follow = (now.cursorInView || mouseGrasp_) && !now.cameraMoving;
  if (follow) {
    if (!inView_ || !placed_) {
      // The mouse comes back from a panel or from moving the camera. A held part must not jump to it.
      const auto tip = now.view.project(worldFromStylus_.position);
      offset_ = tip && (now.holding || grasping()) ? *tip - now.cursor : glm::dvec2(0.0);
      depth_ = std::max(now.view.depthOf(worldFromStylus_.position), nearest(now.view));
    }
    moveTip(now);
    placed_ = true;
  }
  inView_ = follow;
  return moved(before, worldFromStylus_, 1e-3 * now.view.metresPerPixel(depth_));
}

}  // namespace tandem::client
