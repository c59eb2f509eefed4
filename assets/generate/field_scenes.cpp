#include <cmath>
#include <string>
#include <vector>

#include "assets/base/constants.h"
#include "assets/generate/common.h"

// Scenes with forces without contact: bodies that attract the hand, and a path that guides it.

namespace tandem::generate {
namespace {

SampleShape ball(const std::string& name, double radius, AppearanceId appearance, FeelId feel) {
  SampleShape shape{name, {}, {appearance}, feel};
  constexpr int kRings = 24;
  std::vector<ProfilePoint> profile;
  for (int i = 0; i <= kRings; ++i) {
    const double angle = kPi * (static_cast<double>(i) / kRings - 0.5);
    const bool pole = i == 0 || i == kRings;
    profile.push_back({pole ? 0.0 : radius * std::cos(angle), radius * std::sin(angle)});
  }
  shape.solid.revolve(profile, 2 * kRings);
  return shape;
}

struct Body {
  const char* name;
  double radius;        // m
  double surfaceForce;  // N
  glm::dvec3 position;  // m
  AppearanceId appearance;
  bool movable;
};

const Body kBodies[] = {
    {"sun", 30.0 * mm, 2.5, {0.0, 120.0 * mm, 0.0}, kBrass, false},
    {"mercury", 6.0 * mm, 0.5, {52.0 * mm, 120.0 * mm, 12.0 * mm}, kSteel, true},
    {"venus", 9.0 * mm, 0.9, {-46.0 * mm, 120.0 * mm, 58.0 * mm}, kPaper, true},
    {"earth", 10.0 * mm, 1.0, {20.0 * mm, 120.0 * mm, -98.0 * mm}, kPaint, true},
    {"mars", 8.0 * mm, 0.7, {-128.0 * mm, 120.0 * mm, -30.0 * mm}, kPlastic, true},
    {"jupiter", 18.0 * mm, 1.8, {150.0 * mm, 120.0 * mm, 60.0 * mm}, kUsedPaper, true},
};

constexpr double kPlate = 10.0 * mm, kPlateHole = 9.0 * mm;

/// A plate in the x-z plane with one hole through which the path goes.
SampleShape plate() {
  SampleShape shape{"plate", {}, {kPaint, kMachined}, kFeelAluminium};
  Solid& s = shape.solid;
  const double edge = 1.0 * mm;
  const glm::dvec2 size(160.0 * mm, 100.0 * mm);
  const Loop rim = roundedRectangle(size, 8.0 * mm, 8);
  const Loop inner = roundedRectangle(size - glm::dvec2(2.0 * edge), 7.0 * mm, 8);
  const Loop hole = circleAround(kPlateHole, 64), mouth = circleAround(kPlateHole + edge, 64);
  s.paint(1);
  s.band(mouth, kPlate, hole, kPlate - edge);
  s.band(hole, kPlate - edge, hole, edge);
  s.band(hole, edge, mouth, 0.0);
  s.paint(0);
  s.cap(inner, {mouth}, 0.0, Facing::down);
  s.band(inner, 0.0, rim, edge);
  s.band(rim, edge, rim, kPlate - edge);
  s.band(rim, kPlate - edge, inner, kPlate);
  s.cap(inner, {mouth}, kPlate, Facing::up);
  return shape;
}

}  // namespace

SampleScene makeSolarSystem() {
  SampleScene scene{"solar_system", commonAppearances(), commonFeels(), {}, {}};
  for (const Body& body : kBodies) {
    scene.shapes.push_back(ball(body.name, body.radius, body.appearance, kFeelPlastic));
    assets::ForceField pull;
    pull.kind = assets::ForceField::Kind::gravity;
    pull.name = std::string(body.name) + " gravity";
    pull.radius = body.radius;
    pull.strength = body.surfaceForce * body.radius * body.radius;
    pull.maxForce = 3.0;
    scene.parts.push_back({body.name, scene.shapes.size() - 1, body.position, body.movable, {pull}});
  }
  return scene;
}

SampleScene makeGuidedPath() {
  SampleScene scene{"guided_path", commonAppearances(), commonFeels(), {}, {}};
  scene.shapes = {plate()};
  assets::ForceField guide;
  guide.kind = assets::ForceField::Kind::guide;
  guide.name = "way through the hole";
  guide.anchor = assets::ForceField::Anchor::path;
  guide.points = {{-60.0 * mm, 70.0 * mm, 10.0 * mm},
                  {-25.0 * mm, 60.0 * mm, 20.0 * mm},
                  {0.0, 35.0 * mm, 0.0},
                  {0.0, 5.0 * mm, 0.0},
                  {0.0, -25.0 * mm, 0.0},
                  {30.0 * mm, -50.0 * mm, -15.0 * mm}};
  guide.stiffness = 180.0;
  guide.damping.x = 1.0;
  guide.radius = 3.0 * mm;
  guide.range = 30.0 * mm;
  guide.fade = 10.0 * mm;
  guide.maxForce = 2.5;
  scene.parts = {{"plate", 0, glm::dvec3(0.0), false, {guide}}};
  return scene;
}

}  // namespace tandem::generate
