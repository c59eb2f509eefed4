#include <string>

#include "assets/generate/common.h"

namespace tandem::generate {
namespace {

constexpr double kHoleRadius = 10.0 * mm;
constexpr double kChamfer = 1.0 * mm;
constexpr double kBoardThickness = 30.0 * mm;
constexpr double kPegLength = 40.0 * mm;
constexpr double kPitch = 55.0 * mm;
constexpr double kFootHeight = 12.0 * mm;

struct Fit {
  const char* name;
  double clearance;  // m, of the diameters
  int segments;      // at least pi / sqrt(clearance / 2 r): the polygons' play stays within the clearance
  AppearanceId appearance;
};
constexpr Fit kFits[3] = {{"peg_0.5", 0.5 * mm, 64, kLime},
                          {"peg_0.1", 0.1 * mm, 96, kBrass},
                          {"peg_0.02", 0.02 * mm, 192, kSteel}};

/// A board with three chamfered holes, one, two and three dots beside them, on four feet.
SampleShape board() {
  SampleShape shape{"board", {}, {kPaint, kMachined}, kFeelAluminium};
  Solid& s = shape.solid;
  const double bottom = kFootHeight, top = kFootHeight + kBoardThickness, edge = 1.5 * mm;
  const glm::dvec2 size(180.0 * mm, 80.0 * mm);
  const Loop rim = roundedRectangle(size, 10.0 * mm, 10);
  const Loop inner = roundedRectangle(size - glm::dvec2(2.0 * edge), 10.0 * mm - edge, 10);
  std::vector<Loop> above, below;
  s.paint(1);
  for (int i = 0; i < 3; ++i) {
    const glm::dvec2 centre((i - 1) * kPitch, 0.0);
    const Loop hole = circleAround(kHoleRadius, kFits[i].segments, centre);
    const Loop mouth = circleAround(kHoleRadius + kChamfer, kFits[i].segments, centre);
    s.band(mouth, top, hole, top - kChamfer);
    s.band(hole, top - kChamfer, hole, bottom + kChamfer);
    s.band(hole, bottom + kChamfer, mouth, bottom);
    above.push_back(mouth);
    below.push_back(mouth);
    for (int dot = 0; dot <= i; ++dot) {
      const glm::dvec2 place = centre + glm::dvec2((dot - 0.5 * i) * 8.0 * mm, -24.0 * mm);
      s.revolve(
          {{2.5 * mm, top}, {2.0 * mm, top - 0.5 * mm}, {2.0 * mm, top - 1.2 * mm}, {0.0, top - 1.2 * mm}},
          16, place);
      above.push_back(circle(2.5 * mm, 16, place));
    }
  }
  s.paint(0);
  for (const double x : {-76.0 * mm, 76.0 * mm}) {
    for (const double y : {-26.0 * mm, 26.0 * mm}) {
      s.revolve({{0.0, 0.0}, {6.0 * mm, 0.0}, {7.0 * mm, 1.0 * mm}, {7.0 * mm, bottom}}, 32,
                glm::dvec2(x, y));
      below.push_back(circle(7.0 * mm, 32, glm::dvec2(x, y)));
    }
  }
  s.cap(inner, below, bottom, Facing::down);
  s.band(inner, bottom, rim, bottom + edge);
  s.band(rim, bottom + edge, rim, top - edge);
  s.band(rim, top - edge, inner, top);
  s.cap(inner, above, top, Facing::up);
  return shape;
}

SampleShape peg(const Fit& fit) {
  SampleShape shape{fit.name, {}, {fit.appearance}, kFeelSteel};
  if (fit.appearance == kLime) shape.feel = kFeelPlastic;
  if (fit.appearance == kBrass) shape.feel = kFeelBrass;
  const double r = kHoleRadius - 0.5 * fit.clearance;
  shape.solid.revolve({{0.0, 0.0},
                       {r - kChamfer, 0.0},
                       {r, kChamfer},
                       {r, kPegLength - kChamfer},
                       {r - kChamfer, kPegLength},
                       {0.0, kPegLength}},
                      fit.segments);
  return shape;
}

}  // namespace

SampleScene makePegBoard() {
  SampleScene scene{"peg_board", commonAppearances(), commonFeels(), {}, {}};
  scene.shapes = {benchTop(glm::dvec2(300.0 * mm, 240.0 * mm)), board()};
  scene.parts = {{"bench", 0, glm::dvec3(0.0), false},
                 {"board", 1, glm::dvec3(0.0, kRestGap, -40.0 * mm), false}};
  for (int i = 0; i < 3; ++i) {
    scene.shapes.push_back(peg(kFits[i]));
    scene.parts.push_back(
        {kFits[i].name, scene.shapes.size() - 1, glm::dvec3((i - 1) * kPitch, kRestGap, 55.0 * mm), true});
  }
  return scene;
}

}  // namespace tandem::generate
