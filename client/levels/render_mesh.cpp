#include "client/levels/render_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include "assets/base/assert.h"
#include "assets/base/disjoint_sets.h"

namespace tandem::client {
namespace {

using assets::kNone;

bool hasTopology(const assets::Mesh& mesh) {
  return mesh.neighbours.size() == mesh.triangles.size() && mesh.edgeFlags.size() == mesh.triangles.size();
}

std::uint32_t cornerOf(const assets::Mesh& mesh, std::uint32_t triangle, std::uint32_t vertex) {
  for (std::uint32_t k = 0; k < 3; ++k)
    if (mesh.triangles[triangle][k] == vertex) return k;
  return kNone;
}

void joinOverEdge(const assets::Mesh& mesh, std::uint32_t triangle, std::uint32_t edge,
                  DisjointSets& groups) {
  const std::uint32_t other = mesh.neighbours[triangle][edge];
  if (other == kNone || other >= mesh.triangles.size() || mesh.edgeFlags[triangle][edge] != 0) return;
  const std::uint32_t next = (edge + 1) % 3;
  const std::uint32_t start = cornerOf(mesh, other, mesh.triangles[triangle][edge]);
  const std::uint32_t end = cornerOf(mesh, other, mesh.triangles[triangle][next]);
  // A neighbour that runs along the edge in the same direction has the opposite orientation, and its normal
  // must not be mixed in.
  if (start == kNone || end == kNone || (end + 1) % 3 != start) return;
  groups.join(3 * triangle + edge, 3 * other + start);
  groups.join(3 * triangle + next, 3 * other + end);
}

DisjointSets smoothGroups(const assets::Mesh& mesh) {
  DisjointSets groups(3 * mesh.triangles.size());
  if (!hasTopology(mesh)) return groups;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t e = 0; e < 3; ++e)
      if (mesh.neighbours[t][e] > t) joinOverEdge(mesh, t, e, groups);
  return groups;
}

double cornerAngle(const glm::dvec3& at, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 u = b - at, v = c - at;
  return std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v));
}

glm::dvec3 safeNormalize(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0.0 ? v / length : glm::dvec3(0.0, 1.0, 0.0);
}

/// Fills `vertices`; returns the vertex of each corner (3 T).
std::vector<std::uint32_t> makeVertices(const assets::Mesh& mesh, std::vector<RenderVertex>& vertices,
                                        std::vector<std::uint32_t>* points) {
  DisjointSets groups = smoothGroups(mesh);
  const std::size_t cornerCount = 3 * mesh.triangles.size();
  std::vector<std::uint32_t> vertexOfRoot(cornerCount, kNone), vertexOfCorner(cornerCount);
  std::vector<glm::dvec3> normals;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& tri = mesh.triangles[t];
    const glm::dvec3 p[3] = {mesh.positions[tri[0]], mesh.positions[tri[1]], mesh.positions[tri[2]]};
    const glm::dvec3 faceNormal = safeNormalize(glm::cross(p[1] - p[0], p[2] - p[0]));
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t root = groups.find(3 * t + k);
      if (vertexOfRoot[root] == kNone) {
        vertexOfRoot[root] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back({glm::vec3(p[k]), glm::vec3(0.0f)});
        if (points != nullptr) points->push_back(tri[k]);
        normals.emplace_back(0.0);
      }
      vertexOfCorner[3 * t + k] = vertexOfRoot[root];
      normals[vertexOfRoot[root]] += faceNormal * cornerAngle(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
    }
  }
  for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v].normal = glm::vec3(safeNormalize(normals[v]));
  return vertexOfCorner;
}

/// Spreads the lower ten bits so that two zero bits follow each.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | (bits << 16)) & 0x030000FFu;
  bits = (bits | (bits << 8)) & 0x0300F00Fu;
  bits = (bits | (bits << 4)) & 0x030C30C3u;
  return (bits | (bits << 2)) & 0x09249249u;
}

/// Place of a point in a box along a Morton curve of 1024 steps an axis.
std::uint32_t mortonCode(const glm::dvec3& point, const assets::Bounds& bounds) {
  std::uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = bounds.max[axis] - bounds.min[axis];
    const double share = extent > 0.0 ? (point[axis] - bounds.min[axis]) / extent : 0.0;
    code |= spread(static_cast<std::uint32_t>(std::clamp(share, 0.0, 1.0) * 1023.0)) << axis;
  }
  return code;
}

void addIndices(const assets::Mesh& mesh, const std::vector<std::uint32_t>& vertexOfCorner, RenderMesh& out) {
  const bool known = mesh.triangleMaterial.size() == mesh.triangles.size();
  out.indices.reserve(vertexOfCorner.size());
  for (const std::uint32_t t : drawingOrder(mesh)) {
    const std::uint16_t material = known ? mesh.triangleMaterial[t] : std::uint16_t{0};
    if (out.ranges.empty() || out.ranges.back().material != material)
      out.ranges.push_back({material, static_cast<std::uint32_t>(out.indices.size()), 0});
    for (std::uint32_t k = 0; k < 3; ++k) out.indices.push_back(vertexOfCorner[3 * t + k]);
    out.ranges.back().indexCount += 3;
  }
}

RenderCluster makeCluster(const RenderMesh& mesh, std::uint32_t first, std::uint32_t count) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (std::uint32_t i = first; i < first + count; ++i) {
    low = glm::min(low, mesh.vertices[mesh.indices[i]].position);
    high = glm::max(high, mesh.vertices[mesh.indices[i]].position);
  }
  ASSERT(count > 0 && count % 3 == 0);
  return {first, count, 0.5f * (low + high), 0.5f * glm::length(high - low)};
}

void addFeatureEdges(const assets::Mesh& mesh, std::vector<glm::vec3>& edges) {
  if (!hasTopology(mesh)) return;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t other = mesh.neighbours[t][e];
      if (mesh.edgeFlags[t][e] == 0 || (other != kNone && other < t)) continue;
      edges.emplace_back(mesh.positions[mesh.triangles[t][e]]);
      edges.emplace_back(mesh.positions[mesh.triangles[t][(e + 1) % 3]]);
    }
}

/// Builds shapes of revolution about +y, and boxes, in the shape's frame.
class ShapeBuilder {
 public:
  ShapeBuilder(RenderMesh& out, const Pose& partFromShape) : out_(out), partFromShape_(partFromShape) {}

  void quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
    const glm::dvec3 normal = safeNormalize(glm::cross(b - a, d - a));
    const std::uint32_t first = vertex(a, normal);
    vertex(b, normal);
    vertex(c, normal);
    vertex(d, normal);
    for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) out_.indices.push_back(first + k);
    edge(a, b);
    edge(b, c);
    edge(c, d);
    edge(d, a);
  }

  /// A profile of (radius, y) points with normals (radial, y), turned about +y.
  void revolve(const std::vector<glm::dvec2>& profile, const std::vector<glm::dvec2>& normals) {
    const std::uint32_t first = static_cast<std::uint32_t>(out_.vertices.size());
    for (std::size_t i = 0; i < profile.size(); ++i)
      for (int s = 0; s <= kSegments; ++s)
        vertex(around(profile[i], s), safeNormalize(around(normals[i], s)));
    for (std::uint32_t i = 0; i + 1 < profile.size(); ++i)
      for (std::uint32_t s = 0; s < static_cast<std::uint32_t>(kSegments); ++s) {
        const std::uint32_t a = first + i * (kSegments + 1) + s, b = a + kSegments + 1;
        for (const std::uint32_t k : {a, b, a + 1, a + 1, b, b + 1}) out_.indices.push_back(k);
      }
  }

  void circle(double radius, double y) {
    for (int s = 0; s < kSegments; ++s) edge(around({radius, y}, s), around({radius, y}, s + 1));
  }

 private:
  static constexpr int kSegments = 48;

  static glm::dvec3 around(const glm::dvec2& p, int segment) {
    const double angle = glm::two_pi<double>() * segment / kSegments;
    return {p.x * std::sin(angle), p.y, p.x * std::cos(angle)};
  }
  std::uint32_t vertex(const glm::dvec3& p, const glm::dvec3& n) {
    out_.vertices.push_back(
        {glm::vec3(transformPoint(partFromShape_, p)), glm::vec3(transformVector(partFromShape_, n))});
    return static_cast<std::uint32_t>(out_.vertices.size() - 1);
  }
  void edge(const glm::dvec3& a, const glm::dvec3& b) {
    out_.featureEdges.emplace_back(transformPoint(partFromShape_, a));
    out_.featureEdges.emplace_back(transformPoint(partFromShape_, b));
  }

  RenderMesh& out_;
  const Pose& partFromShape_;
};

void buildBox(ShapeBuilder& builder, const glm::dvec3& size) {
  const glm::dvec3 h = 0.5 * size;
  const auto at = [&](int x, int y, int z) { return glm::dvec3(x * h.x, y * h.y, z * h.z); };
  builder.quad(at(-1, -1, 1), at(1, -1, 1), at(1, 1, 1), at(-1, 1, 1));
  builder.quad(at(1, -1, -1), at(-1, -1, -1), at(-1, 1, -1), at(1, 1, -1));
  builder.quad(at(1, -1, 1), at(1, -1, -1), at(1, 1, -1), at(1, 1, 1));
  builder.quad(at(-1, -1, -1), at(-1, -1, 1), at(-1, 1, 1), at(-1, 1, -1));
  builder.quad(at(-1, 1, 1), at(1, 1, 1), at(1, 1, -1), at(-1, 1, -1));
  builder.quad(at(-1, -1, -1), at(1, -1, -1), at(1, -1, 1), at(-1, -1, 1));
}

void buildCylinder(ShapeBuilder& builder, double height, double top, double bottom) {
  const double h = 0.5 * height;
  const glm::dvec2 side(height, bottom - top);
  builder.revolve({{top, h}, {bottom, -h}}, {side, side});
  builder.revolve({{0.0, h}, {top, h}}, {{0.0, 1.0}, {0.0, 1.0}});
  builder.revolve({{bottom, -h}, {0.0, -h}}, {{0.0, -1.0}, {0.0, -1.0}});
  builder.circle(top, h);
  builder.circle(bottom, -h);
}

/// Two spherical caps joined by a cone; height 0 and equal radii give a sphere.
void buildCapsule(ShapeBuilder& builder, double height, double top, double bottom) {
  constexpr int kRings = 12;
  std::vector<glm::dvec2> profile, normals;
  for (int i = 0; i <= 2 * kRings + 1; ++i) {
    const bool upper = i <= kRings;  // the equator comes twice: once with each radius
    const double angle = glm::half_pi<double>() * (upper ? i : i - 1) / kRings;
    const glm::dvec2 normal(std::sin(angle), std::cos(angle));
    profile.push_back(normal * (upper ? top : bottom) + glm::dvec2(0.0, (upper ? 0.5 : -0.5) * height));
    normals.push_back(normal);
  }
  builder.revolve(profile, normals);
}

}  // namespace

std::vector<std::uint32_t> drawingOrder(const assets::Mesh& mesh) {
  const bool known = mesh.triangleMaterial.size() == mesh.triangles.size();
  assets::Bounds bounds;
  for (const glm::dvec3& p : mesh.positions) {
    bounds.include(p);
  }
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& tri = mesh.triangles[t];
    const glm::dvec3 centre =
        (mesh.positions[tri[0]] + mesh.positions[tri[1]] + mesh.positions[tri[2]]) / 3.0;
    const std::uint64_t material = known ? mesh.triangleMaterial[t] : 0;
    keyed[t] = {(material << 32) | mortonCode(centre, bounds), t};
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> order(keyed.size());
  std::transform(keyed.begin(), keyed.end(), order.begin(), [](const auto& entry) { return entry.second; });
  return order;
}

void addClusters(RenderMesh& mesh) {
  constexpr std::uint32_t kClusterIndices = 3 * 1024;
  for (const RenderRange& range : mesh.ranges)
    for (std::uint32_t done = 0; done < range.indexCount; done += kClusterIndices)
      mesh.clusters.push_back(
          makeCluster(mesh, range.firstIndex + done, std::min(kClusterIndices, range.indexCount - done)));
}

RenderMesh makeRenderMesh(const assets::Mesh& mesh, std::vector<std::uint32_t>* points) {
  RenderMesh out;
  const std::vector<std::uint32_t> vertexOfCorner = makeVertices(mesh, out.vertices, points);
  addIndices(mesh, vertexOfCorner, out);
  addClusters(out);
  addFeatureEdges(mesh, out.featureEdges);
  ASSERT(out.indices.size() == 3 * mesh.triangles.size());
  return out;
}

RenderMesh makeRenderMesh(const assets::ImplicitShape& shape, double planeExtent) {
  using Kind = assets::ImplicitShape::Kind;
  RenderMesh out;
  ShapeBuilder builder(out, shape.partFromShape);
  switch (shape.kind) {
    case Kind::box:
      buildBox(builder, shape.size);
      break;
    case Kind::sphere:
      buildCapsule(builder, 0.0, shape.radiusBottom, shape.radiusBottom);
      break;
    case Kind::capsule:
      buildCapsule(builder, shape.height, shape.radiusTop, shape.radiusBottom);
      break;
    case Kind::cylinder:
      buildCylinder(builder, shape.height, shape.radiusTop, shape.radiusBottom);
      break;
    case Kind::plane: {
      const double x = 0.5 * (shape.size.x > 0.0 ? shape.size.x : planeExtent);
      const double z = 0.5 * (shape.size.z > 0.0 ? shape.size.z : planeExtent);
      builder.quad({-x, 0.0, z}, {x, 0.0, z}, {x, 0.0, -z}, {-x, 0.0, -z});
      break;
    }
  }
  out.ranges.push_back({shape.material, 0, static_cast<std::uint32_t>(out.indices.size())});
  addClusters(out);
  return out;
}

}  // namespace tandem::client
