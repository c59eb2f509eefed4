#include "assets/gltf/gltf_geometry.h"

#include <cmath>
#include <map>
#include <optional>

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
  SoupBuilder(const GltfDocument& document, GeometryNotes& notes) : document_(document), notes_(notes) {}

  void addPiece(const MeshPiece& piece) {
    const double determinant = glm::determinant(glm::dmat3(piece.partFromMesh));
    if (determinant == 0.0 || !std::isfinite(determinant)) {
      ++notes_.singularPieces;
      return;
    }
    bases_.clear();
    const std::size_t primitives = document_.model.meshes[piece.mesh].primitives.size();
    for (std::size_t i = 0; i < primitives; ++i) addPrimitive(piece, i, determinant < 0.0);
  }

  TriangleSoup finish() {
    if (!soup_.triangleUv.empty()) soup_.triangleUv.resize(soup_.triangles.size());
    return std::move(soup_);
  }

 private:
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
    if (primitive.draco != nullptr) {
      DracoMesh decoded = decodeDraco(document_, *primitive.draco, place + ".KHR_draco_mesh_compression");
      base = addPositions(decoded.positions, piece.partFromMesh, place);
      vertices = decoded.positions.size();
      indices = std::move(decoded.indices);
      mode = kTriangles;  // Draco converts strips to triangles
    } else {
      if (primitive.positions < 0) return;  // legal, and without geometry
      const auto positions = static_cast<std::size_t>(primitive.positions);
      base = baseOf(positions, piece.partFromMesh, place);
      vertices = elementCount(document_, positions);
      if (primitive.indices >= 0)
        indices = readIndices(document_, static_cast<std::size_t>(primitive.indices));
    }
    const std::vector<glm::vec2> uv =
        piece.textured ? texCoords(primitive, vertices, place) : std::vector<glm::vec2>();
    addTriangles(place, mode, base, vertices, indices ? &*indices : nullptr, mirrored, piece.materials[index],
                 uv);
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
                    const std::vector<glm::vec2>& uv) {
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
    if (!uv.empty()) soup_.triangleUv.resize(soup_.triangles.size());
    forEachTriangle(mode, count, [&](std::size_t a, std::size_t b, std::size_t c) {
      if (mirrored) std::swap(b, c);
      soup_.triangles.push_back({vertex(a), vertex(b), vertex(c)});
      if (!uv.empty()) soup_.triangleUv.push_back({uv[own(a)], uv[own(b)], uv[own(c)]});
    });
    soup_.triangleMaterial.resize(soup_.triangles.size(), material);
  }

  const GltfDocument& document_;
  GeometryNotes& notes_;
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
  SoupBuilder builder(document, notes);
  for (const MeshPiece& piece : pieces) builder.addPiece(piece);
  return builder.finish();
}

}  // namespace tandem::assets
