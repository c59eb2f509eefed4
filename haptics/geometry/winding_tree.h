#pragma once

// How often a mesh winds around a point, also where it has holes, overlaps itself or is a soup.
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

/// Share of the full sphere under which p sees a triangle: positive from behind, -1/2..1/2. van Oosterom &
/// Strackee 1983, "The solid angle of a plane triangle".
double windingOfTriangle(const glm::dvec3& p, const Triangle& triangle);

/// The generalised winding number of Jacobson, Kavan & Sorkine-Hornung 2013, summed over a tree as in Barill
/// et al. 2018, "Fast winding numbers for soups and clouds": far triangles count by their dipole and its
/// first derivative.
class WindingTree {
 public:
  explicit WindingTree(const assets::Mesh& mesh);

  /// 0 outside and 1 inside of a closed mesh, in between where it has holes. Off by up to 0.06 (tested).
  double at(const glm::dvec3& p) const;

 private:
  struct Node {
    glm::dvec3 centre{0.0, 0.0, 0.0};  // m, weighted by area
    double radius = 0.0;               // m, of a ball about it with all triangles
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
