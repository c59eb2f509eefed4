// bench_large: an assembly of many finely cut parts (50 of 200,000 triangles) drawn by the viewer while the
// camera turns: frames a second, memory, time until the first picture.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "assets/base/command_line.h"
#include "assets/base/parallel.h"
#include "assets/generate/large_assembly.h"
#include "client/levels/level_file.h"
#include "client/picture/level_choice.h"
#include "client/viewer/viewer.h"
#include "tests/bench/bench_report.h"
#include "tests/support/gltf_builder.h"

namespace tandem::bench {
namespace {

struct Arguments {
  int parts = 50, triangles = 200'000, frames = 20;
  int exact = 0, make = 0;  // 1: yes
  std::string write, json, picture, cache;
};

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
  options.levels = arguments.exact == 0;
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
  while ((*viewer)->pixelsOff() > client::kMostPixels) {
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
  if (arguments.make != 0) makeAll(scene, arguments, report);
  if (!arguments.write.empty())
    write(scene, arguments.write);
  else
    draw(scene, arguments, report);
  return arguments.json.empty() || report.writeJson(arguments.json) ? 0 : 1;
}

}  // namespace
}  // namespace tandem::bench

int main(int argc, char** argv) {
  tandem::bench::Arguments a;
  tandem::assets::CommandLine line("Draws an assembly of many finely cut parts while the camera turns.",
                                   "bench_large");
  line.option("--parts", a.parts, "parts of the assembly").showDefault().integerFrom(1, 10'000);
  line.option("--triangles", a.triangles, "triangles of each").showDefault().integerFrom(1, 10'000'000);
  line.option("--frames", a.frames, "frames that are timed").showDefault().integerFrom(1, 100'000);
  line.option("--exact", a.exact, "1: without levels of detail").integerFrom(0, 1);
  line.option("--make", a.make, "1: makes all levels first, on all cores").integerFrom(0, 1);
  line.option("--cache", a.cache, "folder in which levels are kept").typeName("DIR");
  line.option("--write", a.write, "writes the assembly for tandem-server and draws nothing")
      .typeName("FILE.glb");
  line.option("--picture", a.picture, "writes the last picture").typeName("FILE.png");
  line.option("--json", a.json, "writes the figures").typeName("FILE");
  if (const std::optional<int> code = line.parse("bench_large", argc, argv)) return *code;
  return tandem::bench::run(a);
}
