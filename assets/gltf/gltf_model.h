#pragma once

// The core sections of a glTF file as plain structs, read by tinygltf from JSON that has passed checkRules().
// gltf_model.cpp is the one source that knows tinygltf's model, because its header costs seconds to compile.
// Images, textures, skins, animations and cameras do not describe shape and are left out, so that a broken
// one never keeps a scene from loading. For the loader's sources only.

#include <array>
#include <string>
#include <vector>

#include "assets/base/json.h"

namespace tandem::assets {

/// glTF 2.0, 3.6.2.2.
enum ComponentType : int {
  kComponentByte = 5120,
  kComponentUnsignedByte = 5121,
  kComponentShort = 5122,
  kComponentUnsignedShort = 5123,
  kComponentUnsignedInt = 5125,
  kComponentFloat = 5126,
};

struct GltfBufferView {
  std::size_t buffer = 0, byteOffset = 0, byteLength = 0;
  std::size_t byteStride = 0;  // 0: tightly packed
};

/// The elements of an accessor that differ from its buffer view's, or from zero.
struct GltfSparse {
  bool present = false;
  std::size_t count = 0;
  std::size_t indicesView = 0, indicesOffset = 0, valuesView = 0, valuesOffset = 0;
  int indicesComponentType = 0;
};

struct GltfAccessor {
  enum class Type { scalar, vec2, vec3, other };

  int bufferView = -1;  // -1: none
  std::size_t byteOffset = 0, count = 0;
  Type type = Type::scalar;
  int componentType = 0;  // need not be one of ComponentType
  bool normalized = false;
  GltfSparse sparse;
};

/// Accessors and the material are -1 where the primitive has none.
struct GltfPrimitive {
  int mode = 4;
  int positions = -1, normals = -1, texCoords = -1, indices = -1, material = -1;
  const Json* draco = nullptr;  // KHR_draco_mesh_compression in the document, if it is there
};

struct GltfMesh {
  std::string name;
  std::vector<GltfPrimitive> primitives;
};

/// A node has either a matrix or some of the other three; an empty vector stands for an absent one.
struct GltfNode {
  std::string name;
  int mesh = -1;  // -1: none
  std::vector<int> children;
  std::vector<double> matrix;       // 16, column by column
  std::vector<double> translation;  // 3
  std::vector<double> rotation;     // 4, x y z w
  std::vector<double> scale;        // 3
};

struct GltfMaterial {
  std::string name;
  std::array<double, 4> baseColour{1.0, 1.0, 1.0, 1.0};
  double metallic = 1.0, roughness = 1.0;
};

struct GltfModel {
  std::vector<GltfBufferView> bufferViews;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfMesh> meshes;
  std::vector<GltfNode> nodes;
  std::vector<std::vector<int>> scenes;  // the root nodes of each
  int defaultScene = -1;                 // -1: the file names none
  std::vector<GltfMaterial> materials;
};

/// Reads the model with tinygltf; throws GltfError where tinygltf refuses it.
GltfModel readModel(const Json& document);

}  // namespace tandem::assets
