#include "assets/cad_import/import_mesh.h"

#include <cmath>
#include <filesystem>
#include <iostream>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include "assets/base/printable.h"
#include "assets/cad_import/length_unit.h"

namespace tandem::cad_import {
namespace {

using Mesh = OpenMesh::TriMesh_ArrayKernelT<>;

/// Corners of the triangles with three different, finite corners in the file's precision.
std::vector<std::uint32_t> soundTriangles(const Mesh& mesh) {
  std::vector<std::uint32_t> corners;
  for (const auto face : mesh.faces()) {
    std::vector<Mesh::VertexHandle> at;
    bool sound = true;
    for (const auto vertex : face.vertices()) {
      for (int axis = 0; axis < 3; ++axis) sound = sound && std::isfinite(mesh.point(vertex)[axis]);
      for (const Mesh::VertexHandle other : at) sound = sound && mesh.point(other) != mesh.point(vertex);
      at.push_back(vertex);
    }
    if (!sound || at.size() != 3) continue;
    for (const Mesh::VertexHandle vertex : at) corners.push_back(static_cast<std::uint32_t>(vertex.idx()));
  }
  return corners;
}

}  // namespace

Result<CadScene> importMesh(const std::string& path, const ImportOptions& options) {
  omerr().disconnect(std::cerr);  // the readers complain at length; the reason that is told is one line
  Mesh read;
  OpenMesh::IO::Options wanted;
  options.progress(0.0, "the file");
  if (!OpenMesh::IO::read_mesh(read, path, wanted)) return Error{"not a mesh that can be read"};
  const std::vector<std::uint32_t> corners = soundTriangles(read);
  if (corners.empty()) return Error{"no triangle in it"};
  CadScene scene;
  scene.unit = options.units;
  scene.metresPerUnit = options.units.empty() ? 1.0 : *metresPerUnit(options.units);
  scene.name = printable(std::filesystem::path(path).stem().string(), 200);
  scene.colours.push_back({0.6f, 0.62f, 0.65f, 1.0f});
  CadMesh mesh;
  mesh.name = scene.name;
  std::vector<std::uint32_t> kept(read.n_vertices(), kNone);  // points that triangles use
  mesh.triangles.push_back({0, {}});
  for (const std::uint32_t corner : corners) {
    if (kept[corner] == kNone) {
      kept[corner] = static_cast<std::uint32_t>(mesh.positions.size());
      const Mesh::Point& p = read.point(Mesh::VertexHandle(static_cast<int>(corner)));
      mesh.positions.push_back(scene.metresPerUnit * glm::dvec3(p[0], p[1], p[2]));
    }
    mesh.triangles.back().corners.push_back(kept[corner]);
  }
  CadNode node;
  node.name = scene.name;
  node.mesh = 0;
  scene.nodes.push_back(node);
  const std::size_t lost = read.n_faces() - corners.size() / 3;
  if (lost > 0)
    scene.findings.push_back(
        {"unusable-triangles", lost, "Triangles without area or without corners are left out."});
  scene.meshes.push_back(std::move(mesh));
  if (const std::string doubt = unitDoubt(scene); !doubt.empty())
    scene.findings.push_back({"unit-doubt", 1, doubt});
  options.progress(1.0, "done");
  return scene;
}

}  // namespace tandem::cad_import
