#include "assets/gltf/load_gltf.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "assets/base/affine.h"
#include "assets/base/parallel.h"
#include "assets/gltf/foreign_file.h"
#include "assets/gltf/gltf_cad.h"
#include "assets/gltf/gltf_controls.h"
#include "assets/gltf/gltf_decode.h"
#include "assets/gltf/gltf_fields.h"
#include "assets/gltf/gltf_json.h"
#include "assets/gltf/gltf_loader.h"
#include "assets/gltf/gltf_parts.h"
#include "assets/gltf/gltf_surface.h"
#include "assets/gltf/part_mass.h"
#include "assets/mesh/mesh_analysis.h"
#include "assets/scene/field_check.h"
#include "assets/scene/near_names.h"
#include "assets/scene/stated_tolerances.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

// Extensions that may be in extensionsRequired. Textures are not drawn, so extensions that concern only
// textures can be ignored.
constexpr const char* kKnownExtensions[] = {
    "KHR_physics_rigid_bodies",   "KHR_implicit_shapes",     "OMI_physics_shape",
    "OMI_physics_body",           "OMI_physics_joint",       "OMI_physics_gravity",
    "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization",
    "KHR_texture_transform",      "KHR_texture_basisu",      "EXT_texture_webp",
};

bool isKnown(const std::string& extension) {
  return std::find(std::begin(kKnownExtensions), std::end(kKnownExtensions), extension) !=
         std::end(kKnownExtensions);
}

constexpr std::size_t kMostTolerances = 2000;  // of a scene, that are shown
constexpr std::size_t kBeginning = 4096;       // bytes of a file, by which it is told what it is

/// The mesh of one distinct geometry while it is being built.
struct Analysed {
  MeshAnalysis analysis;
  GeometryNotes notes;
  bool hasTriangles = false;
  RoundFaces rounds;                   // exact cylinders that the file states
  RoundedMesh rounded;                 // without its soup
  std::uint64_t damagedCylinders = 0;  // of the file
  MassProperties solid;                // at LoadOptions::density; only filled where a movable part uses it
};

/// Whether a mesh whose facets were cut has no defect that it did not have before.
bool isAsSound(const MeshAnalysis& cut, const Mesh& before) {
  const MeshDefects& d = cut.defects;
  return d.duplicateVertices + d.degenerateFaces + d.duplicateFaces + d.flippedFaces + d.tJunctions +
                 d.invertedShells ==
             0 &&
         cut.mesh.closed == before.closed && cut.mesh.shellCount == before.shellCount;
}

class SceneBuilder {
 public:
  SceneBuilder(const GltfDocument& document, const LoadOptions& options)
      : document_(document),
        options_(options),
        physics_(readPhysics(document)),
        plan_(planParts(document, physics_, options.unitScale, options.maxTriangles)) {}

  Scene build() {
    checkMovableNames();
    readMeshes();
    scene_.gravity =
        options_.gravity == glm::dvec3(0.0) ? physics_.gravity.value_or(glm::dvec3(0.0)) : options_.gravity;
    scene_.materials = std::move(plan_.materials);
    addSurfaces();
    addTree();
    addParts();
    addJoints();
    addFields();
    addControls();
    addFindings();
    if (scene_.parts.empty()) throw GltfError("scene", "holds no triangles and no colliders");
    return std::move(scene_);
  }

 private:
  bool wantsMovable(const PartPlan& part) const {
    if (part.motion) return true;
    if (options_.allMovable && part.geometry != kNone) return true;
    return std::find(options_.movable.begin(), options_.movable.end(), part.name) != options_.movable.end();
  }

  void checkMovableNames() const {
    for (const std::string& name : options_.movable) {
      const auto named = [&](const PartPlan& part) { return part.name == name; };
      if (std::any_of(plan_.parts.begin(), plan_.parts.end(), named)) continue;
      std::vector<std::string> names;
      for (const PartPlan& part : plan_.parts) names.push_back(part.name);
      throw GltfError("movable", "there is no part '" + name + "'" + nearNames(name, names));
    }
  }

  void readMeshes() {
    meshes_.resize(plan_.geometries.size());
    std::vector<bool> needsMass(meshes_.size(), false);
    for (const PartPlan& part : plan_.parts)
      if (part.geometry != kNone && wantsMovable(part)) needsMass[part.geometry] = true;
    planRounds(needsMass);
    // The largest mesh comes first, so that no core begins it last.
    std::vector<std::size_t> order(meshes_.size()), size(meshes_.size(), 0);
    for (std::size_t i = 0; i < order.size(); ++i) {
      order[i] = i;
      for (const MeshPiece& piece : plan_.geometries[i]) size[i] += triangleBound(document_, piece.mesh);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
    const auto work = [&](std::size_t i) {
      const std::size_t g = order[i];
      TriangleSoup soup = readGeometry(document_, plan_.geometries[g], meshes_[g].notes);
      if (soup.triangles.empty()) return;
      if (!options_.normals) soup.triangleNormal.clear();
      const double rounding = soup.rounding;
      meshes_[g].analysis = analyseMesh(std::move(soup), options_.creaseAngle);
      cutRounds(meshes_[g], rounding);
      meshes_[g].hasTriangles = !meshes_[g].analysis.mesh.triangles.empty();
      if (needsMass[g] && meshes_[g].hasTriangles)
        meshes_[g].solid = massProperties(meshes_[g].analysis.mesh, options_.density);
    };
    parallelFor(order.size(), work, [&](std::size_t i) {
      if (options_.progress)
        options_.progress(0.1 + 0.85 * double(i) / double(order.size()), "reading meshes");
    });
  }

  /// Reads the exact cylinders of the file, of which those of fits are felt in place of their facets.
  void planRounds(const std::vector<bool>& movable) {
    const bool any = std::find(movable.begin(), movable.end(), true) != movable.end();
    if (!any || !options_.normals) return;
    std::vector<RoundFaces> rounds(meshes_.size());
    for (std::size_t g = 0; g < meshes_.size(); ++g) {
      rounds[g] = readRoundFaces(document_, plan_.geometries[g], meshes_[g].damagedCylinders);
      rounds[g].movable = movable[g];
    }
    planFits(rounds);
    for (std::size_t g = 0; g < meshes_.size(); ++g) meshes_[g].rounds = std::move(rounds[g]);
  }

  void cutRounds(Analysed& mesh, double rounding) const {
    if (mesh.rounds.faces.empty()) return;
    mesh.rounded = roundFaces(mesh.analysis.mesh, mesh.rounds, rounding);
    TriangleSoup soup = std::move(mesh.rounded.soup);
    mesh.rounded.soup = {};
    if (soup.triangles.empty()) return;
    MeshAnalysis cut = analyseMesh(std::move(soup), options_.creaseAngle);
    if (isAsSound(cut, mesh.analysis.mesh)) {
      mesh.analysis.mesh = std::move(cut.mesh);
    } else {
      mesh.rounded.felt = mesh.rounded.equal = 0;
    }
  }

  void addSurfaces() {
    std::uint64_t unread = 0;
    scene_.surfaces = std::move(plan_.surfaces);
    scene_.textures = readTextures(document_, scene_.surfaces, unread);
    addFinding(Finding::Severity::warning, "unread-texture", "", unread,
               "Haptic textures are not PNG or JPEG inside the file; the surfaces are smooth.");
  }

  void addTree() {
    for (const FlatNode& flat : plan_.nodes) {
      const GltfNode& node = document_.model.nodes[flat.gltfNode];
      std::string name = node.name;
      if (name.empty() && node.mesh >= 0)
        name = document_.model.meshes[static_cast<std::size_t>(node.mesh)].name;
      scene_.tree.push_back({cleanText(std::move(name)), flat.parent});
    }
  }

  void addParts() {
    std::vector<std::uint32_t> meshOf(meshes_.size(), kNone);
    partIds_.assign(plan_.parts.size(), kNoPart);
    whereOf_.resize(meshes_.size());
    // A vector that grows copies its meshes: glm's vectors do not promise to move without throwing.
    scene_.meshes.reserve(meshes_.size());
    for (std::size_t i = 0; i < plan_.parts.size(); ++i) {
      const PartPlan& plan = plan_.parts[i];
      if (plan.geometry != kNone && whereOf_[plan.geometry].empty()) whereOf_[plan.geometry] = plan.name;
      const bool hasMesh = plan.geometry != kNone && meshes_[plan.geometry].hasTriangles;
      if (!hasMesh && plan.shapes.empty()) {
        addFinding(Finding::Severity::warning, "empty-part", plan.name, 1,
                   "Has no triangles and no colliders; left out.");
        continue;
      }
      Part part;
      part.name = plan.name;
      part.treeNode = plan.flatNode;
      part.shapes = plan.shapes;
      part.worldFromPart = plan.worldFromPart;
      if (plan.filter) part.filter = physics_.filters[*plan.filter];
      part.contactTolerance = plan.contactTolerance;
      if (hasMesh) part.mesh = placeMesh(plan.geometry, meshOf);
      setMass(plan, part);
      growBounds(part);
      partIds_[i] = static_cast<PartId>(scene_.parts.size());
      scene_.parts.push_back(std::move(part));
    }
  }

  std::uint32_t placeMesh(std::uint32_t geometry, std::vector<std::uint32_t>& meshOf) {
    if (meshOf[geometry] == kNone) {
      meshOf[geometry] = static_cast<std::uint32_t>(scene_.meshes.size());
      scene_.meshes.push_back(std::move(meshes_[geometry].analysis.mesh));
    }
    return meshOf[geometry];
  }

  void setMass(const PartPlan& plan, Part& part) {
    if (!wantsMovable(plan)) return;
    MassProperties computed = part.shapes.empty() || part.mesh != kNone
                                  ? meshes_[plan.geometry].solid
                                  : shapesMass(part.shapes, options_.density);
    if (plan.density > 0.0) {  // instances of one mesh may be of different materials
      computed.mass *= plan.density / options_.density;
      computed.inertia *= plan.density / options_.density;
    }
    part.kinematic = plan.motion && (plan.motion->kinematic || plan.motion->mass == 0.0);
    part.gravityFactor = plan.motion ? plan.motion->gravityFactor : 1.0;
    const std::optional<MassProperties> mass =
        plan.motion ? statedMass(*plan.motion, computed, options_.unitScale) : usableMass(computed);
    part.movable = mass.has_value() || part.kinematic;
    if (mass) part.massProperties = *mass;
    if (!part.movable)
      addFinding(Finding::Severity::error, "no-mass", plan.name, 1,
                 "Has no volume to take a mass from and stays fixed.");
  }

  void growBounds(const Part& part) {
    const auto grow = [&](const Bounds& box) {
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point((corner & 1) != 0 ? box.max.x : box.min.x,
                               (corner & 2) != 0 ? box.max.y : box.min.y,
                               (corner & 4) != 0 ? box.max.z : box.min.z);
        const glm::dvec3 inWorld = transformPoint(part.worldFromPart, point);
        if (!nearOrigin(inWorld))
          throw GltfError("nodes", "part '" + part.name + "' lies farther than 1e9 m from the origin");
        scene_.bounds.include(inWorld);
      }
    };
    if (!nearOrigin(part.worldFromPart.position))
      throw GltfError("nodes", "part '" + part.name + "' lies farther than 1e9 m from the origin");
    if (part.mesh != kNone) grow(scene_.meshes[part.mesh].bounds);
    for (const ImplicitShape& shape : part.shapes) grow(shapeBounds(shape));
  }

  // --- joints

  /// The part that a node moves with and the node's frame in it; kNoPart and the frame in the world if it
  /// does not move.
  std::pair<PartId, Pose> anchor(std::uint32_t flat, const std::string& place) const {
    const std::optional<RigidSplit> split = splitRigid(plan_.nodes[flat].worldFromNode);
    if (!split) throw GltfError(place, "a joint's node is scaled to zero");
    const std::uint32_t planned = plan_.partOfNode[flat];
    const PartId part = planned == kNone ? kNoPart : partIds_[planned];
    if (part == kNoPart || !scene_.parts[part].movable) return {kNoPart, split->rigid};
    return {part, inverse(scene_.parts[part].worldFromPart) * split->rigid};
  }

  void addJoints() {
    std::map<std::size_t, std::uint32_t> flatOf;
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i) flatOf[plan_.nodes[i].gltfNode] = i;
    for (std::uint32_t i = 0; i < plan_.nodes.size(); ++i) {
      const auto& use = physics_.nodes[plan_.nodes[i].gltfNode].joint;
      if (!use) continue;
      const std::string place = placeName("nodes", plan_.nodes[i].gltfNode, "joint");
      const auto other = flatOf.find(use->connectedNode);
      if (other == flatOf.end()) throw GltfError(place + ".connectedNode", "does not belong to the scene");
      Joint joint;
      joint.name = scene_.tree[i].name;
      std::tie(joint.partA, joint.aFromJoint) = anchor(i, place);
      std::tie(joint.partB, joint.bFromJoint) = anchor(other->second, place);
      if (joint.partA == joint.partB) {
        addFinding(Finding::Severity::note, "idle-joint", joint.name, 1,
                   "Joins nothing that moves; left out.");
        continue;
      }
      joint.limits = physics_.joints[use->joint].limits;
      joint.drives = physics_.joints[use->joint].drives;
      joint.pitch = physics_.joints[use->joint].pitch;
      joint.detents = physics_.joints[use->joint].detents;
      joint.detentsTurn = physics_.joints[use->joint].detentsTurn;
      joint.collide = use->collide;
      scaleJoint(joint);
      refuseFault(outOfRange(joint), place);
      scene_.joints.push_back(std::move(joint));
    }
  }

  void addControls() {
    std::vector<PartId> partOfNode(plan_.nodes.size(), kNoPart);
    for (std::size_t i = 0; i < plan_.parts.size(); ++i) partOfNode[plan_.parts[i].flatNode] = partIds_[i];
    scene_.controls = readControls(document_, scene_, plan_.nodes, partOfNode, options_.unitScale);
  }

  /// Lengths from file units to m; 1e300 stays "unbounded".
  void scaleJoint(Joint& joint) const {
    const double scale = options_.unitScale;
    for (JointLimit& limit : joint.limits) {
      if (limit.angular) continue;
      if (std::abs(limit.min) < 1e299) limit.min *= scale;
      if (std::abs(limit.max) < 1e299) limit.max *= scale;
    }
    for (JointDrive& drive : joint.drives) {
      if (drive.angular) continue;
      drive.positionTarget *= scale;
      drive.velocityTarget *= scale;
    }
    joint.pitch *= scale;
    if (joint.detentsTurn) return;
    for (double& place : joint.detents.places) place *= scale;
    joint.detents.width *= scale;
  }

  /// A field moves with the part of its node if that part is movable.
  void addFields() {
    for (PlacedField& placed : readFields(document_, plan_.nodes, options_.unitScale)) {
      const std::uint32_t planned = placed.flatNode == kNone ? kNone : plan_.partOfNode[placed.flatNode];
      const PartId part = planned == kNone ? kNoPart : partIds_[planned];
      if (part != kNoPart && scene_.parts[part].movable) {
        placed.field.part = part;
        placed.field.partFromField = inverse(scene_.parts[part].worldFromPart) * placed.field.partFromField;
      }
      const Status fit = checkField(placed.field, scene_.parts.size(), "field");
      if (!fit) throw GltfError(placed.place, fit.error().message);
      scene_.fields.push_back(std::move(placed.field));
    }
  }

  // --- findings

  void addFinding(Finding::Severity severity, const char* code, const std::string& where, std::uint64_t count,
                  const std::string& message) {
    if (count > 0) scene_.findings.push_back({severity, code, where, count, cleanText(message)});
  }

  void addFindings() {
    for (const std::string& name : extensionNames(document_, "extensionsUsed"))
      if (!isKnown(name))
        addFinding(Finding::Severity::note, "unknown-extension", "", 1,
                   "The extension " + name.substr(0, 80) + " is not read.");
    for (Finding& finding : readImportFindings(document_)) scene_.findings.push_back(std::move(finding));
    for (const Finding& finding : physics_.findings) scene_.findings.push_back(finding);
    for (const Finding& finding : plan_.findings) scene_.findings.push_back(finding);
    for (std::size_t i = 0; i < meshes_.size(); ++i) addMeshFindings(meshes_[i], whereOf_[i]);
    addTolerances();
  }

  /// What is stated of a node is its part's, else its group's, unless that says the same of what is below it.
  void addTolerances() {
    std::vector<std::vector<std::string>> stated(plan_.nodes.size());
    std::vector<std::set<std::string>> below(plan_.nodes.size());
    for (std::size_t i = 0; i < stated.size(); ++i) {
      stated[i] = readTolerances(document_, plan_.nodes[i].gltfNode);
      if (const std::uint32_t parent = plan_.nodes[i].parent; parent != kNone)
        below[parent].insert(stated[i].begin(), stated[i].end());
    }
    std::uint64_t leftOut = 0;
    std::set<std::pair<std::string, std::string>> known;
    for (std::size_t i = 0; i < stated.size(); ++i) {
      const std::uint32_t planned = plan_.partOfNode[i];
      const PartId part = planned == kNone ? kNoPart : partIds_[planned];
      const std::string& where = part == kNoPart ? scene_.tree[i].name : scene_.parts[part].name;
      for (const std::string& words : stated[i]) {
        if (part == kNoPart && below[i].contains(words)) continue;
        if (known.size() >= kMostTolerances)
          ++leftOut;
        else if (known.emplace(where, words).second)
          addFinding(Finding::Severity::note, kStatedTolerance, where, 1, words);
      }
    }
    addFinding(Finding::Severity::note, "tolerances-left-out", "", leftOut,
               "Tolerances of the file are too many to be shown.");
  }

  static std::string feltText(const RoundedMesh& rounded) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "Cylinders of fits are felt as the file states them, to %.2g um, not as its facets.",
                  1e6 * rounded.sag);
    return text;
  }

  static std::string roomText(const RoundedMesh& rounded) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "Cylinders of fits without play are given %.2g um of it, so that they turn.",
                  1e6 * rounded.room);
    return text;
  }

  void addMeshFindings(const Analysed& mesh, const std::string& where) {
    using Severity = Finding::Severity;
    const MeshDefects& d = mesh.analysis.defects;
    addFinding(Severity::note, "exact-fits", where, mesh.rounded.felt, feltText(mesh.rounded));
    addFinding(Severity::note, "equal-fits", where, mesh.rounded.equal, roomText(mesh.rounded));
    addFinding(
        Severity::warning, "unbelieved-cylinders", where, mesh.rounded.unbelieved + mesh.damagedCylinders,
        "Exact cylinders of extras.cad are damaged or do not lie on their facets; the facets are felt.");
    addFinding(Severity::note, "points-and-lines", where, mesh.notes.pointsAndLines,
               "Primitives of points or lines are not felt.");
    addFinding(Severity::warning, "incomplete-triangles", where, mesh.notes.incompleteTriangles,
               "Primitives end in the middle of a triangle.");
    addFinding(Severity::warning, "flattened-mesh", where, mesh.notes.singularPieces,
               "Meshes are scaled to zero thickness and left out.");
    addFinding(Severity::warning, "no-texture-coordinates", where, mesh.notes.withoutUv,
               "Primitives with a haptic image have no texture coordinates and are smooth.");
    addFinding(Severity::note, "duplicate-vertices", where, d.duplicateVertices,
               "Vertices at one place are welded.");
    addFinding(Severity::note, "t-junctions", where, d.tJunctions,
               "Vertices on an edge of another triangle are welded into it.");
    addFinding(Severity::note, "unused-vertices", where, d.unusedVertices,
               "Vertices of no triangle are dropped.");
    addFinding(Severity::warning, "degenerate-faces", where, d.degenerateFaces,
               "Triangles without area are dropped.");
    addFinding(Severity::warning, "duplicate-faces", where, d.duplicateFaces,
               "Triangles that lie twice are dropped.");
    addFinding(Severity::warning, "flipped-faces", where, d.flippedFaces,
               "Triangles facing against their neighbours are turned.");
    addFinding(Severity::warning, "inverted-shells", where, d.invertedShells,
               "Closed shells that were inside out are turned.");
    addFinding(Severity::warning, "open-shells", where, d.openShells,
               "Shells are not closed and have no inside.");
    addFinding(Severity::warning, "boundary-edges", where, d.boundaryEdges,
               "Edges have a triangle on one side only.");
    addFinding(Severity::warning, "non-manifold-edges", where, d.nonManifoldEdges,
               "Edges have more than two triangles.");
    addFinding(Severity::warning, "non-orientable-shells", where, d.nonOrientableShells,
               "Shells have no consistent outside.");
  }

  const GltfDocument& document_;
  const LoadOptions& options_;
  GltfPhysics physics_;
  ScenePlan plan_;
  Scene scene_;
  std::vector<Analysed> meshes_;      // one a ScenePlan::geometries
  std::vector<std::string> whereOf_;  // the first part that uses the geometry
  std::vector<PartId> partIds_;       // of each planned part; kNoPart if it came out empty
};

void refuseUnknownRequired(const GltfDocument& document) {
  for (const std::string& name : extensionNames(document, "extensionsRequired"))
    if (!isKnown(name))
      throw GltfError("extensionsRequired", "the extension " + name.substr(0, 80) + " is not supported");
}

void checkOptions(const LoadOptions& options) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  if (!positive(options.unitScale) || options.unitScale > 1e6 || options.unitScale < 1e-9)
    throw GltfError("options", "the unit scale must lie between 1e-9 and 1e6");
  if (!positive(options.density)) throw GltfError("options", "the density must be positive");
  if (!positive(options.creaseAngle)) throw GltfError("options", "the crease angle must be positive");
  const glm::dvec3& g = options.gravity;
  if (!std::isfinite(g.x) || !std::isfinite(g.y) || !std::isfinite(g.z))
    throw GltfError("options", "gravity must be finite");
}

/// Messages quote the file, whose text may contain line breaks.
Error oneLine(std::string message) {
  std::replace_if(
      message.begin(), message.end(), [](unsigned char c) { return c < 32 || c == 127; }, '_');
  return Error{std::move(message)};
}

}  // namespace

void openFromDisk(const std::string& path, const LoadOptions& options, GltfDocument& document) {
  const std::string directory = std::filesystem::path(path).parent_path().string();
  const std::string base = directory.empty() ? "." : directory;
  GltfSource file(path, "file");
  const GltfPiece beginning = file.read(0, std::min(file.size(), kBeginning));
  if (const std::optional<std::string> foreign = foreignFile(path, beginning.view()))
    throw GltfError("file", *foreign);
  openGltf(std::move(file), &base, options, document);
}

Scene buildScene(const std::string& name, GltfDocument& document, const LoadOptions& options) {
  checkOptions(options);
  if (options.progress) options.progress(0.05, "reading the file");
  refuseUnknownRequired(document);
  document.model = readModel(document.json);
  decodeMeshoptViews(document);
  Scene scene = SceneBuilder(document, options).build();
  document.requireUnchanged();
  scene.name = cleanText(name);
  if (options.progress) options.progress(1.0, "done");
  return scene;
}

Error describeError(const std::string& name) {
  try {
    throw;
  } catch (const GltfError& e) {
    return oneLine(name + ": " + e.place + ": " + e.reason);
  } catch (const std::bad_alloc&) {
    return Error{name + ": file: needs more memory than there is"};
  } catch (const std::exception& e) {
    return oneLine(name + ": file: cannot be read: " + e.what());
  }
}

Result<double> parseUnits(const std::string& name) {
  static const std::pair<const char*, double> kUnits[] = {
      {"m", 1.0}, {"mm", 0.001}, {"cm", 0.01}, {"inch", 0.0254}, {"foot", 0.3048}};
  for (const auto& [unit, scale] : kUnits)
    if (name == unit) return scale;
  return Error{"units: '" + name + "' is unknown; known are m, mm, cm, inch, foot"};
}

Result<Scene> loadGltf(const std::string& path, const LoadOptions& options) {
  try {
    GltfDocument document;
    openFromDisk(path, options, document);
    return buildScene(std::filesystem::path(path).filename().string(), document, options);
  } catch (...) {
    return describeError(path);
  }
}

Result<Scene> loadGltfFromMemory(const std::string& name, const std::vector<unsigned char>& bytes,
                                 const LoadOptions& options) {
  try {
    GltfDocument document;
    openGltf(GltfSource(bytes), nullptr, options, document);
    return buildScene(name, document, options);
  } catch (...) {
    return describeError(name);
  }
}

}  // namespace tandem::assets
