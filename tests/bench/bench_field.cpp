// bench_field [--tolerance M] [--cell M] [--threads N] [--json OUT] [FILE UNIT]...
//
// Distance fields: seconds and memory to bake, cells, what they know near the surface, and a lookup's time.
// Without files: shapes made in code, of up to half a million triangles.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/base/command_line.h"
#include "assets/gltf/load_gltf.h"
#include "haptics/geometry/triangle_bvh.h"
#include "haptics/scene/distance_field.h"
#include "tests/bench/bench_report.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/shapes.h"

namespace {

namespace haptics = tandem::haptics;
namespace bench = tandem::bench;
using tandem::assets::Mesh;

struct Options {
  haptics::DistanceField::Options field;
  std::string json;
  std::vector<std::string> files;
};

/// A peg of diameter 20 mm and height 40 mm with chamfers of 1 mm, of about `triangles` triangles.
Mesh peg(int triangles) {
  tandem::test::ShapeBuilder b;
  const int around = static_cast<int>(std::sqrt(triangles * 0.8)), up = triangles / (2 * around) - 3;
  std::vector<std::pair<double, double>> profile = {{9e-3, 0.0}};
  for (int i = 0; i <= up; ++i) profile.emplace_back(10e-3, 1e-3 + 38e-3 * i / up);
  profile.emplace_back(9e-3, 40e-3);
  const std::uint32_t bottom = b.vertex(0.0, 0.0, 0.0), top = b.vertex(0.0, 0.0, 40e-3);
  for (const auto& [radius, height] : profile)
    for (int i = 0; i < around; ++i) {
      const double angle = 2.0 * tandem::kPi * i / around;
      b.vertex(radius * std::cos(angle), radius * std::sin(angle), height);
    }
  const auto at = [around](std::size_t ring, int i) {
    return static_cast<std::uint32_t>(2 + ring * static_cast<std::size_t>(around) +
                                      static_cast<std::size_t>(i % around));
  };
  for (int i = 0; i < around; ++i) {
    b.triangle(bottom, at(0, i + 1), at(0, i));
    b.triangle(top, at(profile.size() - 1, i), at(profile.size() - 1, i + 1));
    for (std::size_t ring = 0; ring + 1 < profile.size(); ++ring)
      b.quad(at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i));
  }
  return b.mesh();
}

/// Points within `reach` of the surface, relative to the field's origin.
std::vector<glm::vec3> pointsNear(const Mesh& mesh, const haptics::DistanceField& field, double reach,
                                  std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<double> areas;
  for (const auto& t : mesh.triangles)
    areas.push_back(glm::length(glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                           mesh.positions[t[2]] - mesh.positions[t[0]])));
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  std::vector<glm::vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& t = mesh.triangles[pick(random)];
    const double u = std::sqrt(unit(random)), v = unit(random);
    const glm::dvec3 on = (1.0 - u) * mesh.positions[t[0]] + u * (1.0 - v) * mesh.positions[t[1]] +
                          u * v * mesh.positions[t[2]];
    const glm::dvec3 off(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5);
    points.emplace_back(on + 2.0 * reach * off - field.origin());
  }
  return points;
}

class Bench {
 public:
  Bench(const Options& options, bench::Report& report) : options_(options), report_(report) {}

  /// Returns seconds and bytes of the field.
  std::pair<double, double> mesh(const std::string& name, const Mesh& mesh) {
    const haptics::TriangleBvh tree(mesh);
    const bench::Stopwatch watch;
    const haptics::DistanceField field(tree, options_.field);
    const double seconds = watch.seconds();
    std::printf("%s: %zu triangles%s%s\n", name.c_str(), mesh.triangles.size(),
                field.solid() ? "" : ", no inside", field.coarsened() ? ", coarsened" : "");
    report_.value(name + " bake", "s", seconds);
    report_.value(name + " memory", "MB", 1e-6 * static_cast<double>(field.memory()));
    report_.value(name + " cells", "", static_cast<double>(field.cells()));
    report_.value(name + " smallest cell", "um", 1e6 * field.smallestCell());
    report_.value(name + " tolerance", "um", 1e6 * field.tolerance());
    report_.value(name + " worst smooth", "um", 1e6 * field.worstSmoothError());
    errors(name, mesh, field);
    lookups(name, mesh, field);
    return {seconds, static_cast<double>(field.memory())};
  }

 private:
  /// The error of the cells met at random near the surface.
  void errors(const std::string& name, const Mesh& mesh, const haptics::DistanceField& field) {
    std::vector<double> errors;
    std::size_t fine = 0;
    for (const glm::vec3& p : pointsNear(mesh, field, 0.5 * field.band(), 20'000)) {
      const auto reading = field.read(p);
      errors.push_back(1e6 * static_cast<double>(reading.error));
      fine += static_cast<double>(reading.error) <= 1.1 * field.tolerance() ? 1 : 0;
    }
    report_.value(name + " within tolerance", "%", 100.0 * static_cast<double>(fine) / 20'000.0);
    report_.row(name + " error near", "um", bench::percentiles(errors));
  }

  void lookups(const std::string& name, const Mesh& mesh, const haptics::DistanceField& field) {
    const std::vector<glm::vec3> points = pointsNear(mesh, field, field.band(), 4'000);
    double best = 1e300;
    float sum = 0.0f;
    for (int repeat = 0; repeat < 50; ++repeat) {
      const bench::Stopwatch watch;
      for (const glm::vec3& p : points) sum += field.read(p).distance;
      best = std::min(best, watch.seconds());
    }
    asm volatile("" : "+m"(sum) : : "memory");
    report_.value(name + " lookup", "ns", 1e9 * best / static_cast<double>(points.size()));
  }

  const Options& options_;
  bench::Report& report_;
};

/// The exit code, where the program is to end now.
std::optional<int> parse(int argc, char** argv, Options& options) {
  tandem::assets::CommandLine line(
      "Distance fields of meshes: what they cost to bake and to ask, and how exact they are.", "bench_field");
  line.option("--tolerance", options.field.tolerance, "m by which a distance may be wrong")
      .numberFrom(0.0, 1e9);
  line.option("--cell", options.field.smallestCell, "side of the smallest cell, m").numberFrom(0.0, 1e9);
  line.option("--threads", options.field.threads, "threads that bake; 0: one a core").integerFrom(0, 1024);
  line.option("files", options.files, "scenes, each with its unit of length [box, sphere and pegs]")
      .typeName("FILE UNIT");
  line.option("--json", options.json, "writes the figures").typeName("FILE");
  return line.parse("bench_field", argc, argv);
}

bool file(const std::string& path, const std::string& unit, Bench& run, bench::Report& report) {
  tandem::assets::LoadOptions load;
  const auto scale = tandem::assets::parseUnits(unit);
  if (!scale) return false;
  load.unitScale = *scale;
  const auto scene = tandem::assets::loadGltf(path, load);
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.error().message.c_str());
    return false;
  }
  double seconds = 0.0, bytes = 0.0;
  for (std::size_t i = 0; i < scene->meshes.size(); ++i) {
    const auto [took, size] = run.mesh("mesh " + std::to_string(i), scene->meshes[i]);
    seconds += took;
    bytes += size;
  }
  std::fflush(stdout);
  report.value("all meshes, bake", "s", seconds);
  report.value("all meshes, memory", "MB", 1e-6 * bytes);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const std::optional<int> code = parse(argc, argv, options)) return *code;
  if (options.files.size() % 2 != 0) {
    std::fprintf(stderr, "bench_field: %s needs its unit of length behind it\n",
                 options.files.back().c_str());
    return 2;
  }
  bench::Report report("bench_field");
  Bench run(options, report);
  if (options.files.empty()) {
    run.mesh("box", tandem::test::boxMesh({0.03, 0.02, 0.01}));
    run.mesh("sphere", tandem::test::sphereMesh(0.01, 100));
    run.mesh("peg 5k", peg(5'000));
    run.mesh("peg 500k", peg(500'000));
  }
  for (std::size_t i = 0; i < options.files.size(); i += 2)
    if (!file(options.files[i], options.files[i + 1], run, report)) return 1;
  return options.json.empty() || report.writeJson(options.json) ? 0 : 1;
}
