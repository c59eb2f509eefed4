#pragma once

// Cuts the triangles of a mesh at points on their edges. For the files of this room only.
//
// 1. Both triangles of an edge are cut at the same points, so that a closed mesh stays closed.
// 2. Positions that are not moved, and materials, texture coordinates and normals of uncut triangles, keep
//    their bits.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "assets/mesh/mesh_analysis.h"

namespace tandem::assets {

/// On which of `count` rulings around a cylinder the corners of its facets lie.
struct RulingOf {
  const std::map<std::uint32_t, std::size_t>* at = nullptr;
  std::size_t count = 0;
};

class FacetCutter {
 public:
  /// Keeps a reference to the mesh.
  FacetCutter(const Mesh& mesh, double rounding);

  /// Moves a vertex of the mesh.
  void movePoint(std::uint32_t vertex, const glm::dvec3& by) { out_.positions[vertex] += by; }
  bool isCut(std::uint32_t a, std::uint32_t b) const { return cuts_.contains({a, b}); }
  /// Cuts the edge from vertex a to b, a < b, at a point at `share` of its way. Cuts of one edge follow each
  /// other along it. `ruling`: of the cylinder on which the point lies.
  void addPoint(std::uint32_t a, std::uint32_t b, const glm::dvec3& point, double share, std::size_t ruling);

  /// Adds the pieces of a facet of a cylinder, which meet along rulings. `normalAt`: of the cylinder.
  void addRound(std::size_t triangle, const RulingOf& ruling,
                const std::function<glm::vec3(const glm::dvec3&)>& normalAt);
  /// Adds the pieces of another triangle. False, and some pieces are missing, if its edges cross each other.
  bool addFlat(std::size_t triangle);

  std::size_t size() const { return out_.triangles.size(); }
  std::size_t points() const { return out_.positions.size(); }
  TriangleSoup finish() { return std::move(out_); }

 private:
  struct Cut {
    std::uint32_t vertex = 0;
    double share = 0.0;
    std::size_t ruling = 0;
  };
  /// A corner of a piece: its place in the triangle that is cut, in barycentric coordinates.
  struct Corner {
    std::uint32_t vertex = 0;
    glm::dvec3 share{0.0};
    std::size_t ruling = 0;
    bool isNew = false;
  };

  /// The corners along the edge from corner e, with that corner and without the next one.
  void walkEdge(std::size_t triangle, std::size_t e, std::vector<Corner>& corners) const;
  void addPiece(std::size_t triangle, const Corner& a, const Corner& b, const Corner& c,
                const std::function<glm::vec3(const glm::dvec3&)>* normalAt = nullptr);

  const Mesh& mesh_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Cut>> cuts_;
  TriangleSoup out_;
};

}  // namespace tandem::assets
