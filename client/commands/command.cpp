#include "client/commands/command.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "assets/base/assert.h"
#include "assets/gltf/cad_file.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client {

int badInput(const Error& error) {
  // Messages quote files and arguments, which may hold line breaks and control codes of a terminal.
  ASSERT(!error.message.empty());
  std::string line = error.message;
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 32 || c == 127; }, '_');
  std::fprintf(stderr, "tandem: %s\n", line.c_str());
  return kExitBadInput;
}

void addSceneOptions(assets::CommandLine& command, SceneArguments& arguments) {
  command
      .option("scene", arguments.path, "Scene: .gltf or .glb, or a CAD file: .step, .3mf, .stl, .obj, .ply")
      .required();
  command.option("--units", arguments.units, "Unit of the file's numbers: m, cm, mm, inch or foot")
      .showDefault();
  command.option(
      "--movable", arguments.movable,
      "Part that a hand may take, beside those that the file says; 'all' for every part; repeatable [none]");
  command.flag("--no-cache", arguments.noCache, "Neither read nor write the cache of prepared scenes");
  command
      .option("--max-json", arguments.maxJson,
              "Largest JSON of a scene file to read, MiB; 32 take up to 2 GiB")
      .integerFrom(1, 2048)
      .showDefault();
  command.flag("--facets", arguments.facets,
               "Feel flat facets also where the file's normals say that the surface is curved");
}

Result<assets::LoadOptions> loadOptions(const SceneArguments& arguments) {
  assets::LoadOptions options;
  Result<double> scale = assets::parseUnits(arguments.units);
  if (!scale) return Error{"--units " + arguments.units + ": " + scale.error().message};
  options.unitScale = *scale;
  options.normals = !arguments.facets;
  options.maxJsonBytes = static_cast<std::size_t>(arguments.maxJson) << 20;
  for (const std::string& name : arguments.movable) {
    if (name == "all")
      options.allMovable = true;
    else
      options.movable.push_back(name);
  }
  return options;
}

Result<assets::Scene> loadScene(const SceneArguments& arguments) {
  Result<assets::LoadOptions> options = loadOptions(arguments);
  if (!options) return options.error();
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (terminal)
    options->progress = [](double done, const char* what) {
      std::fprintf(stderr, "\r\033[K%3.0f %% %s", 100.0 * done, what);
      std::fflush(stderr);
    };
  const assets::SceneFile file{arguments.path, arguments.units,
                               arguments.noCache ? "" : assets::defaultCacheDirectory()};
  Result<assets::Scene> scene = assets::loadSceneFile(file, *options);
  if (terminal) std::fputs("\r\033[K", stderr);
  return scene;
}

void modelParts(haptics::ContactScene& contact, bool noCache) {
  haptics::ModelOptions options;
  if (!noCache) options.cacheDirectory = assets::defaultCacheDirectory();
  ProgressLine line;
  options.progress = [&](double done, const char* what) {
    line.show(done, what);
    return true;
  };
  static_cast<void>(contact.modelParts(options));  // `progress` never stops it
}

ProgressLine::ProgressLine(bool named) : named_(named), start_(std::chrono::steady_clock::now()) {}

ProgressLine::~ProgressLine() {
  if (!what_.empty() && isatty(STDERR_FILENO) != 0) std::fputs("\r\033[K", stderr);
}

void ProgressLine::show(double done, const char* what) {
  ASSERT(what != nullptr);
  constexpr std::chrono::milliseconds kLong(500);
  if (std::chrono::steady_clock::now() - start_ < kLong) return;
  const bool terminal = isatty(STDERR_FILENO) != 0, other = what_ != what;
  if (terminal && (other || std::abs(done - done_) >= 0.01)) {
    std::fprintf(stderr, "\r\033[K%3.0f %% %s", 100.0 * done, what);
    done_ = done;
  } else if (!terminal && other && named_) {
    std::fprintf(stderr, "tandem: %s\n", what);
  }
  what_ = what;
}

std::string inShort(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

Status writable(const std::string& path) {
  namespace fs = std::filesystem;
  if (path.empty()) return {};
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) return Error{path + ": cannot be written: is a directory"};
  const fs::path parent = fs::path(path).parent_path();
  const std::string existing = fs::exists(status) ? path : parent.empty() ? "." : parent.string();
  if (::access(existing.c_str(), W_OK) != 0)
    return Error{path + ": cannot be written: " + std::error_code(errno, std::generic_category()).message()};
  return {};
}

Status writeFile(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) return Error{path + ": cannot be written"};
  return {};
}

}  // namespace tandem::client
