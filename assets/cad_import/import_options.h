#pragma once

// What a user may state about a CAD file, and how an import says how far it is.

#include <functional>
#include <string>

namespace tandem::cad_import {

struct ImportOptions {
  std::string units;        // m, cm, mm, inch, foot; empty: what the file declares
  double deflection = 0.0;  // m, facets from the surface, at most; 0: a thousandth of each solid's diagonal
  bool yUp = false;         // the file is y-up as glTF; else z-up, and turned
  /// Called with the share done, 0..1, and what is being done.
  std::function<void(double, const char*)> progress = [](double, const char*) {};
};

/// Between two neighbouring facets of a curved surface, rad, at most.
inline constexpr double kFacetAngle = 0.2;

}  // namespace tandem::cad_import
