#pragma once

// A 3MF package as lib3mf reads it: objects that are meshes or are put together of other objects, and what
// of them is to be built. Lengths in the file's unit.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/cad_import/cad_scene.h"

namespace tandem::cad_import {

/// An object in its place, within another object or in what is built.
struct ThreeMfPlace {
  std::uint32_t object = kNone;  // into ThreeMfPackage::objects
  glm::dmat4 parentFromObject{1.0};
  std::string name;  // of a place in what is built: its part number
};

struct ThreeMfObject {
  std::string name;                    // or its part number; empty: it has neither
  bool support = false;                // holds the others while they are printed
  CadMesh mesh;                        // without triangles where the object is put together
  std::string material;                // of all triangles alike; else empty
  std::vector<ThreeMfPlace> children;  // may refer to any object, in a circle too
};

struct ThreeMfPackage {
  std::string unit;
  std::vector<ThreeMfObject> objects;
  std::vector<ThreeMfPlace> built;
  std::vector<std::array<float, 4>> colours;  // linear RGBA
  std::size_t unusable = 0;                   // triangles that are left out
  std::size_t warnings = 0;                   // of lib3mf
  std::string firstWarning;
};

/// `progress` is called with the share done, 0..1.
Result<ThreeMfPackage> read3mf(const std::string& path, const std::function<void(double)>& progress);

}  // namespace tandem::cad_import
