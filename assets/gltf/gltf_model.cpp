#include "assets/gltf/gltf_model.h"

#include <algorithm>

#include <tiny_gltf.h>
#include <nlohmann/json.hpp>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/gltf_error.h"

namespace tandem::assets {
namespace {

using nlohmann::json;

constexpr const char* kSections[] = {"bufferViews", "accessors", "meshes", "nodes", "scenes", "materials"};

void stripObject(json& object) {
  object.erase("extensions");
  object.erase("extras");
}

/// The part of the document that tinygltf is given: tinygltf neither checks indices nor passes over a broken image, and it
/// has no entry for JSON that is already parsed.
std::string sectionsOf(const json& document) {
  json out = {{"asset", {{"version", "2.0"}}}};
  for (const char* section : kSections)
    if (const auto it = document.find(section); it != document.end()) out[section] = *it;
  if (const auto it = document.find("scene"); it != document.end()) out["scene"] = *it;
  for (const char* section : kSections)
    if (const auto it = out.find(section); it != out.end())
      for (json& object : *it) stripObject(object);
  if (const auto meshes = out.find("meshes"); meshes != out.end())
    for (json& mesh : *meshes)
      for (json& primitive : mesh["primitives"]) {
        stripObject(primitive);
        primitive.erase("targets");
        // tinygltf refuses index accessors without a buffer view, which are legal where they are sparse or where Draco
        // holds the data; they are taken from the JSON instead.
        primitive.erase("indices");
      }
  return out.dump();
}

tinygltf::Model parse(const std::string& text) {
  tinygltf::TinyGLTF reader;
  tinygltf::Model model;
  std::string error, warning;
  if (reader.LoadASCIIFromString(&model, &error, &warning, text.c_str(),
                                 static_cast<unsigned int>(text.size()), "", tinygltf::NO_REQUIRE))
    return model;
  std::replace(error.begin(), error.end(), '\n', ' ');
  throw GltfError("json", error.empty() ? "tinygltf refuses it" : error);
}

GltfBufferView bufferView(const tinygltf::BufferView& from) {
  return {static_cast<std::size_t>(from.buffer), from.byteOffset, from.byteLength, from.byteStride};
}

GltfAccessor::Type typeOf(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return GltfAccessor::Type::scalar;
    case TINYGLTF_TYPE_VEC2:
      return GltfAccessor::Type::vec2;
    case TINYGLTF_TYPE_VEC3:
      return GltfAccessor::Type::vec3;
    default:
      return GltfAccessor::Type::other;
  }
}

GltfAccessor accessor(const tinygltf::Accessor& from) {
  GltfAccessor to;
  to.bufferView = from.bufferView;
  to.byteOffset = from.byteOffset;
  to.count = from.count;
  to.type = typeOf(from.type);
  to.componentType = from.componentType;
  to.normalized = from.normalized;
  if (!from.sparse.isSparse) return to;
  to.sparse = {true,
               static_cast<std::size_t>(from.sparse.count),
               static_cast<std::size_t>(from.sparse.indices.bufferView),
               static_cast<std::size_t>(from.sparse.indices.byteOffset),
               static_cast<std::size_t>(from.sparse.values.bufferView),
               static_cast<std::size_t>(from.sparse.values.byteOffset),
               from.sparse.indices.componentType};
  return to;
}

int attribute(const tinygltf::Primitive& primitive, const char* name) {
  const auto it = primitive.attributes.find(name);
  return it == primitive.attributes.end() ? -1 : it->second;
}

GltfMesh mesh(const tinygltf::Mesh& from, JsonView view) {
  GltfMesh to;
  to.name = from.name;
  const JsonView primitives = view.member("primitives");
  for (std::size_t i = 0; i < from.primitives.size(); ++i) {
    const tinygltf::Primitive& primitive = from.primitives[i];
    const JsonView indices = primitives.element(i).member("indices");
    to.primitives.push_back({primitive.mode < 0 ? 4 : primitive.mode, attribute(primitive, "POSITION"),
                             attribute(primitive, "TEXCOORD_0"),
                             indices ? static_cast<int>(indices.whole()) : -1, primitive.material,
                             findExtension(primitives.element(i), "KHR_draco_mesh_compression")});
  }
  return to;
}

GltfNode node(const tinygltf::Node& from) {
  return {from.name, from.mesh, from.children, from.matrix, from.translation, from.rotation, from.scale};
}

GltfMaterial material(const tinygltf::Material& from) {
  const tinygltf::PbrMetallicRoughness& look = from.pbrMetallicRoughness;
  GltfMaterial to;
  to.name = from.name;
  if (look.baseColorFactor.size() == to.baseColour.size())
    std::copy(look.baseColorFactor.begin(), look.baseColorFactor.end(), to.baseColour.begin());
  to.metallic = look.metallicFactor;
  to.roughness = look.roughnessFactor;
  return to;
}

}  // namespace

GltfModel readModel(const JsonTree& document) {
  const tinygltf::Model from = parse(sectionsOf(document.library()));
  const JsonView meshes = document.root().member("meshes");
  GltfModel to;
  for (const tinygltf::BufferView& view : from.bufferViews) to.bufferViews.push_back(bufferView(view));
  for (const tinygltf::Accessor& each : from.accessors) to.accessors.push_back(accessor(each));
  for (std::size_t i = 0; i < from.meshes.size(); ++i)
    to.meshes.push_back(mesh(from.meshes[i], meshes.element(i)));
  for (const tinygltf::Node& each : from.nodes) to.nodes.push_back(node(each));
  for (const tinygltf::Scene& scene : from.scenes) to.scenes.push_back(scene.nodes);
  to.defaultScene = from.defaultScene;
  for (const tinygltf::Material& each : from.materials) to.materials.push_back(material(each));
  return to;
}

}  // namespace tandem::assets
