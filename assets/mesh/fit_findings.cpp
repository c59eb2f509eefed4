#include "assets/mesh/fit_findings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "assets/mesh/cylinders.h"

namespace tandem::assets {
namespace {

constexpr double kAskew = 0.1;        // rad between two axes that are in line
constexpr double kAside = 0.5;        // of the bore's radius, by which they may miss each other
constexpr double kWidest = 1.2;       // a bore's radius in a shaft's, above which facets of no kind matter
constexpr double kNoPlay = 2e-5;      // of the radius: less is rounding, and both have the same radius
constexpr double kShareOfPlay = 0.1;  // of the play, see clearanceOf()

struct Placed {
  PartId part = kNoPart;
  Cylinder cylinder;  // world frame
};

struct Fit {
  const Placed *shaft = nullptr, *bore = nullptr;
  double clearance = 0.0;  // m, radial
  double sag = 0.0;        // m, the larger of both
  std::uint64_t count = 0;
};

bool inLine(const Cylinder& shaft, const Cylinder& bore) {
  if (glm::length(glm::cross(shaft.axis, bore.axis)) > kAskew) return false;
  const glm::dvec3 between = shaft.middle - bore.middle;
  const double along = glm::dot(between, bore.axis);
  // The shaft is in the bore, or the gap between them is less than both lengths.
  return glm::length(between - bore.axis * along) < kAside * bore.radius &&
         std::abs(along) < 3.0 * (shaft.halfLength + bore.halfLength);
}

/// The corners of a shaft's facets lie on its circle. Those of a bore usually do too, as CAD programs write
/// it. The middles of a bore's facets may lie on the circle instead, which is likely where a shaft of any
/// angle still passes them.
double clearanceOf(const Cylinder& shaft, const Cylinder& bore) {
  const double corners = bore.radius - shaft.radius, middles = corners - bore.sag();
  return middles > kShareOfPlay * corners ? middles : corners;
}

std::string textOf(const Scene& scene, const Fit& fit) {
  const Cylinder &shaft = fit.shaft->cylinder, &bore = fit.bore->cylinder;
  const double needed = std::ceil(kPi / std::sqrt(fit.clearance / shaft.radius));
  char text[320], last[64];
  std::snprintf(
      text, sizeof text,
      "facets lie up to %.3g mm off the round, too much for a clearance of %.3g mm of diameter: shaft of "
      "%.5g mm with %d segments, bore of %.5g mm with %d in ",
      fit.sag * 1e3, 2e3 * fit.clearance, 2e3 * shaft.radius, shaft.segments, 2e3 * bore.radius,
      bore.segments);
  std::snprintf(last, sizeof last, "; at least %.0f segments are needed", needed);
  return text + scene.parts[fit.bore->part].name + last;
}

std::vector<Placed> placeCylinders(const Scene& scene) {
  std::map<std::uint32_t, std::vector<Cylinder>> ofMesh;
  std::vector<Placed> placed;
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    const Part& part = scene.parts[i];
    if (part.mesh == kNone || !part.shapes.empty()) continue;
    auto found = ofMesh.find(part.mesh);
    if (found == ofMesh.end())
      found = ofMesh.emplace(part.mesh, findCylinders(scene.meshes[part.mesh])).first;
    for (Cylinder cylinder : found->second) {
      cylinder.middle = transformPoint(part.worldFromPart, cylinder.middle);
      cylinder.axis = transformVector(part.worldFromPart, cylinder.axis);
      placed.push_back({static_cast<PartId>(i), cylinder});
    }
  }
  return placed;
}

}  // namespace

std::vector<Finding> fitFindings(const Scene& scene) {
  if (std::none_of(scene.parts.begin(), scene.parts.end(), [](const Part& part) { return part.movable; }))
    return {};
  const std::vector<Placed> placed = placeCylinders(scene);
  std::vector<const Placed*> bores;
  for (const Placed& one : placed)
    if (one.cylinder.hollow) bores.push_back(&one);
  std::stable_sort(bores.begin(), bores.end(),
                   [](const Placed* l, const Placed* r) { return l->cylinder.radius < r->cylinder.radius; });
  std::map<std::pair<std::uint32_t, std::uint32_t>, Fit> worst;  // by the meshes of shaft and bore
  for (const Placed& shaft : placed) {
    if (shaft.cylinder.hollow) continue;
    const double radius = shaft.cylinder.radius;
    auto at = std::upper_bound(bores.begin(), bores.end(), radius,
                               [](double r, const Placed* bore) { return r < bore->cylinder.radius; });
    for (; at != bores.end() && (*at)->cylinder.radius < kWidest * radius; ++at) {
      const Placed& bore = **at;
      const Part &a = scene.parts[shaft.part], &b = scene.parts[bore.part];
      const double sag = std::max(shaft.cylinder.sag(), bore.cylinder.sag());
      // Uses the circles through the corners: with enough segments the two readings agree.
      if (shaft.part == bore.part || !(a.movable || b.movable) ||
          sag <= 0.5 * (bore.cylinder.radius - radius) || bore.cylinder.radius - radius < kNoPlay * radius ||
          !inLine(shaft.cylinder, bore.cylinder))
        continue;
      Fit& fit = worst[{a.mesh, b.mesh}];
      const double clearance = clearanceOf(shaft.cylinder, bore.cylinder);
      ++fit.count;
      if (fit.shaft == nullptr || sag / clearance > fit.sag / fit.clearance)
        fit = {&shaft, &bore, clearance, sag, fit.count};
    }
  }
  std::vector<Finding> findings;
  for (const auto& [meshes, fit] : worst)
    findings.push_back({Finding::Severity::warning, "coarse-fit", scene.parts[fit.shaft->part].name,
                        fit.count, textOf(scene, fit)});
  return findings;
}

}  // namespace tandem::assets
