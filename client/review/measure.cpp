#include "client/review/measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/mesh/equal_fits.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/contact_scene_data.h"

namespace tandem::client {

namespace {

using assets::Cylinder;
using assets::Mesh;

constexpr double kSmoothTurn = 0.70;  // least cosine at which an edge goes on: just above 45 degrees
constexpr double kParallel = 1e-5;    // rad, below which faces and axes count as parallel
constexpr double kOnCylinder = 1e-5;  // share of the radius by which a facet's corners may be off it
constexpr double kAlongAxis = 1e-3;   // most cosine of a facet's normal with the axis of its cylinder
// Two chamfers of 45 degrees and the band between them turn as a cylinder of eight segments would.
constexpr int kLeastSegments = 10;

/// The edges of a mesh at which a face ends.
class Edges {
 public:
  explicit Edges(const Mesh& mesh) : mesh_(mesh) {
    for (std::size_t t = 0; t < mesh.edgeFlags.size(); ++t)
      for (std::size_t e = 0; e < 3; ++e)
        if (mesh.edgeFlags[t][e] != 0) add(mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3]);
  }

  /// The run that passes nearest to a point, in the mesh's frame.
  std::optional<MeasuredEdge> nearest(const glm::dvec3& point) const {
    double least = std::numeric_limits<double>::infinity();
    std::array<std::uint32_t, 2> found{};
    for (const auto& [from, others] : at_)
      for (const std::uint32_t to : others) {
        const double distance = from < to ? distanceTo(point, from, to) : least;
        if (distance >= least) continue;
        least = distance;
        found = {from, to};
      }
    if (found[0] == found[1]) return std::nullopt;
    return run(found[0], found[1]);
  }

 private:
  void add(std::uint32_t a, std::uint32_t b) {
    std::vector<std::uint32_t>& ofA = at_[a];
    if (std::find(ofA.begin(), ofA.end(), b) != ofA.end()) return;
    ofA.push_back(b);
    at_[b].push_back(a);
  }

  double distanceTo(const glm::dvec3& point, std::uint32_t a, std::uint32_t b) const {
    const glm::dvec3 from = mesh_.positions[a], along = mesh_.positions[b] - from;
    const double square = glm::dot(along, along);
    const double t = square > 0.0 ? std::clamp(glm::dot(point - from, along) / square, 0.0, 1.0) : 0.0;
    return glm::length(from + t * along - point);
  }

  /// The vertex at which a run goes on after `at`, or `at` itself if it ends there.
  std::uint32_t next(std::uint32_t before, std::uint32_t at) const {
    const std::vector<std::uint32_t>& others = at_.at(at);
    if (others.size() != 2) return at;
    const std::uint32_t other = others[0] == before ? others[1] : others[0];
    const glm::dvec3 in = mesh_.positions[at] - mesh_.positions[before];
    const glm::dvec3 out = mesh_.positions[other] - mesh_.positions[at];
    return glm::dot(in, out) >= kSmoothTurn * glm::length(in) * glm::length(out) ? other : at;
  }

  MeasuredEdge run(std::uint32_t a, std::uint32_t b) const {
    MeasuredEdge edge;
    edge.length = glm::length(mesh_.positions[b] - mesh_.positions[a]);
    edge.segments = 1;
    const std::uint32_t end = follow(a, b, a, edge);
    const std::uint32_t start = end == a ? a : follow(b, a, b, edge);
    edge.start = mesh_.positions[start];
    edge.end = mesh_.positions[end];
    return edge;
  }

  /// Adds what follows the segment from `before` to `at`, up to `stop`; returns the last vertex.
  std::uint32_t follow(std::uint32_t before, std::uint32_t at, std::uint32_t stop, MeasuredEdge& edge) const {
    for (std::size_t steps = 0; at != stop && steps < at_.size(); ++steps) {
      const std::uint32_t on = next(before, at);
      if (on == at) break;
      edge.length += glm::length(mesh_.positions[on] - mesh_.positions[at]);
      ++edge.segments;
      before = at;
      at = on;
    }
    return at;
  }

  const Mesh& mesh_;
  std::map<std::uint32_t, std::vector<std::uint32_t>> at_;  // vertices at the other ends
};

glm::dvec3 normalOf(const Mesh& mesh, std::uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const glm::dvec3 normal =
      glm::cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
  const double length = glm::length(normal);
  return length > 0.0 ? normal / length : glm::dvec3(0.0);
}

/// Whether a triangle is a part of a cylinder's side.
bool isOn(const Cylinder& cylinder, const Mesh& mesh, std::uint32_t triangle) {
  if (std::abs(glm::dot(normalOf(mesh, triangle), cylinder.axis)) > kAlongAxis) return false;
  const double tolerance = kOnCylinder * cylinder.radius;
  for (const std::uint32_t corner : mesh.triangles[triangle]) {
    const glm::dvec3 from = mesh.positions[corner] - cylinder.middle;
    const double along = glm::dot(from, cylinder.axis);
    const double off = glm::length(from - along * cylinder.axis) - cylinder.radius;
    if (std::abs(off) > tolerance || std::abs(along) > cylinder.halfLength + tolerance) return false;
  }
  return true;
}

/// The implicit cylinder whose side a point of a part is on. Its facets are up to 1e-4 of the radius inside.
std::optional<Cylinder> implicitCylinder(const assets::Part& part, const glm::dvec3& point) {
  for (const assets::ImplicitShape& shape : part.shapes) {
    if (shape.kind != assets::ImplicitShape::Kind::cylinder || shape.radiusTop != shape.radiusBottom)
      continue;
    const glm::dvec3 in = transformPoint(inverse(shape.partFromShape), point);
    const double off = shape.radiusBottom - std::hypot(in.x, in.z);
    if (std::abs(off) > 1.1e-4 * shape.radiusBottom || std::abs(in.y) > 0.5 * shape.height) continue;
    Cylinder cylinder;
    cylinder.middle = shape.partFromShape.position;
    cylinder.axis = shape.partFromShape.orientation * glm::dvec3(0.0, 1.0, 0.0);
    cylinder.radius = shape.radiusBottom;
    cylinder.halfLength = 0.5 * shape.height;
    return cylinder;
  }
  return std::nullopt;
}

std::optional<Cylinder> cylinderAt(const assets::Part& part, const Mesh& mesh, const haptics::MeshPoint& at) {
  if (!part.shapes.empty()) return implicitCylinder(part, at.point);
  std::optional<Cylinder> best;
  for (const Cylinder& cylinder : assets::findCylinders(mesh)) {
    if (cylinder.segments < (best ? best->segments + 1 : kLeastSegments)) continue;
    if (isOn(cylinder, mesh, at.triangle)) best = cylinder;
  }
  return best;
}

/// The angle between two lines, rad, 0 to pi/2; exact for small ones too.
double angleBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), std::abs(glm::dot(a, b)));
}

}  // namespace

namespace {

/// The place where a mesh of a part was found, in the part's frame.
MeasuredPlace placeOf(const haptics::ContactScene& contact, PartId part, const haptics::MeshPoint& found) {
  const Mesh& mesh = contact.data().colliders[part].tree->mesh();
  MeasuredPlace place;
  place.part = part;
  place.point = found.point;
  place.normal = normalOf(mesh, found.triangle);
  place.edge = Edges(mesh).nearest(found.point);
  place.cylinder = cylinderAt(contact.scene().parts[part], mesh, found);
  if (place.cylinder) place.cylinder->radius = assets::statedRadius(contact.scene(), part, *place.cylinder);
  return place;
}

}  // namespace

std::optional<MeasuredPlace> measurePlace(const haptics::ContactScene& contact, const glm::dvec3& point,
                                          std::span<const Pose> worldFromPart) {
  const assets::Scene& scene = contact.scene();
  ASSERT(worldFromPart.empty() || worldFromPart.size() == scene.parts.size());
  const auto poseOf = [&](PartId part) {
    return worldFromPart.empty() ? scene.parts[part].worldFromPart : worldFromPart[part];
  };
  haptics::MeshPoint nearest;
  nearest.distance = std::numeric_limits<double>::max();
  PartId at = kNoPart;
  for (PartId part = 0; part < scene.parts.size(); ++part) {
    const haptics::TriangleBvh* tree = contact.data().colliders[part].tree;
    if (tree == nullptr || tree->empty()) continue;
    haptics::MeshPoint found;
    const glm::dvec3 inPart = transformPoint(inverse(poseOf(part)), point);
    if (!tree->closestPoint(inPart, nearest.distance, found) || found.distance >= nearest.distance) continue;
    nearest = found;
    at = part;
  }
  if (at == kNoPart) return std::nullopt;
  return moved(placeOf(contact, at, nearest), poseOf(at));
}

std::optional<MeasuredPlace> measurePlaceOn(const haptics::ContactScene& contact, PartId part,
                                            const glm::dvec3& point) {
  ASSERT(part < contact.scene().parts.size());
  const haptics::TriangleBvh* tree = contact.data().colliders[part].tree;
  haptics::MeshPoint found;
  if (tree == nullptr || tree->empty() ||
      !tree->closestPoint(point, std::numeric_limits<double>::max(), found))
    return std::nullopt;
  return placeOf(contact, part, found);
}

MeasuredPlace moved(MeasuredPlace place, const Pose& pose) {
  place.point = transformPoint(pose, place.point);
  place.normal = pose.orientation * place.normal;
  if (place.edge) {
    place.edge->start = transformPoint(pose, place.edge->start);
    place.edge->end = transformPoint(pose, place.edge->end);
  }
  if (place.cylinder) {
    place.cylinder->middle = transformPoint(pose, place.cylinder->middle);
    place.cylinder->axis = pose.orientation * place.cylinder->axis;
  }
  return place;
}

MeasuredPair measurePair(const MeasuredPlace& a, const MeasuredPlace& b) {
  const glm::dvec3 directionA = a.cylinder ? a.cylinder->axis : a.normal;
  const glm::dvec3 directionB = b.cylinder ? b.cylinder->axis : b.normal;
  const double between = angleBetween(directionA, directionB);
  MeasuredPair pair;
  pair.distance = glm::length(b.point - a.point);
  pair.angle = a.cylinder.has_value() == b.cylinder.has_value() ? between : 0.5 * std::numbers::pi - between;
  if (std::abs(pair.angle) > kParallel) return pair;
  const glm::dvec3 fromA = a.cylinder ? a.cylinder->middle : a.point;
  const glm::dvec3 apart = (b.cylinder ? b.cylinder->middle : b.point) - fromA;
  if (a.cylinder && b.cylinder)
    pair.across = glm::length(apart - glm::dot(apart, directionA) * directionA);
  else
    pair.across = std::abs(glm::dot(apart, a.cylinder ? b.normal : a.normal));
  return pair;
}

}  // namespace tandem::client
