#pragma once

// Generalised winding number of a mesh about a point, defined also for meshes with holes, overlaps, or
// without connectivity.
//
// 1. Immutable after construction and safe in every thread. For construction of models, not for ticks.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "assets/scene/scene.h"
#include "haptics/geometry/triangle_math.h"

namespace tandem::haptics {

/// Signed fraction of the full sphere that a triangle covers as seen from p: positive from behind, -1/2..1/2
/// (van Oosterom & Strackee 1983, "The solid angle of a plane triangle").
double windingOfTriangle(const glm::dvec3& p, const Triangle& triangle);

/// Generalised winding number (Jacobson, Kavan & Sorkine-Hornung 2013) by the fast winding numbers of Barill
/// et al. 2018, "Fast winding numbers for soups and clouds": a Barnes-Hut-like tree in which distant
/// triangles count by their dipole and its first derivative.
class WindingTree {
 public:
  explicit WindingTree(const assets::Mesh& mesh);

  /// 0 outside and 1 inside of a closed mesh, between the two near holes. The error is at most 0.06 (tested).
  double at(const glm::dvec3& p) const;

 private:
  struct Node {
    glm::dvec3 centre{0.0, 0.0, 0.0};  // m, weighted by area
    double radius = 0.0;               // m, of a ball about the centre that contains all triangles
    glm::dvec3 area{0.0, 0.0, 0.0};    // m^2, sum of the area vectors
    glm::dmat3 moment{0.0};            // m^3, sum of (x - centre) area^T
    std::uint32_t first = 0, count = 0;
    std::uint32_t children = 0;  // two side by side; 0: a leaf
  };

  void split(std::uint32_t node, std::vector<glm::dvec3>& middles);
  void measure(Node& node) const;
  Triangle triangle(std::uint32_t index) const;

  const assets::Mesh* mesh_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace tandem::haptics
