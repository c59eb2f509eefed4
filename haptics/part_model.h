#pragma once

// What contact between parts needs to know of a mesh, made once: where it can touch (samples), where it turns
// (edges), and how far away it is (field). Instances share it; immutable.

#include <utility>

#include "haptics/contact_samples.h"
#include "haptics/distance_field.h"
#include "haptics/mesh_edges.h"
#include "haptics/triangle_bvh.h"

namespace tandem::haptics {

struct PartModel {
  struct Options {
    ContactSamples::Options samples;
    DistanceField::Options field;
  };

  PartModel(const TriangleBvh& bvh, const Options& options)
      : PartModel(bvh, MeshEdges(bvh.mesh()), options.samples, DistanceField(bvh, options.field)) {}
  /// With edges and a field of this mesh that were made before.
  PartModel(const TriangleBvh& bvh, MeshEdges found, const ContactSamples::Options& sampling,
            DistanceField made)
      : tree(&bvh), edges(std::move(found)), samples(bvh.mesh(), edges, sampling), field(std::move(made)) {}

  /// Bytes, the tree's not counted.
  std::size_t memory() const { return edges.memory() + samples.memory() + field.memory(); }

  const TriangleBvh* tree;  // must outlive this
  MeshEdges edges;
  ContactSamples samples;
  DistanceField field;
  // How it was made, for reports.
  double seconds = 0.0;
  bool cached = false;  // the field was read from the cache
};

}  // namespace tandem::haptics
