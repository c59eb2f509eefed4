#pragma once

// The points of a part with which it can touch another one first: on its sharp convex edges, at its corners
// and on its smooth convex surfaces. Flat and hollow surfaces need none, for what touches them is a sample of
// the other part (every contact of two polyhedra is of a corner with a face, or of two edges).
//
// 1. Immutable; sorted into a tree of balls; part frame.

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "haptics/mesh_edges.h"

namespace tandem::haptics {

/// One point, with the directions in which the part's surface looks there.
struct ContactSample {
  glm::dvec3 point{0.0, 0.0, 0.0};     // m
  std::uint32_t firstNormal = 0;       // into ContactSamples::normals()
  std::uint32_t normalCount = 0;       // of the faces that meet here
  std::uint32_t edge = assets::kNone;  // into MeshEdges::edges(); kNone at corners and on smooth surfaces
  std::uint32_t triangle = 0;          // one of those that meet here
  float along = 0.0f;                  // m: it stands for its edge this far to both sides
};

class ContactSamples {
 public:
  struct Options {
    double spacing = 0.0;        // m between samples of a sharp edge; 0: usualSpacing()
    double smoothSpacing = 0.0;  // m on smooth surfaces; 0: 1.25 times `spacing`
    double sharp = 0.14;         // rad: an edge that turns by more is sampled along its length
  };

  /// A ball that holds the samples [begin, end), with the lengths of edge that they stand for. Its halves are the
  /// node after this one and `second`, which is 0 in a leaf.
  struct Node {
    float centre[3];
    float radius;
    std::uint32_t begin, end, second;
  };
  static constexpr std::uint32_t kMostInLeaf = 16;

  /// m: 1/64 of the mesh's diagonal. A straight edge needs no more, for a sample stands for its piece of it; a smooth
  /// surface is known to the sag of that length.
  static double usualSpacing(const assets::Mesh& mesh);

  ContactSamples(const assets::Mesh& mesh, const MeshEdges& edges, const Options& options);

  std::span<const ContactSample> samples() const { return samples_; }
  /// Points and lengths `along` of the same samples, m, as a tick reads them.
  std::span<const glm::vec4> points() const { return points_; }
  std::span<const glm::dvec3> normals(const ContactSample& sample) const {
    return {normals_.data() + sample.firstNormal, sample.normalCount};
  }
  /// Root first; empty without samples.
  std::span<const Node> nodes() const { return nodes_; }
  /// Spacings as used, m.
  double spacing() const { return spacing_; }
  double smoothSpacing() const { return smoothSpacing_; }
  std::size_t memory() const;

 private:
  void sampleSharpEdges(const MeshEdges& edges, double sharp, std::vector<bool>& corner);
  void sampleSmooth(const assets::Mesh& mesh, const MeshEdges& edges, double sharp, std::vector<bool>& taken);
  void addCorners(const assets::Mesh& mesh, const MeshEdges& edges, const std::vector<bool>& corner);
  std::uint32_t build(std::vector<std::uint32_t>& order, std::uint32_t begin, std::uint32_t end);

  double spacing_ = 0.0, smoothSpacing_ = 0.0;
  std::vector<ContactSample> samples_;
  std::vector<glm::vec4> points_;
  std::vector<glm::dvec3> normals_;
  std::vector<Node> nodes_;
};

}  // namespace tandem::haptics
