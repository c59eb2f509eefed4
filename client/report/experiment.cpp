#include "client/report/experiment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/constants.h"
#include "assets/generate/bench_meshes.h"
#include "assets/generate/profile_god_object.h"
#include "client/report/exact_answers.h"

namespace tandem::client::report {
namespace {

constexpr double kGrooveHalfAngle = kPi / 6.0;
constexpr double kInset = 0.8 * kMillimetre;  // depth under the gear, whose teeth are 2 mm wide at their tips
constexpr int kApproach = 40;                 // ticks in which the tool comes down
constexpr double kHover = 0.3 * kMillimetre;  // height over a surface
constexpr double kScanRadius = 10.0 * kMillimetre, kScanNoise = 0.05;  // the noise in edges of the mesh

/// A number of triangles as an id and a title write it.
struct Size {
  const char* name;
  const char* title;
  int triangles;
};
constexpr std::array<Size, 4> kSizes{
    {{"1k", "1 k", 1000}, {"10k", "10 k", 10'000}, {"100k", "100 k", 100'000}, {"1m", "1 M", 1'000'000}}};

int trianglesOf(const std::string& id) {
  for (const Size& size : kSizes)
    if (id.ends_with(std::string("-") + size.name)) return size.triangles;
  return 0;
}

Experiment onePart(assets::Mesh mesh, const glm::dvec3& position = glm::dvec3(0.0)) {
  Experiment e;
  e.scene = generate::sceneOf(std::move(mesh));
  e.scene.parts[0].worldFromPart.position = position;
  return e;
}

/// Rises from 0 to 1 over the first ticks, with no step of speed at either end.
double approach(int tick) {
  const double share = std::min(1.0, static_cast<double>(tick) / kApproach);
  return share * share * (3.0 - 2.0 * share);
}

/// From 0 (hovering) to 1 (as deep as it goes) and back, twice a second, at rest for a fifth of a second at
/// both ends.
double inAndOut(int tick) {
  const double phase = std::fmod(2.0 * kDt * tick, 1.0), way = phase < 0.5 ? phase : 1.0 - phase;
  const double share = std::clamp(5.0 * (way - 0.2) / 0.5, 0.0, 1.0);
  return share * share * (3.0 - 2.0 * share);
}

/// A direction from the centre of a sphere, along a curve that meets facets at all angles.
glm::dvec3 strokeDirection(double travelled) {
  const double polar = 0.5 * kPi + 0.6 * std::sin(0.37 * travelled + 0.3), azimuth = 0.9 * travelled + 0.1;
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
}

/// A stroke over a sphere around `centre` at 0.2 m/s, at heights over where the tool rests.
template <typename HeightAt>
void strokeSphere(Experiment& e, double radius, double ball, const glm::dvec3& centre, int ticks,
                  const HeightAt& heightAt) {
  const double reach = radius + ball, speed = 0.2;
  for (int i = 0; i < ticks; ++i) {
    const glm::dvec3 goal = strokeDirection(speed * kDt * i / radius) * (reach + heightAt(i));
    e.path.push_back({centre + goal, centre + outsideSphere(goal, reach), 0.0});
  }
}

double down2mm(int tick) { return kMillimetre - approach(tick) * 3.0 * kMillimetre; }

Experiment sphereAt(double radius, int triangles, const glm::dvec3& centre) {
  Experiment e = onePart(generate::sphereMesh(radius, triangles), centre);
  const double deepest = generate::deepestFacet(e.scene.meshes[0], radius);
  e.facetDepth = deepest;
  e.facetTilt = std::acos(1.0 - deepest / radius);
  e.curved = true;
  return e;
}

/// 2 mm deep.
Experiment sphere(double radius, double ball, int triangles, const glm::dvec3& centre, int ticks) {
  Experiment e = sphereAt(radius, triangles, centre);
  strokeSphere(e, radius, ball, centre, ticks, down2mm);
  return e;
}

Experiment sphereInAndOut(int triangles, int ticks) {
  constexpr double kRadius = 0.05, kDeep = 0.8 * kMillimetre;
  Experiment e = sphereAt(kRadius, triangles, glm::dvec3(0.0));
  strokeSphere(e, kRadius, 0.0, glm::dvec3(0.0), ticks,
               [](int i) { return kHover - inAndOut(i) * (kHover + kDeep); });
  return e;
}

/// A point of the surface that scanMesh() is a scan of, and its normal.
struct ScannedPlace {
  glm::dvec3 point, normal;
};

ScannedPlace scannedPlace(const glm::dvec3& direction) {
  constexpr double kStep = 1e-5;
  glm::dvec3 rise(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 step(0.0);
    step[axis] = kStep;
    rise[axis] = (generate::scanWave(kScanRadius, direction + step) -
                  generate::scanWave(kScanRadius, direction - step)) /
                 (2.0 * kStep);
  }
  const double height = kScanRadius + generate::scanWave(kScanRadius, direction);
  const glm::dvec3 across = rise - glm::dot(rise, direction) * direction;
  return {direction * height, glm::normalize(direction - across / height)};
}

/// 2 mm under the body that was scanned, which is less than it is curved anywhere: the exact answer of that
/// body is the place under whose normal the hand is.
Experiment scan(double ball, int triangles, int ticks) {
  Experiment e = onePart(generate::scanMesh(kScanRadius, triangles, kScanNoise, 1));
  e.curved = true;
  for (int i = 0; i < ticks; ++i) {
    const ScannedPlace place = scannedPlace(strokeDirection(0.1 * kDt * i / kScanRadius));
    const double height = down2mm(i);
    const glm::dvec3 rest = place.point + ball * place.normal, goal = rest + height * place.normal;
    e.path.push_back({goal, height < 0.0 ? rest : goal, 0.0});
  }
  return e;
}

/// A closed curve at a given depth under the profile, or above it. Its normal is the mean over kInset in both
/// directions, so that the hand goes smoothly round sharp corners of the surface.
class InsetCurve {
 public:
  explicit InsetCurve(const std::vector<glm::dvec2>& profile) : profile_(profile) {
    for (std::size_t i = 0; i < profile.size(); ++i) {
      starts_.push_back(length_);
      length_ += glm::length(corner(i + 1) - corner(i));
    }
  }

  /// The arc length at which the outline is farthest out along x: on a tooth's tip.
  double arcOfOutermost() const {
    double best = 0.0;
    for (int i = 0; i < 1000; ++i)
      if (sample(1e-3 * i * length_).first.x > sample(best).first.x) best = 1e-3 * i * length_;
    return best;
  }

  glm::dvec2 at(double arc, double depth) const {
    const double span = kInset;
    glm::dvec2 middle(0.0), normal(0.0);
    constexpr int kSamples = 33;
    for (int i = 0; i < kSamples; ++i) {
      const auto [point, outward] = sample(arc + span * (2.0 * i / (kSamples - 1) - 1.0));
      middle += point / static_cast<double>(kSamples);
      normal += outward;
    }
    return middle - depth * glm::normalize(normal);
  }

 private:
  glm::dvec2 corner(std::size_t i) const { return profile_[i % profile_.size()]; }

  std::pair<glm::dvec2, glm::dvec2> sample(double arc) const {
    arc -= length_ * std::floor(arc / length_);
    const auto after = std::upper_bound(starts_.begin(), starts_.end(), arc);
    const auto edge = static_cast<std::size_t>(after - starts_.begin() - 1);
    const glm::dvec2 along = glm::normalize(corner(edge + 1) - corner(edge));
    return {corner(edge) + along * (arc - starts_[edge]), {along.y, -along.x}};
  }

  const std::vector<glm::dvec2>& profile_;
  std::vector<double> starts_;
  double length_ = 0.0;
};

/// A ball is a point outside the gear grown by its radius. Arcs are pieces of 30 urad, which are 0.1 pm off;
/// a goal near an arc's centre gives a proxy up to some 0.1 um beside the exact one.
template <typename DepthAt>
Experiment gear(int triangles, double ball, int ticks, const DepthAt& depthAt) {
  const std::vector<glm::dvec2> profile =
      ball > 0.0 ? generate::grownProfile(generate::gearProfile(), ball, 3e-5) : generate::gearProfile();
  Experiment e = onePart(generate::gearMesh(triangles));
  const InsetCurve curve(profile);
  generate::ProfileGodObject exact(profile);
  // 0.1 m/s along the outline, begun over a tooth; no layer of the mesh is at this height.
  const double start = curve.arcOfOutermost(), z = 0.50712 * generate::kGearHeight;
  for (int i = 0; i < ticks; ++i) {
    const glm::dvec2 goal = curve.at(start + 1e-4 * i, depthAt(i));
    if (i == 0) exact.place(goal);
    const glm::dvec2 proxy = exact.follow(goal);
    e.path.push_back({{goal.x, goal.y, z}, {proxy.x, proxy.y, z}, 0.0});
  }
  return e;
}

Experiment gearInset(int triangles, double ball, int ticks) {
  return gear(triangles, ball, ticks, [](int i) { return (2.0 * approach(i) - 1.0) * kInset; });
}

Experiment gearInAndOut(int triangles, int ticks) {
  return gear(triangles, 0.0, ticks, [](int i) { return inAndOut(i) * (kInset + kHover) - kHover; });
}

/// A point on a circle that meets no vertex of the sheet, `travelled` m along it, and down to 2 mm under z =
/// 0.
glm::dvec3 circleAt(double travelled, int tick) {
  constexpr double kCircle = 0.04;  // m
  const double angle = travelled / kCircle;
  return {kCircle * std::cos(angle) + 0.0013, kCircle * std::sin(angle) + 0.0007, down2mm(tick)};
}

/// Circles on the plane z = 0, 2 mm deep, from 0.02 to 0.5 m/s.
Experiment plane(int ticks) {
  Experiment e = onePart(generate::flatSheet(0.2, 100));
  double travelled = 0.0;
  for (int i = 0; i < ticks; ++i) {
    travelled += kDt * (0.02 + 0.48 * i / ticks);
    const glm::dvec3 goal = circleAt(travelled, i);
    e.path.push_back({goal, abovePlane(goal, 0.0), 0.0});
  }
  return e;
}

/// The same plane with friction, 0.005 to 0.2 m/s. The proxy follows straight towards the hand once it lags
/// by more than the coefficient times the depth, which is exact on a plane (Harwin & Melder 2002).
Experiment roughPlane(double friction, int ticks) {
  Experiment e = onePart(generate::flatSheet(0.2, 100));
  for (assets::Material& m : e.scene.materials) m.staticFriction = m.dynamicFriction = friction;
  double travelled = 0.0;
  glm::dvec3 last(0.0), proxy(0.0);
  bool touches = false;
  for (int i = 0; i < ticks; ++i) {
    travelled += kDt * (0.005 + 0.195 * i / ticks);
    const glm::dvec3 goal = circleAt(travelled, i);
    if (goal.z >= 0.0) {
      proxy = goal;
    } else {
      if (!touches) proxy = glm::mix(last, goal, last.z / (last.z - goal.z));
      touches = true;
      const glm::dvec3 lag(proxy.x - goal.x, proxy.y - goal.y, 0.0);
      const double hold = -friction * goal.z, length = glm::length(lag);
      proxy = glm::dvec3(goal.x, goal.y, 0.0) + (length > hold ? lag * (hold / length) : lag);
    }
    e.path.push_back({goal, proxy, 0.0});
    last = goal;
  }
  return e;
}

/// From wall to wall of a groove of 60 degrees, 3 times a second, while it is followed at 20 mm/s.
Experiment groove(int ticks) {
  Experiment e = onePart(generate::vGroove(0.05, kGrooveHalfAngle, 70));
  for (int i = 0; i < ticks; ++i) {
    const double x = 4.0 * kMillimetre * std::sin(2.0 * kPi * 3.0 * kDt * i);
    const double z = 6.0 * kMillimetre - approach(i) * 7.0 * kMillimetre;
    const glm::dvec3 goal(x, 0.02 * kDt * i - 0.04, z);
    e.path.push_back({goal, insideGroove(goal, kGrooveHalfAngle), 0.0});
  }
  return e;
}

/// 10,000 cubes of 5 mm side by side, their tops one plane; the tool crosses joints at a slant, 1 mm deep at
/// 0.2 m/s.
Experiment tiles(bool moving, int ticks) {
  Experiment e;
  e.partsMove = moving;
  e.scene = generate::plateGrid(100, 5.0 * kMillimetre, 5.0 * kMillimetre);
  for (int i = 0; i < ticks; ++i) {
    const double angle = 0.2 * kDt * i / 0.1;
    const double lift = moving ? 0.5 * kMillimetre * std::sin(2.0 * kPi * kDt * i) : 0.0;
    const double height = 2.0 * kMillimetre - approach(i) * 3.0 * kMillimetre;
    const glm::dvec3 goal(0.1 * std::cos(angle) + 0.0011, 0.1 * std::sin(angle) + 0.0003, height);
    e.path.push_back({goal, abovePlane(goal, lift), lift});
  }
  return e;
}

void addHoveringAndScans(std::vector<ExperimentInfo>& all) {
  const auto hover = [&](const char* over, const char* title, const char* about) {
    for (const Size& size : {kSizes[1], kSizes[3]})
      all.push_back({std::string("hover-") + over + "-" + size.name, std::string("hover-") + over,
                     std::string(title) + ", " + size.title + " triangles", about, size.triangles <= 10'000});
  };
  hover("gear", "Hovering over a gear",
        "A point goes along the outline of the gear, 0.3 mm above it, and twice a second 0.8 mm into it and "
        "out.");
  hover("sphere", "Hovering over a sphere", "The same over a sphere of 50 mm radius, at 0.2 m/s.");
  for (const Size& size : kSizes) {
    if (size.triangles < 10'000) continue;
    all.push_back(
        {std::string("scan-") + size.name, "scan", std::string("Rough scan, ") + size.title + " triangles",
         "A point strokes a lumpy body of 10 mm radius, 2 mm deep at 0.1 m/s; each vertex is off by "
         "up to 5 % of an edge.",
         size.triangles <= 10'000});
    all.back().exact = false;
  }
  all.push_back({"scan-ball1-1m", "scan-ball", "Rough scan, 1 mm ball, 1 M triangles",
                 "A ball of 1 mm radius on the same scan.", false, 1e-3});
  all.back().exact = false;
}

}  // namespace

std::vector<ExperimentInfo> allExperiments() {
  std::vector<ExperimentInfo> all;
  for (const Size& size : kSizes)
    all.push_back(
        {std::string("sphere-") + size.name, "sphere", std::string("Sphere, ") + size.title + " triangles",
         "A point strokes a sphere of 50 mm radius, 2 mm deep at 0.2 m/s.", size.triangles <= 10'000});
  all.push_back({"sphere-far-100k", "sphere-far", "Sphere, 10 m off, 100 k triangles",
                 "The same stroke on a part that stands at (10, 10, 10) m."});
  for (const Size& size : kSizes)
    all.push_back({std::string("gear-") + size.name, "gear",
                   std::string("Gear, ") + size.title + " triangles",
                   "A point follows the outline of a gear of 12 teeth, 0.8 mm inside of it at 0.1 m/s.",
                   size.triangles <= 10'000});
  all.push_back({"plane", "plane", "Plane, 20 k triangles",
                 "A point slides on a plane, 2 mm deep, at 0.02 to 0.5 m/s.", true});
  all.push_back(
      {"gear-ball1-1m", "gear-ball", "Gear, 1 mm ball, 1 M triangles",
       "A ball of 1 mm radius rolls along the same outline, its centre 0.8 mm inside of where it can go.",
       false, 1e-3});
  all.push_back({"friction", "friction", "Plane with friction 0.3",
                 "A point slides on a rough plane, 2 mm deep, at 0.005 to 0.2 m/s.", true, 0.0, 0.3});
  all.push_back({"groove", "groove", "V-groove, 20 k triangles",
                 "A point goes from wall to wall of a groove of 60 degrees while it is drawn along it.",
                 true});
  all.push_back(
      {"parts-still", "parts", "10,000 parts, still",
       "A point slides over the joints of 10,000 cubes whose tops are one plane, 1 mm deep at 0.2 m/s.",
       true});
  all.push_back({"parts-moving", "parts", "10,000 parts, all moving",
                 "The same while every cube rises and falls by 0.5 mm once a second."});
  all.push_back({"fine-point-1m", "fine", "Fine sphere, point",
                 "A point strokes a sphere of 10 mm radius and 1 M triangles, 2 mm deep.", false, 0.0});
  all.push_back({"fine-ball1-1m", "fine", "Fine sphere, 1 mm ball",
                 "A ball of 1 mm radius on the same sphere.", false, 1e-3});
  all.push_back({"fine-ball3-1m", "fine", "Fine sphere, 3 mm ball",
                 "A ball of 3 mm radius on the same sphere.", false, 3e-3});
  addHoveringAndScans(all);
  return all;
}

Experiment buildExperiment(const std::string& id, int ticks) {
  const std::vector<ExperimentInfo> all = allExperiments();
  const auto info = std::find_if(all.begin(), all.end(), [&](const ExperimentInfo& i) { return i.id == id; });
  Experiment e;
  ASSERT(info != all.end() && ticks > 0);
  if (info->family == "sphere") e = sphere(0.05, 0.0, trianglesOf(id), glm::dvec3(0.0), ticks);
  if (info->family == "sphere-far") e = sphere(0.05, 0.0, trianglesOf(id), glm::dvec3(10.0), ticks);
  if (info->family == "gear") e = gearInset(trianglesOf(id), 0.0, ticks);
  if (info->family == "gear-ball") e = gearInset(trianglesOf(id), info->toolRadius, ticks);
  if (info->family == "friction") e = roughPlane(info->friction, ticks);
  if (info->family == "plane") e = plane(ticks);
  if (info->family == "groove") e = groove(ticks);
  if (info->family == "parts") e = tiles(id == "parts-moving", ticks);
  if (info->family == "fine") e = sphere(0.01, info->toolRadius, trianglesOf(id), glm::dvec3(0.0), ticks);
  if (info->family == "hover-gear") e = gearInAndOut(trianglesOf(id), ticks);
  if (info->family == "hover-sphere") e = sphereInAndOut(trianglesOf(id), ticks);
  if (info->family == "scan" || info->family == "scan-ball")
    e = scan(info->toolRadius, trianglesOf(id), ticks);
  e.info = *info;
  return e;
}

}  // namespace tandem::client::report
