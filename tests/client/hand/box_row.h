#pragma once

// A row of three movable boxes of 4 cm, for hands.

#include <string>

#include "assets/scene/scene.h"
#include "tests/support/shapes.h"

namespace tandem::test {

/// Parts 0, 1, 2 at x = 0, 0.2, 0.4 m; 0.2 kg each.
inline assets::Scene rowOfBoxes() {
  assets::Scene scene;
  scene.meshes.push_back(boxMesh({0.04, 0.04, 0.04}));
  scene.materials.emplace_back();
  for (int i = 0; i < 3; ++i) {
    assets::Part part;
    part.name = "box " + std::to_string(i);
    part.mesh = 0;
    part.movable = true;
    part.massProperties.mass = 0.2;
    part.massProperties.inertia = glm::dmat3(5e-5);
    part.worldFromPart.position = {0.2 * i, 0.0, 0.0};
    scene.parts.push_back(part);
  }
  return scene;
}

}  // namespace tandem::test
