#include "assets/gltf/gltf_model.h"

#include <algorithm>
#include <optional>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/gltf_error.h"

namespace tandem::assets {
namespace {

constexpr std::size_t kMaxStride = 252;
constexpr int kFirstComponentType = 5120, kLastComponentType = 5130;

[[noreturn]] void refuse(std::string reason) {
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  throw GltfError("json", std::move(reason));
}

std::size_t wholeOr(JsonView object, const char* key, std::size_t fallback) {
  const JsonView value = object.member(key);
  return value ? static_cast<std::size_t>(value.whole()) : fallback;
}

/// An index, or -1 where there is none.
int indexIn(JsonView object, const char* key) {
  const JsonView value = object.member(key);
  return value ? static_cast<int>(value.whole()) : -1;
}

std::string textIn(JsonView object, const char* key) {
  const JsonView value = object.member(key);
  return value ? value.text() : std::string();
}

std::vector<int> indicesIn(JsonView object, const char* key) {
  std::vector<int> indices;
  const JsonView value = object.member(key);
  for (std::size_t i = 0; i < value.size(); ++i)
    indices.push_back(static_cast<int>(value.element(i).whole()));
  return indices;
}

/// The numbers of an array; nothing where the value is no array or holds anything else.
std::optional<std::vector<double>> numbersIn(JsonView object, const char* key) {
  const JsonView value = object.member(key);
  if (!value.isArray()) return std::nullopt;
  std::vector<double> numbers;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!value.element(i).isNumber()) return std::nullopt;
    numbers.push_back(value.element(i).number());
  }
  return numbers;
}

GltfBufferView readBufferView(JsonView json) {
  GltfBufferView view;
  view.buffer = wholeOr(json, "buffer", 0);
  view.byteOffset = wholeOr(json, "byteOffset", 0);
  view.byteLength = wholeOr(json, "byteLength", 0);
  view.byteStride = wholeOr(json, "byteStride", 0);
  if (view.byteStride > kMaxStride || view.byteStride % 4 != 0)
    refuse("Invalid `byteStride' value. `byteStride' must be the multiple of 4 : " +
           std::to_string(view.byteStride) + '\n');
  return view;
}

GltfAccessor::Type typeOf(const std::string& name) {
  using Type = GltfAccessor::Type;
  if (name == "SCALAR") return Type::scalar;
  if (name == "VEC2") return Type::vec2;
  if (name == "VEC3") return Type::vec3;
  if (name == "VEC4" || name == "MAT2" || name == "MAT3" || name == "MAT4") return Type::other;
  refuse("Unsupported `type` for accessor object. Got \"" + name + "\"\n");
}

GltfSparse readSparse(JsonView json) {
  GltfSparse sparse;
  if (!json) return sparse;
  const JsonView indices = json.member("indices"), values = json.member("values");
  sparse.present = true;
  sparse.count = wholeOr(json, "count", 0);
  sparse.indicesView = wholeOr(indices, "bufferView", 0);
  sparse.indicesOffset = wholeOr(indices, "byteOffset", 0);
  sparse.indicesComponentType = indexIn(indices, "componentType");
  sparse.valuesView = wholeOr(values, "bufferView", 0);
  sparse.valuesOffset = wholeOr(values, "byteOffset", 0);
  return sparse;
}

GltfAccessor readAccessor(JsonView json) {
  GltfAccessor accessor;
  accessor.bufferView = indexIn(json, "bufferView");
  accessor.byteOffset = wholeOr(json, "byteOffset", 0);
  accessor.count = wholeOr(json, "count", 0);
  accessor.componentType = indexIn(json, "componentType");
  const JsonView normalized = json.member("normalized");
  accessor.normalized = normalized && normalized.flag();
  accessor.type = typeOf(textIn(json, "type"));
  if (accessor.componentType < kFirstComponentType || accessor.componentType > kLastComponentType)
    refuse("Invalid `componentType` in accessor. Got " + std::to_string(accessor.componentType) + '\n');
  accessor.sparse = readSparse(json.member("sparse"));
  return accessor;
}

GltfPrimitive readPrimitive(JsonView json) {
  const JsonView attributes = json.member("attributes");
  GltfPrimitive primitive;
  primitive.mode = static_cast<int>(wholeOr(json, "mode", 4));
  primitive.positions = indexIn(attributes, "POSITION");
  primitive.texCoords = indexIn(attributes, "TEXCOORD_0");
  primitive.indices = indexIn(json, "indices");
  primitive.material = indexIn(json, "material");
  primitive.draco = findExtension(json, "KHR_draco_mesh_compression");
  return primitive;
}

GltfMesh readMesh(JsonView json) {
  GltfMesh mesh;
  mesh.name = textIn(json, "name");
  const JsonView primitives = json.member("primitives");
  for (std::size_t i = 0; i < primitives.size(); ++i)
    mesh.primitives.push_back(readPrimitive(primitives.element(i)));
  return mesh;
}

GltfNode readNode(JsonView json) {
  GltfNode node;
  node.name = textIn(json, "name");
  node.mesh = indexIn(json, "mesh");
  node.children = indicesIn(json, "children");
  node.matrix = numbersIn(json, "matrix").value_or(std::vector<double>());
  if (!node.matrix.empty()) return node;
  node.translation = numbersIn(json, "translation").value_or(std::vector<double>());
  node.rotation = numbersIn(json, "rotation").value_or(std::vector<double>());
  node.scale = numbersIn(json, "scale").value_or(std::vector<double>());
  return node;
}

/// A material's colour is only shown, so that a broken one is passed over.
GltfMaterial readMaterial(JsonView json) {
  GltfMaterial material;
  material.name = textIn(json, "name");
  const auto emissive = numbersIn(json, "emissiveFactor");
  if (emissive && emissive->size() != 3)
    refuse("Array length of `emissiveFactor` parameter in material must be 3, but got " +
           std::to_string(emissive->size()) + '\n');
  const JsonView look = json.member("pbrMetallicRoughness");
  if (const auto colour = numbersIn(look, "baseColorFactor")) {
    if (colour->size() != 4) return material;
    std::copy(colour->begin(), colour->end(), material.baseColour.begin());
  }
  if (const JsonView metallic = look.member("metallicFactor"); metallic.isNumber())
    material.metallic = metallic.number();
  if (const JsonView roughness = look.member("roughnessFactor"); roughness.isNumber())
    material.roughness = roughness.number();
  return material;
}

/// Reads each element of a section.
template <typename T>
std::vector<T> readSection(JsonView document, const char* section, T (*read)(JsonView)) {
  const JsonView list = document.member(section);
  std::vector<T> out;
  out.reserve(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) out.push_back(read(list.element(i)));
  return out;
}

}  // namespace

GltfModel readModel(JsonView document) {
  GltfModel model;
  model.bufferViews = readSection(document, "bufferViews", readBufferView);
  model.accessors = readSection(document, "accessors", readAccessor);
  model.meshes = readSection(document, "meshes", readMesh);
  model.nodes = readSection(document, "nodes", readNode);
  model.scenes = readSection<std::vector<int>>(document, "scenes",
                                               [](JsonView scene) { return indicesIn(scene, "nodes"); });
  model.defaultScene = indexIn(document, "scene");
  model.materials = readSection(document, "materials", readMaterial);
  return model;
}

}  // namespace tandem::assets
