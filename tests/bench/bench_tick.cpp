// bench_tick [FILE.glb] [--scale M_PER_UNIT] [--ticks N] [--json OUT]
//
// A point tool walks over the parts of a scene: down onto a surface, along it under pressure, up again,
// thousands of places. Each tick is timed; so is Embree's rtcPointQuery at the same device points on the same
// triangles. Then the build of the tree over a million triangles, against rtcCommitScene.

#include <embree3/rtcore.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "assets/load_gltf.h"
#include "haptics/contact_scene_data.h"
#include "haptics/tick.h"
#include "tests/bench/bench_report.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"

namespace {

using tandem::assets::Scene;
namespace haptics = tandem::haptics;
namespace bench = tandem::bench;

struct Options {
  std::string file, json;
  double scale = 0.001;
  int ticks = 100'000;
};

/// All triangles of a scene in world coordinates, as Embree sees them.
struct WorldMesh {
  std::vector<float> positions;        // 3 a vertex
  std::vector<std::uint32_t> corners;  // 3 a triangle
};

WorldMesh flatten(const Scene& scene) {
  WorldMesh out;
  for (const tandem::assets::Part& part : scene.parts) {
    if (part.mesh == tandem::assets::kNone) continue;
    const tandem::assets::Mesh& mesh = scene.meshes[part.mesh];
    const auto first = static_cast<std::uint32_t>(out.positions.size() / 3);
    for (const glm::dvec3& p : mesh.positions) {
      const glm::dvec3 world = tandem::transformPoint(part.worldFromPart, p);
      for (int i = 0; i < 3; ++i) out.positions.push_back(static_cast<float>(world[i]));
    }
    for (const auto& t : mesh.triangles) {
      for (const std::uint32_t v : t) out.corners.push_back(first + v);
    }
  }
  return out;
}

/// The yardstick: closest point by Embree, with the same triangle routine in single precision.
class EmbreeYardstick {
 public:
  explicit EmbreeYardstick(const WorldMesh& mesh) : mesh_(&mesh), device_(rtcNewDevice("threads=2")) {
    scene_ = rtcNewScene(device_);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             3 * sizeof(float), mesh.positions.size() / 3);
    void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(std::uint32_t), mesh.corners.size() / 3);
    std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<float*>(vertices));
    std::copy(mesh.corners.begin(), mesh.corners.end(), static_cast<std::uint32_t*>(indices));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    const bench::Stopwatch watch;
    rtcCommitScene(scene_);
    buildSeconds_ = watch.seconds();
  }
  ~EmbreeYardstick() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeYardstick(const EmbreeYardstick&) = delete;
  EmbreeYardstick& operator=(const EmbreeYardstick&) = delete;

  double buildSeconds() const { return buildSeconds_; }

  /// Distance from p to the nearest triangle, m.
  double closest(const glm::dvec3& p) {
    RTCPointQuery query{};
    query.x = static_cast<float>(p.x);
    query.y = static_cast<float>(p.y);
    query.z = static_cast<float>(p.z);
    query.radius = std::numeric_limits<float>::infinity();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &query, &context, &EmbreeYardstick::visit, const_cast<WorldMesh*>(mesh_));
    return query.radius;
  }

 private:
  static glm::vec3 corner(const WorldMesh& mesh, std::uint32_t triangle, std::uint32_t i) {
    const float* p = &mesh.positions[3 * mesh.corners[3 * triangle + i]];
    return {p[0], p[1], p[2]};
  }

  /// Ericson's closest point, in float.
  static glm::vec3 closestOnTriangle(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b,
                                     const glm::vec3& c) {
    const glm::vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0.0f && d2 <= 0.0f) return a;
    const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0.0f && d4 <= d3) return b;
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return a + ab * (d1 / (d1 - d3));
    const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0.0f && d5 <= d6) return c;
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return a + ac * (d2 / (d2 - d6));
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0.0f && d4 - d3 >= 0.0f && d5 - d6 >= 0.0f) {
      return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    const float sum = 1.0f / (va + vb + vc);
    return a + ab * (vb * sum) + ac * (vc * sum);
  }

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    const WorldMesh& mesh = *static_cast<const WorldMesh*>(arguments->userPtr);
    const glm::vec3 p(arguments->query->x, arguments->query->y, arguments->query->z);
    const std::uint32_t t = arguments->primID;
    const float distance =
        glm::length(p - closestOnTriangle(p, corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2)));
    if (!(distance < arguments->query->radius)) return false;
    arguments->query->radius = distance;
    return true;
  }

  const WorldMesh* mesh_;
  RTCDevice device_;
  RTCScene scene_ = nullptr;
  double buildSeconds_ = 0.0;
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
  const WorldMesh mesh = flatten(scene);
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
      for (int k = 0; k < 300; ++k) haptics::tick({sample, {}, {}}, contact, {}, state);
      sample.valid = true;
    }
    const tandem::test::AllocationScope scope;
    const bench::Stopwatch watch;
    const haptics::TickOutput out = haptics::tick({sample, {}, {}}, contact, {}, state);
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
  const WorldMesh world = flatten(scene);
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

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool more = i + 1 < argc;
    if (argument == "--json" && more) {
      options.json = argv[++i];
    } else if (argument == "--scale" && more) {
      options.scale = std::atof(argv[++i]);
    } else if (argument == "--ticks" && more) {
      options.ticks = std::atoi(argv[++i]);
    } else if (argument[0] != '-' && options.file.empty()) {
      options.file = argument;
    } else {
      return false;
    }
  }
  return options.ticks > 0 && options.scale > 0.0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) {
    std::fprintf(stderr, "usage: bench_tick [FILE.glb] [--scale M_PER_UNIT] [--ticks N] [--json OUT]\n");
    return 2;
  }
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
