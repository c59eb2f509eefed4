// bench_peers --json OUT [--quick] [--scenes ID...]
//
// The experiments of `tandem report` with what other libraries offer for contact: the nearest point of a
// mesh. The force is a spring to that point while the tool is inside, which the nearest triangle's normal
// decides. Embree 3 answers with rtcPointQuery, FCL with distance() between the mesh and a sphere of no size.
// Where the hand holds a part, FCL, and Bullet and ODE where they are installed, are asked for the contacts
// of two meshes (part_peers/).

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/distance.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assets/base/command_line.h"
#include "client/report/part_sweep.h"
#include "client/report/report_json.h"
#include "client/report/sweep.h"
#include "haptics/geometry/triangle_math.h"
#include "tests/bench/embree_yardstick.h"
#include "tests/bench/part_peers/measure_part_peers.h"

namespace {

namespace report = tandem::client::report;
namespace bench = tandem::bench;
using Clock = std::chrono::steady_clock;

double microseconds(Clock::time_point from) {
  return std::chrono::duration<double, std::micro>(Clock::now() - from).count();
}

/// The triangles of an experiment, world frame.
class Triangles {
 public:
  explicit Triangles(const tandem::assets::Scene& scene) {
    for (const tandem::assets::Part& part : scene.parts) {
      const tandem::assets::Mesh& mesh = scene.meshes[part.mesh];
      for (const auto& t : mesh.triangles)
        all_.push_back({tandem::transformPoint(part.worldFromPart, mesh.positions[t[0]]),
                        tandem::transformPoint(part.worldFromPart, mesh.positions[t[1]]),
                        tandem::transformPoint(part.worldFromPart, mesh.positions[t[2]])});
    }
  }

  const std::vector<tandem::haptics::Triangle>& all() const { return all_; }

  /// Where a spring holds a ball whose centre is at `device`: outside, touching the surface in `point`.
  glm::dvec3 proxy(const glm::dvec3& device, double radius, const glm::dvec3& point,
                   std::size_t triangle) const {
    const tandem::haptics::Triangle& t = all_[triangle];
    const glm::dvec3 normal = glm::normalize(glm::cross(t.b - t.a, t.c - t.a)), way = device - point;
    const double distance = glm::length(way);
    const bool inside = glm::dot(way, normal) < 0.0;
    if (!inside && distance >= radius) return device;
    const glm::dvec3 outward = distance > 0.0 ? way * ((inside ? -1.0 : 1.0) / distance) : normal;
    return point + outward * radius;
  }

 private:
  std::vector<tandem::haptics::Triangle> all_;
};

struct Answer {
  glm::dvec3 point{0.0, 0.0, 0.0};
  std::size_t triangle = 0;
};

class EmbreePeer {
 public:
  static constexpr const char* kId = "embree";
  static constexpr const char* kName = "Embree rtcPointQuery";

  explicit EmbreePeer(const report::Experiment& e, const Triangles&)
      : mesh_(bench::flatten(e.scene)), embree_(mesh_) {}
  double build_ms() const { return 1e3 * embree_.buildSeconds(); }
  Answer nearest(const glm::dvec3& p) {
    const bench::EmbreeYardstick::Nearest found = embree_.closestPoint(p);
    return {glm::dvec3(found.point), found.triangle};
  }

 private:
  const bench::WorldMesh mesh_;
  bench::EmbreeYardstick embree_;
};

class FclPeer {
 public:
  static constexpr const char* kId = "fcl";
  static constexpr const char* kName = "FCL distance";

  FclPeer(const report::Experiment&, const Triangles& triangles)
      : triangles_(triangles),
        model_(std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>()),
        tool_(std::make_shared<fcl::Sphered>(0.0)) {
    std::vector<fcl::Vector3d> corners;
    std::vector<fcl::Triangle> indices;
    for (const tandem::haptics::Triangle& t : triangles.all()) {
      const std::size_t first = corners.size();
      for (const glm::dvec3& p : {t.a, t.b, t.c}) corners.emplace_back(p.x, p.y, p.z);
      indices.emplace_back(first, first + 1, first + 2);
    }
    const Clock::time_point start = Clock::now();
    model_->beginModel(static_cast<int>(indices.size()), static_cast<int>(corners.size()));
    model_->addSubModel(corners, indices);
    model_->endModel();
    build_ms_ = 1e-3 * microseconds(start);
  }
  double build_ms() const { return build_ms_; }
  Answer nearest(const glm::dvec3& p) {
    fcl::Transform3d at = fcl::Transform3d::Identity();
    at.translation() = fcl::Vector3d(p.x, p.y, p.z);
    fcl::DistanceRequestd request;
    request.gjk_solver_type = fcl::GST_INDEP;
    fcl::DistanceResultd result;
    fcl::distance(model_.get(), fcl::Transform3d::Identity(), tool_.get(), at, request, result);
    const auto triangle = static_cast<std::size_t>(std::max<intptr_t>(result.b1, 0));
    return {tandem::haptics::closestPointOnTriangle(p, triangles_.all()[triangle]).point, triangle};
  }

 private:
  const Triangles& triangles_;
  std::shared_ptr<fcl::BVHModel<fcl::OBBRSSd>> model_;
  std::shared_ptr<fcl::Sphered> tool_;
  double build_ms_ = 0.0;
};

template <typename Peer>
report::Measurement measure(const report::Experiment& e, const Triangles& triangles, int runs) {
  Peer peer(e, triangles);
  report::Measurement out;
  out.setting = Peer::kId;
  out.name = Peer::kName;
  out.kind = report::Kind::peer;
  out.build_ms = peer.build_ms();
  std::vector<report::Samples> all(static_cast<std::size_t>(runs));
  for (report::Samples& samples : all)
    for (const report::PathPoint& point : e.path) {
      const Clock::time_point start = Clock::now();
      const Answer answer = peer.nearest(point.device);
      samples.us.push_back(microseconds(start));
      const glm::dvec3 proxy =
          triangles.proxy(point.device, e.info.toolRadius, answer.point, answer.triangle);
      samples.force.push_back(report::springForce(e.stiffness, proxy, point.device));
    }
  report::judge(e, all, out);
  return out;
}

/// The exit code, where the program is to end now.
std::optional<int> parse(int argc, char** argv, report::SweepOptions& options, std::string& json) {
  tandem::assets::CommandLine line("The scenes of 'tandem report' as other libraries feel them.",
                                   "bench_peers");
  line.option("--json", json, "writes the measures for 'tandem report --peers'").typeName("FILE").required();
  line.flag("--quick", options.quick, "shorter runs");
  line.option("--scenes", options.only, "the scenes that are measured").typeName("ID");
  return line.parse("bench_peers", argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  report::SweepOptions options;
  std::string path;
  if (const std::optional<int> code = parse(argc, argv, options, path)) return *code;
  report::SweepResult result;
  result.quick = options.quick;
  result.machine = report::machineLine();
  result.peers = {"Embree " RTC_VERSION_STRING};
  for (const std::string& version : bench::partPeerVersions()) result.peers.push_back(version);
  for (const report::ExperimentInfo& info : report::chosenExperiments(options)) {
    const report::Experiment e = report::buildExperiment(info.id, report::ticksOf(options));
    if (e.partsMove) continue;            // these trees stand for still triangles
    if (e.info.friction > 0.0) continue;  // a nearest point has none
    std::fprintf(stderr, "peers: %s\n", info.title.c_str());
    const Triangles triangles(e.scene);
    report::ExperimentResult& out = result.experiments.emplace_back();
    out.info = e.info;
    out.settings.push_back(measure<EmbreePeer>(e, triangles, report::runsOf(options)));
    // Tenths of a millisecond a query: one run less is still a minute less.
    out.settings.push_back(measure<FclPeer>(e, triangles, 2));
  }
  for (const report::ExperimentInfo& info : report::chosenPartExperiments(options)) {
    std::fprintf(stderr, "peers: %s\n", info.title.c_str());
    result.held.push_back(bench::measurePartPeers(info, options));
  }
  std::ofstream file(path);
  file << report::toJson(result);
  file.close();
  if (!file) {
    std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
    return 2;
  }
  return 0;
}
