// How long until a scene can be touched: file to parts to contact geometry, from a cold and a warm scene
// cache.
//
//   bench_load [ENGINE.glb] [--json OUT.json]
//
// Always measures a sphere of a million triangles in one part; with a file (numbers in millimetres) that one
// too. The yardstick is what cannot be saved: reading the file's bytes and hashing them once.

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "assets/gltf/load_gltf.h"
#include "assets/scene/scene_package.h"
#include "haptics/scene/contact_scene.h"
#include "tests/bench/bench_report.h"
#include "tests/support/gltf_builder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

/// A sphere of radius 0.1 m with 2 * rings * (segments) triangles or so, in one mesh.
std::vector<unsigned char> sphere(int rings, int segments) {
  std::vector<float> positions{0.0f, 0.1f, 0.0f};
  std::vector<std::uint32_t> indices;
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < segments; ++j) {
      const double a = M_PI * i / rings, b = 2.0 * M_PI * j / segments;
      positions.push_back(static_cast<float>(0.1 * std::sin(a) * std::cos(b)));
      positions.push_back(static_cast<float>(0.1 * std::cos(a)));
      positions.push_back(static_cast<float>(-0.1 * std::sin(a) * std::sin(b)));
    }
  positions.insert(positions.end(), {0.0f, -0.1f, 0.0f});
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>(1 + (i - 1) * segments + j % segments);
  };
  const auto last = static_cast<std::uint32_t>(1 + (rings - 1) * segments);
  for (int j = 0; j < segments; ++j) {
    indices.insert(indices.end(), {0u, at(1, j), at(1, j + 1)});
    indices.insert(indices.end(), {last, at(rings - 1, j + 1), at(rings - 1, j)});
    for (int i = 1; i + 1 < rings; ++i) {
      indices.insert(indices.end(), {at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      indices.insert(indices.end(), {at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  tests::GltfBuilder builder;
  const int mesh =
      builder.addMesh(builder.addPositions(positions), builder.addIndices(indices), 4, -1, "sphere");
  builder.addNode({{"mesh", mesh}});
  return builder.glb();
}

/// Seconds until the scene may be touched; exits if it does not load.
double ready(const std::string& file, const assets::LoadOptions& options, const std::string& cache) {
  const bench::Stopwatch watch;
  const Result<assets::Scene> scene = assets::loadScene(file, options, cache);
  if (!scene) {
    std::fprintf(stderr, "bench_load: %s\n", scene.error().message.c_str());
    std::exit(2);
  }
  const haptics::ContactScene contact(*scene);
  return watch.seconds();
}

double readAndHash(const std::string& file) {
  const bench::Stopwatch watch;
  std::ifstream in(file, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  static_cast<void>(assets::contentHash(std::as_bytes(std::span(bytes))));
  return watch.seconds();
}

bool measure(const std::string& name, const std::string& file, double unitScale, double coldBound,
             double warmBound, const fs::path& folder, bench::Report& report) {
  assets::LoadOptions options;
  options.unitScale = unitScale;
  options.allMovable = true;
  std::vector<double> cold, warm, yardstick;
  for (int run = 0; run < 5; ++run) {
    const std::string cache = (folder / (name + std::to_string(run))).string();
    yardstick.push_back(readAndHash(file));
    cold.push_back(ready(file, options, cache));
    warm.push_back(ready(file, options, cache));
  }
  const bench::Percentiles c = bench::percentiles(cold), w = bench::percentiles(warm);
  report.row(name + " cold", "s", c);
  report.row(name + " warm", "s", w);
  report.value(name + " cold / read and hash", "", c.p50 / bench::percentiles(yardstick).p50);
  const bool met = report.bound(name + " cold, median, s", c.p50, coldBound);
  return (warmBound <= 0.0 || report.bound(name + " warm, median, s", w.p50, warmBound)) && met;
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  using namespace tandem;
  std::string engine, json;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc)
      json = argv[++i];
    else
      engine = argv[i];
  }
  const fs::path folder = fs::temp_directory_path() / ("tandem-bench-load-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const std::string file = (folder / "sphere.glb").string();
  const std::vector<unsigned char> bytes = sphere(708, 708);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  bench::Report report("bench_load");
  bool met = measure("1 M triangles", file, 1.0, 2.0, 0.0, folder, report);
  if (!engine.empty()) met = measure("engine", engine, 1e-3, 2.0, 0.3, folder, report) && met;
  fs::remove_all(folder);
  if (!json.empty() && !report.writeJson(json)) return 2;
  return met ? 0 : 1;
}
