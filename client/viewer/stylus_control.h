#pragma once

// The virtual stylus: mouse and keyboard as a six-axis hand, for people without a device. No GL.
//
// 1. The tip stays under the mouse. Unless that is turned off, its depth follows the visible surface and
//    stays just before it, plus what the person pushed with W/S or Ctrl + wheel: pressing W over a surface
//    touches it.
// 2. While a part is held, the tip moves parallel to the screen and keeps its orientation in the world;
//    moving the camera does not move it.

#include <optional>

#include "client/picture/camera.h"
#include "client/picture/scene_renderer.h"
#include "client/viewer/surface.h"

namespace tandem::client {

class StylusControl {
 public:
  struct Situation {
    const View& view;
    const Input& input;
    glm::dvec2 cursor{0.0, 0.0};  // pixels of the view
    bool cursorInView = false;    // and over no panel
    bool cameraMoving = false;    // the mouse turns or shifts the camera
    bool keysFree = true;         // no text field has the keyboard
    bool mayGrasp = true;
    bool holding = false;  // a part is held
    bool followSurface = true;
    double toolRadius = 0.0;       // m
    std::optional<Hit> surface{};  // under the cursor
  };

  /// Puts the tip before a surface in the middle of the view.
  void place(const View& view, double depth);
  /// One frame; true if the stylus moved.
  bool update(const Situation& now);

  const Pose& worldFromStylus() const { return worldFromStylus_; }
  bool grasping() const { return mouseGrasp_ || latched_; }
  bool latched() const { return latched_; }

 private:
  void turn(const Situation& now);
  void moveTip(const Situation& now);
  void updateGrasp(const Situation& now);
  double depthStep(const Situation& now) const;

  Pose worldFromStylus_;
  glm::dquat eyeFromStylus_{1.0, 0.0, 0.0, 0.0};
  glm::dvec2 offset_{0.0, 0.0};  // pixels from the cursor to the tip
  double depth_ = 1.0;           // m
  double push_ = 0.0;            // m, by the person, beyond that place
  bool mouseGrasp_ = false, latched_ = false, placed_ = false, inView_ = false;
};

}  // namespace tandem::client
