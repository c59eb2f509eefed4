#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>
#include <sstream>

#include <tiny_gltf.h>

#include "assets/generate/grey_png.h"
#include "assets/generate/sample_scene.h"
#include "assets/scene/describe.h"

namespace tandem::generate {
namespace {

using Object = tinygltf::Value::Object;
using Array = tinygltf::Value::Array;

/// The value with four digits, as on a data sheet, so that the file holds no noise of the last bits.
double rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return std::strtod(text, nullptr);
}

tinygltf::Value number(double value) { return tinygltf::Value(value); }
tinygltf::Value vector(const glm::dvec3& v) {
  return tinygltf::Value(Array{number(v.x), number(v.y), number(v.z)});
}
tinygltf::Value index(std::size_t i) { return tinygltf::Value(static_cast<int>(i)); }

template <typename T>
int addAccessor(tinygltf::Model& model, const std::vector<T>& data, int componentType, int type, int target) {
  std::vector<unsigned char>& bytes = model.buffers[0].data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = bytes.size();
  view.byteLength = data.size() * sizeof(T);
  view.target = target;
  bytes.resize(view.byteOffset + view.byteLength);
  std::memcpy(bytes.data() + view.byteOffset, data.data(), view.byteLength);
  model.bufferViews.push_back(view);
  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(model.bufferViews.size()) - 1;
  accessor.componentType = componentType;
  accessor.type = type;
  accessor.count =
      data.size() / static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(type)));
  model.accessors.push_back(accessor);
  return static_cast<int>(model.accessors.size()) - 1;
}

void add(Object& object, const char* key, double value) {
  if (value != 0.0) object[key] = number(value);
}

/// Collects the described numbers of a texture that are not their defaults.
struct TextureNumbers {
  std::vector<std::pair<std::string, double>> numbers;

  void number(const std::string& property, double value, const assets::Range&, bool = true) {
    const std::size_t dot = property.find('.');
    if (dot != std::string::npos) numbers.emplace_back(property.substr(dot + 1), value);
  }
  void choice(const char*, const auto&, const auto&) {}
  void whole(const char*, const auto&) {}
};

tinygltf::Value textureValue(const assets::SurfaceTexture& texture) {
  Object value;
  if (texture.pattern == assets::SurfaceTexture::Pattern::image)
    value["image"] = index(texture.image);
  else
    value["function"] =
        tinygltf::Value(std::string(assets::kPatternNames[static_cast<std::size_t>(texture.pattern)]));
  assets::SurfaceTexture relief = texture;
  relief.amplitudeForce = 0.0;  // a relief in N has a short form of its own, which no sample scene uses
  const assets::SurfaceTexture plain;
  TextureNumbers stated, defaults;
  describe(stated, relief);
  describe(defaults, plain);
  for (std::size_t i = 0; i < stated.numbers.size(); ++i)
    if (stated.numbers[i].second != defaults.numbers[i].second)
      value[stated.numbers[i].first] = number(stated.numbers[i].second);
  return tinygltf::Value(value);
}

/// Writes a described record as the properties of extras.haptic. A number without a group is written where it
/// is not its default, a group with all that apply to it where one of them is not.
class RecordWriter {
 public:
  explicit RecordWriter(Object& out) : out_(out) {}

  void number(const std::string& property, double value, const assets::Range&, bool applies = true) {
    const std::size_t dot = property.find('.');
    if (dot == std::string::npos) return add(out_, property.c_str(), value);
    if (applies) put(property, tinygltf::Value(value), value != 0.0);
  }
  void choice(const std::string& property, const auto& value, const auto& names) {
    const auto index = static_cast<std::size_t>(value);
    put(property, tinygltf::Value(std::string(names[index])), index != 0);
  }
  void record(const char* property, const assets::SurfaceTexture& texture) {
    if (texture.pattern != assets::SurfaceTexture::Pattern::none) out_[property] = textureValue(texture);
  }

  void finish() {
    for (const std::string& group : stated_) out_[group] = tinygltf::Value(groups_[group]);
  }

 private:
  void put(const std::string& property, tinygltf::Value value, bool states) {
    const std::size_t dot = property.find('.');
    const std::string group = property.substr(0, dot);
    groups_[group][property.substr(dot + 1)] = std::move(value);
    if (states) stated_.insert(group);
  }

  Object& out_;
  std::map<std::string, Object> groups_;
  std::set<std::string> stated_;
};

/// Adds the properties of extras.haptic of a physics material other than stiffness, damping and friction.
void addSurface(Object& haptic, const assets::Surface& surface) {
  RecordWriter writer(haptic);
  describe(writer, surface);
  writer.finish();
}

void addImages(tinygltf::Model& model, const SampleScene& scene) {
  for (const assets::TextureImage& image : scene.images) {
    std::vector<unsigned char> png = greyPng(image);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = model.buffers[0].data.size();
    view.byteLength = png.size();
    png.resize((png.size() + 3) / 4 * 4);  // what follows starts on a multiple of its own size
    model.buffers[0].data.insert(model.buffers[0].data.end(), png.begin(), png.end());
    tinygltf::Image entry;
    entry.bufferView = static_cast<int>(model.bufferViews.size());
    entry.mimeType = "image/png";
    tinygltf::Texture texture;
    texture.source = static_cast<int>(model.images.size());
    model.bufferViews.push_back(view);
    model.images.push_back(entry);
    model.textures.push_back(texture);
  }
}

void addMaterials(tinygltf::Model& model, const SampleScene& scene) {
  for (const Appearance& appearance : scene.appearances) {
    tinygltf::Material material;
    material.name = appearance.name;
    material.pbrMetallicRoughness.baseColorFactor = {appearance.colour[0], appearance.colour[1],
                                                     appearance.colour[2], 1.0};
    material.pbrMetallicRoughness.metallicFactor = appearance.metallic;
    material.pbrMetallicRoughness.roughnessFactor = appearance.roughness;
    model.materials.push_back(material);
  }
  Array feels;
  for (const Feel& feel : scene.feels) {
    Object haptic{{"stiffness", number(feel.stiffness)}, {"damping", number(feel.damping)}};
    addSurface(haptic, feel.surface);
    feels.emplace_back(Object{{"name", tinygltf::Value(feel.name)},
                              {"staticFriction", number(feel.staticFriction)},
                              {"dynamicFriction", number(feel.dynamicFriction)},
                              {"restitution", number(feel.restitution)},
                              {"extras", tinygltf::Value(Object{{"haptic", tinygltf::Value(haptic)}})}});
  }
  model.extensions["KHR_physics_rigid_bodies"] =
      tinygltf::Value(Object{{"physicsMaterials", tinygltf::Value(feels)}});
  model.extensionsUsed.push_back("KHR_physics_rigid_bodies");
}

/// Maps the image from above, with its middle at the origin and its rows along x.
int addTextureCoordinates(tinygltf::Model& model, double repeat, const assets::Mesh& welded) {
  std::vector<float> uv;
  for (const glm::dvec3& p : welded.positions) {
    uv.push_back(static_cast<float>(0.5 + p.x / repeat));
    uv.push_back(static_cast<float>(0.5 + p.z / repeat));
  }
  return addAccessor(model, uv, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC2,
                     TINYGLTF_TARGET_ARRAY_BUFFER);
}

void addMesh(tinygltf::Model& model, const SampleShape& shape, const assets::Mesh& welded) {
  std::vector<float> positions;
  for (const glm::dvec3& p : welded.positions)
    for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(p[axis]));
  const int positionAccessor = addAccessor(model, positions, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                           TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER);
  for (int axis = 0; axis < 3; ++axis) {  // the bounds must be those of the floats
    model.accessors.back().minValues.push_back(static_cast<float>(welded.bounds.min[axis]));
    model.accessors.back().maxValues.push_back(static_cast<float>(welded.bounds.max[axis]));
  }
  const int uvAccessor = shape.repeat > 0.0 ? addTextureCoordinates(model, shape.repeat, welded) : -1;
  tinygltf::Mesh mesh;
  mesh.name = shape.name;
  for (std::size_t slot = 0; slot < shape.appearances.size(); ++slot) {
    std::vector<std::uint32_t> corners;
    for (std::size_t t = 0; t < welded.triangles.size(); ++t)
      if (welded.triangleMaterial[t] == slot)
        corners.insert(corners.end(), welded.triangles[t].begin(), welded.triangles[t].end());
    tinygltf::Primitive primitive;
    primitive.attributes["POSITION"] = positionAccessor;
    if (uvAccessor >= 0) primitive.attributes["TEXCOORD_0"] = uvAccessor;
    primitive.indices = addAccessor(model, corners, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                                    TINYGLTF_TYPE_SCALAR, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    primitive.material = static_cast<int>(shape.appearances[slot]);
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    mesh.primitives.push_back(primitive);
  }
  model.meshes.push_back(mesh);
}

tinygltf::Value motion(const assets::Mesh& mesh, double density) {
  const assets::MassProperties m = assets::massProperties(mesh, density);
  glm::dvec3 centre(0.0), inertia(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    // All movable shapes are symmetric about their own axis; components across it are rounding errors.
    centre[axis] = std::abs(m.centreOfMass[axis]) < 1e-7 ? 0.0 : rounded(m.centreOfMass[axis]);
    inertia[axis] = rounded(m.inertia[axis][axis]);
  }
  return tinygltf::Value(Object{{"mass", number(rounded(m.mass))},
                                {"centerOfMass", vector(centre)},
                                {"inertiaDiagonal", vector(inertia)}});
}

tinygltf::Value fieldValue(const assets::ForceField& field) {
  Object value{{"kind", tinygltf::Value(std::string(assets::nameOf(field.kind)))},
               {"name", tinygltf::Value(field.name)},
               {"maxForce", number(field.maxForce)},
               {"radius", number(field.radius)}};
  if (field.kind == assets::ForceField::Kind::gravity) {
    value["surfaceForce"] = number(rounded(field.strength / (field.radius * field.radius)));
    return tinygltf::Value(value);
  }
  Array points;
  for (const glm::dvec3& p : field.points) points.push_back(vector(p));
  value["points"] = tinygltf::Value(points);
  value["stiffness"] = number(field.stiffness);
  value["damping"] = number(field.damping.x);
  value["range"] = number(field.range);
  value["fade"] = number(field.fade);
  return tinygltf::Value(value);
}

void addFields(const SamplePart& part, tinygltf::Node& node) {
  if (part.fields.empty()) return;
  Array fields;
  for (const assets::ForceField& field : part.fields) fields.push_back(fieldValue(field));
  node.extras =
      tinygltf::Value(Object{{"haptic", tinygltf::Value(Object{{"field", tinygltf::Value(fields)}})}});
}

tinygltf::Value numbers(const std::vector<double>& values) {
  Array array;
  for (const double v : values) array.push_back(number(v));
  return tinygltf::Value(array);
}

/// extras.haptic.control of a node.
tinygltf::Value controlExtras(const SampleControl& c) {
  Object control{{"kind", tinygltf::Value(c.kind)}, {"axis", vector(c.axis)}};
  if (c.min != c.max) {
    control["min"] = number(c.min);
    control["max"] = number(c.max);
  }
  add(control, "value", c.value);
  add(control, "damping", c.damping);
  add(control, "friction", c.friction);
  if (c.spring > 0.0)
    control["spring"] =
        tinygltf::Value(Object{{"stiffness", number(c.spring)}, {"rest", number(c.springRest)}});
  if (c.clickDrop > 0.0)
    control["click"] = tinygltf::Value(
        Object{{"at", number(c.clickAt)}, {"drop", number(c.clickDrop)}, {"width", number(c.clickWidth)}});
  if (c.detentForce > 0.0) {
    Object detents{{"force", number(c.detentForce)}};
    add(detents, "width", c.detentWidth);
    if (c.detents.empty())
      detents["count"] = index(c.detentCount);
    else
      detents["positions"] = numbers(c.detents);
    control["detents"] = tinygltf::Value(detents);
  }
  if (!c.shows.empty()) {
    Array nodes;
    for (const std::size_t part : c.shows) nodes.push_back(index(part));
    control["shows"] = tinygltf::Value(nodes);
  }
  if (c.instructorOnly) control["roles"] = tinygltf::Value(Array{tinygltf::Value(std::string("instructor"))});
  const Object haptic{{"control", tinygltf::Value(control)}};
  return tinygltf::Value(Object{{"haptic", tinygltf::Value(haptic)}});
}

}  // namespace

std::string toGlb(const SampleScene& scene) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "tandem-scenes";
  model.buffers.emplace_back();
  addMaterials(model, scene);
  addImages(model, scene);
  std::vector<assets::Mesh> meshes;
  for (const SampleShape& shape : scene.shapes) {
    meshes.push_back(assets::analyseMesh(shape.solid.soup(), 0.5).mesh);
    addMesh(model, shape, meshes.back());
  }
  tinygltf::Scene root;
  root.name = scene.name;
  for (const SamplePart& part : scene.parts) {
    const SampleShape& shape = scene.shapes[part.shape];
    tinygltf::Node node;
    node.name = part.name;
    node.mesh = static_cast<int>(part.shape);
    node.translation = {part.position.x, part.position.y, part.position.z};
    const Object geometry{{"node", index(model.nodes.size())}};
    Object body{{"collider", tinygltf::Value(Object{{"geometry", tinygltf::Value(geometry)},
                                                    {"physicsMaterial", index(shape.feel)}})}};
    if (part.movable) body["motion"] = motion(meshes[part.shape], scene.feels[shape.feel].density);
    node.extensions["KHR_physics_rigid_bodies"] = tinygltf::Value(body);
    addFields(part, node);
    if (part.control) node.extras = controlExtras(*part.control);
    root.nodes.push_back(static_cast<int>(model.nodes.size()));
    model.nodes.push_back(node);
  }
  model.scenes.push_back(root);
  model.defaultScene = 0;
  std::ostringstream out;
  tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, out, false, true);
  return out.str();
}

}  // namespace tandem::generate
