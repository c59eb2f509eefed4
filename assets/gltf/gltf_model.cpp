#include "assets/gltf/gltf_model.h"

#include <algorithm>

#include <tiny_gltf.h>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/gltf_error.h"

namespace tandem::assets {
namespace {

constexpr const char* kSections[] = {"bufferViews", "accessors", "meshes", "nodes", "scenes", "materials"};

void stripObject(Json& object) {
  object.erase("extensions");
  object.erase("extras");
}

/// The part of the document that tinygltf is given. tinygltf checks no index, refuses a file for a broken
/// image, and has no entry for JSON that is already parsed.
std::string sectionsOf(const Json& document) {
  Json out;
  out["asset"]["version"] = "2.0";
  if (document.contains("scene")) out["scene"] = document.at("scene");
  for (const char* section : kSections) {
    if (!document.contains(section)) continue;
    Json& copy = out[section] = document.at(section);
    for (Json& object : copy) stripObject(object);
  }
  if (Json* meshes = out.find("meshes"))
    for (Json& mesh : *meshes)
      for (Json& primitive : mesh["primitives"]) {
        stripObject(primitive);
        primitive.erase("targets");
        // tinygltf refuses index accessors without a buffer view, which are legal where they are sparse or
        // where Draco holds the data. mesh() below reads the indices from the document instead.
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

GltfMesh mesh(const tinygltf::Mesh& from, const Json& stated) {
  GltfMesh to;
  to.name = from.name;
  for (std::size_t i = 0; i < from.primitives.size(); ++i) {
    const tinygltf::Primitive& primitive = from.primitives[i];
    const Json& statedPrimitive = stated.at("primitives").at(i);
    const Json& indices = statedPrimitive.member("indices");
    const Json& draco = findExtension(statedPrimitive, "KHR_draco_mesh_compression");
    to.primitives.push_back({primitive.mode < 0 ? 4 : primitive.mode, attribute(primitive, "POSITION"),
                             attribute(primitive, "NORMAL"), attribute(primitive, "TEXCOORD_0"),
                             indices.isAbsent() ? -1 : static_cast<int>(indices.integer()),
                             primitive.material, draco.isAbsent() ? nullptr : &draco});
  }
  return to;
}

GltfNode node(const tinygltf::Node& from) {
  return {from.name, from.mesh, from.children, from.matrix, from.translation, from.rotation, from.scale};
}

GltfMaterial material(const tinygltf::Material& from) {
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  GltfMaterial to;
  to.name = from.name;
  if (pbr.baseColorFactor.size() == to.baseColour.size())
    std::copy(pbr.baseColorFactor.begin(), pbr.baseColorFactor.end(), to.baseColour.begin());
  to.metallic = pbr.metallicFactor;
  to.roughness = pbr.roughnessFactor;
  return to;
}

}  // namespace

GltfModel readModel(const Json& document) {
  const tinygltf::Model from = parse(sectionsOf(document));
  const Json& meshes = document.member("meshes");
  GltfModel to;
  for (const tinygltf::BufferView& view : from.bufferViews) to.bufferViews.push_back(bufferView(view));
  for (const tinygltf::Accessor& each : from.accessors) to.accessors.push_back(accessor(each));
  for (std::size_t i = 0; i < from.meshes.size(); ++i)
    to.meshes.push_back(mesh(from.meshes[i], meshes.at(i)));
  for (const tinygltf::Node& each : from.nodes) to.nodes.push_back(node(each));
  for (const tinygltf::Scene& scene : from.scenes) to.scenes.push_back(scene.nodes);
  to.defaultScene = from.defaultScene;
  for (const tinygltf::Material& each : from.materials) to.materials.push_back(material(each));
  return to;
}

}  // namespace tandem::assets
