#pragma once

// Contact samples: the points of a part that can touch another part first. They lie on its sharp convex
// edges, at its corners and on its smooth convex surfaces. Flat and concave surfaces need none, because what
// touches them is a sample of the other part: every contact of two polyhedra is between a corner and a face,
// or between two edges.
//
// 1. Immutable; sorted into a tree of balls; part frame.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "haptics/geometry/mesh_edges.h"
#include "haptics/geometry/primitive_distance.h"
#include "haptics/scene/contact_patch.h"

namespace tandem::haptics {

/// One sample, with the directions of the part's surface there.
struct ContactSample {
  glm::dvec3 point{0.0, 0.0, 0.0};     // m
  std::uint32_t firstNormal = 0;       // into ContactSamples::normals()
  std::uint32_t normalCount = 0;       // of the faces that meet here
  std::uint32_t edge = assets::kNone;  // an edge of MeshEdges; kNone at corners and on implicit shapes
  std::uint32_t triangle = 0;          // one of those that meet here
  // m: half length of the sharp edge's piece, or the radius of the patch, that the sample represents; 0 on a
  // smooth surface.
  float along = 0.0f;
  std::uint32_t patch = assets::kNone;  // into ContactSamples::patches(); kNone for a mesh
  float turn = 0.0f;  // sine of the angle by which a smooth surface turns between here and its next samples
};

/// Samples with the lists that they index, part frame.
struct SampleSet {
  std::vector<ContactSample> samples;
  std::vector<glm::dvec3> normals;
  std::vector<ContactPatch> patches;  // of implicit shapes
};

class ContactSamples {
 public:
  struct Options {
    double spacing = 0.0;        // m between samples of a sharp edge; 0: usualSpacing()
    double smoothSpacing = 0.0;  // m on smooth surfaces; 0: 1.25 times `spacing`
    double sharp = 0.14;         // rad: edges that turn by more are sampled along their length
  };

  /// A ball that contains the samples [begin, end) with all that they stand for. Its halves are the next node
  /// and `second`, which is 0 in a leaf.
  struct Node {
    float centre[3];
    float radius;
    std::uint32_t begin, end, second;
  };
  static constexpr std::uint32_t kMaxInLeaf = 16;
  /// Spacings of the samples of a smooth surface that each of them stands for.
  static constexpr double kDescent = 1.5;
  /// Share of smoothDip() by which a part is nearer to another one than at its nearest sample at most.
  static constexpr double kSag = 0.75;

  /// 1/64 of the mesh's diagonal, m. A straight edge needs no finer spacing, because a sample represents its
  /// piece of the edge; the error on a smooth surface is the sag over that length.
  static double usualSpacing(const assets::Mesh& mesh);

  ContactSamples(const assets::Mesh& mesh, const MeshEdges& edges, const Options& options);
  /// Samples of implicit shapes (primitive_samples.h). `mesh` is the one that represents the shapes
  /// elsewhere.
  ContactSamples(std::span<const assets::ImplicitShape> shapes, const assets::Mesh& mesh,
                 const Options& options);

  std::span<const ContactSample> samples() const { return set_.samples; }
  /// Positions of the samples, m, and in w, m, `along`, or -sag() of a sample of a smooth surface: a compact
  /// copy for ticks.
  std::span<const glm::vec4> points() const { return points_; }
  /// Of one of points(): half length of the piece of edge, or radius of the patch, that the sample
  /// represents, m; 0 on a smooth surface.
  static float pieceAbout(const glm::vec4& point) { return std::max(point.w, 0.0f); }
  /// Of one of points(): the largest distance, m, of the sample from another part that its own part may touch
  /// already, beside the sample.
  static float touchAbout(const glm::vec4& point) { return std::abs(point.w); }
  /// The direction of the piece of a straight edge that the sample represents, unit; zero for other samples.
  const glm::vec3& axis(const ContactSample& sample) const {
    return axes_[static_cast<std::size_t>(&sample - set_.samples.data())];
  }
  std::span<const glm::dvec3> normals(const ContactSample& sample) const {
    return {set_.normals.data() + sample.firstNormal, sample.normalCount};
  }
  /// Patches of implicit shapes, part frame.
  std::span<const ContactPatch> patches() const { return set_.patches; }
  /// Whether the sample represents a piece of a round surface or a rim, not a point or a piece of a straight
  /// edge.
  bool isRound(const ContactSample& sample) const {
    return sample.patch != assets::kNone && set_.patches[sample.patch].kind != ContactPatch::Kind::straight;
  }
  /// Whether the sample lies on a smooth surface of a mesh.
  static bool isSmooth(const ContactSample& sample) {
    return sample.edge != assets::kNone && !(sample.along > 0.0f);
  }
  /// m around a sample of a mesh of what it stands for.
  double extent(const ContactSample& sample) const {
    return isSmooth(sample) ? kDescent * smoothSpacing_ : static_cast<double>(sample.along);
  }
  /// Upper bound (m) of how much nearer to another part a smooth convex surface can be between its samples
  /// than at this one.
  double smoothDip(const ContactSample& sample) const {
    return static_cast<double>(sample.turn) * smoothSpacing_;
  }
  /// The same of the sample that is nearest to the other part.
  float sag(const ContactSample& sample) const { return sample.turn * sagOfTurn_; }
  /// The same of what any sample of a mesh stands for: along a sharp edge at most its whole piece.
  double dip(const ContactSample& sample) const {
    return isSmooth(sample) ? smoothDip(sample) : static_cast<double>(sample.along);
  }
  /// Root first; empty without samples.
  std::span<const Node> nodes() const { return nodes_; }
  /// Spacings as used, m.
  double spacing() const { return spacing_; }
  double smoothSpacing() const { return smoothSpacing_; }
  std::size_t memory() const;

 private:
  /// Sets the spacings.
  ContactSamples(const Options& options, const assets::Mesh& mesh);
  /// Builds the tree and sorts the samples into its order.
  void sort();
  std::uint32_t build(std::vector<std::uint32_t>& order, std::uint32_t begin, std::uint32_t end);

  double spacing_ = 0.0, smoothSpacing_ = 0.0;
  float sagOfTurn_ = 0.0f;  // m a unit of ContactSample::turn
  SampleSet set_;
  std::vector<glm::vec4> points_;
  std::vector<glm::vec3> axes_;
  std::vector<Node> nodes_;
};

}  // namespace tandem::haptics
