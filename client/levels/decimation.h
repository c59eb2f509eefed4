#pragma once

// A mesh with ever fewer triangles, by collapses of edges onto their ends. Needs OpenMesh's decimater, which
// only decimation.cpp sees.
//
// 1. Vertices are taken away and never moved. One on a sharp edge, an open border or a border of materials
//    is only merged with its neighbour along that line, so that these lines keep their corners.
// 2. A closed mesh stays closed.

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "assets/scene/scene.h"

namespace tandem::client {

/// A decimated mesh. Shells, volume, texture coordinates and stated normals are left out.
struct DecimatedMesh {
  assets::Mesh mesh;
  std::vector<std::uint32_t> exactPoint;  // of each position, in the exact mesh
};

class Decimation {
 public:
  /// Nothing for a mesh without topology, or one that OpenMesh cannot hold. Copies what it needs.
  static std::optional<Decimation> of(const assets::Mesh& mesh);
  ~Decimation();
  Decimation(Decimation&&) noexcept;

  /// Collapses edges, those first that change the shape least, until no more than `triangles` are left, none
  /// can be collapsed, or `stopped` holds. Returns how many are left.
  std::size_t reduceTo(std::size_t triangles, const std::function<bool()>& stopped);
  /// What it is now; `exact` is the mesh that it was made of.
  DecimatedMesh mesh(const assets::Mesh& exact) const;

 private:
  struct Data;
  explicit Decimation(std::unique_ptr<Data> data);
  std::unique_ptr<Data> data_;
};

}  // namespace tandem::client
