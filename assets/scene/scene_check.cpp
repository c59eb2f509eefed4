#include "assets/scene/scene_check.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>

#include <glm/geometric.hpp>

#include "assets/scene/field_check.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

constexpr std::size_t kMaxName = 4096;

bool finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool finite(const glm::dvec3& v) { return finite({v.x, v.y, v.z}); }

bool finite(const Bounds& b) { return finite(b.min) && finite(b.max); }

bool nonNegative(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v) && v >= 0.0; });
}

bool printable(const std::string& text) {
  return text.size() <= kMaxName &&
         std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; });
}

Error broken(const std::string& place, const std::string& reason) { return Error{place + ": " + reason}; }

template <typename T>
Status inRange(const T& value, const std::string& place) {
  if (const auto fault = outOfRange(value)) return broken(place + "." + fault->property, fault->reason);
  return {};
}

std::string numbered(const char* what, std::size_t i) {
  return std::string(what) + "[" + std::to_string(i) + "]";
}

Status checkMaterial(const Material& m, std::size_t surfaces, const std::string& place) {
  for (const float c : m.baseColour)
    if (!(c >= 0.0f && c <= 1.0f)) return broken(place, "a colour is not in 0..1");
  if (!(m.metallic >= 0.0f && m.metallic <= 1.0f && m.roughness >= 0.0f && m.roughness <= 1.0f))
    return broken(place, "metallic or roughness is not in 0..1");
  if (Status s = inRange(m, place); !s) return s;
  if (m.surface != kNone && m.surface >= surfaces) return broken(place, "its surface is out of range");
  if (!printable(m.name)) return broken(place, "the name is not printable");
  return {};
}

Status checkSurface(const Surface& s, std::size_t textures, const std::string& place) {
  const SurfaceTexture& t = s.texture;
  if (Status status = inRange(s, place); !status) return status;
  if (s.law > Surface::Law::plastic || t.pattern > SurfaceTexture::Pattern::noise)
    return broken(place, "an unknown law or pattern");
  const bool isImage = t.pattern == SurfaceTexture::Pattern::image;
  if (isImage ? t.image >= textures : t.image != kNoTexture)
    return broken(place, "its texture's image is out of range");
  if (t.pattern > SurfaceTexture::Pattern::image && !(t.wavelength > 0.0))
    return broken(place, "its texture has no wavelength");
  return {};
}

Status checkTexture(const TextureImage& image, const std::string& place) {
  if (image.width == 0 || image.height == 0 || image.width > kMaxTextureSide ||
      image.height > kMaxTextureSide)
    return broken(place, "its size is out of range");
  if (image.texels.size() != std::size_t(image.width) * image.height)
    return broken(place, "it has not as many texels as its size says");
  return {};
}

bool cornersFit(const std::array<std::uint32_t, 3>& corners, std::size_t size) {
  return corners[0] < size && corners[1] < size && corners[2] < size;
}

Status checkTriangles(const Mesh& mesh, std::size_t materials, const std::string& place) {
  const std::size_t count = mesh.triangles.size();
  for (std::size_t t = 0; t < count; ++t) {
    if (!cornersFit(mesh.triangles[t], mesh.positions.size()))
      return broken(place, "a vertex index is out of range");
    if (mesh.triangleMaterial[t] >= materials) return broken(place, "a material index is out of range");
    if (mesh.triangleShell[t] >= mesh.shellCount) return broken(place, "a shell index is out of range");
    for (const std::uint32_t n : mesh.neighbours[t])
      if (n != kNone && n >= count) return broken(place, "a neighbour is out of range");
    for (const std::uint8_t flags : mesh.edgeFlags[t])
      if (flags > 7) return broken(place, "unknown edge flags");
  }
  return {};
}

Status checkMesh(const Mesh& mesh, std::size_t materials, const std::string& place) {
  const std::size_t count = mesh.triangles.size();
  if (mesh.triangleMaterial.size() != count || mesh.neighbours.size() != count ||
      mesh.edgeFlags.size() != count || mesh.triangleShell.size() != count)
    return broken(place, "the arrays of its triangles differ in length");
  if (mesh.shellCount > count) return broken(place, "more shells than triangles");
  if ((!mesh.triangleUv.empty() && mesh.triangleUv.size() != count) ||
      (!mesh.triangleNormal.empty() && mesh.triangleNormal.size() != count))
    return broken(place, "the arrays of its triangles differ in length");
  for (const std::array<glm::vec2, 3>& corners : mesh.triangleUv)
    for (const glm::vec2& uv : corners)
      if (!finite({uv.x, uv.y})) return broken(place, "a texture coordinate is not finite");
  for (const std::array<glm::vec3, 3>& corners : mesh.triangleNormal)
    for (const glm::vec3& normal : corners)
      if (!(std::abs(glm::dot(normal, normal) - 1.0f) < 1e-3f))
        return broken(place, "a normal has not length 1");
  for (const glm::dvec3& p : mesh.positions)
    if (!nearOrigin(p)) return broken(place, "a position lies farther than 1e9 m from its part's origin");
  if (!finite(mesh.bounds) || !std::isfinite(mesh.volume))
    return broken(place, "bounds or volume are not finite");
  return checkTriangles(mesh, materials, place);
}

Status checkShape(const ImplicitShape& shape, std::size_t materials, const std::string& place) {
  if (shape.kind > ImplicitShape::Kind::plane) return broken(place, "a shape of unknown kind");
  if (!isValid(shape.partFromShape)) return broken(place, "a shape's pose is not rigid");
  if (Status s = inRange(shape, place); !s) return s;
  if (shape.material >= materials) return broken(place, "a shape's material is out of range");
  return {};
}

Status checkPart(const Scene& scene, const Part& part, const std::string& place) {
  if (!printable(part.name) || part.name.empty()) return broken(place, "the name is empty or not printable");
  if (part.treeNode != kNone && part.treeNode >= scene.tree.size())
    return broken(place, "treeNode is out of range");
  if (part.mesh != kNone && part.mesh >= scene.meshes.size()) return broken(place, "mesh is out of range");
  if (!isValid(part.worldFromPart)) return broken(place, "the pose is not rigid");
  if (!nearOrigin(part.worldFromPart.position))
    return broken(place, "lies farther than 1e9 m from the origin");
  const MassProperties& m = part.massProperties;
  if (!nonNegative({m.mass}) || !finite(m.centreOfMass) || !finite(m.inertia[0]) || !finite(m.inertia[1]) ||
      !finite(m.inertia[2]))
    return broken(place, "mass properties are not finite");
  if (const auto fault = gravityFactorFault(part.gravityFactor))
    return broken(place + "." + fault->property, fault->reason);
  if (part.contactTolerance != 0.0)
    if (const auto fault = toleranceFault(part.contactTolerance))
      return broken(place + "." + fault->property, fault->reason);
  for (const ImplicitShape& shape : part.shapes)
    if (Status s = checkShape(shape, scene.materials.size(), place); !s) return s;
  return {};
}

Status checkJoint(const Scene& scene, const Joint& joint, const std::string& place) {
  if (!printable(joint.name)) return broken(place, "the name is not printable");
  for (const PartId part : {joint.partA, joint.partB})
    if (part != kNoPart && part >= scene.parts.size()) return broken(place, "a part is out of range");
  if (Status s = inRange(joint, place); !s) return s;
  if (!isValid(joint.aFromJoint) || !isValid(joint.bFromJoint)) return broken(place, "a frame is not rigid");
  for (const JointLimit& l : joint.limits)
    if (l.axes == 0 || l.axes > 7 || !finite({l.min, l.max}) || l.min > l.max ||
        !nonNegative({l.stiffness, l.damping}))
      return broken(place, "a limit is not valid");
  for (const JointDrive& d : joint.drives)
    if (d.axis > 2 || !nonNegative({d.maxForce, d.stiffness, d.damping}) ||
        !finite({d.positionTarget, d.velocityTarget}))
      return broken(place, "a drive is not valid");
  const std::vector<double>& wells = joint.detents.places;
  for (std::size_t i = 1; i < wells.size(); ++i)
    if (!(wells[i] > wells[i - 1])) return broken(place, "its detents do not ascend");
  if (wells.size() == 1 && joint.detents.width == 0.0) return broken(place, "its detent has no width");
  return {};
}

Status checkFeel(const Control& c, const std::string& place) {
  if (Status s = inRange(c, place); !s) return s;
  if (!(c.min < c.max) || c.initial < c.min || c.initial > c.max)
    return broken(place, "its range is not valid");
  if (c.click.drop > 0.0 && c.click.width == 0.0) return broken(place, "its click has no width");
  const std::vector<double>& wells = c.detents.places;
  for (std::size_t i = 0; i < wells.size(); ++i)
    if (!(wells[i] >= c.min && wells[i] <= c.max) || (i > 0 && !(wells[i] > wells[i - 1])))
      return broken(place, "its detents do not ascend between its ends");
  if (wells.size() == 1 && c.detents.width == 0.0 && !c.endless)
    return broken(place, "its detent has no width");
  return {};
}

Status checkControl(const Scene& scene, const Control& c, const std::string& place) {
  if (!printable(c.name)) return broken(place, "the name is not printable");
  if (c.kind > ControlKind::layer) return broken(place, "a control of unknown kind");
  if (c.endless && !turns(c)) return broken(place, "only a dial is endless");
  if (c.part >= scene.parts.size() || !scene.parts[c.part].movable)
    return broken(place, "its part is out of range or cannot move");
  if (!isValid(c.worldFromAxis) || !isValid(c.axisFromPart)) return broken(place, "a frame is not rigid");
  for (const PartId part : c.shows)
    if (part >= scene.parts.size()) return broken(place, "a part that it shows is out of range");
  return checkFeel(c, place);
}

Status checkTree(const Scene& scene) {
  for (std::size_t i = 0; i < scene.tree.size(); ++i) {
    const TreeNode& node = scene.tree[i];
    if (node.parent != kNone && node.parent >= i)
      return broken(numbered("tree", i), "its parent does not stand before it");
    if (!printable(node.name)) return broken(numbered("tree", i), "the name is not printable");
  }
  return {};
}

}  // namespace

Status checkScene(const Scene& scene) {
  if (!printable(scene.name)) return broken("name", "is not printable");
  if (scene.materials.empty() || scene.materials.size() > 0xffff)
    return broken("materials", "none or too many");
  if (scene.parts.size() > kMaxParts) return broken("parts", "too many");
  if (!finite(scene.bounds)) return broken("scene", "bounds are not finite");
  if (const auto fault = gravityFault(scene.gravity))
    return broken("scene." + fault->property, fault->reason);
  for (std::size_t i = 0; i < scene.materials.size(); ++i)
    if (Status s = checkMaterial(scene.materials[i], scene.surfaces.size(), numbered("materials", i)); !s)
      return s;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
    if (Status s = checkSurface(scene.surfaces[i], scene.textures.size(), numbered("surfaces", i)); !s)
      return s;
  for (std::size_t i = 0; i < scene.textures.size(); ++i)
    if (Status s = checkTexture(scene.textures[i], numbered("textures", i)); !s) return s;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i)
    if (Status s = checkMesh(scene.meshes[i], scene.materials.size(), numbered("meshes", i)); !s) return s;
  if (Status s = checkTree(scene); !s) return s;
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    if (Status s = checkPart(scene, scene.parts[i], numbered("parts", i)); !s) return s;
    if (!names.insert(scene.parts[i].name).second) return broken(numbered("parts", i), "its name is taken");
  }
  for (std::size_t i = 0; i < scene.joints.size(); ++i)
    if (Status s = checkJoint(scene, scene.joints[i], numbered("joints", i)); !s) return s;
  if (scene.fields.size() > kMaxForceFields) return broken("fields", "too many");
  for (std::size_t i = 0; i < scene.fields.size(); ++i)
    if (Status s = checkField(scene.fields[i], scene.parts.size(), numbered("fields", i)); !s) return s;
  std::set<PartId> controlled;
  for (std::size_t i = 0; i < scene.controls.size(); ++i) {
    if (Status s = checkControl(scene, scene.controls[i], numbered("controls", i)); !s) return s;
    if (!controlled.insert(scene.controls[i].part).second)
      return broken(numbered("controls", i), "its part has a control already");
  }
  for (std::size_t i = 0; i < scene.findings.size(); ++i) {
    const Finding& f = scene.findings[i];
    if (f.severity > Finding::Severity::error || !printable(f.code) || !printable(f.where) ||
        !printable(f.message))
      return broken(numbered("findings", i), "is not valid");
  }
  return {};
}

}  // namespace tandem::assets
