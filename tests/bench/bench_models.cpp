// bench_models [--threads N] [--json OUT] [FILE UNIT | assembly]
//
// The models by which parts in the hand collide: seconds to make them, from nothing and from the cache, of
// the clock and of all cores together, and their memory. `assembly`: 95 parts, each with a mesh of its own,
// of about 650,000 triangles in all. Without a file: the two-cylinder engine in $TANDEM_DATA. Every part is
// taken for movable.

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

#include "assets/gltf/load_gltf.h"
#include "haptics/scene/contact_scene_data.h"
#include "tests/bench/bench_report.h"
#include "tests/support/part_cases.h"

namespace {

namespace haptics = tandem::haptics;
namespace bench = tandem::bench;

constexpr const char* kAssembly = "assembly";

struct Options {
  std::string file, unit = "m", json;
  int threads = 0;
};

bool parse(int argc, char** argv, Options& options) {
  int i = 1;
  for (; i + 1 < argc && argv[i][0] == '-'; i += 2) {
    const std::string name = argv[i];
    if (name == "--threads") {
      options.threads = std::atoi(argv[i + 1]);
    } else if (name == "--json") {
      options.json = argv[i + 1];
    } else {
      return false;
    }
  }
  if (i + 1 == argc && std::string(argv[i]) == kAssembly) {
    options.file = kAssembly;
  } else if (i + 2 == argc) {
    options.file = argv[i];
    options.unit = argv[i + 1];
  } else if (const char* data = std::getenv("TANDEM_DATA"); data != nullptr && i == argc) {
    options.file = std::string(data) + "/2CylinderEngine.glb";
    options.unit = "mm";
  }
  return !options.file.empty();
}

/// 95 parts side by side, each a little different: pegs, each in its bore, gears, and nuts on their bolts.
tandem::assets::Scene assembly() {
  using namespace tandem::test;
  constexpr int kPegs = 30, kGears = 25, kBolts = 5;
  const auto at = [](int i) {
    return tandem::Pose{{0.1 * (i % 10), 0.1 * (i / 10), 0.0}, {1.0, 0.0, 0.0, 0.0}};
  };
  std::vector<CasePart> parts;
  const auto add = [&](const char* name, const tandem::assets::TriangleSoup& soup, int place) {
    parts.push_back({name + std::to_string(place), meshOf(soup), at(place), true});
  };
  int place = 0;
  for (int i = 0; i < kPegs; ++i, ++place) {
    const Facets facets = facetsFor(5'100 + 20 * i);
    add("peg", moved(pegSoup({0.010, 0.040, 0.001, facets}), {0.0, 0.0, -0.040}), place);
    add("bore", boredBlockSoup({0.01005, 0.045, 0.060, 0.050, 0.001, Fit::around, facets}), place);
  }
  for (int i = 0; i < kGears; ++i, ++place) {
    SpurGear gear;
    gear.teeth = 20 + i;
    add("gear", prismSoup(spurGearOutline(gear), gear.width, 5), place);
  }
  for (int i = 0; i < kBolts; ++i, ++place) {
    Thread thread;
    thread.clearance = 0.1e-3;
    thread.length = 0.010 + 0.0002 * i;
    thread.segments = 96;
    add("bolt", boltThreadSoup(thread), place);
    add("nut", nutThreadSoup(thread, 0.012), place);
  }
  return sceneOfParts(parts);
}

struct Run {
  double seconds = 0.0, cpuSeconds = 0.0;
  std::size_t bytes = 0, cells = 0, samples = 0, cached = 0, models = 0;
};

/// Of this process, all its threads together.
double cpuSeconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

Run bake(const tandem::assets::Scene& scene, const Options& options, const std::string& directory) {
  haptics::ContactScene contact(scene, options.threads);
  const std::size_t before = contact.memory();
  const bench::Stopwatch watch;
  const double cpu = cpuSeconds();
  haptics::ModelOptions how;
  how.cacheDirectory = directory;
  how.threads = options.threads;
  static_cast<void>(contact.modelParts(how));
  Run run;
  run.seconds = watch.seconds();
  run.cpuSeconds = cpuSeconds() - cpu;
  run.bytes = contact.memory() - before;
  for (const auto& model : contact.data().models) {
    if (model == nullptr) continue;
    ++run.models;
    run.cached += model->cached ? 1 : 0;
    run.cells += model->field.cells();
    run.samples += model->samples.samples().size();
  }
  return run;
}

tandem::Result<tandem::assets::Scene> sceneOf(const Options& options) {
  if (options.file == kAssembly) return assembly();
  tandem::assets::LoadOptions load;
  const auto scale = tandem::assets::parseUnits(options.unit);
  if (!scale) return tandem::Error{options.unit + " is no unit"};
  load.unitScale = *scale;
  load.allMovable = true;
  return tandem::assets::loadGltf(options.file, load);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) {
    std::fprintf(
        stderr,
        "usage: bench_models [--threads N] [--json OUT] [FILE UNIT | assembly], or set TANDEM_DATA\n");
    return 2;
  }
  const bool large = options.file == kAssembly;
  const auto scene = sceneOf(options);
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.error().message.c_str());
    return 1;
  }
  const std::filesystem::path directory =
      std::filesystem::temp_directory_path() / ("bench_models." + std::to_string(getpid()));
  bench::Report report("bench_models");
  const Run cold = bake(*scene, options, directory.string());
  report.value("parts", "", static_cast<double>(scene->parts.size()));
  report.value("triangles", "", static_cast<double>(tandem::assets::triangleCount(*scene)));
  report.value("models", "", static_cast<double>(cold.models));
  report.value("samples", "", static_cast<double>(cold.samples));
  report.value("cells", "", static_cast<double>(cold.cells));
  report.value("memory", "MB", 1e-6 * static_cast<double>(cold.bytes));
  bool met = report.bound("cold, s", cold.seconds, large ? 60.0 : 20.0);
  report.value("cold, all cores", "s", cold.cpuSeconds);
  if (large) {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    met = report.bound("most memory of all, GB", 1.024e-6 * static_cast<double>(used.ru_maxrss), 1.0) && met;
  }
  double best = 1e300;
  Run cached;
  for (int i = 0; i < 3; ++i) {
    cached = bake(*scene, options, directory.string());
    best = std::min(best, cached.seconds);
  }
  if (large)
    report.value("from the cache", "s", best);
  else
    met = report.bound("from the cache, s", best, 0.5) && met;
  report.value("read from the cache", "", static_cast<double>(cached.cached));
  std::error_code error;
  std::filesystem::remove_all(directory, error);
  if (!options.json.empty() && !report.writeJson(options.json)) return 1;
  return met && cached.cached == cached.models ? 0 : 1;
}
