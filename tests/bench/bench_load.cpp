// How long until a scene can be touched: file to parts to contact geometry, from a cold and a warm scene
// cache.
//
//   bench_load [--weld] [ENGINE.glb] [--json OUT.json]
//
// Always measures a sphere of a million triangles in one part; with a file (numbers in millimetres) that one
// too. The yardstick is what cannot be saved: reading the file's bytes and hashing them once. Then what the
// weld of T-junctions costs meshes of a million triangles, with the whole analysis of a mesh as the
// yardstick; --weld measures that alone.

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "assets/gltf/load_gltf.h"
#include "assets/mesh/mesh_analysis.h"
#include "assets/mesh/t_junctions.h"
#include "assets/mesh/vertex_weld.h"
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

/// Strips side by side whose columns do not match, about a million triangles: with `different` each strip has
/// a number of its own, and every vertex on the border of two lies on an edge of the other.
assets::TriangleSoup strips(int count, int columns, bool different) {
  assets::TriangleSoup soup;
  for (int strip = 0; strip < count; ++strip) {
    const int own = different ? columns + strip % 2 : columns;
    for (int i = 0; i < own; ++i) {
      const auto first = static_cast<std::uint32_t>(soup.positions.size());
      for (const auto& [x, y] : {std::pair(i, strip), {i + 1, strip}, {i + 1, strip + 1}, {i, strip + 1}})
        soup.positions.emplace_back(glm::vec3(0.1 * x / own, 0.1 * y / count, 0.0));
      soup.triangles.push_back({first, first + 1, first + 2});
      soup.triangles.push_back({first, first + 2, first + 3});
      soup.triangleMaterial.insert(soup.triangleMaterial.end(), 2, 0);
    }
  }
  return soup;
}

/// Every triangle apart from the others: all edges are open, and none lies on another.
assets::TriangleSoup confetti(int count) {
  assets::TriangleSoup soup = strips(count, count, false), out;
  for (const auto& t : soup.triangles) {
    const glm::dvec3 middle = (soup.positions[t[0]] + soup.positions[t[1]] + soup.positions[t[2]]) / 3.0;
    const auto first = static_cast<std::uint32_t>(out.positions.size());
    for (const std::uint32_t v : t) out.positions.push_back(middle + 0.9 * (soup.positions[v] - middle));
    out.triangles.push_back({first, first + 1, first + 2});
    out.triangleMaterial.push_back(0);
  }
  return out;
}

/// Medians over runs of analyseMesh(), of the search for T-junctions alone, and the ratio.
void measureWeld(const std::string& name, const assets::TriangleSoup& soup, bench::Report& report) {
  std::vector<double> whole, search;
  std::uint64_t junctions = 0;
  for (int run = 0; run < 3; ++run) {
    assets::TriangleSoup copy = soup;
    bench::Stopwatch watch;
    junctions = assets::analyseMesh(std::move(copy), 0.5).defects.tJunctions;
    whole.push_back(watch.seconds());
    const assets::WeldedVertices welded = assets::weldVertices(soup.positions, soup.triangles);
    std::vector<assets::TriangleIndices> triangles = soup.triangles;
    for (assets::TriangleIndices& t : triangles)
      for (std::uint32_t& v : t) v = welded.pointOf[v];
    const assets::EdgePairs pairs = assets::pairEdges(triangles, welded.points.size());
    watch = bench::Stopwatch();
    static_cast<void>(
        assets::splitAtJunctions(welded.points, triangles, pairs, std::sqrt(3.0) * welded.tolerance));
    search.push_back(watch.seconds());
  }
  report.value(name + ": junctions", "", static_cast<double>(junctions));
  report.value(name + ": analysis", "s", bench::percentiles(whole).p50);
  report.value(name + ": search", "s", bench::percentiles(search).p50);
  report.value(name + ": search / analysis", "",
               bench::percentiles(search).p50 / bench::percentiles(whole).p50);
}

void measureWelds(bench::Report& report) {
  measureWeld("weld, 1 M in one sheet", strips(707, 707, false), report);
  measureWeld("weld, 1 M in 707 strips", strips(707, 707, true), report);
  measureWeld("weld, 1 M apart", confetti(707), report);
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  using namespace tandem;
  std::string engine, json;
  bool weldOnly = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc)
      json = argv[++i];
    else if (std::strcmp(argv[i], "--weld") == 0)
      weldOnly = true;
    else
      engine = argv[i];
  }
  bench::Report report("bench_load");
  if (weldOnly) {
    measureWelds(report);
    return json.empty() || report.writeJson(json) ? 0 : 2;
  }
  const fs::path folder = fs::temp_directory_path() / ("tandem-bench-load-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const std::string file = (folder / "sphere.glb").string();
  const std::vector<unsigned char> bytes = sphere(708, 708);
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  bool met = measure("1 M triangles", file, 1.0, 2.0, 0.0, folder, report);
  if (!engine.empty()) met = measure("engine", engine, 1e-3, 2.0, 0.3, folder, report) && met;
  fs::remove_all(folder);
  measureWelds(report);
  if (!json.empty() && !report.writeJson(json)) return 2;
  return met ? 0 : 1;
}
