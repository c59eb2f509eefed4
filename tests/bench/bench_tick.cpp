// bench_tick [FILE.glb] [--scale M_PER_UNIT] [--ticks N] [--json OUT]
//
// A point tool walks over the parts of a scene: down onto a surface, along it under pressure, up again,
// thousands of places. Each tick is timed; so is Embree's rtcPointQuery at the same device points on the same
// triangles. Then the build of the tree over a million triangles, against rtcCommitScene.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/base/command_line.h"
#include "assets/gltf/load_gltf.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/tick.h"
#include "tests/bench/bench_report.h"
#include "tests/bench/embree_yardstick.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"

namespace {

using tandem::assets::Scene;
namespace haptics = tandem::haptics;
namespace bench = tandem::bench;
using bench::EmbreeYardstick;
using bench::WorldMesh;

struct Options {
  std::string file, json;
  double scale = 0.001;
  int ticks = 100'000;
};

constexpr int kVisit = 35 + 100 + 33;

/// Visits of kVisit ticks: down 5 mm onto a triangle, 1.5 mm into it, 20 mm along it, up: at most 0.2 m/s,
/// one point a millisecond. Lengths are for a scene of half a metre and scale with it.
std::vector<glm::dvec3> scriptedPath(const WorldMesh& mesh, double unit, int ticks) {
  std::vector<glm::dvec3> path;
  std::mt19937 random(1);
  const auto at = [&](std::uint32_t v) {
    return glm::dvec3(mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]);
  };
  while (path.size() < static_cast<std::size_t>(ticks)) {
    const std::size_t t = random() % (mesh.corners.size() / 3);
    const glm::dvec3 a = at(mesh.corners[3 * t]), b = at(mesh.corners[3 * t + 1]),
                     c = at(mesh.corners[3 * t + 2]);
    const glm::dvec3 cross = glm::cross(b - a, c - a);
    if (!(glm::length(cross) > 0.0)) continue;
    const glm::dvec3 n = glm::normalize(cross), along = glm::normalize(b - a), middle = (a + b + c) / 3.0;
    for (int i = 0; i < 35; ++i) path.push_back(middle + n * unit * (0.005 - 0.0065 * i / 34.0));
    for (int i = 1; i <= 100; ++i) path.push_back(middle - n * unit * 0.0015 + along * unit * (2e-4 * i));
    for (int i = 1; i <= 33; ++i)
      path.push_back(middle + along * unit * 0.02 + n * unit * (-0.0015 + 2e-4 * i));
  }
  path.resize(static_cast<std::size_t>(ticks));
  return path;
}

Scene defaultScene() {
  tandem::test::SceneBuilder b;
  const std::uint32_t mesh = b.addMesh(tandem::test::sphereMesh(0.06, 60));
  for (int i = 0; i < 9; ++i) {
    b.addPart(mesh, {{0.1 * (i % 3), 0.1 * (i / 3), 0.0}, {1.0, 0.0, 0.0, 0.0}});
  }
  return b.scene;
}

bool benchTick(const Scene& scene, const Options& options, bench::Report& report) {
  const WorldMesh mesh = bench::flatten(scene);
  glm::dvec3 low(1e300), high(-1e300);
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    const glm::dvec3 p(mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2]);
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const std::vector<glm::dvec3> path = scriptedPath(mesh, glm::length(high - low) / 0.5, options.ticks);
  const bench::Stopwatch ready;
  const haptics::ContactScene contact(scene);
  report.value("contact ready", "ms", 1e3 * ready.seconds());
  report.value("triangles", "", static_cast<double>(mesh.corners.size() / 3));

  EmbreeYardstick embree(mesh);
  haptics::TickState state(contact);
  haptics::DeviceSample sample;
  sample.valid = true;
  std::vector<double> ours, theirs;
  ours.reserve(path.size());
  theirs.reserve(path.size());
  std::uint64_t allocations = 0;
  int touching = 0;
  double sum = 0.0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const glm::dvec3& p = path[i];
    sample.worldFromDevice.position = p;
    if (i % kVisit == 0) {
      // The hand goes from place to place unseen, so that the proxy is not dragged through the whole scene
      // between.
      sample.valid = false;
      for (int k = 0; k < 300; ++k)
        haptics::tick({.hands = {{{sample}}}, .moved = {}, .commands = {}}, contact, {}, state);
      sample.valid = true;
    }
    const tandem::test::AllocationScope scope;
    const bench::Stopwatch watch;
    const haptics::TickOutput out =
        haptics::tick({.hands = {{{sample}}}, .moved = {}, .commands = {}}, contact, {}, state);
    ours.push_back(1e6 * watch.seconds());
    allocations += scope.count();
    touching += out.contactCount > 0 ? 1 : 0;
  }
  for (const glm::dvec3& p : path) {
    const bench::Stopwatch watch;
    sum += embree.closest(p);
    theirs.push_back(1e6 * watch.seconds());
  }
  const bench::Percentiles tick = bench::percentiles(ours), query = bench::percentiles(theirs);
  report.row("tick", "us", tick);
  report.row("Embree rtcPointQuery", "us", query);
  report.value("ticks in contact", "%", 100.0 * touching / static_cast<double>(path.size()));
  report.value("mean distance (Embree)", "m", sum / static_cast<double>(path.size()));
  bool met = report.bound("allocations in ticks", static_cast<double>(allocations), 0.0);
  met = report.bound("tick p99, us", tick.p99, 25.0) && met;
  met = report.bound("tick p50 / Embree p50", tick.p50 / query.p50, 3.0) && met;
  return report.bound("tick p99 / Embree p99", tick.p99 / query.p99, 3.0) && met;
}

bool benchBuild(bench::Report& report) {
  Scene scene;
  scene.materials.emplace_back();
  tandem::assets::TriangleSoup soup = tandem::test::sphereSoup(0.1, 501);
  tandem::assets::Mesh mesh;
  mesh.positions = std::move(soup.positions);
  mesh.triangles = std::move(soup.triangles);
  scene.meshes.push_back(std::move(mesh));
  scene.parts.emplace_back();
  scene.parts[0].mesh = 0;
  const WorldMesh world = bench::flatten(scene);
  double ours = 1e300, theirs = 1e300, processor = 1e300;
  for (int i = 0; i < 3; ++i) {
    const bench::Stopwatch watch;
    const std::clock_t before = std::clock();
    const haptics::TriangleBvh tree(scene.meshes[0]);
    processor = std::min(processor, static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
    ours = std::min(ours, watch.seconds());
    theirs = std::min(theirs, EmbreeYardstick(world).buildSeconds());
  }
  report.value("rtcCommitScene, 1 M triangles", "ms", 1e3 * theirs);
  report.value("build, processor time, 1 M triangles", "ms", 1e3 * processor);
  report.value("build / rtcCommitScene", "", ours / theirs);
  return report.bound("build, 1 M triangles, ms", 1e3 * ours, 300.0);
}

/// The exit code, where the program is to end now.
std::optional<int> parse(int argc, char** argv, Options& options) {
  tandem::assets::CommandLine line(
      "Ticks of a point that visits a scene, against point queries of Embree, and how fast a tree is built.",
      "bench_tick");
  line.option("file", options.file, "scene (.gltf or .glb) [nine spheres]");
  line.option("--scale", options.scale, "m a unit of the file").showDefault().numberFrom(1e-9, 1e9);
  line.option("--ticks", options.ticks, "ticks that are timed").showDefault().integerFrom(1, 10'000'000);
  line.option("--json", options.json, "writes the figures").typeName("FILE");
  return line.parse("bench_tick", argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const std::optional<int> code = parse(argc, argv, options)) return *code;
  Scene scene;
  if (options.file.empty()) {
    scene = defaultScene();
  } else {
    tandem::assets::LoadOptions load;
    load.unitScale = options.scale;
    auto loaded = tandem::assets::loadGltf(options.file, load);
    if (!loaded) {
      std::fprintf(stderr, "%s\n", loaded.error().message.c_str());
      return 2;
    }
    scene = std::move(loaded).value();
  }
  bench::Report report("bench_tick " + (options.file.empty() ? std::string("(nine spheres)") : options.file));
  const bool tickMet = benchTick(scene, options, report);
  const bool buildMet = benchBuild(report);
  if (!options.json.empty() && !report.writeJson(options.json)) {
    std::fprintf(stderr, "%s: cannot be written\n", options.json.c_str());
    return 2;
  }
  return tickMet && buildMet ? 0 : 1;
}
