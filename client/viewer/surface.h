#pragma once

// The target of pictures and the source of input: a GLFW window, or an EGL context without any display. Main
// thread only.

#include <array>
#include <bitset>
#include <memory>
#include <vector>

#include <glm/vec2.hpp>

#include "assets/base/result.h"
#include "client/viewer/viewer.h"

namespace tandem::client {

inline constexpr std::size_t kKeyCount = 512;  // above GLFW_KEY_LAST

/// What mouse and keyboard did since the last frame. Keys are GLFW's codes.
struct Input {
  glm::dvec2 cursor{-1e9, -1e9};  // window pixels, top left origin
  glm::dvec2 cursorMove{0.0, 0.0};
  std::array<bool, 3> down{}, pressed{}, released{};  // left, right, middle
  glm::dvec2 pressedAt{-1e9, -1e9};  // where the last button went down; the cursor may have moved since
  double wheel = 0.0;                // steps, away from the person = positive
  bool shift = false, ctrl = false;
  std::bitset<kKeyCount> keysDown;
  std::vector<int> keysPressed;  // in order; a key that went down and up again is still here
  double dt = 1.0 / 60.0;        // s since the last frame
};

class Surface {
 public:
  virtual ~Surface() = default;
  virtual void makeCurrent() = 0;
  /// Size in window pixels, as the input counts them.
  virtual glm::ivec2 size() const = 0;
  /// Size in pixels of the picture.
  virtual glm::ivec2 framebufferSize() const = 0;
  /// The framebuffer to draw into.
  virtual unsigned framebuffer() const = 0;
  /// How much larger than at 96 dpi text should be.
  virtual float contentScale() const = 0;
  /// Starts ImGui's platform side; its context and this surface are current.
  virtual void startInterface() = 0;
  virtual void stopInterface() = 0;
  /// Polls events and passes them to ImGui; ImGui::NewFrame() follows.
  virtual void beginFrame(Input& input) = 0;
  /// Shows the picture, at most 60 times a second (30 where the processor draws).
  virtual void present() = 0;
  virtual bool closeRequested() const = 0;
  /// The mouse of the next frames, window pixels, where there is no window; a window has its own.
  virtual void pointMouse(const glm::dvec2& cursor, bool leftDown) = 0;
  /// Whether frames follow each other, as in a window; false where single pictures are taken.
  virtual bool live() const = 0;
};

/// A window with an OpenGL 3.3 core context.
Result<std::unique_ptr<Surface>> openWindow(const ViewerOptions& options);
/// A framebuffer with an OpenGL 3.3 core context from EGL.
Result<std::unique_ptr<Surface>> openOffscreenSurface(const ViewerOptions& options);

}  // namespace tandem::client
