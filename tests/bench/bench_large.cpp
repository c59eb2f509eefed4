// bench_large: an assembly of many finely cut parts (50 of 200,000 triangles) drawn by the viewer while the
// camera turns: frames a second, memory, time until the first picture. `--make 1` makes all levels first, on
// all cores; `--write FILE.glb` writes the assembly, for tandem-server.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "assets/base/parallel.h"
#include "assets/generate/large_assembly.h"
#include "client/levels/level_file.h"
#include "client/viewer/viewer.h"
#include "tests/bench/bench_report.h"
#include "tests/support/gltf_builder.h"

namespace tandem::bench {
namespace {

struct Arguments {
  int parts = 50, triangles = 200'000, frames = 20;
  bool exact = false, make = false;
  std::string write, json, picture, cache;
};

bool parse(int argc, char** argv, Arguments& arguments) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i], value = argv[i + 1];
    if (name == "--parts")
      arguments.parts = std::atoi(value.c_str());
    else if (name == "--triangles")
      arguments.triangles = std::atoi(value.c_str());
    else if (name == "--frames")
      arguments.frames = std::atoi(value.c_str());
    else if (name == "--exact")
      arguments.exact = value == "1";
    else if (name == "--make")
      arguments.make = value == "1";
    else if (name == "--cache")
      arguments.cache = value;
    else if (name == "--write")
      arguments.write = value;
    else if (name == "--picture")
      arguments.picture = value;
    else if (name == "--json")
      arguments.json = value;
    else
      return false;
  }
  return argc % 2 == 1;
}

/// MB of this process, from /proc/self/status ("VmRSS", "VmHWM").
double memory(const char* field) {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line))
    if (line.rfind(field, 0) == 0) return std::atof(line.c_str() + std::strlen(field) + 1) / 1024.0;
  return 0.0;
}

void write(const assets::Scene& scene, const std::string& path) {
  tests::GltfBuilder builder;
  for (const assets::Part& part : scene.parts) {
    const assets::Mesh& mesh = scene.meshes[part.mesh];
    std::vector<float> xyz;
    for (const glm::dvec3& p : mesh.positions)
      for (int axis = 0; axis < 3; ++axis) xyz.push_back(static_cast<float>(p[axis]));
    std::vector<std::uint32_t> indices;
    for (const auto& corners : mesh.triangles) indices.insert(indices.end(), corners.begin(), corners.end());
    const glm::dvec3& at = part.worldFromPart.position;
    const int shape = builder.addMesh(builder.addPositions(xyz), builder.addIndices(indices));
    builder.addNode({{"mesh", shape}, {"name", part.name}, {"translation", {at.x, at.y, at.z}}});
  }
  const auto bytes = builder.glb();
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Makes the levels of all meshes on all cores, and keeps them.
void makeAll(const assets::Scene& scene, const Arguments& arguments, Report& report) {
  const std::clock_t began = std::clock();
  const Stopwatch watch;
  parallelFor(scene.meshes.size(), [&](std::size_t m) {
    const assets::ContentHash content = client::levelContent(scene.meshes[m]);
    if (client::readLevels(arguments.cache, content)) return;
    client::keepLevels(arguments.cache, content, client::makeLevels(scene.meshes[m], [] { return false; }));
  });
  report.value("levels made in", "s", watch.seconds());
  report.value("their processor time", "s", static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
}

void draw(const assets::Scene& scene, const Arguments& arguments, Report& report) {
  client::ViewModel model;
  model.scene = &scene;
  for (const assets::Part& part : scene.parts) model.worldFromPart.push_back(part.worldFromPart);
  model.owner.assign(scene.parts.size(), kNoSite);
  client::ViewerOptions options;
  options.width = 1280;
  options.height = 800;
  options.panels = false;
  options.levels = !arguments.exact;
  options.cacheDirectory = arguments.cache;
  Stopwatch opening;
  auto viewer = client::Viewer::openOffscreen(scene, options);
  if (!viewer) {
    std::fprintf(stderr, "%s\n", viewer.error().message.c_str());
    std::exit(2);
  }
  static_cast<void>((*viewer)->frame(model));
  report.value("first picture after", "s", opening.seconds());
  report.value("memory with it", "MB", memory("VmRSS"));
  report.value("off at first", "pixels", (*viewer)->pixelsOff());
  const Stopwatch waiting;
  while ((*viewer)->pixelsOff() > 1.0) {
    static_cast<void>((*viewer)->frame(model));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  report.value("within a pixel after", "s", waiting.seconds());
  const std::clock_t began = std::clock();
  const Stopwatch watch;
  for (int i = 0; i < arguments.frames; ++i) {
    (*viewer)->camera().yaw += 0.01;
    static_cast<void>((*viewer)->frame(model));
  }
  report.value("frames a second", "1/s", arguments.frames / watch.seconds());
  report.value("processor time of a frame", "ms",
               1e3 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC / arguments.frames);
  report.value("memory", "MB", memory("VmRSS"));
  report.value("memory at most", "MB", memory("VmHWM"));
  if (!arguments.picture.empty()) static_cast<void>((*viewer)->screenshot(arguments.picture));
}

int run(const Arguments& arguments) {
  Report report("bench_large");
  const Stopwatch making;
  const assets::Scene scene = generate::largeAssembly(arguments.parts, arguments.triangles);
  report.value("triangles", "", static_cast<double>(assets::triangleCount(scene)));
  report.value("made in", "s", making.seconds());
  report.value("memory of the scene", "MB", memory("VmRSS"));
  if (arguments.make) makeAll(scene, arguments, report);
  if (!arguments.write.empty())
    write(scene, arguments.write);
  else
    draw(scene, arguments, report);
  return arguments.json.empty() || report.writeJson(arguments.json) ? 0 : 1;
}

}  // namespace
}  // namespace tandem::bench

int main(int argc, char** argv) {
  tandem::bench::Arguments arguments;
  if (!tandem::bench::parse(argc, argv, arguments)) {
    std::fprintf(
        stderr,
        "usage: bench_large [--parts N] [--triangles N] [--frames N] [--exact 1] [--make 1] [--cache DIR] "
        "[--write FILE.glb] [--picture FILE.png] [--json FILE]\n");
    return 2;
  }
  return tandem::bench::run(arguments);
}
