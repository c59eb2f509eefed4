#pragma once

// A pin of 20 mm in a bore of a block, as a CAD import writes them: coarse facets, and the exact cylinders in
// extras.cad of the meshes.

#include <cstdint>
#include <vector>

#include "assets/base/pose.h"
#include "tests/support/gltf_builder.h"
#include "tests/support/part_meshes.h"

namespace tandem::test {

struct ExactFit {
  double radius = 0.010;  // m, of the pin
  double play = 5e-6;     // m, radial
  double height = 0.004;  // m, of the block
  int segments = 48;      // of both
  bool exact = true;      // the file states the cylinders
  double scale = 1.0;     // metres a unit of the file
  int boreSegments = 0;   // of the bore alone; 0: as the pin
  Pose place{};           // m, of the axis, z of this pose, in the frame of both meshes
};

inline tests::GltfBuilder::Json statedCylinder(const ExactFit& fit, bool hollow, double from, double to) {
  const double unit = 1.0 / fit.scale;
  const glm::dvec3 p = unit * fit.place.position, axis = fit.place.orientation * glm::dvec3(0.0, 0.0, 1.0);
  return {{"kind", "cylinder"},
          {"point", {p.x, p.y, p.z}},
          {"axis", {axis.x, axis.y, axis.z}},
          {"radius", unit * (fit.radius + (hollow ? fit.play : 0.0))},
          {"hollow", hollow},
          {"from", unit * from},
          {"to", unit * to},
          {"turn", 6.283185307179586}};
}

/// Mesh 0 is that of the pin, mesh 1 that of the block. The pin stands out of the bore at both ends, by a
/// fifth of its radius.
inline tests::GltfBuilder exactFitFile(const ExactFit& fit = {}) {
  tests::GltfBuilder file;
  const Facets facets{fit.segments, 1};
  const double out = 0.2 * fit.radius, low = -fit.height - out, unit = 1.0 / fit.scale;
  const auto add = [&](const assets::TriangleSoup& soup, const char* name) {
    std::vector<float> xyz;
    std::vector<std::uint32_t> indices;
    for (const glm::dvec3& p : soup.positions) {
      const glm::dvec3 placed = transformPoint(fit.place, p);
      for (int k = 0; k < 3; ++k) xyz.push_back(static_cast<float>(unit * placed[k]));
    }
    for (const auto& corners : soup.triangles) indices.insert(indices.end(), corners.begin(), corners.end());
    file.addNode({{"mesh", file.addMesh(file.addPositions(xyz), file.addIndices(indices))}, {"name", name}});
  };
  add(moved(pegSoup({fit.radius, fit.height + 2.0 * out, 0.5 * out, facets}), {0.0, 0.0, low}), "pin");
  const Facets bore{fit.boreSegments > 0 ? fit.boreSegments : fit.segments, 1};
  add(boredBlockSoup(
          {fit.radius + fit.play, fit.height, 3.0 * fit.radius, fit.height, 0.0, Fit::within, bore}),
      "block");
  if (!fit.exact) return file;
  auto& meshes = file.json["meshes"];
  // One element in braces is an array to one compiler and a copy of it to another.
  using Json = tests::GltfBuilder::Json;
  meshes[0]["extras"]["cad"]["faces"] = Json::array({statedCylinder(fit, false, low + 0.5 * out, out)});
  meshes[1]["extras"]["cad"]["faces"] = Json::array({statedCylinder(fit, true, -fit.height, 0.0)});
  return file;
}

}  // namespace tandem::test
