#include "assets/cad_import/import_file.h"

#include <cctype>
#include <filesystem>
#include <fstream>

#include "assets/cad_import/import_3mf.h"
#include "assets/cad_import/import_mesh.h"

namespace tandem::cad_import {

Result<CadScene> importFile(const std::string& path, const ImportOptions& options, ImportFigures& figures) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed)) return Error{"no such file"};
  if (!std::ifstream(path, std::ios::binary)) return Error{"cannot be read"};
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".step" || ending == ".stp") return importStep(path, options, figures);
  if (ending == ".stl" || ending == ".obj" || ending == ".ply") return importMesh(path, options);
  if (ending == ".3mf") return import3mf(path, options);
  return Error{"not a CAD file that is read: .step, .stp, .3mf, .stl, .obj and .ply are"};
}

}  // namespace tandem::cad_import
