#pragma once

// A sample scene before it is written: solids, how they look and feel, and where they stand.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "assets/force_field.h"
#include "assets/generate/shapes.h"

namespace tandem::generate {

/// How one kind of surface looks.
struct Look {
  std::string name;
  std::array<double, 3> colour{};  // linear RGB, 0..1
  double metallic = 0.0;
  double roughness = 0.5;
};

/// How one kind of material feels.
struct Feel {
  std::string name;
  double density = 0.0;  // kg/m^3
  double staticFriction = 0.0;
  double dynamicFriction = 0.0;
  double restitution = 0.0;
  double stiffness = 0.0;  // N/m
  double damping = 0.0;    // N·s/m
};

/// A solid, and the look of each material slot that it is painted with.
struct SampleShape {
  std::string name;
  Solid solid;
  std::vector<std::size_t> looks;  // into SampleScene::looks
  std::size_t feel = 0;            // into SampleScene::feels
};

/// One part at rest; several may share a shape. Part axes stay parallel to the world's, y upward.
struct SamplePart {
  std::string name;
  std::size_t shape = 0;
  glm::dvec3 position{0.0};  // m
  bool movable = false;
  std::vector<assets::ForceField> fields{};  // of gravity, or guides; in the part's frame
};

struct SampleScene {
  std::string name;
  std::vector<Look> looks;
  std::vector<Feel> feels;
  std::vector<SampleShape> shapes;
  std::vector<SamplePart> parts;
};

SampleScene makePump();
SampleScene makeFilterChange();
SampleScene makePegBoard();
SampleScene makeSolarSystem();
SampleScene makeGuidedPath();

/// All of them, in the order of their files.
std::vector<SampleScene> makeAllScenes();

/// The scene as a .glb file: the same bytes at every run. Movable parts get their mass and inertia from the
/// density.
std::string toGlb(const SampleScene& scene);

}  // namespace tandem::generate
