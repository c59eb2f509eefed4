#include "assets/mesh/mesh_analysis.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/mesh/edge_pairs.h"
#include "assets/mesh/halfedge_topology.h"
#include "assets/mesh/shell_nesting.h"
#include "assets/mesh/t_junctions.h"
#include "assets/mesh/vertex_weld.h"
#include "assets/scene/smooth_normals.h"

namespace tandem::assets {
namespace {

/// Distance of a vertex from an edge in welding tolerances. The tolerance is along each axis; a distance
/// within it along all three is at most sqrt(3) of it.
constexpr double kJunctionReach = 1.7320508075688772;
constexpr int kJunctionRounds = 8;

/// Whether three points lie on a line, up to the rounding of double coordinates (of which the welding
/// tolerance is 2^30 units). Slivers remain faces, because the file distinguishes their corners.
bool isDegenerate(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double weldTolerance) {
  const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  return glm::length(glm::cross(b - a, c - a)) <= std::ldexp(weldTolerance, -24) * longest;
}

/// Drops the faces that have no area; the others keep their order. Returns how many were dropped.
std::uint64_t dropDegenerate(TriangleSoup& soup, double weldTolerance) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    const TriangleIndices& t = soup.triangles[i];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] ||
        isDegenerate(soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]], weldTolerance))
      continue;
    soup.triangles[count] = t;
    if (!soup.triangleUv.empty()) soup.triangleUv[count] = soup.triangleUv[i];
    if (!soup.triangleNormal.empty()) soup.triangleNormal[count] = soup.triangleNormal[i];
    soup.triangleMaterial[count++] = soup.triangleMaterial[i];
  }
  const std::uint64_t dropped = soup.triangles.size() - count;
  soup.triangles.resize(count);
  soup.triangleMaterial.resize(count);
  if (!soup.triangleUv.empty()) soup.triangleUv.resize(count);
  if (!soup.triangleNormal.empty()) soup.triangleNormal.resize(count);
  return dropped;
}

/// Replaces vertices by points and drops the faces that have no area. Returns the tolerance, m.
double weld(TriangleSoup& soup, MeshDefects& defects) {
  WeldedVertices welded = weldVertices(soup.positions, soup.triangles, soup.rounding);
  const auto unused = std::count(welded.pointOf.begin(), welded.pointOf.end(), kNone);
  defects.unusedVertices += static_cast<std::uint64_t>(unused);
  defects.duplicateVertices = soup.positions.size() - static_cast<std::size_t>(unused) - welded.points.size();
  soup.positions = std::move(welded.points);
  for (TriangleIndices& t : soup.triangles)
    for (std::uint32_t& vertex : t) vertex = welded.pointOf[vertex];
  defects.degenerateFaces = dropDegenerate(soup, welded.tolerance);
  return welded.tolerance;
}

/// dropDuplicates() for the whole soup. What the corners have follows by the order of what stays.
std::uint64_t dropDuplicateFaces(TriangleSoup& soup) {
  if (soup.triangleUv.empty() && soup.triangleNormal.empty())
    return dropDuplicates(soup.triangles, soup.triangleMaterial, soup.positions.size());
  const std::vector<TriangleIndices> before = soup.triangles;
  const std::uint64_t dropped = dropDuplicates(soup.triangles, soup.triangleMaterial, soup.positions.size());
  std::size_t count = 0;
  // The first of several equal faces stays, so the first match is the right one.
  for (std::size_t t = 0; t < before.size() && count < soup.triangles.size(); ++t) {
    if (before[t] != soup.triangles[count]) continue;
    if (!soup.triangleUv.empty()) soup.triangleUv[count] = soup.triangleUv[t];
    if (!soup.triangleNormal.empty()) soup.triangleNormal[count] = soup.triangleNormal[t];
    ++count;
  }
  if (!soup.triangleUv.empty()) soup.triangleUv.resize(count);
  if (!soup.triangleNormal.empty()) soup.triangleNormal.resize(count);
  return dropped;
}

/// What the corners of the pieces have of what those of their parents had, interpolated.
template <typename Value>
void cutCorners(const std::vector<SplitTriangle>& pieces, std::vector<std::array<Value, 3>>& values) {
  if (values.empty()) return;
  std::vector<std::array<Value, 3>> cut(pieces.size());
  for (std::size_t t = 0; t < pieces.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::array<Value, 3>& of = values[pieces[t].parent];
      const glm::vec3 w(pieces[t].weights[c]);
      cut[t][c] = w.x * of[0] + w.y * of[1] + w.z * of[2];
    }
  values = std::move(cut);
}

/// Replaces the triangles by what they were cut into.
void takePieces(TriangleSoup& soup, const std::vector<SplitTriangle>& pieces) {
  const std::vector<std::uint16_t> material = std::move(soup.triangleMaterial);
  soup.triangles.clear();
  soup.triangleMaterial.clear();
  for (const SplitTriangle& piece : pieces) {
    soup.triangles.push_back(piece.corners);
    soup.triangleMaterial.push_back(material[piece.parent]);
  }
  cutCorners(pieces, soup.triangleUv);
  cutCorners(pieces, soup.triangleNormal);
}

/// Joins vertices to the open edges that they lie on, and pairs the edges anew. Where a piece has no area and
/// is dropped, the edges beside it may overlap again.
void weldJunctions(TriangleSoup& soup, double weldTolerance, EdgePairs& pairs, MeshDefects& defects) {
  for (int round = 0; round < kJunctionRounds; ++round) {
    const std::size_t before = soup.triangles.size();
    const EdgeSplits splits =
        splitAtJunctions(soup.positions, soup.triangles, pairs, kJunctionReach * weldTolerance);
    if (splits.junctions == 0) return;
    defects.tJunctions += splits.junctions;
    defects.degenerateFaces += before + splits.junctions - splits.triangles.size();
    takePieces(soup, splits.triangles);
    defects.degenerateFaces += dropDegenerate(soup, weldTolerance);
    defects.duplicateFaces += dropDuplicateFaces(soup);
    pairs = pairEdges(soup.triangles, soup.positions.size());
  }
}

/// What corners have in the order of the corners `after`, where the triangles may have been turned.
template <typename Value>
void turnCorners(const std::vector<TriangleIndices>& before, const std::vector<TriangleIndices>& after,
                 std::vector<std::array<Value, 3>>& values) {
  for (std::size_t t = 0; t < values.size(); ++t) {
    const std::array<Value, 3> old = values[t];
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t o = 0; o < 3; ++o)
        if (after[t][c] == before[t][o]) values[t][c] = old[o];
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
    bounds.include(p);
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
  const double weldTolerance = weld(soup, defects);
  defects.duplicateFaces = dropDuplicateFaces(soup);
  EdgePairs pairs = pairEdges(soup.triangles, soup.positions.size());
  weldJunctions(soup, weldTolerance, pairs, defects);
  dropUnused(soup, defects);

  const std::vector<TriangleIndices> asRead = soup.triangleUv.empty() && soup.triangleNormal.empty()
                                                  ? std::vector<TriangleIndices>()
                                                  : soup.triangles;
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
  mesh.triangleNormal = std::move(soup.triangleNormal);
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
  turnCorners(asRead, mesh.triangles, mesh.triangleUv);
  turnCorners(asRead, mesh.triangles, mesh.triangleNormal);
  settleNormals(mesh);
  // They have grown one by one, and stay as long as the scene does.
  mesh.positions.shrink_to_fit();
  mesh.triangles.shrink_to_fit();
  mesh.triangleMaterial.shrink_to_fit();
  mesh.triangleUv.shrink_to_fit();
  mesh.triangleNormal.shrink_to_fit();
  return result;
}

}  // namespace tandem::assets
