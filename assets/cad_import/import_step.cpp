#include "assets/cad_import/import_step.h"

#include <ctime>
#include <set>

#include <BRep_Tool.hxx>
#include <Poly_Triangulation.hxx>
#include <Standard_Failure.hxx>

#include "assets/cad_import/fit_rings.h"
#include "assets/cad_import/length_unit.h"
#include "assets/cad_import/ring_mesher.h"
#include "assets/cad_import/solid_mesher.h"
#include "assets/cad_import/step_document.h"
#include "assets/cad_import/step_tree.h"

namespace tandem::cad_import {
namespace {

constexpr double kMeshingBegins = 0.85;  // of the progress
constexpr double kMillimetre = 1e-3;     // m

double processorTime() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

struct Unit {
  std::string name;                    // as declared
  double metres = kMillimetre;         // a unit of the file
  double perMillimetre = kMillimetre;  // m for each mm of the document
};

/// The file's unit, or the one that the user states in its place.
Result<Unit> unitOf(const StepDocument& step, const ImportOptions& options) {
  Unit unit;
  const std::set<std::string> declared(step.lengthUnits.begin(), step.lengthUnits.end());
  if (!step.lengthUnits.empty()) unit.name = step.lengthUnits.front();
  const std::optional<double> own = metresPerUnit(unit.name);
  unit.metres = own.value_or(kMillimetre);
  if (options.units.empty()) return unit;
  if (!unit.name.empty() && (!own || declared.size() > 1))
    return Error{"its length unit is " + unit.name + (declared.size() > 1 ? ", among others" : "") +
                 ": --units cannot stand in for it"};
  const std::optional<double> stated = metresPerUnit(options.units);
  unit.perMillimetre = kMillimetre * *stated / unit.metres;
  unit.metres = *stated;
  unit.name = options.units;
  return unit;
}

std::vector<Placement> placementsOf(const StepTree& tree, double metresPerMillimetre) {
  std::vector<glm::dmat4> worldFromNode;
  std::vector<Placement> placements;
  for (const CadNode& node : tree.scene.nodes) {
    worldFromNode.push_back(node.parent == kNone ? node.parentFromNode
                                                 : worldFromNode[node.parent] * node.parentFromNode);
    if (node.mesh == kNone) continue;
    glm::dmat4 map = worldFromNode.back();
    for (int axis = 0; axis < 3; ++axis) map[3][axis] /= metresPerMillimetre;
    placements.push_back({node.mesh, map});
  }
  return placements;
}

/// Lays the facets of all round faces from circle to circle. Returns the fits that are cut alike.
std::size_t layRings(StepTree& tree, const std::vector<double>& deflections, double metresPerMillimetre) {
  std::vector<Ring> rings;
  std::vector<std::vector<RingFace>> faces;
  std::size_t trimmed = 0;
  for (std::uint32_t i = 0; i < tree.bodies.size(); ++i)
    faces.push_back(findRingFaces(tree.bodies[i], i, deflections[i], rings, trimmed));
  const RingAngles chosen = chooseAngles(rings, placementsOf(tree, metresPerMillimetre));
  for (const auto& ofBody : faces)
    for (const RingFace& face : ofBody) layRingFacets(face, chosen.angles[face.ring]);
  if (chosen.unlike > 0)
    tree.scene.findings.push_back(
        {"fits-unlike", chosen.unlike,
         "Shafts in bores whose facets cannot lie alike in all places; they may overlap."});
  if (trimmed > 0)
    tree.scene.findings.push_back(
        {"trimmed-cylinders", trimmed,
         "Round faces with other edges than circles and lines along them; facets of a fit "
         "may overlap there."});
  return chosen.fits;
}

void addMeshes(StepTree& tree, const std::vector<double>& deflections, double metresPerMillimetre,
               const ImportOptions& options) {
  std::size_t lost = 0;
  for (std::size_t i = 0; i < tree.bodies.size(); ++i) {
    options.progress(kMeshingBegins + (1.0 - kMeshingBegins) * static_cast<double>(i) /
                                          static_cast<double>(tree.bodies.size()),
                     "facets");
    tree.scene.meshes.push_back(meshBody(tree.bodies[i], deflections[i], metresPerMillimetre, lost));
  }
  for (CadNode& node : tree.scene.nodes)
    if (node.mesh != kNone && tree.scene.meshes[node.mesh].triangles.empty()) node.mesh = kNone;
  if (lost > 0)
    tree.scene.findings.push_back(
        {"unmeshed-faces", lost, "Faces could not be cut into facets; there are holes."});
}

}  // namespace

Result<CadScene> importStep(const std::string& path, const ImportOptions& options, StepFigures& figures) try {
  const Result<StepDocument> step = readStep(path, options);
  if (!step) return step.error();
  figures.readingTime = processorTime();
  const Result<Unit> unit = unitOf(*step, options);
  if (!unit) return unit.error();
  StepTree tree = buildTree(*step, unit->perMillimetre, options.yUp);
  for (const std::string& file : step->missingFiles)
    tree.scene.findings.push_back({"missing-file", 1, "It names " + file + ", which is not there."});
  if (tree.bodies.empty()) return Error{"no solid and no surface in it"};
  std::vector<double> deflections;
  for (const Body& body : tree.bodies)
    deflections.push_back(deflectionOf(body, options.deflection / unit->perMillimetre));
  figures.fits = layRings(tree, deflections, unit->perMillimetre);
  addMeshes(tree, deflections, unit->perMillimetre, options);
  tree.scene.unit = unit->name;
  tree.scene.metresPerUnit = unit->metres;
  if (const std::string doubt = unitDoubt(tree.scene); !doubt.empty())
    tree.scene.findings.push_back({"unit-doubt", 1, doubt});
  figures.meshingTime = processorTime() - figures.readingTime;
  return std::move(tree.scene);
} catch (const Standard_Failure& failure) {
  return Error{std::string("it cannot be used: ") + failure.DynamicType()->Name()};
}

}  // namespace tandem::cad_import
