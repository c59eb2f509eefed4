#pragma once

// The mouse turns or shifts the camera while a button is down.

#include <algorithm>

#include <glm/geometric.hpp>

#include "client/picture/camera.h"
#include "client/viewer/surface.h"

namespace tandem::client {

class CameraDrag {
 public:
  bool active() const { return drag_ != Drag::none; }
  /// Whether the mouse has moved since the button went down: then its release is no click.
  bool moved() const { return moved_; }

  /// Begins if a button went down: the right or middle one, the left one too if it `leftTurns`, or any with
  /// shift. Turns about `pivot`, and shifts what is as far away as that; world.
  void begin(const Input& input, bool leftTurns, const glm::dvec3& pivot) {
    const bool pressed = (leftTurns && input.pressed[0]) || input.pressed[1] || input.pressed[2] ||
                         (input.shift && input.pressed[0]);
    if (active() || !pressed) return;
    drag_ = input.shift ? Drag::shift : Drag::turn;
    moved_ = false;
    start_ = input.cursor;
    pivot_ = pivot;
  }
  /// Moves the camera; true if it has.
  bool move(const Input& input, const View& view, Camera& camera) {
    if (!input.down[0] && !input.down[1] && !input.down[2]) drag_ = Drag::none;
    if (!active()) return false;
    moved_ = moved_ || glm::length(input.cursor - start_) > 4.0;
    if (!moved_) return false;
    if (drag_ == Drag::turn) orbit(camera, input.cursorMove, pivot_);
    if (drag_ == Drag::shift)
      pan(camera, input.cursorMove, view.metresPerPixel(std::max(view.depthOf(pivot_), view.near)));
    return true;
  }

 private:
  enum class Drag { none, turn, shift };
  Drag drag_ = Drag::none;
  bool moved_ = false;
  glm::dvec2 start_{0.0, 0.0};  // pixels
  glm::dvec3 pivot_{0.0, 0.0, 0.0};
};

}  // namespace tandem::client
