#include "assets/cad_import/report.h"

#include <map>

namespace tandem::cad_import {
namespace {

constexpr const char* kKinds[] = {"plane", "cylinder", "cone", "sphere", "torus"};
constexpr std::size_t kMostTolerances = 1000;  // in the report; all stand in the scene

std::string count(const Json& report, const char* what) { return std::to_string(report.at(what).integer()); }

}  // namespace

Json reportOf(const CadScene& scene, const ImportFigures& figures) {
  std::size_t parts = 0, triangles = 0, meshes = 0;
  Json faces = Json::object(), findings = Json::array(), tolerances = Json::array();
  std::map<std::size_t, std::size_t> kinds;
  for (const CadMesh& mesh : scene.meshes) {
    meshes += mesh.triangles.empty() ? 0 : 1;
    for (const CadTriangles& group : mesh.triangles) triangles += group.corners.size() / 3;
    for (const ExactFace& face : mesh.faces) ++kinds[static_cast<std::size_t>(face.kind)];
  }
  for (const auto& [kind, number] : kinds) faces[kKinds[kind]] = number;
  for (const CadNode& node : scene.nodes) {
    parts += node.mesh == kNone ? 0 : 1;
    for (const std::string& said : node.tolerances)
      if (tolerances.size() < kMostTolerances) tolerances.push({{"part", node.name}, {"said", said}});
  }
  for (const CadFinding& finding : scene.findings)
    findings.push({{"code", finding.code}, {"count", finding.count}, {"message", finding.message}});
  return {{"parts", parts},
          {"meshes", meshes},
          {"triangles", triangles},
          {"unit", scene.unit},
          {"fits", figures.fits},
          {"exact_faces", faces},
          {"reading_s", figures.readingTime},
          {"meshing_s", figures.meshingTime},
          {"tolerances", tolerances},
          {"findings", findings}};
}

std::string inWords(const Json& report, const std::string& output) {
  std::string text = output + ": " + count(report, "parts") + " parts of " + count(report, "meshes") +
                     " meshes, " + count(report, "triangles") + " triangles";
  const std::string unit = report.at("unit").text();
  text += unit.empty() ? "\n" : "; unit " + unit + "\n";
  if (report.at("fits").integer() > 0)
    text += count(report, "fits") + " fits of a shaft in a bore are cut alike\n";
  for (const Json& said : report.at("tolerances"))
    text += "tolerance: " + said.at("part").text() + ": " + said.at("said").text() + "\n";
  for (const Json& finding : report.at("findings"))
    text += finding.at("code").text() + " (" + count(finding, "count") +
            "): " + finding.at("message").text() + "\n";
  return text;
}

}  // namespace tandem::cad_import
