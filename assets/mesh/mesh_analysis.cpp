#include "assets/mesh/mesh_analysis.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/mesh/edge_pairs.h"
#include "assets/mesh/halfedge_topology.h"
#include "assets/mesh/shell_nesting.h"
#include "assets/mesh/vertex_weld.h"

namespace tandem::assets {
namespace {

/// Whether three points lie on a line, up to the rounding of double coordinates (of which the welding
/// tolerance is 2^30 units). Slivers remain faces, because the file distinguishes their corners.
bool isDegenerate(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double weldTolerance) {
  const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  return glm::length(glm::cross(b - a, c - a)) <= std::ldexp(weldTolerance, -24) * longest;
}

/// Replaces vertices by points and drops the faces that have no area.
void weld(TriangleSoup& soup, MeshDefects& defects) {
  WeldedVertices welded = weldVertices(soup.positions, soup.triangles);
  const auto unused = std::count(welded.pointOf.begin(), welded.pointOf.end(), kNone);
  defects.unusedVertices += static_cast<std::uint64_t>(unused);
  defects.duplicateVertices = soup.positions.size() - static_cast<std::size_t>(unused) - welded.points.size();
  soup.positions = std::move(welded.points);
  std::size_t count = 0;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    TriangleIndices t = soup.triangles[i];
    for (std::uint32_t& vertex : t) vertex = welded.pointOf[vertex];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] ||
        isDegenerate(soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]], welded.tolerance))
      continue;
    soup.triangles[count] = t;
    if (!soup.triangleUv.empty()) soup.triangleUv[count] = soup.triangleUv[i];
    soup.triangleMaterial[count++] = soup.triangleMaterial[i];
  }
  defects.degenerateFaces = soup.triangles.size() - count;
  soup.triangles.resize(count);
  soup.triangleMaterial.resize(count);
  if (!soup.triangleUv.empty()) soup.triangleUv.resize(count);
}

/// dropDuplicates() for the whole soup. Texture coordinates follow by the order of what stays.
std::uint64_t dropDuplicateFaces(TriangleSoup& soup) {
  if (soup.triangleUv.empty())
    return dropDuplicates(soup.triangles, soup.triangleMaterial, soup.positions.size());
  const std::vector<TriangleIndices> before = soup.triangles;
  const std::uint64_t dropped = dropDuplicates(soup.triangles, soup.triangleMaterial, soup.positions.size());
  std::size_t count = 0;
  // The first of several equal faces stays, so the first match is the right one.
  for (std::size_t t = 0; t < before.size() && count < soup.triangles.size(); ++t)
    if (before[t] == soup.triangles[count]) soup.triangleUv[count++] = soup.triangleUv[t];
  soup.triangleUv.resize(soup.triangles.size());
  return dropped;
}

/// Texture coordinates in the order of the corners `after`, where the triangles may have been turned.
void turnUv(const std::vector<TriangleIndices>& before, const std::vector<TriangleIndices>& after,
            std::vector<std::array<glm::vec2, 3>>& uv) {
  for (std::size_t t = 0; t < uv.size(); ++t) {
    const std::array<glm::vec2, 3> old = uv[t];
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t o = 0; o < 3; ++o)
        if (after[t][c] == before[t][o]) uv[t][c] = old[o];
  }
}

/// Drops the points without faces; the others keep their order.
void dropUnused(TriangleSoup& soup, MeshDefects& defects) {
  std::vector<std::uint32_t> renamed(soup.positions.size(), kNone);
  for (const TriangleIndices& t : soup.triangles)
    for (const std::uint32_t v : t) renamed[v] = 0;
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < renamed.size(); ++v) {
    if (renamed[v] == kNone) continue;
    soup.positions[count] = soup.positions[v];
    renamed[v] = count++;
  }
  if (count == soup.positions.size()) return;
  defects.unusedVertices += soup.positions.size() - count;
  soup.positions.resize(count);
  for (TriangleIndices& t : soup.triangles)
    for (std::uint32_t& v : t) v = renamed[v];
}

Bounds boundsOf(const std::vector<glm::dvec3>& positions) {
  Bounds bounds;
  for (const glm::dvec3& p : positions) {
    bounds.min = glm::min(bounds.min, p);
    bounds.max = glm::max(bounds.max, p);
  }
  return bounds;
}

/// Turns the shells of `invert` inside out.
void invertShells(Mesh& mesh, const std::vector<bool>& invert) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!invert[mesh.triangleShell[t]]) continue;
    mesh.triangles[t] = reversed(mesh.triangles[t]);
    std::swap(mesh.neighbours[t][0], mesh.neighbours[t][reversedEdge(0)]);
    std::swap(mesh.edgeFlags[t][0], mesh.edgeFlags[t][reversedEdge(0)]);
  }
}

}  // namespace

MeshAnalysis analyseMesh(TriangleSoup soup, double creaseAngle) {
  MeshAnalysis result;
  MeshDefects& defects = result.defects;
  weld(soup, defects);
  defects.duplicateFaces = dropDuplicateFaces(soup);
  dropUnused(soup, defects);

  const std::vector<TriangleIndices> asRead =
      soup.triangleUv.empty() ? std::vector<TriangleIndices>() : soup.triangles;
  EdgePairs pairs = pairEdges(soup.triangles, soup.positions.size());
  defects.boundaryEdges = pairs.openEdges;
  defects.nonManifoldEdges = pairs.manyFaced.size();
  const Orientation orientation = orientAlike(soup.triangles, pairs);
  defects.flippedFaces = orientation.flippedFaces;
  defects.nonOrientableShells = orientation.nonOrientableShells;

  const Bounds bounds = boundsOf(soup.positions);
  const glm::dvec3 centre = soup.positions.empty() ? glm::dvec3(0.0) : 0.5 * (bounds.min + bounds.max);
  HalfedgeTopology topology = findTopology(soup.positions, soup.triangles, pairs, creaseAngle, centre);
  defects.sharpEdges = topology.sharpEdges;

  Mesh& mesh = result.mesh;
  mesh.bounds = bounds;
  mesh.positions = std::move(soup.positions);
  mesh.triangles = std::move(soup.triangles);
  mesh.triangleMaterial = std::move(soup.triangleMaterial);
  mesh.triangleUv = std::move(soup.triangleUv);
  mesh.neighbours = std::move(topology.neighbours);
  mesh.edgeFlags = std::move(topology.edgeFlags);
  mesh.triangleShell = std::move(topology.triangleShell);
  mesh.shellCount = static_cast<std::uint32_t>(topology.shells.size());

  const std::vector<bool> invert = shellsToInvert(mesh, topology.shells);
  mesh.closed = !mesh.triangles.empty() && pairs.openEdges == 0 && pairs.manyFaced.empty();
  for (std::size_t s = 0; s < topology.shells.size(); ++s) {
    const Shell& shell = topology.shells[s];
    defects.openShells += shell.hasBoundary ? 1 : 0;
    defects.invertedShells += invert[s] ? 1 : 0;
    mesh.closed = mesh.closed && shell.closed;
    mesh.volume += invert[s] ? -shell.signedVolume : shell.signedVolume;
  }
  if (!mesh.closed) mesh.volume = 0.0;
  invertShells(mesh, invert);
  turnUv(asRead, mesh.triangles, mesh.triangleUv);
  return result;
}

}  // namespace tandem::assets
