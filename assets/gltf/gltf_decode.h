#pragma once

// Reads numbers from a glTF file's buffers: accessors (strided, sparse, quantised), Draco, meshopt. Every
// byte range and every count is checked against the available bytes before memory is allocated. For the
// loader's sources only.

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "assets/gltf/gltf_document.h"

namespace tandem::assets {

/// Decompresses every buffer view that carries EXT_meshopt_compression into document.ownedViews.
void decodeMeshoptViews(GltfDocument& document);

/// Number of elements of an accessor. An accessor whose bytes cannot hold them is refused, so the count can
/// be trusted before the elements are read. 0 <= accessor < accessors.size(), here and below.
std::size_t elementCount(const GltfDocument& document, std::size_t accessor);

/// A VEC3 accessor as finite positions in file units: floats, or integers as KHR_mesh_quantization allows.
std::vector<glm::dvec3> readPositions(const GltfDocument& document, std::size_t accessor);

/// A VEC3 accessor of `count` normals in the mesh's frame, not of length 1 and possibly not finite; empty if
/// the accessor is not one that glTF allows for normals.
std::vector<glm::dvec3> readNormals(const GltfDocument& document, std::size_t accessor, std::size_t count);

/// The range of a buffer view's bytes, in their decompressed form where the file compresses them. Throws
/// GltfError if it reaches past the end of its buffer.
GltfRange viewRange(const GltfDocument& document, std::size_t view);

/// A VEC2 accessor as finite texture coordinates: floats, or integers, normalised or not.
std::vector<glm::vec2> readTexCoords(const GltfDocument& document, std::size_t accessor);

/// A SCALAR accessor of unsigned integers.
std::vector<std::uint32_t> readIndices(const GltfDocument& document, std::size_t accessor);

struct DracoMesh {
  std::vector<glm::dvec3> positions;   // file units, all finite
  std::vector<glm::dvec3> normals;     // one a position, or empty where there are none
  std::vector<std::uint32_t> indices;  // a triangle list, all in range
};

/// The geometry of a primitive with KHR_draco_mesh_compression; `extension` is that object.
DracoMesh decodeDraco(const GltfDocument& document, const Json& extension, const std::string& place);

}  // namespace tandem::assets
