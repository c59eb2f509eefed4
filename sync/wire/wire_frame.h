#pragma once

// The cube in which positions are quantised on the wire. Every site computes the same one from the scene.

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::sync {

/// The range in which positions are quantised on the wire; the same at every site because it comes from the
/// scene. Positions outside are clamped, and counted by the encoder.
struct WireFrame {
  glm::dvec3 centre{0.0, 0.0, 0.0};  // m
  double halfExtent = 2.0;           // m, of a cube around the centre
};

/// A cube several times the scene's bounds, so that parts can be laid aside. Position quantum: 2 halfExtent /
/// 2^24.
WireFrame wireFrame(const assets::Bounds& sceneBounds);

/// Whether a part may stand there: no state can say that a part is outside, so no other message may either.
bool contains(const WireFrame& frame, const glm::dvec3& worldPoint);

}  // namespace tandem::sync
