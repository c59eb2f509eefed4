#pragma once

// Part model: what contact between parts needs of a mesh, made once. It consists of samples (where the part
// can touch), edges (where its surface turns) and a field (the distance to it). Instances share it;
// immutable.

#include <span>
#include <utility>

#include "haptics/geometry/mesh_edges.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/contact_samples.h"
#include "haptics/scene/distance_field.h"

namespace tandem::haptics {

struct PartModel {
  struct Options {
    ContactSamples::Options samples;
    DistanceField::Options field;
  };

  PartModel(const TriangleBvh& bvh, const Options& options)
      : PartModel(bvh, MeshEdges(bvh.mesh()), options.samples, DistanceField(bvh, options.field)) {}
  /// Model with edges and a field of this mesh that were made before.
  PartModel(const TriangleBvh& bvh, MeshEdges found, const ContactSamples::Options& sampling,
            DistanceField made)
      : tree(&bvh),
        edges(made.solid() ? std::move(found).ofSolid() : std::move(found)),
        samples(bvh.mesh(), edges, sampling),
        field(std::move(made)) {}

  /// Model of implicit shapes, by formula. The tree is that of the mesh that represents them elsewhere.
  PartModel(const TriangleBvh& bvh, std::span<const assets::ImplicitShape> shapes,
            const ContactSamples::Options& sampling, double tolerance)
      : tree(&bvh), samples(shapes, bvh.mesh(), sampling), field(shapes, bvh.mesh(), tolerance) {}

  bool byFormula() const { return !field.shapes().empty(); }
  /// The patch that a sample represents, part frame; false if that is a point.
  bool patchOf(const ContactSample& sample, ContactPatch& patch) const;

  /// Size in bytes without the tree.
  std::size_t memory() const { return edges.memory() + samples.memory() + field.memory(); }

  const TriangleBvh* tree;  // must outlive this
  MeshEdges edges;
  ContactSamples samples;
  DistanceField field;
  // Statistics for reports.
  double seconds = 0.0;
  bool cached = false;  // the field was read from the cache
};

inline bool PartModel::patchOf(const ContactSample& sample, ContactPatch& patch) const {
  if (sample.patch != assets::kNone) {
    patch = samples.patches()[sample.patch];
    return true;
  }
  if (sample.edge == assets::kNone || !(sample.along > 0.0f)) return false;
  const MeshEdge& edge = edges.edges()[sample.edge];
  patch = ContactPatch{};
  patch.kind = ContactPatch::Kind::straight;
  patch.centre = sample.point;
  patch.axis = glm::normalize(edge.b - edge.a);
  patch.along = static_cast<double>(sample.along);
  return true;
}

}  // namespace tandem::haptics
