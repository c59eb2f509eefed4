#pragma once

// A proxy as most libraries of the field have it, as a baseline for Tandem's: segments are intersected with
// triangles one after another, and each hit gives one plane (Zilles & Salisbury 1995 as sequences of at most
// three planes; Ruspini, Kolarov & Khatib 1997, section 4). Written for the report alone; a point tool on
// still parts.
//
// Real is the type of vertices, boxes and arithmetic.

#include <cstdint>
#include <limits>
#include <vector>

#include <glm/vec3.hpp>

#include "assets/scene/scene.h"

namespace tandem::client::report {

/// When the baseline's three steps (to the surface, along one plane, along two) are taken.
enum class PlaneOrder {
  onePlaneATick,     // one step a tick, so that sliding on a plane takes two
  threePlanesATick,  // all in one tick
};

/// Triangles in world coordinates under a binary tree of boxes, split at the median.
template <typename Real>
class SegmentTree {
 public:
  using Vec = glm::vec<3, Real>;

  struct Hit {
    Real t = Real(1);  // share of the segment
    Vec normal{Real(0)};
    std::uint32_t triangle = 0xffffffffu;
  };

  explicit SegmentTree(const assets::Scene& scene);

  /// The first triangle between `from` and `from + displacement`; both sides of a triangle count.
  bool firstHit(const Vec& from, const Vec& displacement, Hit& hit) const;

  /// Length of the diagonal of everything, m.
  Real size() const { return size_; }

 private:
  struct Box {
    Vec low{std::numeric_limits<Real>::max()}, high{std::numeric_limits<Real>::lowest()};
  };
  struct Node {
    Box box;
    std::uint32_t first = 0, count = 0;  // of a leaf's triangles; count 0: children at first and first + 1
  };
  static constexpr std::uint32_t kLeaf = 4;

  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count, std::vector<Vec>& centres);
  bool meets(const Box& box, const Vec& from, const Vec& inverseDisplacement, Real limit) const;
  void testTriangle(std::uint32_t triangle, const Vec& from, const Vec& displacement, Hit& hit) const;

  std::vector<Vec> corners_;          // three a triangle
  std::vector<std::uint32_t> order_;  // triangles in leaf order
  std::vector<Node> nodes_;
  Real size_ = Real(0);
};

/// The proxy over such a tree.
template <typename Real>
class BaselineProxy {
 public:
  using Vec = glm::vec<3, Real>;

  BaselineProxy(const SegmentTree<Real>& tree, PlaneOrder order, const glm::dvec3& start);

  /// One tick: where the proxy is now, for a device at `goal`. World frame, m.
  glm::dvec3 follow(const glm::dvec3& goal);

 private:
  /// One step of the sequence. True if another one may follow.
  bool step(const Vec& goal);
  Vec target(const Vec& goal) const;

  const SegmentTree<Real>& tree_;
  const PlaneOrder order_;
  Real gap_;  // m, kept from a surface: a share of the scene's size, well above the resolution of Real
  Vec position_;
  Vec normals_[2] = {Vec(Real(0)), Vec(Real(0))};
  Vec point_{Real(0)};  // of the first plane
  int planes_ = 0;
};

extern template class SegmentTree<float>;
extern template class SegmentTree<double>;
extern template class BaselineProxy<float>;
extern template class BaselineProxy<double>;

}  // namespace tandem::client::report
