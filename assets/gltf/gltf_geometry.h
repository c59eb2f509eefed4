#pragma once

// Reads the triangles of glTF meshes in a part's frame. For the loader's sources only.

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>

#include "assets/gltf/gltf_document.h"
#include "assets/mesh/mesh_analysis.h"

namespace tandem::assets {

/// One glTF mesh placed in a part.
struct MeshPiece {
  std::size_t mesh = 0;                  // into model.meshes
  glm::dmat4 partFromMesh{1.0};          // m; may scale, shear and mirror
  std::int64_t surface = -1;             // its physics surface, which distinguishes pieces; -1 = none
  std::vector<std::uint16_t> materials;  // one a primitive, into Scene::materials
  bool textured = false;                 // its surface has an image, so that texture coordinates are read
  bool normals = true;                   // felt, unless its surface says how smooth it is
};

/// Counts of what was left out of a mesh.
struct GeometryNotes {
  std::uint64_t pointsAndLines = 0;       // primitives
  std::uint64_t incompleteTriangles = 0;  // primitives whose index count is no multiple of three
  std::uint64_t singularPieces = 0;       // pieces whose transform flattens them
  std::uint64_t withoutUv = 0;            // primitives whose surface has an image, but no texture coordinates
};

/// An upper bound of a mesh's triangles from its counts alone, before any byte is read.
std::size_t triangleBound(const GltfDocument& document, std::size_t mesh);

/// The triangles of all pieces, in part order, with positions in the part's frame and the winding of mirrored
/// pieces reversed.
TriangleSoup readGeometry(const GltfDocument& document, const std::vector<MeshPiece>& pieces,
                          GeometryNotes& notes);

}  // namespace tandem::assets
