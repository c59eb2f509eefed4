#pragma once

// A STEP file as OpenCASCADE's document of products, instances, colours and tolerances.
//
// The reader crashes, hangs and takes memory on damaged files: it runs in a process of its own with limits
// (main.cpp).

#include <string>
#include <vector>

#include <TDocStd_Document.hxx>

#include "assets/base/result.h"
#include "assets/cad_import/import_options.h"

namespace tandem::cad_import {

/// Lengths are mm, whatever the file's unit.
struct StepDocument {
  Handle(TDocStd_Document) document;
  std::vector<std::string> lengthUnits;   // that the file declares, as it names them
  std::vector<std::string> missingFiles;  // external files that it names and that are not there
};

Result<StepDocument> readStep(const std::string& path, const ImportOptions& options);

}  // namespace tandem::cad_import
