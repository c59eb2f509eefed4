// bench_surfaces [--ticks N] [--repeats N] [--json OUT]
//
// What each effect of a surface costs in a tick, against the same contact with a bare spring: a plate (for
// shading a sphere) of some thousand triangles, 1 mm deep, stroked at 0.1 m/s. What a scene without effects
// pays. What 10,000 magnets cost against one. What it costs to ask Embree for the closest point at the same
// places, in the same run.
//
// Every run of a path does the same work tick by tick, so each tick counts with its best time of --repeats.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/base/command_line.h"
#include "haptics/surface/apply_surface.h"
#include "haptics/tick.h"
#include "tests/bench/bench_report.h"
#include "tests/bench/embree_yardstick.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/shapes.h"

namespace {

namespace haptics = tandem::haptics;
namespace bench = tandem::bench;
using tandem::assets::Material;
using tandem::assets::Scene;
using tandem::assets::Surface;
using Pattern = tandem::assets::SurfaceTexture::Pattern;

constexpr double kDepth = 1e-3;  // m
constexpr double kSize = 0.1;    // m, of the plate
constexpr int kApproach = 40;    // ticks, not measured

struct Options {
  int ticks = 5'000;
  int repeats = 7;
  std::string json;
};

/// A kind of surface, and what it is called.
struct Kind {
  std::string name;
  Surface surface;
  double friction = 0.0;
};

Kind kind(const char* name) { return {name, {}, 0.0}; }

Kind textured(const char* name, Pattern pattern) {
  Kind k = kind(name);
  k.surface.texture = {pattern, pattern == Pattern::image ? 0u : tandem::assets::kNoTexture, 1e-4, 0.0, 4e-3,
                       1.0};
  return k;
}

std::vector<Kind> kinds() {
  std::vector<Kind> all = {kind("friction"),
                           textured("image relief", Pattern::image),
                           textured("sine relief", Pattern::sine),
                           textured("grid relief", Pattern::grid),
                           textured("bump relief", Pattern::bumps),
                           textured("noise relief", Pattern::noise),
                           textured("friction and friction map", Pattern::image),
                           kind("viscosity"),
                           kind("vibration"),
                           kind("stick-slip"),
                           kind("magnet"),
                           kind("pop-through"),
                           kind("viscoelastic"),
                           kind("plastic"),
                           kind("all of them but the laws")};
  all[0].friction = all[6].friction = 0.3;
  all[6].surface.texture.amplitude = 0.0;
  all[6].surface.texture.frictionScale = 3.0;
  Surface& last = all.back().surface;
  last = all[1].surface;
  for (Surface* s : {&all[7].surface, &last}) s->viscosity = 2.0;
  for (Surface* s : {&all[8].surface, &last}) s->vibrationFrequency = 80.0, s->vibrationAmplitude = 0.2;
  for (Surface* s : {&all[9].surface, &last}) s->stickSlipForce = 0.3, s->stickSlipStiffness = 500.0;
  for (Surface* s : {&all[10].surface, &last}) s->magneticForce = 0.5, s->magneticDistance = 5e-3;
  for (Surface* s : {&all[11].surface, &last}) s->popThroughForce = 1e3;
  all[12].surface.law = Surface::Law::viscoelastic;
  all[12].surface.stiffness2 = 1000.0;
  all[12].surface.relaxation = 0.2;
  all[13].surface.law = Surface::Law::plastic;
  all[13].surface.yieldForce = 0.3;
  all[13].surface.hardening = 200.0;
  return all;
}

tandem::assets::TextureImage hills() {
  tandem::assets::TextureImage image{256, 256, {}};
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      image.texels.push_back(
          static_cast<std::uint8_t>(127.5 * (1.0 + std::sin(0.2 * x) * std::sin(0.15 * y))));
  return image;
}

tandem::assets::Mesh plate() {
  tandem::assets::Mesh mesh = tandem::test::sheetMesh(kSize, 40);
  for (const auto& t : mesh.triangles) {
    auto& uv = mesh.triangleUv.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) uv[c] = glm::vec2(mesh.positions[t[c]]) / static_cast<float>(kSize);
  }
  return mesh;
}

/// One part; `surface` null: nothing but a spring.
Scene sceneOf(tandem::assets::Mesh mesh, const Surface* surface, double friction = 0.0) {
  tandem::test::SceneBuilder b;
  Material& material = b.scene.materials[0];
  material.staticFriction = material.dynamicFriction = friction;
  if (surface != nullptr) {
    b.scene.surfaces.push_back(*surface);
    material.surface = 0;
    if (surface->texture.pattern == Pattern::image) b.scene.textures.push_back(hills());
  }
  b.addPart(std::move(mesh));
  return b.scene;
}

/// To and fro over the plate, `depth` under it.
std::vector<glm::dvec3> overPlate(int ticks, double depth) {
  std::vector<glm::dvec3> path;
  for (int i = 0; i < kApproach; ++i) path.emplace_back(0.0, 0.0, 4e-3 - (4e-3 + depth) * i / kApproach);
  for (int i = 0; i < ticks; ++i) {
    const double x = 0.04 * std::sin(2.5e-3 * i);
    path.emplace_back(x, 0.37 * x + 1.3e-3, -depth);
  }
  return path;
}

std::vector<glm::dvec3> aroundSphere(int ticks, double radius) {
  std::vector<glm::dvec3> path;
  for (int i = -kApproach; i < ticks; ++i) {
    const double a = 1e-4 / radius * std::max(i, 0), b = 2e-4 * std::max(i, 0);
    const double height = i < 0 ? 4e-3 - (4e-3 + kDepth) * (i + kApproach) / kApproach : -kDepth;
    path.push_back((radius + height) *
                   glm::dvec3(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)));
  }
  return path;
}

class Bench {
 public:
  Bench(const Options& options, bench::Report& report) : options_(options), report_(report) {}
  bool met() const { return met_; }

  void plates() {
    const std::vector<glm::dvec3> path = overPlate(options_.ticks, kDepth);
    const Scene plain = sceneOf(plate(), nullptr);
    const double yardstick = embree(plain, path);
    const double bare = row("bare plate", plain, path, yardstick, 0.0);
    row("  once more: what the machine adds", plain, path, yardstick, bare);
    row("beside a plate with effects", beside(), path, yardstick, bare);
    for (const Kind& k : kinds())
      row(k.name, sceneOf(plate(), &k.surface, k.friction), path, yardstick, bare);
  }

  /// What is asked of every tick of a scene without surfaces.
  void question() {
    const Scene plain = sceneOf(plate(), nullptr);
    const haptics::ContactScene contact(plain, 1);
    const haptics::ContactWorld world(contact);
    const haptics::Proxy proxy;
    const haptics::DeviceSample device;
    const haptics::TickParameters parameters;
    haptics::SurfaceState state;
    haptics::TickOutput out;
    constexpr int kTimes = 10'000'000;
    glm::dvec3 force(1.0, 0.0, 0.0);
    const bench::Stopwatch watch;
    for (int i = 0; i < kTimes; ++i) {
      force = haptics::applySurface(world, proxy, device, parameters, force, state, out);
      asm volatile("" : "+m"(force) : : "memory");
    }
    report_.value("without surfaces: the question", "ns", 1e9 * watch.seconds() / kTimes);
  }

  void shading() {
    constexpr double kRadius = 0.05;
    const std::vector<glm::dvec3> path = aroundSphere(options_.ticks, kRadius);
    const tandem::assets::Mesh mesh = tandem::tests::sphereMesh(kRadius, 10'000);
    const Scene plain = sceneOf(mesh, nullptr);
    const double yardstick = embree(plain, path);
    const double bare = row("bare sphere, 10k triangles", plain, path, yardstick, 0.0);
    Surface smooth;
    smooth.creaseAngle = 0.5;
    row("shading", sceneOf(mesh, &smooth), path, yardstick, bare);
  }

  /// Over magnets, near enough to be pulled and without touching: one, and one in the midst of ten thousand.
  void magnets() {
    Surface magnet;
    magnet.magneticForce = 0.5;
    magnet.magneticDistance = 2e-3;
    for (const bool relief : {false, true}) {
      Surface surface = relief ? Surface{} : magnet;
      if (relief) surface.texture = {Pattern::bumps, tandem::assets::kNoTexture, 1e-3, 0.0, 2e-3, 1.0};
      double one = 0.0;
      for (const int count : {1, 100, 10'000}) {
        Scene scene = tandem::tests::smallParts(count);
        scene.surfaces.push_back(surface);
        for (Material& material : scene.materials) material.surface = 0;
        std::vector<glm::dvec3> path;
        const glm::dvec3 over = scene.parts[scene.parts.size() / 2].worldFromPart.position;
        for (int i = -kApproach; i < options_.ticks; ++i)
          path.push_back(over + glm::dvec3(1e-3 * std::sin(0.01 * i), 1e-3 * std::cos(0.013 * i), 2.9e-3));
        const double yardstick = embree(scene, path);
        const std::string name = std::to_string(count) + (relief ? " parts with bumps" : " magnets");
        const double us = row(name, scene, path, yardstick, one);
        if (count == 1) one = us;
        if (count == 10'000) report_.value("  10,000 against one", "", us / one);
      }
    }
  }

 private:
  /// The bare plate with a plate of every effect out of the path's way.
  static Scene beside() {
    tandem::test::SceneBuilder b;
    b.scene.materials.push_back(b.scene.materials[0]);
    const Kind all = kinds().back();
    b.scene.surfaces.push_back(all.surface);
    b.scene.textures.push_back(hills());
    b.scene.materials[1].surface = 0;
    b.addPart(plate());
    tandem::assets::Mesh other = plate();
    std::fill(other.triangleMaterial.begin(), other.triangleMaterial.end(), std::uint16_t{1});
    b.addPart(b.addMesh(std::move(other)), {{0.3, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}});
    return b.scene;
  }

  /// Median of the best tick times, us, of a scene along a path; and what that is against `bare`.
  double row(const std::string& name, const Scene& scene, const std::vector<glm::dvec3>& path,
             double yardstick, double bare) {
    const haptics::ContactScene contact(scene, 1);
    std::vector<double> best(path.size() - kApproach, 1e300);
    std::uint64_t allocations = 0;
    for (int repeat = 0; repeat < options_.repeats; ++repeat) allocations += play(contact, path, best);
    const bench::Percentiles tick = bench::percentiles(best);
    report_.row(name, "us", tick);
    report_.value("  / Embree rtcPointQuery", "", tick.p50 / yardstick);
    if (bare > 0.0) report_.value("  more than bare", "ns", 1e3 * (tick.p50 - bare));
    met_ = report_.bound("  allocations", static_cast<double>(allocations), 0.0) && met_;
    return tick.p50;
  }

  static std::uint64_t play(const haptics::ContactScene& contact, const std::vector<glm::dvec3>& path,
                            std::vector<double>& best) {
    haptics::TickState state(contact);
    haptics::TickParameters parameters;
    parameters.stiffness = 1000.0;
    haptics::TickInput input;
    input.hands[0].device.valid = true;
    std::uint64_t allocations = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      if (i > 0) input.hands[0].device.twist.linear = (path[i] - path[i - 1]) / parameters.dt;
      input.hands[0].device.worldFromDevice.position = path[i];
      input.hands[0].device.time = 1e-3 * static_cast<double>(i);
      const tandem::test::AllocationScope scope;
      const bench::Stopwatch watch;
      static_cast<void>(haptics::tick(input, contact, parameters, state));
      const double us = 1e6 * watch.seconds();
      allocations += scope.count();
      if (i >= kApproach) best[i - kApproach] = std::min(best[i - kApproach], us);
    }
    return allocations;
  }

  /// Median of the best times of Embree's closest point, us.
  double embree(const Scene& scene, const std::vector<glm::dvec3>& path) {
    const bench::WorldMesh world = bench::flatten(scene);
    bench::EmbreeYardstick query(world);
    std::vector<double> best(path.size(), 1e300);
    for (int repeat = 0; repeat < options_.repeats; ++repeat) {
      for (std::size_t i = 0; i < path.size(); ++i) {
        const bench::Stopwatch watch;
        sum_ += query.closest(path[i]);
        best[i] = std::min(best[i], 1e6 * watch.seconds());
      }
    }
    return bench::percentiles(best).p50;
  }

  const Options& options_;
  bench::Report& report_;
  double sum_ = 0.0;  // keeps the queries from being optimised away
  bool met_ = true;
};

/// The exit code, where the program is to end now.
std::optional<int> parse(int argc, char** argv, Options& options) {
  tandem::assets::CommandLine line("What surface effects and fields cost a tick.", "bench_surfaces");
  line.option("--ticks", options.ticks, "ticks that are timed").showDefault().integerFrom(1, 10'000'000);
  line.option("--repeats", options.repeats, "runs, of which the fastest counts")
      .showDefault()
      .integerFrom(1, 1000);
  line.option("--json", options.json, "writes the figures").typeName("FILE");
  return line.parse("bench_surfaces", argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const std::optional<int> code = parse(argc, argv, options)) return *code;
  bench::Report report("bench_surfaces");
  Bench all(options, report);
  all.question();
  all.plates();
  all.shading();
  all.magnets();
  if (!options.json.empty() && !report.writeJson(options.json)) {
    std::fprintf(stderr, "%s: cannot be written\n", options.json.c_str());
    return 2;
  }
  return all.met() ? 0 : 1;
}
