#pragma once

// A pin of 20 mm in a bore of a block, as a CAD import writes them: coarse facets, and the exact cylinders in
// extras.cad of the meshes.

#include <cstdint>
#include <vector>

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
};

inline tests::GltfBuilder::Json statedCylinder(double radius, bool hollow, double from, double to) {
  return {{"kind", "cylinder"}, {"point", {0, 0, 0}}, {"axis", {0, 0, 1}}, {"radius", radius},
          {"hollow", hollow},   {"from", from},       {"to", to},          {"turn", 6.283185307179586}};
}

/// Mesh 0 is that of the pin, mesh 1 that of the block. The pin stands 2 mm out of the bore at both ends.
inline tests::GltfBuilder exactFitFile(const ExactFit& fit = {}) {
  tests::GltfBuilder file;
  const Facets facets{fit.segments, 1};
  const double low = -fit.height - 0.002, unit = 1.0 / fit.scale;
  const auto add = [&](const assets::TriangleSoup& soup, const char* name) {
    std::vector<float> xyz;
    std::vector<std::uint32_t> indices;
    for (const glm::dvec3& p : soup.positions)
      for (int k = 0; k < 3; ++k) xyz.push_back(static_cast<float>(unit * p[k]));
    for (const auto& corners : soup.triangles) indices.insert(indices.end(), corners.begin(), corners.end());
    file.addNode({{"mesh", file.addMesh(file.addPositions(xyz), file.addIndices(indices))}, {"name", name}});
  };
  add(moved(pegSoup({fit.radius, fit.height + 0.004, 0.001, facets}), {0.0, 0.0, low}), "pin");
  add(boredBlockSoup({fit.radius + fit.play, fit.height, 0.03, fit.height, 0.0, Fit::within, facets}),
      "block");
  if (!fit.exact) return file;
  auto& meshes = file.json["meshes"];
  // One element in braces is an array to one compiler and a copy of it to another.
  using Json = tests::GltfBuilder::Json;
  meshes[0]["extras"]["cad"]["faces"] =
      Json::array({statedCylinder(unit * fit.radius, false, unit * (low + 0.001), unit * 0.002)});
  meshes[1]["extras"]["cad"]["faces"] =
      Json::array({statedCylinder(unit * (fit.radius + fit.play), true, -unit * fit.height, 0.0)});
  return file;
}

}  // namespace tandem::test
