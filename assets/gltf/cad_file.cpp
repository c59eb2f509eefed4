#include "assets/gltf/cad_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

#include "assets/base/cache_file.h"
#include "assets/base/limited_process.h"
#include "assets/base/temporary_folder.h"
#include "assets/scene/scene_package.h"

namespace tandem::assets {
namespace {

namespace fs = std::filesystem;

// A new one where tandem-import makes another scene of the same file.
constexpr char kImportVersion = '2';
constexpr const char* kPrefix = "tandem-import: ";

std::string endingOf(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return ending;
}

Error withoutImporter(const std::string& path, const Error& error) {
  return Error{path + ": reading it needs tandem-import, a package of its own that is not here (" +
               error.message + "): bash .ci/install import && bash .ci/build import"};
}

Status runImporter(const std::vector<std::string>& command,
                   const std::function<void(double, const char*)>& progress,
                   const std::function<bool()>& cancelled) {
  // tandem-import keeps limits of its own; these are for what it may do in their place.
  ProcessLimits limits;
  limits.wallTime = 1800.0;
  const auto onLine = [&](const std::string& line) {
    double share = 0.0;
    if (progress && std::sscanf(line.c_str(), "progress %lf", &share) == 1) progress(share, "importing");
  };
  const Result<ProcessEnd> end = runLimited(command, limits, onLine, cancelled);
  if (!end) return withoutImporter(command[1], end.error());
  if (end->how == ProcessEnd::How::exited && end->code == 0) return {};
  if (end->how == ProcessEnd::How::cancelled) return Error{command[1] + ": the import was stopped"};
  if (end->lastError.rfind(kPrefix, 0) == 0)
    return Error{end->lastError.substr(std::char_traits<char>::length(kPrefix))};
  return Error{command[1] + ": tandem-import ended without a scene"};
}

/// Where the import of a file is kept. The scene keeps the file's name, which people read.
Result<fs::path> importOf(const SceneFile& file, const std::string& units,
                          std::optional<TemporaryFolder>& temporary) {
  const fs::path name = fs::path(file.path).stem().concat(".glb");
  if (file.cacheDirectory.empty()) {
    const std::string& folder = temporary.emplace("tandem-import-").path();
    if (folder.empty()) return Error{file.path + ": no temporary folder for its import can be made"};
    return folder / name;
  }
  auto content = readCacheFile(file.path);
  if (!content) return Error{file.path + ": cannot be read"};
  for (const char c : endingOf(file.path) + ' ' + units + ' ' + kImportVersion)
    content->push_back(std::byte(c));
  const fs::path folder = fs::path(file.cacheDirectory) / ("import-" + toHex(contentHash(*content)));
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  return folder / name;
}

}  // namespace

bool isCadFile(const std::string& path) {
  static const std::array<const char*, 6> kEndings{".step", ".stp", ".3mf", ".stl", ".obj", ".ply"};
  const std::string ending = endingOf(path);
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

Result<Scene> loadSceneFile(const SceneFile& file, LoadOptions options,
                            const std::function<bool()>& cancelled) {
  if (!isCadFile(file.path)) return loadScene(file.path, options, file.cacheDirectory);
  const std::string units = file.units == "m" ? "" : file.units;
  std::optional<TemporaryFolder> temporary;
  const Result<fs::path> output = importOf(file, units, temporary);
  if (!output) return output.error();
  std::error_code ignored;
  if (!fs::exists(*output, ignored)) {
    std::vector<std::string> command{besideThisProgram("tandem-import"), file.path, "-o", output->string(),
                                     "--progress"};
    if (!units.empty()) command.insert(command.end(), {"--units", units});
    if (Status done = runImporter(command, options.progress, cancelled); !done) return done.error();
  }
  options.unitScale = 1.0;
  return loadScene(output->string(), options, file.cacheDirectory);
}

}  // namespace tandem::assets
