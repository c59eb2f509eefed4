#include "assets/mesh/equal_fits.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/base/constants.h"
#include "assets/mesh/round_faces.h"

namespace tandem::assets {
namespace {

// The sag of facets that the corners of such a bore allow for, of the planned one; of it, the mean facet's.
constexpr double kLeastSag = 0.3, kMostSag = 1.2, kMeanSag = 0.5;
constexpr double kOutOfLine = 1e-3;  // rad between the axes
constexpr double kBeyondEnd = 1e-6;  // of the radius, by which a place may lie beyond an end

bool isNamedEqual(const Scene& scene, PartId part) {
  return std::any_of(scene.findings.begin(), scene.findings.end(), [&](const Finding& finding) {
    if (finding.code != "equal-fits") return false;
    // The finding names the first part that has the mesh.
    const PartId named = findPart(scene, finding.where);
    return named != kNoPart && scene.parts[named].mesh == scene.parts[part].mesh;
  });
}

std::vector<Cylinder> cylindersOf(const Scene& scene, PartId part, const Pose& worldFromPart) {
  std::vector<Cylinder> found = findCylinders(scene.meshes[scene.parts[part].mesh]);
  for (Cylinder& cylinder : found) {
    cylinder.middle = transformPoint(worldFromPart, cylinder.middle);
    cylinder.axis = transformVector(worldFromPart, cylinder.axis);
  }
  return found;
}

/// Whether the place is on the cylinder, to within the room of a fit.
bool isOnCylinder(const Cylinder& cylinder, const glm::dvec3& place, double room) {
  const glm::dvec3 from = place - cylinder.middle;
  const double height = glm::dot(from, cylinder.axis);
  return std::abs(height) < cylinder.halfLength + kBeyondEnd * cylinder.radius + room &&
         std::abs(glm::length(from - height * cylinder.axis) - cylinder.radius) < 2.0 * room;
}

/// Whether a bore is one to which loading has given room for a shaft.
bool hasRoomFor(const Cylinder& shaft, const Cylinder& bore) {
  if (shaft.hollow || !bore.hollow) return false;
  const EqualFitRoom room = equalFitRoom(shaft.radius);
  const double sag = bore.radius - shaft.radius - room.least;
  return sag > kLeastSag * room.sag && sag < kMostSag * room.sag && bore.sag() > kMeanSag * sag;
}

bool fitEqually(const Cylinder& shaft, const Cylinder& bore, const glm::dvec3& place) {
  const EqualFitRoom room = equalFitRoom(shaft.radius);
  const glm::dvec3 apart = bore.middle - shaft.middle;
  const double whole = room.most + room.sag;
  return hasRoomFor(shaft, bore) && glm::length(glm::cross(shaft.axis, bore.axis)) < kOutOfLine &&
         glm::length(glm::cross(shaft.axis, apart)) < whole + kOutOfLine * shaft.halfLength &&
         isOnCylinder(shaft, place, whole) && isOnCylinder(bore, place, whole);
}

}  // namespace

bool hasEqualFits(const Scene& scene) {
  return std::any_of(scene.findings.begin(), scene.findings.end(),
                     [](const Finding& finding) { return finding.code == "equal-fits"; });
}

double widestEqualFit(const Scene& scene, PartId a, PartId b) {
  double radius = 1e300;  // no shaft or bore is larger than its mesh
  for (const PartId part : {a, b}) {
    if (scene.parts[part].mesh == kNone) return 0.0;
    const Bounds& bounds = scene.meshes[scene.parts[part].mesh].bounds;
    radius = std::min(radius, 0.5 * glm::length(bounds.max - bounds.min));
  }
  const EqualFitRoom room = equalFitRoom(radius);
  return room.least + 1.2 * room.sag;
}

bool isInEqualFit(const Scene& scene, PartId a, const Pose& worldFromA, PartId b, const Pose& worldFromB,
                  const glm::dvec3& place) {
  if (scene.parts[a].mesh == kNone || scene.parts[b].mesh == kNone) return false;
  if (!isNamedEqual(scene, a) || !isNamedEqual(scene, b)) return false;
  const std::vector<Cylinder> ofA = cylindersOf(scene, a, worldFromA),
                              ofB = cylindersOf(scene, b, worldFromB);
  for (const Cylinder& one : ofA)
    for (const Cylinder& other : ofB)
      if (fitEqually(one, other, place) || fitEqually(other, one, place)) return true;
  return false;
}

double statedRadius(const Scene& scene, PartId part, const Cylinder& cylinder) {
  if (!cylinder.hollow || scene.parts[part].mesh == kNone || !isNamedEqual(scene, part))
    return cylinder.radius;
  for (const Finding& finding : scene.findings) {
    const PartId other = finding.code == "equal-fits" ? findPart(scene, finding.where) : kNoPart;
    if (other == kNoPart || scene.parts[other].mesh == kNone) continue;
    for (const Cylinder& shaft : findCylinders(scene.meshes[scene.parts[other].mesh]))
      if (hasRoomFor(shaft, cylinder)) return shaft.radius;
  }
  return cylinder.radius;
}

}  // namespace tandem::assets
