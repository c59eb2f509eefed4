#include "server/program/cad_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <vector>

#include "assets/base/cache_file.h"
#include "assets/base/limited_process.h"
#include "assets/scene/scene_package.h"

namespace tandem::server {
namespace {

// A new one where tandem-import makes another scene of the same file.
constexpr char kVersion = '1';

std::string endingOf(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return ending;
}

Status runImporter(const std::vector<std::string>& command, const std::function<void(double)>& progress,
                   const std::function<bool()>& cancelled) {
  // tandem-import keeps limits of its own; these are for what it may do in their place.
  ProcessLimits limits;
  limits.wallTime = 1800.0;
  const auto onLine = [&](const std::string& line) {
    double share = 0.0;
    if (progress && std::sscanf(line.c_str(), "progress %lf", &share) == 1) progress(share);
  };
  const Result<ProcessEnd> end = runLimited(command, limits, onLine, cancelled);
  if (!end)
    return Error{command[1] + ": a CAD file needs tandem-import (.ci/build import): " + end.error().message};
  if (end->how == ProcessEnd::How::exited && end->code == 0) return {};
  if (end->how == ProcessEnd::How::cancelled) return Error{command[1] + ": the import was stopped"};
  constexpr const char* kPrefix = "tandem-import: ";
  if (end->lastError.rfind(kPrefix, 0) == 0) return Error{end->lastError.substr(15)};
  return Error{command[1] + ": tandem-import ended without a scene"};
}

}  // namespace

bool isCadFile(const std::string& path) {
  static const std::array<const char*, 6> kEndings{".step", ".stp", ".3mf", ".stl", ".obj", ".ply"};
  const std::string ending = endingOf(path);
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

Result<std::string> importCadFile(const std::string& path, const std::string& units,
                                  const std::string& cacheDirectory, const std::string& fallback,
                                  const std::function<void(double)>& progress,
                                  const std::function<bool()>& cancelled) {
  std::string output = fallback;
  std::error_code ignored;
  if (!cacheDirectory.empty()) {
    auto content = assets::readCacheFile(path);
    if (!content) return Error{path + ": cannot be read"};
    for (const char c : endingOf(path) + ' ' + units + ' ' + kVersion) content->push_back(std::byte(c));
    // The scene keeps the file's name, which people read.
    const std::filesystem::path folder =
        std::filesystem::path(cacheDirectory) / ("import-" + assets::toHex(assets::contentHash(*content)));
    std::filesystem::create_directories(folder, ignored);
    output = folder / std::filesystem::path(path).stem().concat(".glb");
    if (std::filesystem::exists(output, ignored)) return output;
  }
  std::vector<std::string> command{besideThisProgram("tandem-import"), path, "-o", output, "--progress"};
  if (!units.empty()) command.insert(command.end(), {"--units", units});
  if (Status done = runImporter(command, progress, cancelled); !done) return done.error();
  return output;
}

}  // namespace tandem::server
