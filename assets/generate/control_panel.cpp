#include <cmath>
#include <numbers>
#include <string>

#include "assets/generate/common.h"

namespace tandem::generate {
namespace {

constexpr double kPlateTop = 20.0 * mm;

/// A solid of revolution with bevelled edges.
SampleShape turned(const char* name, double radius, double height, double bevel, AppearanceId appearance) {
  SampleShape shape{name, {}, {appearance}, kFeelPlastic};
  shape.solid.revolve({{0.0, 0.0},
                       {radius - bevel, 0.0},
                       {radius, bevel},
                       {radius, height - bevel},
                       {radius - bevel, height},
                       {0.0, height}},
                      96);
  return shape;
}

/// A knob with twelve flutes, for a tool to turn it by.
SampleShape knob() {
  SampleShape shape{"dial", {}, {kMachined}, kFeelAluminium};
  Solid& s = shape.solid;
  Loop rim, inner;
  constexpr int kCorners = 240;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kCorners;
    const double radius = (24.0 - 2.0 * (0.5 + 0.5 * std::cos(12.0 * angle))) * mm;
    rim.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    inner.push_back(rim.back() * (1.0 - 1.0 * mm / radius));
  }
  s.cap(inner, {}, 0.0, Facing::down);
  s.band(inner, 0.0, rim, 1.0 * mm);
  s.band(rim, 1.0 * mm, rim, 17.0 * mm);
  s.band(rim, 17.0 * mm, inner, 18.0 * mm);
  s.cap(inner, {}, 18.0 * mm, Facing::up);
  return shape;
}

}  // namespace

SampleScene makeControlPanel() {
  SampleScene scene{"control_panel", commonAppearances(), commonFeels(), {}, {}};
  SampleShape plate = block("panel", glm::dvec2(240.0 * mm, 150.0 * mm), kPlateTop, kPaint, kFeelAluminium);
  scene.shapes = {benchTop(glm::dvec2(320.0 * mm, 260.0 * mm)),
                  plate,
                  turned("button", 12.0 * mm, 8.0 * mm, 1.0 * mm, kPlastic),
                  knob(),
                  block("slider", glm::dvec2(12.0 * mm, 24.0 * mm), 14.0 * mm, kLime, kFeelPlastic),
                  block("drawer", glm::dvec2(90.0 * mm, 40.0 * mm), 30.0 * mm, kBrass, kFeelWood),
                  block("layer switch", glm::dvec2(10.0 * mm, 18.0 * mm), 12.0 * mm, kRubber, kFeelPlastic),
                  turned("gauge", 16.0 * mm, 10.0 * mm, 1.0 * mm, kSteel)};
  const auto on = [](double x, double z, double above) {
    return glm::dvec3(x * mm, kPlateTop + above * mm, z * mm);
  };
  scene.parts = {
      {"bench", 0, glm::dvec3(0.0), false},           {"panel", 1, glm::dvec3(0.0, kRestGap, 0.0), false},
      {"start", 2, on(-90.0, -40.0, 3.0), true},      {"mode", 3, on(-25.0, -35.0, 1.0), true},
      {"level", 4, on(30.0, 35.0, 1.0), true},        {"drawer", 5, on(70.0, -40.0, 1.0), true},
      {"gauge layer", 6, on(-95.0, 40.0, 1.0), true}, {"gauge", 7, on(-40.0, 40.0, 1.0), false}};

  SampleControl button{"button", glm::dvec3(0.0, -1.0, 0.0)};
  button.max = 2.5 * mm;
  button.spring = 300.0;
  button.springRest = -1.0 * mm;
  button.damping = 2.0;
  button.clickAt = 1.2 * mm;
  button.clickDrop = 0.8;
  button.clickWidth = 0.3 * mm;
  scene.parts[2].control = button;

  SampleControl dial{"dial", glm::dvec3(0.0, 1.0, 0.0)};
  dial.detentCount = 12;
  dial.detentForce = 0.02;
  dial.damping = 1e-3;
  dial.friction = 1e-3;
  scene.parts[3].control = dial;

  SampleControl slider{"slider", glm::dvec3(1.0, 0.0, 0.0)};
  slider.max = 70.0 * mm;
  slider.damping = 2.0;
  slider.friction = 0.3;
  scene.parts[4].control = slider;

  SampleControl drawer{"drawer", glm::dvec3(0.0, 0.0, -1.0)};
  drawer.max = 60.0 * mm;
  drawer.damping = 4.0;
  drawer.friction = 0.4;
  drawer.detents = {0.0, 60.0 * mm};
  drawer.detentForce = 0.8;
  drawer.detentWidth = 8.0 * mm;
  scene.parts[5].control = drawer;

  SampleControl layer{"layer", glm::dvec3(1.0, 0.0, 0.0)};
  layer.max = 12.0 * mm;
  layer.value = 0.0;
  layer.damping = 2.0;
  layer.detents = {0.0, 12.0 * mm};
  layer.detentForce = 0.6;
  layer.shows = {7};
  layer.instructorOnly = true;
  scene.parts[6].control = layer;
  return scene;
}

}  // namespace tandem::generate
