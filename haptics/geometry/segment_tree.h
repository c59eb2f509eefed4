#pragma once

// All crossings of a segment with the triangles of a mesh, in double precision. For measurements, not for
// ticks.

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::haptics {

struct SegmentCrossing {
  double t = 0.0;              // fraction of the segment
  std::uint32_t triangle = 0;  // of the mesh
  int sign = 0;                // +1 where the segment leaves to the outside, -1 where it enters
};

/// A binary tree of boxes, split at the median. Keeps a reference to the mesh.
class SegmentTree {
 public:
  explicit SegmentTree(const assets::Mesh& mesh);

  /// Appends the crossings to `found`. A segment in a triangle's plane does not cross it; one through an edge
  /// crosses both triangles of the edge, even if it only touches.
  void crossings(const glm::dvec3& from, const glm::dvec3& to, std::vector<SegmentCrossing>& found) const;

 private:
  struct Node {
    glm::dvec3 low, high;
    std::uint32_t first = 0;  // leaf: into order_; else the second child (the first one follows the node)
    std::uint32_t count = 0;  // of triangles; 0: not a leaf
  };
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);
  void cross(std::uint32_t triangle, const glm::dvec3& from, const glm::dvec3& path,
             std::vector<SegmentCrossing>& found) const;

  const assets::Mesh* mesh_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<glm::dvec3> centres_;  // of triangles, during construction
};

}  // namespace tandem::haptics
