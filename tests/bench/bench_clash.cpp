// How long it takes to measure parts against each other, and a whole assembly.
//
//   bench_clash [ASSEMBLY.glb] [--json OUT.json]
//
// The yardstick is FCL 0.7 in the same run: distance() between trees of OBBRSS over the same triangles at the
// same poses, in double. With a file (numbers in millimetres) all pairs of its parts that come within 5 mm
// are measured by both, and then `tandem check --clash` is run on it, in all and without loading.

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/distance.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "assets/gltf/load_gltf.h"
#include "client/review/clash_check.h"
#include "haptics/geometry/mesh_distance.h"
#include "haptics/overlap/mesh_overlap.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/scene/contact_scene_data.h"
#include "tests/bench/bench_report.h"
#include "tests/support/bench_meshes.h"
#include "tests/support/part_meshes.h"

namespace tandem {
namespace {

constexpr double kEverything = 1e300;

using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Model> fclModel(const assets::Mesh& mesh) {
  std::vector<fcl::Vector3d> corners;
  std::vector<fcl::Triangle> triangles;
  for (const glm::dvec3& p : mesh.positions) corners.emplace_back(p.x, p.y, p.z);
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  auto model = std::make_shared<Model>();
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(corners.size()));
  model->addSubModel(corners, triangles);
  model->endModel();
  return model;
}

fcl::Transform3d fclPose(const Pose& pose) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  const glm::dquat& q = pose.orientation;
  out.linear() = fcl::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
  out.translation() = fcl::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return out;
}

/// One mesh as both libraries know it.
struct Body {
  explicit Body(const assets::Mesh& mesh) : tree(mesh), closing(tree), model(fclModel(mesh)) {}
  haptics::TriangleBvh tree;
  haptics::MeshClosing closing;
  std::shared_ptr<Model> model;
};

/// Times of both over some poses.
struct Times {
  std::vector<double> tandem_us, fcl_us, overlap_us;
  double largestDifference = 0.0;  // m, between the two distances
};

void measure(const Body& a, const Pose& worldFromA, const Body& b, const Pose& worldFromB, Times& times) {
  haptics::MeshGap gap;
  const bench::Stopwatch own;
  haptics::nearestPoints({&a.tree, worldFromA}, {&b.tree, worldFromB}, kEverything, gap);
  times.tandem_us.push_back(1e6 * own.seconds());
  const bench::Stopwatch overlapping;
  haptics::overlapOf({&a.tree, worldFromA}, a.closing, {&b.tree, worldFromB}, b.closing);
  times.overlap_us.push_back(1e6 * overlapping.seconds());
  fcl::DistanceRequestd request;
  fcl::DistanceResultd result;
  const bench::Stopwatch theirs;
  fcl::distance(a.model.get(), fclPose(worldFromA), b.model.get(), fclPose(worldFromB), request, result);
  times.fcl_us.push_back(1e6 * theirs.seconds());
  const double theirDistance = std::max(0.0, result.min_distance);
  times.largestDifference = std::max(times.largestDifference, std::abs(theirDistance - gap.distance));
}

void tell(bench::Report& report, const std::string& name, const Times& times) {
  report.row(name + ", distance", "us", bench::percentiles(times.tandem_us));
  report.row(name + ", FCL", "us", bench::percentiles(times.fcl_us));
  report.row(name + ", overlap", "us", bench::percentiles(times.overlap_us));
  double own = 0.0, theirs = 0.0;
  for (const double t : times.tandem_us) own += t;
  for (const double t : times.fcl_us) theirs += t;
  report.value(name + ", share of FCL's time", "", own / theirs);
  report.value(name + ", distances differ by", "m", times.largestDifference);
}

/// Two copies of a mesh beside each other, some apart and some crossing, turned at random.
void beside(bench::Report& report, const std::string& name, const assets::Mesh& mesh, double spread) {
  const Body body(mesh);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Times times;
  for (int i = 0; i < 20; ++i) {
    const glm::dvec3 way = glm::normalize(glm::dvec3(u(random), u(random), u(random)));
    const Pose there{way * spread, fromRotationVector({u(random), u(random), u(random)})};
    measure(body, {}, body, there, times);
  }
  tell(report, name, times);
}

/// A shaft of 20 mm in a bore that is 20 um wider all round: everywhere almost equally near.
void pegInBore(bench::Report& report, int triangles) {
  test::BoredBlock block;
  block.boreRadius = 0.01002;
  block.facets = test::facetsFor(triangles);
  test::Peg peg;
  peg.facets = block.facets;
  const assets::Mesh shaft = test::meshOf(test::pegSoup(peg)),
                     bore = test::meshOf(test::boredBlockSoup(block));
  const Body a(bore), b(shaft);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Times times;
  for (int i = 0; i < 5; ++i) {
    const Pose there{{5e-6 * u(random), 5e-6 * u(random), -0.03}, fromRotationVector({0.0, 0.0, u(random)})};
    measure(a, {}, b, there, times);
  }
  const std::size_t count = shaft.triangles.size() + bore.triangles.size();
  tell(report, "peg in bore, " + std::to_string(count) + " tri.", times);
}

/// All pairs of an assembly whose parts come within 5 mm of each other.
void assembly(bench::Report& report, const std::string& file) {
  assets::LoadOptions options;
  options.unitScale = 0.001;
  const bench::Stopwatch all;
  const Result<assets::Scene> scene = assets::loadScene(file, options, "");
  if (!scene) {
    std::fprintf(stderr, "bench_clash: %s\n", scene.error().message.c_str());
    std::exit(2);
  }
  const haptics::ContactScene contact(*scene);
  const bench::Stopwatch asked;
  const client::ClashReport clashes = client::findClashes(contact, {});
  report.value("assembly, all clashes", "s", asked.seconds());
  report.value("assembly, from the file on", "s", all.seconds());
  report.value("assembly, pairs measured", "", static_cast<double>(clashes.pairs));
  report.value("assembly, found", "", static_cast<double>(clashes.clashes.size()));

  client::ClashOptions near;
  near.clearance = 0.005;
  std::vector<std::unique_ptr<Body>> bodies;
  for (const assets::Mesh& mesh : scene->meshes) bodies.push_back(std::make_unique<Body>(mesh));
  Times times;
  for (const client::Clash& clash : client::findClashes(contact, near).clashes) {
    const assets::Part &a = scene->parts[clash.a], &b = scene->parts[clash.b];
    if (a.mesh == assets::kNone || b.mesh == assets::kNone) continue;
    measure(*bodies[a.mesh], a.worldFromPart, *bodies[b.mesh], b.worldFromPart, times);
  }
  tell(report, "assembly, pairs within 5 mm", times);
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  std::string file, json;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc)
      json = argv[++i];
    else if (argv[i][0] != '-' && file.empty())
      file = argv[i];
    else {
      std::fprintf(stderr, "bench_clash [ASSEMBLY.glb] [--json OUT.json]\n");
      return 2;
    }
  }
  using namespace tandem;
  bench::Report report("bench_clash");
  beside(report, "gears of 100 k", tests::gearMesh(100'000), 0.044);
  beside(report, "spheres of 100 k", tests::sphereMesh(0.02, 100'000), 0.0401);
  pegInBore(report, 5'000);
  pegInBore(report, 50'000);
  if (!file.empty()) assembly(report, file);
  if (!json.empty() && !report.writeJson(json)) {
    std::fprintf(stderr, "bench_clash: cannot write %s\n", json.c_str());
    return 2;
  }
  return 0;
}
