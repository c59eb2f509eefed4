#include "assets/cad_import/write_glb.h"

#include <algorithm>
#include <cstring>

#include <glm/geometric.hpp>

#include "assets/base/json.h"

namespace tandem::cad_import {
namespace {

constexpr int kFloat = 5126, kUnsignedInt = 5125;
constexpr int kVertices = 34962, kIndices = 34963;
constexpr const char* kKinds[] = {"plane", "cylinder", "cone", "sphere", "torus"};

Json vector(const glm::dvec3& v) { return Json(std::vector<double>{v.x, v.y, v.z}); }

class GlbWriter {
 public:
  std::string write(const CadScene& scene) {
    Json file = Json::object(), asset = Json::object();
    asset["version"] = "2.0";
    asset["generator"] = "tandem-import";
    addFindings(asset, scene);
    file["asset"] = asset;
    addNodes(file, scene);
    if (!scene.colours.empty()) addColours(file, scene);
    addMeshes(file, scene);
    if (!bytes_.empty()) {
      Json buffer = Json::object();
      buffer["byteLength"] = bytes_.size();
      file["accessors"] = accessors_;
      file["bufferViews"] = views_;
      file["buffers"].push(buffer);
    }
    return container(file.dump());
  }

 private:
  static void addFindings(Json& asset, const CadScene& scene) {
    if (scene.findings.empty()) return;
    Json list = Json::array();
    for (const CadFinding& finding : scene.findings)
      list.push({{"code", finding.code}, {"count", finding.count}, {"message", finding.message}});
    asset["extras"]["cad"]["findings"] = std::move(list);
  }

  template <typename T>
  std::size_t add(const std::vector<T>& data, int component, const char* type, std::size_t count,
                  int target) {
    Json view = Json::object(), accessor = Json::object();
    view["buffer"] = 0;
    view["byteOffset"] = bytes_.size();
    view["byteLength"] = data.size() * sizeof(T);
    view["target"] = target;
    accessor["bufferView"] = views_.size();
    accessor["componentType"] = component;
    accessor["count"] = count;
    accessor["type"] = type;
    bytes_.append(reinterpret_cast<const char*>(data.data()), data.size() * sizeof(T));
    views_.push(std::move(view));
    accessors_.push(std::move(accessor));
    return accessors_.size() - 1;
  }

  std::size_t addPositions(const CadMesh& mesh) {
    std::vector<float> values;
    std::array<float, 3> least{}, most{};
    for (const glm::dvec3& p : mesh.positions)
      for (int axis = 0; axis < 3; ++axis) {
        const auto value = static_cast<float>(p[axis]);
        const auto at = static_cast<std::size_t>(axis);
        least[at] = values.size() < 3 ? value : std::min(least[at], value);
        most[at] = values.size() < 3 ? value : std::max(most[at], value);
        values.push_back(value);
      }
    const std::size_t accessor = add(values, kFloat, "VEC3", mesh.positions.size(), kVertices);
    accessors_.back()["min"] = vector({least[0], least[1], least[2]});
    accessors_.back()["max"] = vector({most[0], most[1], most[2]});
    return accessor;
  }

  std::size_t addNormals(const CadMesh& mesh) {
    std::vector<float> values;
    for (const glm::vec3& n : mesh.normals)
      for (int axis = 0; axis < 3; ++axis) values.push_back(n[axis]);
    return add(values, kFloat, "VEC3", mesh.normals.size(), kVertices);
  }

  void addMeshes(Json& file, const CadScene& scene) {
    for (const CadMesh& mesh : scene.meshes) {
      Json attributes = Json::object(), out = Json::object();
      attributes["POSITION"] = addPositions(mesh);
      if (!mesh.normals.empty()) attributes["NORMAL"] = addNormals(mesh);
      if (!mesh.name.empty()) out["name"] = mesh.name;
      for (const CadTriangles& triangles : mesh.triangles) {
        if (triangles.corners.empty()) continue;
        Json primitive = Json::object();
        primitive["attributes"] = attributes;
        primitive["indices"] =
            add(triangles.corners, kUnsignedInt, "SCALAR", triangles.corners.size(), kIndices);
        if (triangles.colour < scene.colours.size()) primitive["material"] = triangles.colour;
        out["primitives"].push(primitive);
      }
      if (!mesh.faces.empty()) out["extras"]["cad"]["faces"] = facesOf(mesh);
      file["meshes"].push(out);
    }
  }

  static Json facesOf(const CadMesh& mesh) {
    Json faces = Json::array();
    for (const ExactFace& face : mesh.faces) {
      using Kind = ExactFace::Kind;
      Json out = Json::object();
      out["kind"] = kKinds[static_cast<std::size_t>(face.kind)];
      out["point"] = vector(face.point);
      if (face.kind != Kind::sphere) out["axis"] = vector(face.axis);
      if (face.kind != Kind::plane) {
        out["radius"] = face.radius;
        out["hollow"] = face.hollow;
        out["turn"] = face.turn;
      }
      if (face.kind == Kind::torus) out["minorRadius"] = face.minorRadius;
      if (face.kind == Kind::cone) out["halfAngle"] = face.halfAngle;
      if (face.kind == Kind::cylinder || face.kind == Kind::cone) {
        out["from"] = face.from;
        out["to"] = face.to;
      }
      faces.push(out);
    }
    return faces;
  }

  static void addColours(Json& file, const CadScene& scene) {
    for (const std::array<float, 4>& colour : scene.colours) {
      Json look = Json::object(), material = Json::object();
      std::vector<double> components;
      for (const float c : colour) components.push_back(std::clamp(static_cast<double>(c), 0.0, 1.0));
      look["baseColorFactor"] = Json(components);
      look["metallicFactor"] = 0.0;
      look["roughnessFactor"] = 0.7;
      material["pbrMetallicRoughness"] = look;
      if (colour[3] < 1.0f) material["alphaMode"] = "BLEND";
      file["materials"].push(material);
    }
  }

  static Json nodeOf(const CadNode& node) {
    Json out = Json::object();
    if (!node.name.empty()) out["name"] = node.name;
    if (node.parentFromNode != glm::dmat4(1.0)) {
      std::vector<double> matrix;
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) matrix.push_back(node.parentFromNode[c][r]);
      out["matrix"] = Json(matrix);
    }
    if (node.mesh != kNone) out["mesh"] = node.mesh;
    Json cad = Json::object();
    if (!node.material.empty()) cad["material"] = node.material;
    if (node.density > 0.0) cad["density"] = node.density;
    if (!node.tolerances.empty()) cad["tolerances"] = Json(node.tolerances);
    if (!cad.members().empty()) out["extras"]["cad"] = cad;
    return out;
  }

  static void addNodes(Json& file, const CadScene& scene) {
    Json nodes = Json::array(), root = Json::object();
    if (!scene.name.empty()) root["name"] = scene.name;
    for (const CadNode& node : scene.nodes) nodes.push(nodeOf(node));
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
      const std::uint32_t parent = scene.nodes[i].parent;
      (parent == kNone ? root["nodes"] : (nodes.begin() + parent)->operator[]("children")).push(Json(i));
    }
    file["scene"] = 0;
    file["scenes"].push(root);
    if (nodes.size() > 0) file["nodes"] = nodes;
  }

  static void append(std::string& out, std::uint32_t value) {
    for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
  }

  std::string container(std::string json) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    bytes_.resize((bytes_.size() + 3) / 4 * 4, '\0');
    const std::size_t binary = bytes_.empty() ? 0 : 8 + bytes_.size();
    std::string out = "glTF";
    append(out, 2);
    append(out, static_cast<std::uint32_t>(12 + 8 + json.size() + binary));
    append(out, static_cast<std::uint32_t>(json.size()));
    out += "JSON" + json;
    if (binary == 0) return out;
    append(out, static_cast<std::uint32_t>(bytes_.size()));
    out.append("BIN\0", 4);
    return out + bytes_;
  }

  std::string bytes_;
  Json accessors_ = Json::array(), views_ = Json::array();
};

}  // namespace

std::string toGlb(const CadScene& scene) { return GlbWriter().write(scene); }

}  // namespace tandem::cad_import
