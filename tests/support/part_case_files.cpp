#include "tests/support/part_case_files.h"

#include <cstdio>

#include "tests/support/gltf_builder.h"

namespace tandem::test {
namespace {

using Json = tests::GltfBuilder::Json;

template <typename Triangles>
int addMesh(tests::GltfBuilder& file, const Triangles& source, const std::string& name) {
  std::vector<float> xyz;
  for (const glm::dvec3& p : source.positions) {
    for (int i = 0; i < 3; ++i) xyz.push_back(static_cast<float>(p[i]));
  }
  std::vector<std::uint32_t> indices;
  for (const auto& t : source.triangles) indices.insert(indices.end(), t.begin(), t.end());
  const int positions = file.addPositions(xyz);
  return file.addMesh(positions, file.addIndices(indices), 4, -1, name);
}

Json vectorOf(const glm::dvec3& v) { return Json::array({v.x, v.y, v.z}); }

Json bodyOf(const assets::Part& part, int node, std::size_t material) {
  Json body = {{"collider", {{"geometry", {{"node", node}}}, {"physicsMaterial", material}}}};
  if (!part.movable) return body;
  const assets::MassProperties& m = part.massProperties;
  body["motion"] = {{"mass", m.mass},
                    {"centerOfMass", vectorOf(m.centreOfMass)},
                    {"inertiaDiagonal", vectorOf({m.inertia[0][0], m.inertia[1][1], m.inertia[2][2]})}};
  return body;
}

}  // namespace

std::vector<unsigned char> glbOf(const PartCase& given) {
  tests::GltfBuilder file;
  Json materials = Json::array();
  for (const assets::Material& m : given.scene.materials) {
    materials.push_back({{"name", m.name},
                         {"staticFriction", m.staticFriction},
                         {"dynamicFriction", m.dynamicFriction},
                         {"restitution", 0}});
  }
  file.json["extensionsUsed"] = Json::array({"KHR_physics_rigid_bodies"});
  file.json["extensions"]["KHR_physics_rigid_bodies"] = {{"physicsMaterials", materials}};
  for (std::size_t i = 0; i < given.scene.parts.size(); ++i) {
    const assets::Part& part = given.scene.parts[i];
    const bool asFiled = i + 1 == given.scene.parts.size() && !given.asFiled.triangles.empty();
    const int mesh = asFiled ? addMesh(file, given.asFiled, part.name)
                             : addMesh(file, given.scene.meshes[part.mesh], part.name);
    const glm::dquat& q = part.worldFromPart.orientation;
    file.addNode({{"name", part.name},
                  {"mesh", mesh},
                  {"translation", vectorOf(part.worldFromPart.position)},
                  {"rotation", {q.x, q.y, q.z, q.w}},
                  {"extensions", {{"KHR_physics_rigid_bodies", bodyOf(part, static_cast<int>(i), i)}}}});
  }
  return file.glb();
}

std::string csvOf(const PartCase& given) {
  std::string text = "t,x,y,z,qw,qx,qy,qz\n";
  const int count = static_cast<int>(1000.0 * given.duration + 0.5);
  for (int i = 0; i < count; ++i) {
    const Pose pose = given.path(1e-3 * i);
    const glm::dvec3& p = pose.position;
    const glm::dquat& q = pose.orientation;
    char line[256];
    std::snprintf(line, sizeof line, "%.3f,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n", 1e-3 * i, p.x, p.y,
                  p.z, q.w, q.x, q.y, q.z);
    text += line;
  }
  return text;
}

}  // namespace tandem::test
