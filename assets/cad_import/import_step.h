#pragma once

// A STEP file as a scene: read, its tree built, its fits cut alike, its bodies meshed.

#include <string>

#include "assets/base/result.h"
#include "assets/cad_import/cad_scene.h"
#include "assets/cad_import/import_options.h"

namespace tandem::cad_import {

/// What an import did, for the report.
struct StepFigures {
  double readingTime = 0.0;  // s of the processor: OpenCASCADE's own reading and transfer
  double meshingTime = 0.0;  // s of the processor: everything after it
  std::size_t fits = 0;      // pairs of shaft and bore, cut alike
};

/// Crashes, hangs and takes memory on damaged files: for a process with limits.
Result<CadScene> importStep(const std::string& path, const ImportOptions& options, StepFigures& figures);

}  // namespace tandem::cad_import
