#include <cmath>

#include "assets/generate/common.h"

namespace tandem::generate {
namespace {

constexpr int kSegments = 96;
constexpr double kFloor = 14.0 * mm, kRim = 150.0 * mm;
constexpr double kBoreRadius = 44.0 * mm, kRimRadius = 60.0 * mm;
constexpr double kRingRadius = 51.0 * mm,
                 kRingSection = 1.8 * mm;  // o-ring: middle circle and section radius

/// Bowl on a foot plate: a spigot in its floor centres the cartridge, a groove in its rim takes the o-ring.
SampleShape bowl() {
  SampleShape shape{"filter_bowl", {}, {kPaint, kMachined}, kFeelAluminium};
  Solid& s = shape.solid;
  const auto feet = boltCircle(65.0 * mm, 4, M_PI / 4.0);
  std::vector<Loop> below, above{circle(54.0 * mm, kSegments)};
  for (const glm::dvec2& foot : feet) {
    s.revolve({{4.5 * mm, 8.0 * mm}, {4.5 * mm, 0.0}}, 24, foot);
    below.push_back(circle(4.5 * mm, 24, foot));
    above.push_back(circle(4.5 * mm, 24, foot));
  }
  s.cap(circle(75.0 * mm, kSegments), below, 0.0, Facing::down);
  s.revolve({{75.0 * mm, 0.0}, {76.0 * mm, 1.0 * mm}, {76.0 * mm, 7.0 * mm}, {75.0 * mm, 8.0 * mm}},
            kSegments);
  s.cap(circle(75.0 * mm, kSegments), above, 8.0 * mm, Facing::up);
  s.revolve({{54.0 * mm, 8.0 * mm},
             {51.2 * mm, 9.2 * mm},
             {50.0 * mm, 12.0 * mm},
             {50.0 * mm, 128.0 * mm},
             {51.5 * mm, 131.0 * mm},
             {kRimRadius - 1.0 * mm, 138.0 * mm},
             {kRimRadius, 139.0 * mm},
             {kRimRadius, kRim - 1.0 * mm},
             {kRimRadius - 1.0 * mm, kRim}},
            kSegments);
  s.paint(1);
  s.revolve({{kRimRadius - 1.0 * mm, kRim},
             {53.0 * mm, kRim},
             {53.0 * mm, kRim - 3.8 * mm},
             {49.0 * mm, kRim - 3.8 * mm},
             {49.0 * mm, kRim},
             {kBoreRadius + 1.0 * mm, kRim},
             {kBoreRadius, kRim - 1.0 * mm},
             {kBoreRadius, kFloor + 2.0 * mm},
             {kBoreRadius - 2.0 * mm, kFloor},
             {11.8 * mm, kFloor},
             {11.8 * mm, kFloor + 16.0 * mm},
             {9.8 * mm, kFloor + 20.0 * mm},
             {0.0, kFloor + 20.0 * mm}},
            kSegments);
  return shape;
}

SampleShape oRing() {
  SampleShape shape{"o_ring", {}, {kRubber}, kFeelRubber};
  std::vector<ProfilePoint> section;
  for (int i = 0; i <= 16; ++i) {
    const double turn = 2.0 * M_PI * (i % 16) / 16;
    section.push_back({kRingRadius + kRingSection * std::cos(turn), kRingSection * (1.0 + std::sin(turn))});
  }
  shape.solid.revolve(section, kSegments);
  return shape;
}

/// 40 pleats between two end discs, with a bore for the bowl's spigot.
SampleShape cartridge(const char* name, AppearanceId paper, AppearanceId ends) {
  SampleShape shape{name, {}, {ends, paper}, kFeelPlastic};
  Solid& s = shape.solid;
  const double disc = 7.0 * mm, height = 116.0 * mm, radius = 41.0 * mm, bore = 12.1 * mm, edge = 1.0 * mm;
  Loop pleats;
  for (int i = 0; i < 160; ++i) {
    const double turn = 2.0 * M_PI * i / 160;
    const double r = (i % 4 < 2 ? 37.5 : 30.0) * mm;
    pleats.push_back(r * glm::dvec2(std::cos(turn), std::sin(turn)));
  }
  s.revolve({{bore, height - edge},
             {bore, edge},
             {bore + edge, 0.0},
             {radius - edge, 0.0},
             {radius, edge},
             {radius, disc - edge},
             {radius - edge, disc}},
            kSegments);
  s.cap(circle(radius - edge, kSegments), {pleats}, disc, Facing::up);
  s.cap(circle(radius - edge, kSegments), {pleats}, height - disc, Facing::down);
  s.revolve({{radius - edge, height - disc},
             {radius, height - disc + edge},
             {radius, height - edge},
             {radius - edge, height},
             {bore + edge, height},
             {bore, height - edge}},
            kSegments);
  s.paint(1);
  s.band(pleats, disc, pleats, height - disc);
  return shape;
}

/// A lid with twelve finger scallops, a spigot into the bowl and a hexagon for a wrench. Its seat is y = 0.
SampleShape cap() {
  SampleShape shape{"cap", {}, {kPlastic}, kFeelPlastic};
  Solid& s = shape.solid;
  const double top = 16.0 * mm, bevel = 1.5 * mm, flats = 36.0 * mm;
  const auto scalloped = [](double radius) {
    Loop loop;
    for (int i = 0; i < 192; ++i) {
      const double turn = 2.0 * M_PI * i / 192;
      const double r = radius - 2.0 * mm * std::pow(0.5 + 0.5 * std::cos(12.0 * turn), 3.0);
      loop.push_back(r * glm::dvec2(std::cos(turn), std::sin(turn)));
    }
    return loop;
  };
  const Loop rim = scalloped(63.0 * mm), inner = scalloped(63.0 * mm - bevel), hex = hexagon(flats, 4);
  const Loop hexTop = hexagon(flats - 2.0 * bevel, 4);
  s.revolve({{0.0, -9.0 * mm}, {42.8 * mm, -9.0 * mm}, {43.8 * mm, -8.0 * mm}, {43.8 * mm, 0.0}}, kSegments);
  s.cap(inner, {circle(43.8 * mm, kSegments)}, 0.0, Facing::down);
  s.band(inner, 0.0, rim, bevel);
  s.band(rim, bevel, rim, top - bevel);
  s.band(rim, top - bevel, inner, top);
  s.cap(inner, {hex}, top, Facing::up);
  s.band(hex, top, hex, top + 16.0 * mm - bevel);
  s.band(hex, top + 16.0 * mm - bevel, hexTop, top + 16.0 * mm);
  s.cap(hexTop, {}, top + 16.0 * mm, Facing::up);
  return shape;
}

}  // namespace

SampleScene makeFilterChange() {
  SampleScene scene{"filter_change", commonAppearances(), commonFeels(), {}, {}};
  scene.shapes = {benchTop(glm::dvec2(520.0 * mm, 300.0 * mm)),
                  bowl(),
                  oRing(),
                  cartridge("cartridge_old", kUsedPaper, kRubber),
                  cartridge("cartridge_new", kPaper, kLime),
                  cap()};
  const double x = -120.0 * mm, gap = kRestGap;
  scene.parts = {{"bench", 0, glm::dvec3(0.0), false},
                 {"filter_bowl", 1, glm::dvec3(x, gap, 0.0), false},
                 {"o_ring", 2, glm::dvec3(x, gap + kRim - 3.7 * mm, 0.0), true},
                 {"cartridge_old", 3, glm::dvec3(x, gap + kFloor + 0.1 * mm, 0.0), true},
                 {"cap", 5, glm::dvec3(x, gap + kRim + 0.1 * mm, 0.0), true},
                 {"cartridge_new", 4, glm::dvec3(40.0 * mm, gap, 0.0), true},
                 {"o_ring_new", 2, glm::dvec3(160.0 * mm, gap, 40.0 * mm), true}};
  return scene;
}

}  // namespace tandem::generate
