#pragma once

// Part model: what contact between parts needs of a mesh. It consists of features, which are samples (where
// the part can touch) and edges (where its surface turns), and of a field (the distance to it). Instances
// share it; immutable. A coarse field may be followed by a finer one with the same features.

#include <memory>
#include <span>
#include <utility>

#include "haptics/geometry/mesh_edges.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/contact_samples.h"
#include "haptics/scene/distance_field.h"

namespace tandem::haptics {

/// Where a part can touch, and how its surface turns there: the same whatever the cells of its field.
struct PartFeatures {
  PartFeatures(const assets::Mesh& mesh, MeshEdges found, bool solid, const ContactSamples::Options& sampling)
      : edges(solid ? std::move(found).ofSolid() : std::move(found)), samples(mesh, edges, sampling) {}
  /// Of implicit shapes; the mesh represents them elsewhere.
  PartFeatures(const assets::Mesh& mesh, std::span<const assets::ImplicitShape> shapes,
               const ContactSamples::Options& sampling)
      : samples(shapes, mesh, sampling) {}

  MeshEdges edges;
  ContactSamples samples;
};

struct PartModel {
  /// Model of a mesh with a field of it.
  PartModel(const TriangleBvh& bvh, std::shared_ptr<const PartFeatures> found, DistanceField made)
      : tree(&bvh),
        features(std::move(found)),
        edges(features->edges),
        samples(features->samples),
        field(std::move(made)) {}

  /// Model of implicit shapes, by formula. The tree is that of the mesh that represents them elsewhere.
  PartModel(const TriangleBvh& bvh, std::span<const assets::ImplicitShape> shapes,
            const ContactSamples::Options& sampling, double tolerance)
      : PartModel(bvh, std::make_shared<PartFeatures>(bvh.mesh(), shapes, sampling),
                  DistanceField(shapes, bvh.mesh(), tolerance)) {}

  bool byFormula() const { return !field.shapes().empty(); }
  /// The patch that a sample represents, part frame; false if that is a point.
  bool patchOf(const ContactSample& sample, ContactPatch& patch) const;

  /// Size in bytes without the tree.
  std::size_t memory() const { return edges.memory() + samples.memory() + field.memory(); }

  const TriangleBvh* tree;  // must outlive this
  std::shared_ptr<const PartFeatures> features;
  const MeshEdges& edges;         // of `features`
  const ContactSamples& samples;  // of `features`
  DistanceField field;
  bool coarse = false;  // a finer field is to follow
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
  const EdgeLine edge = edges.line(sample.edge);
  patch = ContactPatch{};
  patch.kind = ContactPatch::Kind::straight;
  patch.centre = sample.point;
  patch.axis = glm::normalize(edge.b - edge.a);
  patch.along = static_cast<double>(sample.along);
  return true;
}

}  // namespace tandem::haptics
