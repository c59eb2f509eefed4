#include "assets/gltf/gltf_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "assets/gltf/gltf_decode.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

constexpr int kTriangles = 4, kStrip = 5, kFan = 6;

std::string primitivePlace(std::size_t mesh, std::size_t primitive) {
  return placeName("meshes", mesh, "primitives") + "[" + std::to_string(primitive) + "]";
}

/// Corner triples in the order of the specification (glTF 2.0, 3.7.2.1), each named by its place in the index
/// list.
template <typename Emit>
void forEachTriangle(int mode, std::size_t count, const Emit& emit) {
  if (mode == kTriangles) {
    for (std::size_t i = 0; i + 2 < count; i += 3) emit(i, i + 1, i + 2);
  } else if (mode == kStrip) {
    for (std::size_t i = 0; i + 2 < count; ++i) emit(i, i + 1 + i % 2, i + 2 - i % 2);
  } else {
    for (std::size_t i = 0; i + 2 < count; ++i) emit(i + 1, i + 2, 0);
  }
}

/// Reads one mesh piece after the other into one soup.
class SoupBuilder {
 public:
  SoupBuilder(const GltfDocument& document, const std::vector<MeshPiece>& pieces, GeometryNotes& notes)
      : document_(document),
        notes_(notes),
        several_(pieces.size() > 1),
        moved_(std::any_of(pieces.begin(), pieces.end(), isMoved)) {}

  void addPiece(const MeshPiece& piece) {
    const double determinant = glm::determinant(glm::dmat3(piece.partFromMesh));
    if (determinant == 0.0 || !std::isfinite(determinant)) {
      ++notes_.singularPieces;
      return;
    }
    bases_.clear();
    const std::size_t first = soup_.triangles.size();
    const std::size_t primitives = document_.model.meshes[piece.mesh].primitives.size();
    for (std::size_t i = 0; i < primitives; ++i) addPrimitive(piece, i, determinant < 0.0);
    if (moved_) noteRounding(piece.partFromMesh, first);
  }

  TriangleSoup finish() {
    if (!soup_.triangleUv.empty()) soup_.triangleUv.resize(soup_.triangles.size());
    if (!soup_.triangleNormal.empty()) soup_.triangleNormal.resize(soup_.triangles.size());
    return std::move(soup_);
  }

 private:
  /// What a primitive states of each of its vertices; an array is empty where it states nothing.
  struct CornerAttributes {
    std::vector<glm::vec2> uv;
    std::vector<glm::vec3> normals;
  };

  void addPrimitive(const MeshPiece& piece, std::size_t index, bool mirrored) {
    const GltfPrimitive& primitive = document_.model.meshes[piece.mesh].primitives[index];
    const std::string place = primitivePlace(piece.mesh, index);
    int mode = primitive.mode;
    if (mode > kFan) throw GltfError(place + ".mode", std::to_string(mode) + " is unknown");
    if (mode < kTriangles) {
      ++notes_.pointsAndLines;
      return;
    }
    std::size_t base = 0, vertices = 0;
    std::optional<std::vector<std::uint32_t>> indices;
    CornerAttributes corners;
    if (primitive.draco != nullptr) {
      DracoMesh decoded = decodeDraco(document_, *primitive.draco, place + ".KHR_draco_mesh_compression");
      base = addPositions(decoded.positions, piece.partFromMesh, place);
      vertices = decoded.positions.size();
      indices = std::move(decoded.indices);
      if (piece.normals) corners.normals = inPart(decoded.normals, piece.partFromMesh);
      mode = kTriangles;  // Draco converts strips to triangles
    } else {
      if (primitive.positions < 0) return;  // legal, and without geometry
      const auto positions = static_cast<std::size_t>(primitive.positions);
      base = baseOf(positions, piece.partFromMesh, place);
      vertices = elementCount(document_, positions);
      if (primitive.indices >= 0)
        indices = readIndices(document_, static_cast<std::size_t>(primitive.indices));
      if (piece.normals && primitive.normals >= 0)
        corners.normals =
            inPart(readNormals(document_, static_cast<std::size_t>(primitive.normals), vertices),
                   piece.partFromMesh);
    }
    if (piece.textured) corners.uv = texCoords(primitive, vertices, place);
    addTriangles(place, mode, base, vertices, indices ? &*indices : nullptr, mirrored, piece.materials[index],
                 corners);
  }

  /// Normals of length 1 in the part's frame, by the inverse transpose; zero where there is none.
  static std::vector<glm::vec3> inPart(const std::vector<glm::dvec3>& normals,
                                       const glm::dmat4& partFromMesh) {
    const glm::dmat3 turn = glm::transpose(glm::inverse(glm::dmat3(partFromMesh)));
    std::vector<glm::vec3> out;
    out.reserve(normals.size());
    for (const glm::dvec3& normal : normals) {
      const glm::dvec3 n = turn * normal;
      const double length = glm::length(n);
      const bool usable = std::isfinite(length) && length > 0.0;
      out.push_back(usable ? glm::vec3(n / length) : glm::vec3(0.0f));
    }
    return out;
  }

  /// Whether a piece's coordinates in the part have another size than the scaled ones of its mesh.
  static bool isMoved(const MeshPiece& piece) {
    const glm::dmat4& m = piece.partFromMesh;
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row)
        if (row != column && m[column][row] != 0.0) return true;
    return false;
  }

  /// Raises the rounding of the soup to that of a piece: of the floats that its triangles, from `first` on,
  /// had in their mesh, and of its place where there are others beside it.
  void noteRounding(const glm::dmat4& partFromMesh, std::size_t first) {
    const glm::dmat3 linear(partFromMesh), back = glm::inverse(linear);
    const glm::dvec3 offset(partFromMesh[3]);
    glm::dvec3 size(0.0);
    for (std::size_t t = first; t < soup_.triangles.size(); ++t)
      for (const std::uint32_t v : soup_.triangles[t])
        size = glm::max(size, glm::abs(back * (soup_.positions[v] - offset)));
    for (int row = 0; row < 3; ++row) {
      double sum = several_ ? std::abs(offset[row]) : 0.0;
      for (int column = 0; column < 3; ++column) sum += std::abs(linear[column][row]) * size[column];
      if (std::isfinite(sum)) soup_.rounding = std::max(soup_.rounding, std::ldexp(sum, -24));
    }
  }

  /// The first set of texture coordinates; Draco's are not read.
  std::vector<glm::vec2> texCoords(const GltfPrimitive& primitive, std::size_t vertices,
                                   const std::string& place) {
    if (primitive.texCoords < 0 || primitive.draco != nullptr) {
      ++notes_.withoutUv;
      return {};
    }
    std::vector<glm::vec2> uv = readTexCoords(document_, static_cast<std::size_t>(primitive.texCoords));
    if (uv.size() != vertices) throw GltfError(place, "has not as many texture coordinates as positions");
    return uv;
  }

  /// Where the positions of an accessor begin in the soup; primitives of a mesh often share one.
  std::size_t baseOf(std::size_t accessor, const glm::dmat4& partFromMesh, const std::string& place) {
    const auto it = bases_.find(accessor);
    if (it != bases_.end()) return it->second;
    const std::size_t base = addPositions(readPositions(document_, accessor), partFromMesh, place);
    bases_.emplace(accessor, base);
    return base;
  }

  std::size_t addPositions(const std::vector<glm::dvec3>& positions, const glm::dmat4& partFromMesh,
                           const std::string& place) {
    const std::size_t base = soup_.positions.size();
    if (base + positions.size() > 0xfffffff0u) throw GltfError(place, "a part has more than 2^32 vertices");
    soup_.positions.reserve(base + positions.size());
    const glm::dmat3 linear(partFromMesh);
    const glm::dvec3 offset(partFromMesh[3]);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const glm::dvec3 p = linear * positions[i] + offset;
      if (!nearOrigin(p))
        throw GltfError(place,
                        "position " + std::to_string(i) + " lies farther than 1e9 m from its part's origin");
      soup_.positions.push_back(p);
    }
    return base;
  }

  void addTriangles(const std::string& place, int mode, std::size_t base, std::size_t vertices,
                    const std::vector<std::uint32_t>* indices, bool mirrored, std::uint16_t material,
                    const CornerAttributes& corners) {
    const std::size_t count = indices != nullptr ? indices->size() : vertices;
    if (indices != nullptr)
      for (std::size_t i = 0; i < count; ++i)
        if ((*indices)[i] >= vertices)
          throw GltfError(place + ".indices", "index " + std::to_string((*indices)[i]) + " at " +
                                                  std::to_string(i) + " is out of range (" +
                                                  std::to_string(vertices) + " vertices)");
    if (mode == kTriangles && count % 3 != 0) ++notes_.incompleteTriangles;
    const auto own = [&](std::size_t i) { return indices != nullptr ? std::size_t{(*indices)[i]} : i; };
    const auto vertex = [&](std::size_t i) { return static_cast<std::uint32_t>(base + own(i)); };
    const std::vector<glm::vec2>& uv = corners.uv;
    const std::vector<glm::vec3>& normals = corners.normals;
    if (!uv.empty()) soup_.triangleUv.resize(soup_.triangles.size());
    if (!normals.empty()) soup_.triangleNormal.resize(soup_.triangles.size());
    forEachTriangle(mode, count, [&](std::size_t a, std::size_t b, std::size_t c) {
      if (mirrored) std::swap(b, c);
      soup_.triangles.push_back({vertex(a), vertex(b), vertex(c)});
      if (!uv.empty()) soup_.triangleUv.push_back({uv[own(a)], uv[own(b)], uv[own(c)]});
      if (!normals.empty())
        soup_.triangleNormal.push_back({normals[own(a)], normals[own(b)], normals[own(c)]});
    });
    soup_.triangleMaterial.resize(soup_.triangles.size(), material);
  }

  const GltfDocument& document_;
  GeometryNotes& notes_;
  const bool several_;  // pieces
  const bool moved_;    // any of them
  TriangleSoup soup_;
  std::map<std::size_t, std::size_t> bases_;  // of the mesh being read: accessor to first vertex
};

}  // namespace

std::size_t triangleBound(const GltfDocument& document, std::size_t mesh) {
  std::size_t total = 0;
  for (const GltfPrimitive& primitive : document.model.meshes[mesh].primitives) {
    // Draco's accessors have no bytes of their own; its decoder checks its counts itself.
    const auto count = [&](int accessor) {
      const auto index = static_cast<std::size_t>(accessor);
      return primitive.draco != nullptr ? document.model.accessors[index].count
                                        : elementCount(document, index);
    };
    const std::size_t vertices = primitive.positions >= 0 ? count(primitive.positions) : 0;
    const std::size_t corners = primitive.indices >= 0 ? count(primitive.indices) : vertices;
    // Positions cost as much memory as triangles, even if no index refers to them.
    total += std::max(primitive.mode == kTriangles ? corners / 3 : corners, vertices / 3) + 1;
  }
  return total;
}

TriangleSoup readGeometry(const GltfDocument& document, const std::vector<MeshPiece>& pieces,
                          GeometryNotes& notes) {
  SoupBuilder builder(document, pieces, notes);
  for (const MeshPiece& piece : pieces) builder.addPiece(piece);
  return builder.finish();
}

}  // namespace tandem::assets
