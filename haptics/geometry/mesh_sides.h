#pragma once

// Which side of a mesh is solid, for meshes as they come from files.
//
// 1. Immutable after construction and safe in every thread. For construction of models, not for ticks.
// 2. The tree and its mesh must outlive it.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <glm/vec3.hpp>

#include "haptics/geometry/triangle_bvh.h"
#include "haptics/geometry/winding_tree.h"

namespace tandem::haptics {

class MeshSides {
 public:
  /// Examines the edges and up to a thousand samples of the surface. Triangles from `firstCap` on only close
  /// slits (slit_caps.h): they separate inside from outside, but their normals do not count.
  explicit MeshSides(const TriangleBvh& tree, std::size_t firstCap = ~std::size_t{0}, int threads = 1);

  /// Whether there is a sensible inside. A single open sheet has none.
  bool solid() const { return solid_; }
  /// Whether the inside can be entered through a mouth: a hole that is wide for the mesh, and on all of whose
  /// cap outside turns into inside without a face. A missing face that has a hole is none.
  bool hasMouth() const { return mouth_; }
  /// Takes the mesh for a sheet, which has no inside.
  void forgetInside() { solid_ = false; }
  /// How inside is told from outside.
  enum class Kind {
    clean,      /// nearest feature: closed, or closed by caps, with outside in front everywhere
    crossings,  /// rays: closed, or closed by caps, but shells overlap
    winding,    /// generalised winding number: a triangle soup
  };
  Kind kind() const { return kind_; }
  /// Whether the faces at edge e of a triangle do not cancel, so that the surface ends there.
  bool openEdge(std::uint32_t triangle, std::size_t e) const {
    return !open_.empty() && (open_[triangle] >> e & 1) != 0;
  }
  /// -1 where the triangles of the file face inwards, else 1.
  double facing() const { return facing_; }

  /// Outside direction at a point of the surface, not of unit length: the face's normal, or the
  /// angle-weighted pseudonormal of an edge or corner (Baerentzen & Aanaes 2005, "Signed distance computation
  /// using the angle weighted pseudonormal").
  glm::dvec3 outwards(const MeshPoint& at) const;

  /// Inside or outside near a point.
  struct Side {
    double sign = 1.0;    // 1 outside, -1 inside; always 1 if there is no inside
    bool certain = true;  // holds for all points within `reach` that no surface separates from p
  };
  /// The side of p, whose nearest point of the surface is `nearest`.
  Side sideOf(const glm::dvec3& p, const MeshPoint& nearest, double reach) const;
  /// sideOf() without a nearest point; slower.
  Side sideAt(const glm::dvec3& p, double reach) const;
  /// Only whether the side of p is certain.
  bool isCertain(const glm::dvec3& p, double reach) const;
  /// Whether within `reach` of p outside is in front of the surface and inside behind it.
  bool isRegular(const glm::dvec3& p, double reach) const;

 private:
  void findEdges();
  void findNormals();
  void closeHoles(int threads);
  /// Whether one of the caps over holes is that of a mouth.
  bool findMouth() const;
  /// m^2 of a triangle of a cap on which outside turns into inside, by comparing `across` places along each
  /// side at `beside` m on both sides of it.
  double enteredArea(const Triangle& cap, int across, double beside) const;
  void judge();
  void buildOpenEdges();
  /// Winding number of the closed mesh, from two or three rays.
  int crossingsFrom(const glm::dvec3& p) const;
  /// Whether the cap of a slit is part of the nearest feature.
  bool isBesideSlit(const MeshPoint& at) const;

  const TriangleBvh& tree_;
  const assets::Mesh& mesh_;
  std::size_t firstCap_;
  std::vector<std::array<std::uint32_t, 3>> edge_;  // T, index into edgeNormals_
  std::vector<glm::dvec3> edgeNormals_;             // sum of the unit normals of an edge's faces
  std::vector<glm::dvec3> cornerNormals_;           // V, angle-weighted
  std::vector<std::uint8_t> open_;                  // T or empty, bit e: openEdge()
  std::vector<bool> besideSlit_;                    // V or empty: corners of caps of slits
  double facing_ = 1.0;
  Kind kind_ = Kind::clean;
  bool solid_ = false, anyOpen_ = false, mouth_ = false;
  assets::Mesh closedMesh_, holeMesh_;                  // the mesh with caps over its holes; the caps alone
  std::unique_ptr<TriangleBvh> closedTree_, holeTree_;  // null unless all holes could be closed
  std::vector<std::uint32_t> loopOfCap_;                // of each triangle of holeMesh_
  std::unique_ptr<WindingTree> winding_;                // for Kind::winding
  assets::Mesh openMesh_;                               // for Kind::winding: open edges as faces without area
  std::unique_ptr<TriangleBvh> openTree_;
};

}  // namespace tandem::haptics
