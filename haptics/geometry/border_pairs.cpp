#include "haptics/geometry/border_pairs.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/buckets.h"
#include "assets/base/point_tree.h"
#include "haptics/geometry/segment.h"

namespace tandem::haptics {
namespace {

using assets::kNone;

/// Cosine between two edges above which they do not run back along each other.
constexpr double kBack = -0.5;
/// Steps of a search an open edge, on the mean; past them borders stay unpaired.
constexpr std::size_t kStepsPerEdge = 512;

class BorderPairs {
 public:
  BorderPairs(const assets::Mesh& mesh, double widest) : mesh_(mesh), widest_(widest) {
    for (std::uint32_t t = 0; t < mesh.edgeFlags.size(); ++t)
      for (std::uint32_t e = 0; e < 3; ++e)
        if ((mesh.edgeFlags[t][e] & assets::kEdgeBoundary) != 0) borders_.push_back(3 * t + e);
  }

  std::vector<std::uint32_t> faces() {
    if (borders_.empty()) return {};
    face_.assign(3 * mesh_.triangles.size(), kNone);
    distance_.assign(borders_.size(), widest_);
    listBordersOfVertices();
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < bordersAt_.keys(); ++v)
      if (!bordersAt_[v].empty()) vertices.push_back(v);
    const PointTree tree(mesh_.positions, std::move(vertices));
    std::size_t steps = kStepsPerEdge * (borders_.size() + 1024);
    // Of two borders along each other, an end of one lies on the other.
    for (std::uint32_t i = 0; i < borders_.size(); ++i) {
      const glm::dvec3 a = start(i), b = end(i);
      tree.forEachNear(a, b, widest_, steps, [&](std::uint32_t v) {
        if (glm::distance(mesh_.positions[v], closestPointOnSegment(mesh_.positions[v], a, b)) > widest_)
          return;
        for (const std::uint32_t border : bordersAt_[v]) {
          if (steps == 0) return;
          --steps;
          meet(i, border);
          meet(border, i);
        }
      });
    }
    return std::move(face_);
  }

 private:
  std::uint32_t vertex(std::uint32_t border, std::uint32_t end) const {
    const std::uint32_t h = borders_[border];
    return mesh_.triangles[h / 3][(h % 3 + end) % 3];
  }
  const glm::dvec3& start(std::uint32_t border) const { return mesh_.positions[vertex(border, 0)]; }
  const glm::dvec3& end(std::uint32_t border) const { return mesh_.positions[vertex(border, 1)]; }

  void listBordersOfVertices() {
    bordersAt_ = Buckets(mesh_.positions.size(), [&](const auto& add) {
      for (std::uint32_t i = 0; i < borders_.size(); ++i)
        for (const std::uint32_t k : {0u, 1u}) add(vertex(i, k), i);
    });
  }

  /// Takes the face of another border if that is the nearest one to the middle of this so far.
  void meet(std::uint32_t border, std::uint32_t other) {
    if (borders_[border] / 3 == borders_[other] / 3) return;
    const glm::dvec3 along = end(border) - start(border), back = end(other) - start(other);
    if (glm::dot(along, back) > kBack * glm::length(along) * glm::length(back)) return;
    const glm::dvec3 middle = 0.5 * (start(border) + end(border));
    const double off = glm::distance(middle, closestPointOnSegment(middle, start(other), end(other)));
    std::uint32_t& face = face_[borders_[border]];
    if (off > distance_[border] || (off == distance_[border] && borders_[other] / 3 >= face)) return;
    distance_[border] = off;
    face = borders_[other] / 3;
  }

  const assets::Mesh& mesh_;
  double widest_;                       // m
  std::vector<std::uint32_t> borders_;  // B: 3 * triangle + edge
  Buckets bordersAt_;                   // borders that end at each vertex
  std::vector<std::uint32_t> face_;     // 3T, the result
  std::vector<double> distance_;        // B: m, of the border whose face was taken
};

}  // namespace

std::vector<std::uint32_t> facesBeyondBorders(const assets::Mesh& mesh, double widest) {
  return BorderPairs(mesh, widest).faces();
}

}  // namespace tandem::haptics
