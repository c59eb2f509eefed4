#include "client/report/experiment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "assets/generate/bench_shapes.h"
#include "assets/mesh_analysis.h"
#include "client/report/exact_answers.h"

namespace tandem::client::report {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDt = 1e-3;           // s
constexpr double kCrease = kPi / 6.0;  // rad, above which an edge of a gear counts as sharp
constexpr double kMillimetre = 1e-3;
constexpr double kGrooveHalfAngle = kPi / 6.0;
constexpr int kApproach = 40;  // ticks in which the tool comes down

/// Ways to write a number of triangles in an id.
struct Size {
  const char* name;
  std::size_t triangles;
};
constexpr std::array<Size, 4> kSizes{{{"1k", 1000}, {"10k", 10'000}, {"100k", 100'000}, {"1m", 1'000'000}}};

std::size_t trianglesOf(const std::string& id) {
  for (const Size& size : kSizes)
    if (id.ends_with(std::string("-") + size.name)) return size.triangles;
  return 0;
}

std::uint32_t addMesh(assets::Scene& scene, assets::TriangleSoup soup) {
  scene.meshes.push_back(assets::analyseMesh(std::move(soup), kCrease).mesh);
  return static_cast<std::uint32_t>(scene.meshes.size() - 1);
}

void addPart(assets::Scene& scene, std::uint32_t mesh, const glm::dvec3& position) {
  assets::Part part;
  part.name = "part" + std::to_string(scene.parts.size());
  part.mesh = mesh;
  part.worldFromPart.position = position;
  scene.parts.push_back(std::move(part));
}

Experiment onePart(assets::TriangleSoup soup, const glm::dvec3& position = glm::dvec3(0.0)) {
  Experiment e;
  e.scene.materials.emplace_back();
  addPart(e.scene, addMesh(e.scene, std::move(soup)), position);
  return e;
}

/// 0 to 1 over the first ticks, with no step of speed at either end.
double approach(int tick) {
  const double share = std::min(1.0, static_cast<double>(tick) / kApproach);
  return share * share * (3.0 - 2.0 * share);
}

/// A stroke over a sphere around `centre`: 2 mm deep at 0.2 m/s along a curve that meets facets at all
/// angles.
void strokeSphere(Experiment& e, double radius, double ball, const glm::dvec3& centre, int ticks) {
  const double reach = radius + ball, depth = 2.0 * kMillimetre, speed = 0.2;
  for (int i = 0; i < ticks; ++i) {
    const double way = speed * kDt * i / radius;
    const double polar = 0.5 * kPi + 0.6 * std::sin(0.37 * way + 0.3), azimuth = 0.9 * way + 0.1;
    const glm::dvec3 direction(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                               std::cos(polar));
    const double height = reach + kMillimetre - approach(i) * (kMillimetre + depth);
    const glm::dvec3 goal = direction * height;
    e.path.push_back({centre + goal, centre + outsideSphere(goal, reach), 0.0});
  }
}

Experiment sphere(const std::string& id, double radius, double ball, std::size_t triangles,
                  const glm::dvec3& centre, int ticks) {
  assets::TriangleSoup soup = generate::geodesicSphere(radius, triangles);
  const double deepest = generate::deepestFacet(soup, radius);
  Experiment e = onePart(std::move(soup), centre);
  e.info.id = id;
  e.facetDepth = deepest;
  e.facetTilt = std::acos(1.0 - deepest / radius);
  strokeSphere(e, radius, ball, centre, ticks);
  return e;
}

/// A closed curve beside the profile, 2 mm inside of it. Its normal is the mean over 2 mm either way, so that
/// the hand goes smoothly round corners which the surface has sharp.
class InsetCurve {
 public:
  explicit InsetCurve(const generate::Loop& profile) : profile_(profile) {
    for (std::size_t i = 0; i < profile.size(); ++i) {
      starts_.push_back(length_);
      length_ += glm::length(corner(i + 1) - corner(i));
    }
  }

  glm::dvec2 at(double way, double depth) const {
    const double span = 2.0 * kMillimetre;
    glm::dvec2 middle(0.0), normal(0.0);
    constexpr int kSamples = 33;
    for (int i = 0; i < kSamples; ++i) {
      const auto [point, outward] = sample(way + span * (2.0 * i / (kSamples - 1) - 1.0));
      middle += point / static_cast<double>(kSamples);
      normal += outward;
    }
    return middle - depth * glm::normalize(normal);
  }

 private:
  glm::dvec2 corner(std::size_t i) const { return profile_[i % profile_.size()]; }

  std::pair<glm::dvec2, glm::dvec2> sample(double way) const {
    way -= length_ * std::floor(way / length_);
    const auto after = std::upper_bound(starts_.begin(), starts_.end(), way);
    const auto edge = static_cast<std::size_t>(after - starts_.begin() - 1);
    const glm::dvec2 along = glm::normalize(corner(edge + 1) - corner(edge));
    return {corner(edge) + along * (way - starts_[edge]), {along.y, -along.x}};
  }

  const generate::Loop& profile_;
  std::vector<double> starts_;
  double length_ = 0.0;
};

Experiment gear(const std::string& id, int ticks) {
  const generate::Loop profile = generate::gearProfile();
  Experiment e = onePart(generate::extrudeStar(profile, 0.02, trianglesOf(id)));
  e.info.id = id;
  const InsetCurve curve(profile);
  ProfileGodObject exact(profile);
  for (int i = 0; i < ticks; ++i) {
    // 0.1 m/s along the outline, begun on a tooth's land; the mesh's layers meet the tool at no special
    // height.
    const double way = 1e-4 * i + 0.1155;
    const glm::dvec2 goal =
        curve.at(way, 2.0 * kMillimetre * approach(i) - kMillimetre * (1.0 - approach(i)));
    if (i == 0) exact.place(goal);
    const glm::dvec2 proxy = exact.follow(goal);
    const double z = 0.7123 * kMillimetre;
    e.path.push_back({{goal.x, goal.y, z}, {proxy.x, proxy.y, z}, 0.0});
  }
  return e;
}

/// Circles on the plane z = 0, 2 mm deep, from 0.02 to 0.5 m/s.
Experiment plane(const std::string& id, int ticks) {
  Experiment e = onePart(generate::flatSheet(0.2, 100));
  e.info.id = id;
  double way = 0.0;
  for (int i = 0; i < ticks; ++i) {
    way += kDt * (0.02 + 0.48 * i / ticks);
    const double angle = way / 0.04;
    const double height = kMillimetre - approach(i) * 3.0 * kMillimetre;
    const glm::dvec3 goal(0.04 * std::cos(angle) + 0.0013, 0.04 * std::sin(angle) + 0.0007, height);
    e.path.push_back({goal, abovePlane(goal, 0.0), 0.0});
  }
  return e;
}

/// From wall to wall of a groove of 60 degrees, 3 times a second, while it is followed at 20 mm/s.
Experiment groove(const std::string& id, int ticks) {
  Experiment e = onePart(generate::vGroove(0.05, kGrooveHalfAngle, 70));
  e.info.id = id;
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
Experiment tiles(const std::string& id, bool moving, int ticks) {
  Experiment e;
  e.info.id = id;
  e.partsMove = moving;
  e.scene.materials.emplace_back();
  const double side = 5.0 * kMillimetre;
  const std::uint32_t mesh = addMesh(e.scene, generate::plainBox(glm::dvec3(side)));
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) addPart(e.scene, mesh, {side * (x - 49.5), side * (y - 49.5), -0.5 * side});
  for (int i = 0; i < ticks; ++i) {
    const double angle = 0.2 * kDt * i / 0.1;
    const double lift = moving ? 0.5 * kMillimetre * std::sin(2.0 * kPi * kDt * i) : 0.0;
    const double height = 2.0 * kMillimetre - approach(i) * 3.0 * kMillimetre;
    const glm::dvec3 goal(0.1 * std::cos(angle) + 0.0011, 0.1 * std::sin(angle) + 0.0003, height);
    e.path.push_back({goal, abovePlane(goal, lift), lift});
  }
  return e;
}

}  // namespace

std::vector<ExperimentInfo> allExperiments() {
  std::vector<ExperimentInfo> all;
  for (const Size& size : kSizes)
    all.push_back(
        {std::string("sphere-") + size.name, "sphere", std::string("Sphere, ") + size.name + " triangles",
         "A point strokes a sphere of 50 mm radius, 2 mm deep at 0.2 m/s.", size.triangles <= 10'000});
  all.push_back({"sphere-far-100k", "sphere-far", "Sphere 10 m from the origin, 100k triangles",
                 "The same stroke on a part that stands at (10, 10, 10) m."});
  for (const Size& size : kSizes)
    all.push_back({std::string("gear-") + size.name, "gear", std::string("Gear, ") + size.name + " triangles",
                   "A point follows the outline of a gear of 12 teeth, 2 mm inside of it at 0.1 m/s.",
                   size.triangles <= 10'000});
  all.push_back({"plane", "plane", "Plane, 20k triangles",
                 "A point slides on a plane, 2 mm deep, at 0.02 to 0.5 m/s.", true});
  all.push_back({"groove", "groove", "V-groove, 20k triangles",
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
  return all;
}

Experiment buildExperiment(const std::string& id, int ticks) {
  const std::vector<ExperimentInfo> all = allExperiments();
  const auto info = std::find_if(all.begin(), all.end(), [&](const ExperimentInfo& i) { return i.id == id; });
  Experiment e;
  if (info == all.end()) return e;
  if (info->family == "sphere") e = sphere(id, 0.05, 0.0, trianglesOf(id), glm::dvec3(0.0), ticks);
  if (info->family == "sphere-far") e = sphere(id, 0.05, 0.0, trianglesOf(id), glm::dvec3(10.0), ticks);
  if (info->family == "gear") e = gear(id, ticks);
  if (info->family == "plane") e = plane(id, ticks);
  if (info->family == "groove") e = groove(id, ticks);
  if (info->family == "parts") e = tiles(id, id == "parts-moving", ticks);
  if (info->family == "fine") e = sphere(id, 0.01, info->toolRadius, trianglesOf(id), glm::dvec3(0.0), ticks);
  e.info = *info;
  return e;
}

}  // namespace tandem::client::report
