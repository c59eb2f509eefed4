#include "assets/generate/common.h"

namespace tandem::generate {

SampleShape benchTop(const glm::dvec2& size) {
  SampleShape shape{"bench", {}, {kBench}, kFeelWood};
  const double bevel = 2.0 * mm, thickness = 18.0 * mm, radius = 20.0 * mm;
  const Loop rim = roundedRectangle(size, radius, 8);
  const Loop inner = roundedRectangle(size - glm::dvec2(2.0 * bevel), radius - bevel, 8);
  shape.solid.cap(inner, {}, -thickness, Facing::down);
  shape.solid.band(inner, -thickness, rim, -thickness + bevel);
  shape.solid.band(rim, -thickness + bevel, rim, -bevel);
  shape.solid.band(rim, -bevel, inner, 0.0);
  shape.solid.cap(inner, {}, 0.0, Facing::up);
  return shape;
}

SampleShape block(const std::string& name, const glm::dvec2& size, double height, AppearanceId appearance,
                  std::size_t feel) {
  SampleShape shape{name, {}, {appearance}, feel};
  const double bevel = 1.0 * mm, corner = 3.0 * mm;
  Solid& s = shape.solid;
  const Loop rim = roundedRectangle(size, corner, 6);
  const Loop inner = roundedRectangle(size - glm::dvec2(2.0 * bevel), corner - bevel, 6);
  s.cap(inner, {}, 0.0, Facing::down);
  s.band(inner, 0.0, rim, bevel);
  s.band(rim, bevel, rim, height - bevel);
  s.band(rim, height - bevel, inner, height);
  s.cap(inner, {}, height, Facing::up);
  return shape;
}

std::vector<SampleScene> makeAllScenes() {
  std::vector<SampleScene> scenes;
  scenes.push_back(makePump());
  scenes.push_back(makeFilterChange());
  scenes.push_back(makePegBoard());
  scenes.push_back(makeSolarSystem());
  scenes.push_back(makeGuidedPath());
  scenes.push_back(makeControlPanel());
  scenes.push_back(makeSurfaces());
  return scenes;
}

}  // namespace tandem::generate
