#include <cmath>
#include <string>

#include "assets/generate/common.h"

namespace tandem::generate {
namespace {

constexpr int kRound = 96;  // segments of large circles
constexpr int kHole = 24;   // of bolt holes
constexpr int kBolts = 6;
constexpr double kFlangeRadius = 106.0 * mm, kBoltCircle = 95.0 * mm, kBoltHole = 4.5 * mm;
constexpr double kVoluteFloor = 50.0 * mm, kShoulder = 98.0 * mm, kFlangeTop = 102.0 * mm;

/// The volute: its radius grows by 16 mm over 335 degrees and falls back at the tongue. `wall` is added to
/// it.
Loop volute(double wall) {
  Loop loop;
  for (int i = 0; i < 144; ++i) {
    const double turn = 360.0 * i / 144, rise = 335.0;
    const double back = turn <= rise ? 0.0 : (turn - rise) / (360.0 - rise);
    const double smooth = back * back * (3.0 - 2.0 * back);
    const double radius = 60.0 * mm + wall + 16.0 * mm * (turn <= rise ? turn / rise : 1.0 - smooth);
    const double angle = turn * M_PI / 180.0;
    loop.push_back(radius * glm::dvec2(std::cos(angle), std::sin(angle)));
  }
  return loop;
}

std::vector<Loop> circles(const std::vector<glm::dvec2>& centres, double radius, int segments) {
  std::vector<Loop> loops;
  for (const glm::dvec2& centre : centres) loops.push_back(circle(radius, segments, centre));
  return loops;
}

std::vector<Loop> with(std::vector<Loop> loops, const std::vector<Loop>& more) {
  loops.insert(loops.end(), more.begin(), more.end());
  return loops;
}

/// Foot plate, pedestal with the bearing bore, volute with its discharge below, flange with bolt holes.
SampleShape housing() {
  SampleShape shape{"housing", {}, {kPaint, kMachined}, kFeelAluminium};
  Solid& s = shape.solid;
  const glm::dvec2 port = 60.0 * mm * glm::dvec2(std::cos(5.2), std::sin(5.2));
  const auto feet = boltCircle(92.0 * mm, 4, M_PI / 4.0);
  const auto bolts = boltCircle(kBoltCircle, kBolts);
  const Loop cavity = volute(0.0), outside = volute(8.0 * mm);

  // Foot plate and pedestal.
  s.cap(circle(104.0 * mm, kRound), with({circle(16.1 * mm, kRound)}, circles(feet, 5.5 * mm, kHole)), 0.0,
        Facing::down);
  s.revolve({{104.0 * mm, 0.0}, {105.0 * mm, 1.0 * mm}, {105.0 * mm, 10.5 * mm}, {103.5 * mm, 12.0 * mm}},
            kRound);
  for (const glm::dvec2& foot : feet) s.revolve({{5.5 * mm, 12.0 * mm}, {5.5 * mm, 0.0}}, kHole, foot);
  s.cap(circle(103.5 * mm, kRound), with({circle(55.0 * mm, kRound)}, circles(feet, 5.5 * mm, kHole)),
        12.0 * mm, Facing::up);
  std::vector<ProfilePoint> pedestal;
  for (int i = 0; i <= 8; ++i) {
    const double turn = 0.5 * M_PI * i / 8;
    pedestal.push_back({55.0 * mm - 11.0 * mm * std::sin(turn), 23.0 * mm - 11.0 * mm * std::cos(turn)});
  }
  pedestal.push_back({44.0 * mm, 40.0 * mm});
  s.revolve(pedestal, kRound);

  // Outside of the volute, and the discharge stub below it.
  s.cap(outside, {circle(44.0 * mm, kRound), circle(13.5 * mm, 48, port)}, 40.0 * mm, Facing::down);
  s.revolve({{10.0 * mm, kVoluteFloor},
             {10.0 * mm, 22.0 * mm},
             {12.7 * mm, 22.0 * mm},
             {13.5 * mm, 22.8 * mm},
             {13.5 * mm, 40.0 * mm}},
            48, port);
  s.band(outside, 40.0 * mm, outside, 90.0 * mm);

  // Flange.
  s.cap(circle(kFlangeRadius - 1.0 * mm, kRound), with({outside}, circles(bolts, kBoltHole, kHole)),
        90.0 * mm, Facing::down);
  s.revolve({{kFlangeRadius - 1.0 * mm, 90.0 * mm},
             {kFlangeRadius, 91.0 * mm},
             {kFlangeRadius, 101.0 * mm},
             {kFlangeRadius - 1.0 * mm, kFlangeTop}},
            kRound);
  s.paint(1);
  s.cap(circle(kFlangeRadius - 1.0 * mm, kRound),
        with({circle(82.0 * mm, kRound)}, circles(bolts, 5.3 * mm, kHole)), kFlangeTop, Facing::up);
  for (const glm::dvec2& bolt : bolts)
    s.revolve({{5.3 * mm, kFlangeTop}, {kBoltHole, kFlangeTop - 0.8 * mm}, {kBoltHole, 90.0 * mm}}, kHole,
              bolt);
  s.revolve({{82.0 * mm, kFlangeTop}, {82.0 * mm, kShoulder}}, kRound);
  s.cap(circle(82.0 * mm, kRound), {cavity}, kShoulder, Facing::up);

  // Cavity, seat of the shaft's collar, bearing bore.
  s.paint(0);
  s.band(cavity, kShoulder, cavity, kVoluteFloor);
  s.cap(cavity, {circle(22.0 * mm, kRound), circle(10.0 * mm, 48, port)}, kVoluteFloor, Facing::up);
  s.paint(1);
  s.revolve({{22.0 * mm, kVoluteFloor},
             {22.0 * mm, 44.0 * mm},
             {16.1 * mm, 44.0 * mm},
             {15.1 * mm, 43.0 * mm},
             {15.1 * mm, 1.0 * mm},
             {16.1 * mm, 0.0}},
            kRound);
  return shape;
}

/// Journal of 30 mm, collar, impeller seat of 24 mm, end of 16 mm for the nut.
SampleShape shaft() {
  SampleShape shape{"shaft", {}, {kSteel}, kFeelSteel};
  shape.solid.revolve({{0.0, 0.0},
                       {14.0 * mm, 0.0},
                       {15.0 * mm, 1.0 * mm},
                       {15.0 * mm, 42.0 * mm},
                       {20.0 * mm, 42.0 * mm},
                       {21.0 * mm, 43.0 * mm},
                       {21.0 * mm, 46.0 * mm},
                       {20.0 * mm, 47.0 * mm},
                       {12.0 * mm, 47.0 * mm},
                       {12.0 * mm, 84.0 * mm},
                       {11.0 * mm, 85.0 * mm},
                       {8.0 * mm, 85.0 * mm},
                       {8.0 * mm, 105.0 * mm},
                       {7.0 * mm, 106.0 * mm},
                       {0.0, 106.0 * mm}},
                      kRound);
  return shape;
}

/// A backward-curved vane between two logarithmic spirals, rounded at neither end: 3 mm thick.
Loop vane(double firstAngle) {
  constexpr int kSteps = 12;
  Loop inner, outer;
  for (int i = 0; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps, radius = (20.5 + 32.5 * share) * mm;
    const double angle = firstAngle - 1.05 * share;
    const double half =
        0.5 * (2.6 + 1.0 * share) * mm / radius * 1.35;  // the vane stands slanting to the circle
    inner.push_back(radius * glm::dvec2(std::cos(angle - half), std::sin(angle - half)));
    outer.push_back(radius * glm::dvec2(std::cos(angle + half), std::sin(angle + half)));
  }
  Loop loop = inner;
  loop.insert(loop.end(), outer.rbegin(), outer.rend());
  return loop;
}

SampleShape impeller() {
  SampleShape shape{"impeller", {}, {kBrass}, kFeelBrass};
  Solid& s = shape.solid;
  const double disc = 6.0 * mm, face = 10.0 * mm, vaneTop = 38.0 * mm, hubTop = 40.0 * mm;
  s.revolve({{12.05 * mm, hubTop - 0.8 * mm},
             {12.05 * mm, 0.8 * mm},
             {12.85 * mm, 0.0},
             {18.0 * mm, 0.0},
             {18.0 * mm, disc},
             {54.0 * mm, disc},
             {55.0 * mm, disc + 1.0 * mm},
             {55.0 * mm, face - 1.0 * mm},
             {54.0 * mm, face}},
            kRound);
  std::vector<Loop> onFace{circle(19.0 * mm, kRound)};
  for (int i = 0; i < 6; ++i) {
    const Loop loop = vane(2.0 * M_PI * i / 6);
    s.band(loop, face, loop, vaneTop);
    s.cap(loop, {}, vaneTop, Facing::up);
    onFace.push_back(loop);
  }
  s.cap(circle(54.0 * mm, kRound), onFace, face, Facing::up);
  s.revolve({{19.0 * mm, face},
             {17.5 * mm, face + 2.0 * mm},
             {16.5 * mm, face + 6.0 * mm},
             {15.5 * mm, hubTop - 1.0 * mm},
             {14.5 * mm, hubTop},
             {12.85 * mm, hubTop},
             {12.05 * mm, hubTop - 0.8 * mm}},
            kRound);
  return shape;
}

/// A hexagonal prism whose upper or lower corners are turned off; the loop at its end is a circle.
void chamferedHexagon(Solid& s, double acrossFlats, double flatEnd, double roundEnd) {
  const Loop hexagonLoop = hexagon(acrossFlats, 8);
  // The circle's corners stand at the hexagon's angles, so that the band between them does not twist.
  Loop end;
  for (const glm::dvec2& p : hexagonLoop)
    end.push_back(0.5 * 0.94 * acrossFlats / std::sqrt(p.x * p.x + p.y * p.y) * p);
  if (roundEnd > flatEnd)
    s.band(hexagonLoop, flatEnd, end, roundEnd);
  else
    s.band(end, roundEnd, hexagonLoop, flatEnd);
}

Loop chamferEnd(double acrossFlats) {
  Loop end;
  for (const glm::dvec2& p : hexagon(acrossFlats, 8))
    end.push_back(0.5 * 0.94 * acrossFlats / std::sqrt(p.x * p.x + p.y * p.y) * p);
  return end;
}

SampleShape impellerNut() {
  SampleShape shape{"impeller_nut", {}, {kSteel}, kFeelSteel};
  Solid& s = shape.solid;
  const double flats = 24.0 * mm, height = 13.0 * mm, bevel = 1.2 * mm;
  const Loop side = hexagon(flats, 8), mouth = circle(9.2 * mm, 48), bore = circle(8.2 * mm, 48);
  s.cap(chamferEnd(flats), {mouth}, 0.0, Facing::down);
  chamferedHexagon(s, flats, bevel, 0.0);
  s.band(side, bevel, side, height - bevel);
  chamferedHexagon(s, flats, height - bevel, height);
  s.cap(chamferEnd(flats), {mouth}, height, Facing::up);
  s.band(mouth, height, bore, height - 1.0 * mm);
  s.band(bore, height - 1.0 * mm, bore, 1.0 * mm);
  s.band(bore, 1.0 * mm, mouth, 0.0);
  return shape;
}

/// M8 x 30, standing on its head's underside at y = 0 with the shank below.
SampleShape bolt() {
  SampleShape shape{"bolt_m8x30", {}, {kSteel}, kFeelSteel};
  Solid& s = shape.solid;
  const double flats = 13.0 * mm, height = 5.3 * mm, bevel = 0.7 * mm, washer = 0.4 * mm;
  const Loop side = hexagon(flats, 8), seat = circle(5.8 * mm, 48), shank = circle(4.0 * mm, 48);
  s.revolve({{0.0, -30.0 * mm}, {3.2 * mm, -30.0 * mm}, {4.0 * mm, -29.2 * mm}, {4.0 * mm, 0.0}}, 48);
  s.band(shank, 0.0, seat, 0.0);
  s.band(seat, 0.0, seat, washer);
  s.cap(side, {seat}, washer, Facing::down);
  s.band(side, washer, side, height - bevel);
  chamferedHexagon(s, flats, height - bevel, height);
  s.cap(chamferEnd(flats), {}, height, Facing::up);
  return shape;
}

/// Bolted flange with a spigot into the housing, and the suction nozzle with its own flange.
SampleShape cover() {
  SampleShape shape{"cover", {}, {kPaint, kMachined}, kFeelAluminium};
  Solid& s = shape.solid;
  const auto bolts = boltCircle(kBoltCircle, kBolts), pipe = boltCircle(42.0 * mm, 4, M_PI / 4.0);
  const double top = 10.0 * mm, nozzle = 46.0 * mm, end = 56.0 * mm;
  s.paint(1);
  s.revolve({{24.0 * mm, end},
             {24.0 * mm, -10.0 * mm},
             {26.0 * mm, -12.0 * mm},
             {56.0 * mm, -12.0 * mm},
             {57.0 * mm, -11.0 * mm},
             {57.0 * mm, -3.8 * mm},
             {81.1 * mm, -3.8 * mm},
             {81.9 * mm, -3.0 * mm},
             {81.9 * mm, 0.0}},
            kRound);
  s.cap(circle(kFlangeRadius - 1.0 * mm, kRound),
        with({circle(81.9 * mm, kRound)}, circles(bolts, kBoltHole, kHole)), 0.0, Facing::down);
  for (const glm::dvec2& hole : bolts)
    s.revolve({{5.3 * mm, top}, {kBoltHole, top - 0.8 * mm}, {kBoltHole, 0.0}}, kHole, hole);
  s.paint(0);
  s.revolve({{kFlangeRadius - 1.0 * mm, 0.0},
             {kFlangeRadius, 1.0 * mm},
             {kFlangeRadius, top - 1.0 * mm},
             {kFlangeRadius - 1.0 * mm, top}},
            kRound);
  s.cap(circle(kFlangeRadius - 1.0 * mm, kRound),
        with({circle(50.0 * mm, kRound)}, circles(bolts, 5.3 * mm, kHole)), top, Facing::up);
  std::vector<ProfilePoint> neck;
  for (int i = 0; i <= 10; ++i) {
    const double turn = 0.5 * M_PI * i / 10;
    neck.push_back({50.0 * mm - 19.0 * mm * std::sin(turn), top + 19.0 * mm - 19.0 * mm * std::cos(turn)});
  }
  neck.push_back({31.0 * mm, nozzle});
  s.revolve(neck, kRound);
  s.cap(circle(51.0 * mm, kRound), with({circle(31.0 * mm, kRound)}, circles(pipe, kBoltHole, kHole)), nozzle,
        Facing::down);
  s.revolve(
      {{51.0 * mm, nozzle}, {52.0 * mm, nozzle + 1.0 * mm}, {52.0 * mm, end - 1.0 * mm}, {51.0 * mm, end}},
      kRound);
  s.paint(1);
  s.cap(circle(51.0 * mm, kRound), with({circle(24.0 * mm, kRound)}, circles(pipe, kBoltHole, kHole)), end,
        Facing::up);
  for (const glm::dvec2& hole : pipe) s.revolve({{kBoltHole, end}, {kBoltHole, nozzle}}, kHole, hole);
  return shape;
}

}  // namespace

SampleScene makePump() {
  SampleScene scene{"pump", commonAppearances(), commonFeels(), {}, {}};
  scene.shapes = {benchTop(glm::dvec2(640.0 * mm, 420.0 * mm)),
                  housing(),
                  shaft(),
                  impeller(),
                  impellerNut(),
                  cover(),
                  bolt()};
  const double rest = kRestGap;
  scene.parts = {{"bench", 0, glm::dvec3(0.0), false},
                 {"housing", 1, glm::dvec3(-120.0 * mm, rest, -60.0 * mm), false},
                 {"shaft", 2, glm::dvec3(-150.0 * mm, rest, 130.0 * mm), true},
                 {"impeller", 3, glm::dvec3(-50.0 * mm, rest, 130.0 * mm), true},
                 {"impeller_nut", 4, glm::dvec3(35.0 * mm, rest, 130.0 * mm), true},
                 {"cover", 5, glm::dvec3(150.0 * mm, rest + 12.0 * mm, -60.0 * mm), true}};
  for (int i = 0; i < kBolts; ++i)
    scene.parts.push_back(
        {"bolt_" + std::to_string(i + 1), 6,
         glm::dvec3((90.0 + 32.0 * (i % 3)) * mm, rest + 30.0 * mm, (115.0 + 32.0 * (i / 3)) * mm), true});
  return scene;
}

}  // namespace tandem::generate
