#include "client/levels/mesh_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>

#include "client/levels/decimation.h"
#include "client/levels/facing.h"
#include "client/levels/level_error.h"

namespace tandem::client {
namespace {

constexpr std::size_t kFinestShare = 6, kLeastTriangles = 500;
constexpr double kStep = 3.3;         // triangles of a level against those of the next
constexpr double kWorstError = 0.05;  // of the diagonal: what is further off stands for nothing
constexpr int kStandInCells = 32;     // along the diagonal

/// Gives the vertices the normals that the exact mesh has there: of several at a crease the one on that side.
void takeNormals(const RenderMesh& exact, const std::vector<std::uint32_t>& exactPoints,
                 const std::vector<std::uint32_t>& exactPoint, const std::vector<std::uint32_t>& points,
                 RenderMesh& level) {
  constexpr std::uint32_t kNoVertex = assets::kNone;
  std::vector<std::uint32_t> first, next(exactPoints.size(), kNoVertex);
  for (std::uint32_t v = 0; v < exactPoints.size(); ++v) {
    if (exactPoints[v] >= first.size()) first.resize(exactPoints[v] + 1, kNoVertex);
    next[v] = first[exactPoints[v]];
    first[exactPoints[v]] = v;
  }
  for (std::size_t v = 0; v < level.vertices.size(); ++v) {
    glm::vec3& normal = level.vertices[v].normal;
    const glm::vec3 own = normal;
    float best = 0.0f;  // what leans away belongs to another side
    for (std::uint32_t e = first[exactPoint[points[v]]]; e != kNoVertex; e = next[e]) {
      const float along = glm::dot(own, exact.vertices[e].normal);
      if (along <= best) continue;
      best = along;
      normal = exact.vertices[e].normal;
    }
  }
}

/// The cell of each vertex of a mesh, and the mean of the vertices of each cell.
struct Cells {
  std::vector<std::uint32_t> ofVertex;
  std::vector<glm::dvec3> middle;
  double mostMoved = 0.0;  // m, by a vertex that goes to the middle of its cell
};

Cells cellsOf(const assets::Mesh& mesh) {
  const glm::dvec3 extent = mesh.bounds.max - mesh.bounds.min;
  const double cell = std::max(glm::length(extent) / kStandInCells, 1e-300);
  const glm::uvec3 counts = glm::uvec3(extent / cell) + 1u;
  std::vector<std::uint32_t> named(std::size_t{counts.x} * counts.y * counts.z, assets::kNone), members;
  Cells cells;
  cells.ofVertex.reserve(mesh.positions.size());
  for (const glm::dvec3& p : mesh.positions) {
    const glm::uvec3 at = glm::min(glm::uvec3((p - mesh.bounds.min) / cell), counts - 1u);
    std::uint32_t& name = named[(std::size_t{at.z} * counts.y + at.y) * counts.x + at.x];
    if (name == assets::kNone) {
      name = static_cast<std::uint32_t>(cells.middle.size());
      cells.middle.emplace_back(0.0);
      members.push_back(0);
    }
    cells.middle[name] += p;
    ++members[name];
    cells.ofVertex.push_back(name);
  }
  for (std::size_t c = 0; c < members.size(); ++c) cells.middle[c] /= members[c];
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    cells.mostMoved =
        std::max(cells.mostMoved, glm::distance(mesh.positions[v], cells.middle[cells.ofVertex[v]]));
  return cells;
}

/// Which of the six axes a direction is nearest to.
std::uint32_t nearestAxis(const glm::dvec3& direction) {
  const glm::dvec3 size = glm::abs(direction);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return static_cast<std::uint32_t>(2 * axis + (direction[axis] < 0.0 ? 1 : 0));
}

}  // namespace

// A triangle goes where its corners go, and no point of it further than they: what is left of the triangles
// is the whole surface, moved by at most `error`, so that none is further from the exact one, nor that from
// it.
Level standInFor(const assets::Mesh& mesh) {
  const Cells cells = cellsOf(mesh);
  std::vector<std::uint32_t> vertexOf(6 * cells.middle.size(), assets::kNone);
  std::vector<std::vector<std::uint32_t>> indicesOf;  // of each material
  Level level;
  level.error = cells.mostMoved;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    const std::array<std::uint32_t, 3> in{cells.ofVertex[corners[0]], cells.ofVertex[corners[1]],
                                          cells.ofVertex[corners[2]]};
    const glm::dvec3 area = glm::cross(mesh.positions[corners[1]] - mesh.positions[corners[0]],
                                       mesh.positions[corners[2]] - mesh.positions[corners[0]]);
    // Faces that look elsewhere have vertices of their own, so that creases are seen.
    const std::uint32_t side = nearestAxis(area);
    const bool vanishes = in[0] == in[1] || in[1] == in[2] || in[2] == in[0];
    const std::size_t material = t < mesh.triangleMaterial.size() ? mesh.triangleMaterial[t] : 0;
    if (material >= indicesOf.size()) indicesOf.resize(material + 1);
    for (const std::uint32_t c : in) {
      std::uint32_t& vertex = vertexOf[6 * c + side];
      if (vertex == assets::kNone) {
        if (vanishes) continue;
        vertex = static_cast<std::uint32_t>(level.mesh.vertices.size());
        level.mesh.vertices.push_back({glm::vec3(cells.middle[c]), glm::vec3(0.0f)});
      }
      level.mesh.vertices[vertex].normal +=
          glm::vec3(area / std::max(cells.mostMoved * cells.mostMoved, 1e-300));
      if (!vanishes) indicesOf[material].push_back(vertex);
    }
  }
  for (RenderVertex& vertex : level.mesh.vertices) {
    const float length = glm::length(vertex.normal);
    vertex.normal = length > 0.0f ? vertex.normal / length : glm::vec3(0.0f, 1.0f, 0.0f);
  }
  for (std::size_t material = 0; material < indicesOf.size(); ++material) {
    const std::vector<std::uint32_t>& indices = indicesOf[material];
    if (indices.empty()) continue;
    level.mesh.ranges.push_back({static_cast<std::uint16_t>(material),
                                 static_cast<std::uint32_t>(level.mesh.indices.size()),
                                 static_cast<std::uint32_t>(indices.size())});
    level.mesh.indices.insert(level.mesh.indices.end(), indices.begin(), indices.end());
  }
  addClusters(level.mesh);
  return level;
}

std::vector<Level> makeLevels(const assets::Mesh& mesh, const std::function<bool()>& stopped) {
  std::vector<Level> levels;
  std::optional<Decimation> decimation = Decimation::of(mesh);
  if (!decimation) return levels;
  std::vector<std::uint32_t> exactPoints;
  const RenderMesh exact = makeRenderMesh(mesh, &exactPoints);
  const haptics::TriangleBvh exactTree(mesh, 1);
  const double size = glm::length(mesh.bounds.max - mesh.bounds.min), spacing = meanEdge(mesh);
  std::size_t left = mesh.triangles.size();
  double error = 0.0;
  for (std::size_t target = left / kFinestShare; target >= kLeastTriangles;
       target = static_cast<std::size_t>(static_cast<double>(target) / kStep)) {
    const std::size_t reached = decimation->reduceTo(target, stopped);
    if (stopped()) return {};
    if (static_cast<double>(reached) > 0.8 * static_cast<double>(left)) break;
    left = reached;
    const DecimatedMesh decimated = decimation->mesh(mesh);
    const haptics::TriangleBvh tree(decimated.mesh, 1);
    error = std::max(error, levelError(mesh, exactTree, spacing, decimated.mesh, tree));
    if (stopped()) return {};
    if (error > kWorstError * size) break;
    Level level;
    std::vector<std::uint32_t> points;
    level.mesh = makeRenderMesh(decimated.mesh, &points);
    takeNormals(exact, exactPoints, decimated.exactPoint, points, level.mesh);
    level.error = error;
    // A coarser level is inside out where the finest is, but for less than its error.
    level.facesOutward = levels.empty() ? facesOutward(mesh, level.mesh) : levels.front().facesOutward;
    levels.push_back(std::move(level));
  }
  return levels;
}

}  // namespace tandem::client
