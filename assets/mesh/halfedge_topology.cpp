#include "assets/mesh/halfedge_topology.h"

#include <cmath>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "assets/scene/scene.h"

namespace tandem::assets {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::VectorT<double, 3>;
  using Normal = OpenMesh::VectorT<double, 3>;
  VertexAttributes(0);
  HalfedgeAttributes(0);  // no previous halfedge: in triangles it is next of next
  EdgeAttributes(0);
  FaceAttributes(OpenMesh::Attributes::Normal);
};
using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using OpenMesh::HalfedgeHandle;

std::uint32_t nextOf(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
std::uint32_t previousOf(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

/// Writes a soup into an OpenMesh mesh as a whole. OpenMesh's own add_face() searches and patches the mesh at
/// every face, and refuses faces at edges of three and more, at corners where fans meet, and in
/// non-orientable shells. With the pairs known, the links can be written directly, and whatever is not
/// manifold is cut: each side of such an edge becomes a boundary, each fan of faces around a point a vertex
/// of its own. No face is lost.
class Builder {
 public:
  Builder(const std::vector<glm::dvec3>& points, const std::vector<TriangleIndices>& triangles,
          const EdgePairs& pairs)
      : points_(points), triangles_(triangles), pairs_(pairs), handleOf_(3 * triangles.size()) {}

  HalfedgeMesh build() {
    const std::size_t edges = nameHalfedges();
    const std::size_t fans = nameFans();
    mesh_.resize(fans, edges, triangles_.size());
    for (std::uint32_t h = 0; h < handleOf_.size(); ++h) linkFaceHalfedge(h);
    for (std::uint32_t h = 0; h < handleOf_.size(); ++h)
      if (partner(h) == kOpenEdge) linkBoundary(h);
    return std::move(mesh_);
  }

  /// Halfedge h = 3 t + e of the soup in the mesh.
  const std::vector<int>& handles() const { return handleOf_; }

 private:
  /// The halfedge that shares a manifold, consistently oriented edge with h, or kOpenEdge.
  std::uint32_t partner(std::uint32_t h) const {
    const std::uint32_t other = pairs_.across[h];
    if (other >= kManyFacedEdge || startOf(triangles_, other) == startOf(triangles_, h)) return kOpenEdge;
    return other;
  }

  std::size_t nameHalfedges() {
    int edges = 0;
    for (std::uint32_t h = 0; h < handleOf_.size(); ++h) {
      const std::uint32_t other = partner(h);
      // The halfedges of OpenMesh's edge i are 2 i and 2 i + 1.
      handleOf_[h] = other < h ? handleOf_[other] ^ 1 : 2 * edges++;
    }
    return static_cast<std::size_t>(edges);
  }

  /// The next halfedge that leaves the start of h, counter-clockwise; kOpenEdge at a boundary.
  std::uint32_t rotate(std::uint32_t h) const { return partner(previousOf(h)); }
  std::uint32_t rotateBack(std::uint32_t h) const {
    const std::uint32_t other = partner(h);
    return other == kOpenEdge ? kOpenEdge : nextOf(other);
  }

  std::size_t nameFans() {
    fanOf_.assign(handleOf_.size(), -1);
    int fans = 0;
    for (std::uint32_t seed = 0; seed < fanOf_.size(); ++seed) {
      if (fanOf_[seed] >= 0) continue;
      // Begin at the clockwise end, so that a single sweep sees the whole fan.
      std::uint32_t first = seed;
      for (std::uint32_t h = rotateBack(seed); h != kOpenEdge && h != seed; h = rotateBack(h)) first = h;
      if (rotateBack(first) == seed) first = seed;
      for (std::uint32_t h = first; h != kOpenEdge && fanOf_[h] < 0; h = rotate(h)) fanOf_[h] = fans;
      ++fans;
    }
    return static_cast<std::size_t>(fans);
  }

  void linkFaceHalfedge(std::uint32_t h) {
    const HalfedgeHandle handle(handleOf_[h]);
    const OpenMesh::FaceHandle face(static_cast<int>(h / 3));
    const OpenMesh::VertexHandle start(fanOf_[h]);
    mesh_.set_vertex_handle(handle, OpenMesh::VertexHandle(fanOf_[nextOf(h)]));
    mesh_.set_face_handle(handle, face);
    mesh_.set_next_halfedge_handle(handle, HalfedgeHandle(handleOf_[nextOf(h)]));
    mesh_.set_halfedge_handle(face, handle);
    if (!mesh_.halfedge_handle(start).is_valid()) {
      mesh_.set_halfedge_handle(start, handle);
      const glm::dvec3& p = points_[startOf(triangles_, h)];
      mesh_.set_point(start, {p.x, p.y, p.z});
    }
  }

  /// Links the boundary halfedge opposite to h, which ends where h starts.
  void linkBoundary(std::uint32_t h) {
    const HalfedgeHandle boundary(handleOf_[h] ^ 1);
    const OpenMesh::VertexHandle vertex(fanOf_[h]);
    mesh_.set_vertex_handle(boundary, vertex);
    std::uint32_t last = h;
    while (rotate(last) != kOpenEdge) last = rotate(last);
    const HalfedgeHandle leaving(handleOf_[previousOf(last)] ^ 1);
    mesh_.set_next_halfedge_handle(boundary, leaving);
    mesh_.set_halfedge_handle(vertex, leaving);  // OpenMesh knows a boundary vertex by its halfedge
  }

  const std::vector<glm::dvec3>& points_;
  const std::vector<TriangleIndices>& triangles_;
  const EdgePairs& pairs_;
  std::vector<int> handleOf_;  // 3T
  std::vector<int> fanOf_;     // 3T, vertex of the mesh where h starts
  HalfedgeMesh mesh_;
};

void findShells(const HalfedgeMesh& mesh, HalfedgeTopology& topology) {
  topology.triangleShell.assign(mesh.n_faces(), kNone);
  std::vector<OpenMesh::FaceHandle> open;
  for (const auto seed : mesh.faces()) {
    if (topology.triangleShell[seed.idx()] != kNone) continue;
    const auto shell = static_cast<std::uint32_t>(topology.shells.size());
    topology.shells.emplace_back().firstFace = static_cast<std::uint32_t>(seed.idx());
    topology.triangleShell[seed.idx()] = shell;
    open.assign(1, seed);
    while (!open.empty()) {
      HalfedgeHandle h = mesh.halfedge_handle(open.back());
      open.pop_back();
      for (int e = 0; e < 3; ++e, h = mesh.next_halfedge_handle(h)) {
        const OpenMesh::FaceHandle other = mesh.opposite_face_handle(h);
        if (!other.is_valid() || topology.triangleShell[other.idx()] != kNone) continue;
        topology.triangleShell[other.idx()] = shell;
        open.push_back(other);
      }
    }
  }
}

void findNeighbours(const HalfedgeMesh& mesh, const std::vector<int>& handles, const EdgePairs& pairs,
                    double creaseAngle, HalfedgeTopology& topology) {
  const double creaseCosine = std::cos(creaseAngle);
  topology.neighbours.resize(mesh.n_faces());
  topology.edgeFlags.resize(mesh.n_faces());
  for (std::uint32_t h = 0; h < handles.size(); ++h) {
    const std::uint32_t t = h / 3;
    std::uint32_t& neighbour = topology.neighbours[t][h % 3];
    std::uint8_t& flags = topology.edgeFlags[t][h % 3];
    const HalfedgeHandle handle(handles[h]);
    const OpenMesh::FaceHandle other = mesh.opposite_face_handle(handle);
    neighbour = kNone;
    flags = 0;
    if (other.is_valid()) {
      neighbour = static_cast<std::uint32_t>(other.idx());
      const double cosine = mesh.normal(mesh.face_handle(handle)) | mesh.normal(other);
      if (cosine < creaseCosine) flags = kEdgeSharp;
    } else if (pairs.across[h] == kOpenEdge) {
      flags = kEdgeBoundary;
      topology.shells[topology.triangleShell[t]].hasBoundary = true;
      topology.shells[topology.triangleShell[t]].closed = false;
    } else if (pairs.across[h] == kManyFacedEdge) {
      flags = kEdgeNonManifold;
    } else {
      // The faces at a seam of a non-orientable shell are neighbours with opposite normals.
      neighbour = pairs.across[h] / 3;
      flags = kEdgeSharp;
      topology.shells[topology.triangleShell[t]].closed = false;
    }
    if (flags == kEdgeSharp && h < pairs.across[h]) ++topology.sharpEdges;
  }
}

void sumVolumes(const HalfedgeMesh& mesh, const glm::dvec3& reference, HalfedgeTopology& topology) {
  const Traits::Point origin(reference.x, reference.y, reference.z);
  for (const auto face : mesh.faces()) {
    const HalfedgeHandle h = mesh.halfedge_handle(face);
    const HalfedgeHandle n = mesh.next_halfedge_handle(h);
    const Traits::Point a = mesh.point(mesh.from_vertex_handle(h)) - origin;
    const Traits::Point b = mesh.point(mesh.to_vertex_handle(h)) - origin;
    const Traits::Point c = mesh.point(mesh.to_vertex_handle(n)) - origin;
    topology.shells[topology.triangleShell[face.idx()]].signedVolume += (a | (b % c)) / 6.0;
  }
}

/// A shell whose faces pass an edge of many faces unequally often in the two directions is open there.
void openUnbalancedShells(const std::vector<TriangleIndices>& triangles, const EdgePairs& pairs,
                          HalfedgeTopology& topology) {
  std::vector<std::int64_t> balance(topology.shells.size(), 0);
  for (const std::vector<std::uint32_t>& edge : pairs.manyFaced) {
    for (const std::uint32_t h : edge)
      balance[topology.triangleShell[h / 3]] += startOf(triangles, h) < endOf(triangles, h) ? 1 : -1;
    for (const std::uint32_t h : edge) {
      const std::uint32_t shell = topology.triangleShell[h / 3];
      if (balance[shell] != 0) topology.shells[shell].closed = false;
      balance[shell] = 0;
    }
  }
}

}  // namespace

HalfedgeTopology findTopology(const std::vector<glm::dvec3>& points,
                              const std::vector<TriangleIndices>& triangles, const EdgePairs& pairs,
                              double creaseAngle, const glm::dvec3& reference) {
  HalfedgeTopology topology;
  Builder builder(points, triangles, pairs);
  HalfedgeMesh mesh = builder.build();
  mesh.update_face_normals();
  findShells(mesh, topology);
  findNeighbours(mesh, builder.handles(), pairs, creaseAngle, topology);
  sumVolumes(mesh, reference, topology);
  openUnbalancedShells(triangles, pairs, topology);
  return topology;
}

}  // namespace tandem::assets
