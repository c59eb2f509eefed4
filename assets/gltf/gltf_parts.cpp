#include "assets/gltf/gltf_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "assets/base/affine.h"
#include "assets/gltf/gltf_json.h"

namespace tandem::assets {
namespace {

constexpr std::size_t kMaxPieces = 1u << 20;
// Instances whose residuals differ by less than the precision of float matrices count as equal.
constexpr double kSameTransform = 1e-6;

/// Appends " #2", " #3" ... to names that are in use.
class UniqueNames {
 public:
  std::string unique(const std::string& wanted) {
    if (taken_.insert(wanted).second) return wanted;
    std::size_t& next = nextSuffix_.try_emplace(wanted, 2).first->second;
    while (true) {
      std::string name = wanted + " #" + std::to_string(next++);
      if (taken_.insert(name).second) return name;
    }
  }

 private:
  std::set<std::string> taken_;
  std::map<std::string, std::size_t> nextSuffix_;
};

/// A colour component, clamped to 0..1.
float unit(double value) {
  return static_cast<float>(std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0.0);
}

/// Scene::materials: each pair of a visual material and a physics surface that is in use.
class MaterialTable {
 public:
  MaterialTable(const GltfDocument& document, std::vector<Material>& out, std::vector<Surface>& surfacesOut)
      : document_(document), out_(out), surfacesOut_(surfacesOut) {}

  std::int64_t surfaceId(const PhysicsSurface& s) {
    const auto [it, isNew] = surfaceIds_.emplace(s, static_cast<std::int64_t>(surfaces_.size()));
    if (isNew) surfaces_.push_back(s);
    return it->second;
  }

  /// Whether the surface needs the mesh's texture coordinates.
  bool textured(std::int64_t surface) const {
    return surface >= 0 && surfaces_[static_cast<std::size_t>(surface)].feel.texture.pattern ==
                               SurfaceTexture::Pattern::image;
  }

  /// Whether the surface itself says how smooth it is.
  bool saysHowSmooth(std::int64_t surface) const {
    return surface >= 0 && surfaces_[static_cast<std::size_t>(surface)].saysHowSmooth;
  }

  std::uint16_t index(int visual, std::int64_t surface) {
    const auto [it, isNew] = indices_.emplace(std::make_pair(visual, surface), out_.size());
    if (isNew) {
      if (out_.size() >= 0xffff) throw GltfError("materials", "more than 65535 pairs of look and feel");
      out_.push_back(make(visual, surface));
    }
    return static_cast<std::uint16_t>(it->second);
  }

 private:
  /// Index into ScenePlan::surfaces; kNone for a surface whose properties all fit in a material.
  std::uint32_t feelIndex(const Surface& feel) {
    if (feel == Surface{}) return kNone;
    const auto [it, isNew] = feels_.emplace(feel, static_cast<std::uint32_t>(surfacesOut_.size()));
    if (isNew) surfacesOut_.push_back(feel);
    return it->second;
  }

  Material make(int visual, std::int64_t surface) {
    Material material;
    if (visual >= 0) {
      const GltfMaterial& from = document_.model.materials[static_cast<std::size_t>(visual)];
      material.name = cleanText(from.name);
      for (std::size_t i = 0; i < 4; ++i) material.baseColour[i] = unit(from.baseColour[i]);
      material.metallic = unit(from.metallic);
      material.roughness = unit(from.roughness);
    }
    if (surface >= 0) {
      const PhysicsSurface& feel = surfaces_[static_cast<std::size_t>(surface)];
      material.stiffness = feel.stiffness;
      material.damping = feel.damping;
      material.staticFriction = feel.staticFriction;
      material.dynamicFriction = feel.dynamicFriction;
      material.restitution = feel.restitution;
      material.surface = feelIndex(feel.feel);
    }
    return material;
  }

  const GltfDocument& document_;
  std::vector<Material>& out_;
  std::vector<Surface>& surfacesOut_;
  std::vector<PhysicsSurface> surfaces_;
  std::map<PhysicsSurface, std::int64_t> surfaceIds_;
  std::map<Surface, std::uint32_t> feels_;
  std::map<std::pair<int, std::int64_t>, std::size_t> indices_;
};

bool sameTransform(const glm::dmat4& a, const glm::dmat4& b) {
  double linear = 0.0, offset = 0.0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) linear = std::max(linear, std::abs(a[c][r]));
  for (int r = 0; r < 3; ++r) offset = std::max(offset, std::abs(a[3][r]));
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (!(std::abs(a[c][r] - b[c][r]) <= kSameTransform * linear)) return false;
  for (int r = 0; r < 3; ++r)
    if (!(std::abs(a[3][r] - b[3][r]) <= kSameTransform * offset)) return false;
  return true;
}

bool samePieces(const std::vector<MeshPiece>& a, const std::vector<MeshPiece>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const MeshPiece& x, const MeshPiece& y) {
    return x.mesh == y.mesh && x.surface == y.surface && sameTransform(x.partFromMesh, y.partFromMesh);
  });
}

class Planner {
 public:
  Planner(const GltfDocument& document, const GltfPhysics& physics, double unitScale)
      : document_(document), physics_(physics), table_(document, plan_.materials, plan_.surfaces) {
    plan_.nodes = flattenNodes(document, unitScale);
  }

  ScenePlan run(std::size_t maxTriangles) {
    flatOf_.assign(document_.model.nodes.size(), kNone);
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i) flatOf_[plan_.nodes[i].gltfNode] = i;
    findParts();
    findSurfaces();
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i) addMesh(i);
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i) addCollider(i);
    shareGeometries(maxTriangles);
    if (plan_.materials.empty()) table_.index(-1, -1);
    addFinding(Finding::Severity::warning, "flattened-node", flattened_,
               "Nodes with meshes or colliders are scaled to zero thickness and left out.");
    addFinding(Finding::Severity::warning, "approximated-shape", approximated_,
               "Primitive colliders are scaled so that they are no longer primitives; sizes are averaged.");
    addFinding(Finding::Severity::note, "collider-mesh-unused", unusedColliderMeshes_,
               "Bodies name another mesh as collider; they are felt by the mesh that is seen.");
    return std::move(plan_);
  }

 private:
  void addFinding(Finding::Severity severity, const char* code, std::uint64_t count, const char* message) {
    if (count > 0) plan_.findings.push_back({severity, code, "", count, message});
  }

  const GltfNode& nodeOf(std::uint32_t flat) const {
    return document_.model.nodes[plan_.nodes[flat].gltfNode];
  }
  const PhysicsNode& physicsOf(std::uint32_t flat) const {
    return physics_.nodes[plan_.nodes[flat].gltfNode];
  }

  /// Whether the node or an ancestor is a body; only bodies gather the geometry of their descendants.
  bool inBody(std::uint32_t part) const { return part != kNone && plan_.parts[part].motion.has_value(); }

  void findParts() {
    plan_.partOfNode.assign(plan_.nodes.size(), kNone);
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i) {
      const FlatNode& flat = plan_.nodes[i];
      const std::uint32_t above = flat.parent == kNone ? kNone : plan_.partOfNode[flat.parent];
      const PhysicsNode& physics = physicsOf(i);
      // CAD states the material of a product, and its solids lie below.
      if (physics.density > 0.0 || flat.parent == kNone)
        densityOf_.push_back(physics.density);
      else
        densityOf_.push_back(densityOf_[flat.parent]);
      const bool touchable = nodeOf(i).mesh >= 0 || physics.collider.has_value();
      const bool isPart = physics.motion.has_value() || (touchable && !inBody(above));
      plan_.partOfNode[i] = isPart ? addPart(i, above) : above;
      const std::uint32_t own = plan_.partOfNode[i];
      if (physics.contactTolerance > 0.0 && own != kNone && (isPart || inBody(own)))
        keepStrictest(plan_.parts[own].contactTolerance, physics.contactTolerance);
    }
  }

  static void keepStrictest(double& tolerance, double other) {
    tolerance = tolerance > 0.0 ? std::min(tolerance, other) : other;
  }

  std::uint32_t addPart(std::uint32_t node, std::uint32_t above) {
    const std::optional<RigidSplit> split = splitRigid(plan_.nodes[node].worldFromNode);
    if (!split) {
      ++flattened_;
      return above;
    }
    if (plan_.parts.size() >= kMaxParts)
      throw GltfError("nodes", "more than " + std::to_string(kMaxParts) + " parts");
    PartPlan part;
    part.name = names_.unique(nameOf(node));
    part.flatNode = node;
    part.worldFromPart = split->rigid;
    part.motion = physicsOf(node).motion;
    part.density = densityOf_[node];
    plan_.parts.push_back(std::move(part));
    return static_cast<std::uint32_t>(plan_.parts.size() - 1);
  }

  std::string nameOf(std::uint32_t flat) const {
    const GltfNode& node = nodeOf(flat);
    std::string name = cleanText(node.name);
    if (name.empty() && node.mesh >= 0)
      name = cleanText(document_.model.meshes[static_cast<std::size_t>(node.mesh)].name);
    return name.empty() ? "part" : name;
  }

  /// The surface that a node states itself: its collider's material, completed by its own extras.haptic.
  std::optional<PhysicsSurface> ownSurface(std::uint32_t flat) const {
    const PhysicsNode& node = physicsOf(flat);
    std::optional<PhysicsSurface> surface;
    if (node.collider && node.collider->surface)
      surface = physics_.surfaces[*node.collider->surface];
    else if (const auto it = surfaceFromOther_.find(plan_.nodes[flat].gltfNode);
             it != surfaceFromOther_.end())
      surface = physics_.surfaces[it->second];
    if (!node.hapticSurface) return surface;
    const PhysicsSurface& haptic = physics_.surfaces[*node.hapticSurface];
    if (!surface) return haptic;
    if (surface->stiffness == 0.0) surface->stiffness = haptic.stiffness;
    if (surface->damping == 0.0) surface->damping = haptic.damping;
    if (surface->feel == Surface{} && !surface->saysHowSmooth) {
      surface->feel = haptic.feel;
      surface->saysHowSmooth = haptic.saysHowSmooth;
    }
    return surface;
  }

  /// surfaceOf_: what each node states, else its parent's within the same part, else its part's first
  /// collider's.
  void findSurfaces() {
    std::vector<std::int64_t> partDefault(plan_.parts.size(), -1);
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i) {
      const auto& collider = physicsOf(i).collider;
      if (collider && collider->node && collider->surface)
        surfaceFromOther_.emplace(*collider->node, *collider->surface);
    }
    surfaceOf_.assign(plan_.nodes.size(), -1);
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i) {
      const std::uint32_t parent = plan_.nodes[i].parent, part = plan_.partOfNode[i];
      if (const auto own = ownSurface(i))
        surfaceOf_[i] = table_.surfaceId(*own);
      else if (parent != kNone && plan_.partOfNode[parent] == part)
        surfaceOf_[i] = surfaceOf_[parent];
      if (part != kNone && partDefault[part] < 0) partDefault[part] = surfaceOf_[i];
    }
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i)
      if (surfaceOf_[i] < 0 && inBody(plan_.partOfNode[i])) surfaceOf_[i] = partDefault[plan_.partOfNode[i]];
  }

  void addPiece(PartPlan& part, std::size_t mesh, const glm::dmat4& partFromMesh, std::int64_t surface) {
    if (++pieceCount_ > kMaxPieces) throw GltfError("nodes", "more than a million placed meshes");
    MeshPiece piece{mesh, partFromMesh, surface, {}};
    for (const auto& primitive : document_.model.meshes[mesh].primitives)
      piece.materials.push_back(table_.index(primitive.material, surface));
    piece.textured = table_.textured(surface);
    piece.normals = !table_.saysHowSmooth(surface);
    part.pieces.push_back(std::move(piece));
  }

  glm::dmat4 partFromNode(const PartPlan& part, std::uint32_t flat) const {
    if (part.flatNode == flat) {
      // Translation is exactly zero, so that equal instances compare equal.
      glm::dmat4 residual(splitRigid(plan_.nodes[flat].worldFromNode).value().residual);
      return residual;
    }
    return toMatrix(inverse(part.worldFromPart)) * plan_.nodes[flat].worldFromNode;
  }

  void addMesh(std::uint32_t flat) {
    const int mesh = nodeOf(flat).mesh;
    const std::uint32_t index = plan_.partOfNode[flat];
    if (mesh < 0 || index == kNone) return;
    PartPlan& part = plan_.parts[index];
    if (part.flatNode != flat && !inBody(index)) return;  // a flattened node below a static part
    addPiece(part, static_cast<std::size_t>(mesh), partFromNode(part, flat), surfaceOf_[flat]);
  }

  void addCollider(std::uint32_t flat) {
    const auto& collider = physicsOf(flat).collider;
    const std::uint32_t index = plan_.partOfNode[flat];
    if (!collider || index == kNone) return;
    PartPlan& part = plan_.parts[index];
    if (part.flatNode != flat && !inBody(index)) return;
    if (!part.filter) part.filter = collider->filter;
    if (collider->shape) return addShape(part, flat, physics_.shapes[*collider->shape].shape);
    addColliderMesh(part, index, flat, *collider);
  }

  /// A collider that is a mesh. It is nearly always the visible mesh, which the part has already; only a part
  /// without a visible mesh gets its geometry from the collider.
  void addColliderMesh(PartPlan& part, std::uint32_t index, std::uint32_t flat,
                       const PhysicsCollider& collider) {
    const bool bare = part.pieces.empty() || bareParts_.count(index) > 0;
    if (!bare) {
      const std::uint32_t other = collider.node ? flatOf_[*collider.node] : kNone;
      const bool isVisual = collider.node ? other != kNone && plan_.partOfNode[other] == index
                                          : nodeOf(flat).mesh == static_cast<int>(*collider.mesh);
      if (!isVisual) ++unusedColliderMeshes_;
      return;
    }
    bareParts_.insert(index);
    const glm::dmat4 partFromCollider = partFromNode(part, flat);
    if (collider.mesh) return addPiece(part, *collider.mesh, partFromCollider, surfaceOf_[flat]);
    for (const SubtreeMesh& below : subtreeMeshes(document_, *collider.node, subtreeBudget_))
      addPiece(part, static_cast<std::size_t>(document_.model.nodes[below.gltfNode].mesh),
               partFromCollider * below.rootFromNode, surfaceOf_[flat]);
  }

  void addShape(PartPlan& part, std::uint32_t flat, ImplicitShape shape) {
    const std::optional<RigidSplit> split = splitRigid(partFromNode(part, flat));
    if (!split) {
      ++flattened_;
      return;
    }
    shape.partFromShape = split->rigid;
    scaleShape(shape, split->residual);
    refuseFault(outOfRange(shape), placeName("nodes", plan_.nodes[flat].gltfNode, "collider"));
    shape.material = table_.index(-1, surfaceOf_[flat]);
    part.shapes.push_back(shape);
  }

  /// Scales a primitive by a symmetric matrix; where the result would not be a primitive, by the mean scale.
  void scaleShape(ImplicitShape& shape, const glm::dmat3& residual) {
    const glm::dvec3 diagonal(std::abs(residual[0][0]), std::abs(residual[1][1]), std::abs(residual[2][2]));
    const double mean = std::cbrt(std::abs(glm::determinant(residual)));
    const double tolerance = 1e-6 * mean;
    const bool sheared =
        std::abs(residual[0][1]) + std::abs(residual[0][2]) + std::abs(residual[1][2]) > tolerance;
    const bool round = std::abs(diagonal.x - diagonal.z) <= tolerance;
    const bool uniform = round && std::abs(diagonal.x - diagonal.y) <= tolerance;
    using Kind = ImplicitShape::Kind;
    const bool exact = shape.kind == Kind::box || shape.kind == Kind::plane ? !sheared
                       : shape.kind == Kind::cylinder                       ? !sheared && round
                                                                            : !sheared && uniform;
    const glm::dvec3 scale = exact ? diagonal : glm::dvec3(mean);
    if (!exact) ++approximated_;
    shape.size *= scale;
    shape.height *= scale.y;
    shape.radiusTop *= scale.x;
    shape.radiusBottom *= scale.x;
  }

  /// Gives parts with the same pieces one geometry.
  void shareGeometries(std::size_t maxTriangles) {
    std::map<std::vector<std::size_t>, std::vector<std::uint32_t>> byMeshes;
    std::size_t triangles = 0;
    for (PartPlan& part : plan_.parts) {
      if (part.pieces.empty()) continue;
      std::vector<std::size_t> key;
      for (const MeshPiece& piece : part.pieces) key.push_back(piece.mesh);
      std::vector<std::uint32_t>& candidates = byMeshes[key];
      for (const std::uint32_t candidate : candidates)
        if (samePieces(plan_.geometries[candidate], part.pieces)) part.geometry = candidate;
      if (part.geometry != kNone) continue;
      for (const MeshPiece& piece : part.pieces) triangles += triangleBound(document_, piece.mesh);
      if (triangles > maxTriangles)
        throw GltfError("meshes", "more than " + std::to_string(maxTriangles) +
                                      " triangles in the scene's distinct meshes");
      part.geometry = static_cast<std::uint32_t>(plan_.geometries.size());
      candidates.push_back(part.geometry);
      plan_.geometries.push_back(part.pieces);
    }
  }

  const GltfDocument& document_;
  const GltfPhysics& physics_;
  ScenePlan plan_;
  MaterialTable table_;
  UniqueNames names_;
  std::vector<std::uint32_t> flatOf_;  // glTF node to flat node
  std::map<std::size_t, std::size_t>
      surfaceFromOther_;                 // glTF node to the surface of a collider that names it
  std::vector<std::int64_t> surfaceOf_;  // flat node to surface id, -1 = none
  std::vector<double> densityOf_;        // flat node to kg/m^3, 0 = none
  std::set<std::uint32_t> bareParts_;    // parts without a mesh of their own
  std::size_t pieceCount_ = 0, subtreeBudget_ = kMaxPieces;
  std::uint64_t flattened_ = 0, approximated_ = 0, unusedColliderMeshes_ = 0;
};

}  // namespace

ScenePlan planParts(const GltfDocument& document, const GltfPhysics& physics, double unitScale,
                    std::size_t maxTriangles) {
  return Planner(document, physics, unitScale).run(maxTriangles);
}

}  // namespace tandem::assets
