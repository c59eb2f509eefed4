#pragma once

// A sample scene before it is written: solids, their appearance and feel, and their places.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "assets/generate/shapes.h"
#include "assets/scene/force_field.h"
#include "assets/scene/surface.h"

namespace tandem::generate {

/// Appearance of one kind of surface.
struct Appearance {
  std::string name;
  std::array<double, 3> colour{};  // linear RGB, 0..1
  double metallic = 0.0;
  double roughness = 0.5;
};

/// Contact properties of one kind of material.
struct Feel {
  std::string name;
  double density = 0.0;  // kg/m^3
  double staticFriction = 0.0;
  double dynamicFriction = 0.0;
  double restitution = 0.0;
  double stiffness = 0.0;     // N/m
  double damping = 0.0;       // N·s/m
  assets::Surface surface{};  // its texture's image is into SampleScene::images
};

/// A solid, and the appearance of each material slot that it is painted with.
struct SampleShape {
  std::string name;
  Solid solid;
  std::vector<std::size_t> appearances;  // into SampleScene::appearances
  std::size_t feel = 0;                  // into SampleScene::feels
  double repeat = 0.0;                   // m of the x-z plane that texture coordinates cover; 0 = none
};

/// Properties of a part that is a control; zero leaves a property out. Units: m and N; rad and N·m for a
/// dial.
struct SampleControl {
  std::string kind;
  glm::dvec3 axis{0.0};         // part frame
  double min = 0.0, max = 0.0;  // both 0: a dial without stops
  double value = 0.0;
  double spring = 0.0, springRest = 0.0;
  double damping = 0.0, friction = 0.0;
  std::size_t detentCount = 0;
  std::vector<double> detents{};
  double detentForce = 0.0, detentWidth = 0.0;
  double clickAt = 0.0, clickDrop = 0.0, clickWidth = 0.0;
  std::vector<std::size_t> shows{};  // into SampleScene::parts
  bool instructorOnly = false;
};

/// One part at rest; several may share a shape. Part axes stay parallel to the world's, y upward.
struct SamplePart {
  std::string name;
  std::size_t shape = 0;
  glm::dvec3 position{0.0};  // m
  bool movable = false;
  std::vector<assets::ForceField> fields{};  // of gravity, or guides; in the part's frame
  std::optional<SampleControl> control{};
};

struct SampleScene {
  std::string name;
  std::vector<Appearance> appearances;
  std::vector<Feel> feels;
  std::vector<SampleShape> shapes;
  std::vector<SamplePart> parts;
  std::vector<assets::TextureImage> images{};
};

SampleScene makePump();
SampleScene makeFilterChange();
SampleScene makePegBoard();
SampleScene makeSolarSystem();
SampleScene makeGuidedPath();
SampleScene makeControlPanel();
SampleScene makeSurfaces();

/// All sample scenes, in the order of their files.
std::vector<SampleScene> makeAllScenes();

/// The scene as a .glb file: the same bytes at every run. Movable parts get their mass and inertia from the
/// density.
std::string toGlb(const SampleScene& scene);

}  // namespace tandem::generate
