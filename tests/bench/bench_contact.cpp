// bench_contact [--ticks N] [--repeats N] [--only NAME] [--json OUT] [--large]
//
// The whole tick in contact, 2 mm deep at 1000 N/m, on geometry that is hard on distance queries: a gear of a
// million triangles, a sphere whose triangles are far smaller than the ball, rough scans, ten thousand parts
// that stand still or all move; and on paths that hover over a gear or a sphere, enter and leave. With
// --large also ten million triangles, which takes 4 GB. Embree's rtcPointQuery is asked at the same device
// positions in the same run. Then what it costs to build and to refit a tree, and to exchange a mesh.
//
// Every run of a path does the same work tick by tick, so each tick counts with
// its best time of --repeats runs: that leaves out what other programs on the
// machine cost. The row "of all repeats" leaves nothing out.
//
// Exits with 0 if every bound was met, but for those that haptics/README.md
// records as missed, which are shown only: all parts moving, a rough scan,
// and the refit.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "assets/base/command_line.h"
#include "client/report/targets.h"
#include "haptics/geometry/query_work.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/tick.h"
#include "tests/bench/bench_report.h"
#include "tests/bench/embree_yardstick.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/bench_meshes.h"

namespace {

namespace haptics = tandem::haptics;
namespace bench = tandem::bench;
namespace report = tandem::client::report;
namespace tests = tandem::tests;
using tandem::assets::Scene;

constexpr double kDepth = 0.002;  // m
constexpr double kSpeed = 0.1;    // m/s along the surface
constexpr int kApproach = 100;    // ticks from outside to full depth; not measured
constexpr double kPi = std::numbers::pi;
constexpr double kScanRadius = 0.010;  // m

struct Options {
  int ticks = 20'000;
  int repeats = 5;
  std::string only, json;
  bool large = false;
};

/// A point of a way along a surface and the direction out of it.
struct Stance {
  glm::dvec3 point, outward;
};

/// Device positions: from 3 mm outside to `depth` under the ball's rest
/// position at the first stance, then along.
std::vector<glm::dvec3> press(const std::vector<Stance>& stances, double radius) {
  std::vector<glm::dvec3> path;
  for (int i = 0; i < kApproach; ++i) {
    const double height = 0.003 - (0.003 + kDepth) * i / kApproach;
    path.push_back(stances.front().point + stances.front().outward * (radius + height));
  }
  for (const Stance& s : stances) path.push_back(s.point + s.outward * (radius - kDepth));
  return path;
}

/// Hovers at up to 1.5 mm, enters to 1.5 mm and leaves again, twice a second, after an approach in the air.
std::vector<glm::dvec3> swing(const std::vector<Stance>& stances, double radius) {
  std::vector<glm::dvec3> path(kApproach,
                               stances.front().point + stances.front().outward * (radius + 0.0015));
  for (std::size_t i = 0; i < stances.size(); ++i) {
    const double height = 0.0015 * std::cos(4e-3 * kPi * static_cast<double>(i));
    path.push_back(stances[i].point + stances[i].outward * (radius + height));
  }
  return path;
}

/// At a constant height over a surface.
std::vector<glm::dvec3> hover(const std::vector<Stance>& stances, double height) {
  std::vector<glm::dvec3> path(kApproach, stances.front().point + stances.front().outward * height);
  for (const Stance& s : stances) path.push_back(s.point + s.outward * height);
  return path;
}

/// Around the teeth: along every flank, tip and root, turning about the
/// corners, while z swings.
std::vector<Stance> gearOutline(int ticks) {
  const std::vector<glm::dvec2> profile = tests::gearProfile();
  const double step = kSpeed * 1e-3;
  std::vector<Stance> way;
  const auto add = [&](const glm::dvec2& p, double angle) {
    const double z = 0.5 * tests::kGearHeight + 0.003 * std::sin(1e-3 * static_cast<double>(way.size()));
    way.push_back({{p.x, p.y, z}, {std::cos(angle), std::sin(angle), 0.0}});
  };
  // The first edge is a tip, where the approach is free.
  for (std::size_t i = 7; static_cast<int>(way.size()) < ticks; i = (i + 1) % profile.size()) {
    const glm::dvec2 &a = profile[i], &b = profile[(i + 1) % profile.size()],
                     &c = profile[(i + 2) % profile.size()];
    const glm::dvec2 ab = b - a, bc = c - b;
    const double angle = std::atan2(-ab.x, ab.y), length = glm::length(ab);
    for (double s = 0.0; s < length; s += step) add(a + ab * (s / length), angle);
    // About the corner the device swings at the same speed on its arc of 2 mm.
    const double turn = std::remainder(std::atan2(-bc.x, bc.y) - angle, 2.0 * kPi);
    const int swing = static_cast<int>(std::abs(turn) * kDepth / step);
    for (int k = 1; k <= swing; ++k) add(b, angle + turn * k / (swing + 1));
  }
  way.resize(static_cast<std::size_t>(ticks));
  return way;
}

/// Round and round on the flat upper face.
std::vector<Stance> gearFace(int ticks) {
  std::vector<Stance> way;
  for (int i = 0; i < ticks; ++i) {
    const double angle = 1e-3 * kSpeed / 0.012 * i, r = 0.012 + 0.002 * std::sin(3e-4 * i);
    way.push_back({{r * std::cos(angle), r * std::sin(angle), tests::kGearHeight}, {0.0, 0.0, 1.0}});
  }
  return way;
}

std::vector<Stance> aroundSphere(double radius, int ticks) {
  std::vector<Stance> way;
  for (int i = 0; i < ticks; ++i) {
    const double a = 1e-3 * kSpeed / radius * i, b = 1e-4 * i;
    const glm::dvec3 n(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b));
    way.push_back({n * radius, n});
  }
  return way;
}

/// Around a scan of this radius (scanMesh()), on its waves.
std::vector<Stance> overScan(double radius, int ticks) {
  std::vector<Stance> way = aroundSphere(radius, ticks);
  for (Stance& s : way) s.point += s.outward * tests::scanWave(radius, s.outward);
  return way;
}

/// Straight lines over a floor of parts, at the height of their tops.
std::vector<Stance> overFloor(double half, double top, int ticks) {
  std::vector<Stance> way;
  for (int i = 0; i < ticks; ++i) {
    const double s = kSpeed * 1e-3 * i;
    const double x = std::abs(std::remainder(s, 4.0 * half)) - half;  // to and fro
    way.push_back({{x, 0.37 * x + 0.0013, top}, {0.0, 0.0, 1.0}});
  }
  return way;
}

/// All parts of a scene swing a little, each at its own phase; two frames of
/// input, to be used in turn.
std::vector<std::vector<haptics::PartMotion>> allMoving(const Scene& scene, int frames) {
  std::vector<std::vector<haptics::PartMotion>> motions(static_cast<std::size_t>(frames));
  for (int f = 0; f < frames; ++f) {
    for (std::size_t i = 0; i < scene.parts.size(); ++i) {
      const double phase = 2.0 * kPi * f / frames + static_cast<double>(i);
      haptics::PartMotion m;
      m.part = static_cast<tandem::PartId>(i);
      m.worldFromPart = scene.parts[i].worldFromPart;
      m.worldFromPart.position += 1e-4 * glm::dvec3(std::cos(phase), std::sin(phase), 0.3 * std::cos(phase));
      m.twist.linear = glm::dvec3(1e-3 * std::sin(phase), 0.0, 0.0);
      motions[static_cast<std::size_t>(f)].push_back(m);
    }
  }
  return motions;
}

struct Line {
  std::string name;
  report::TargetCost target;
  bool judged = true;  // by the exit code
};

class Bench {
 public:
  Bench(const Options& options, bench::Report& report) : options_(options), report_(report) {}
  bool wanted(const std::string& name) const { return name.find(options_.only) != std::string::npos; }
  bool anyWanted(const std::vector<std::string>& names) const {
    return std::any_of(names.begin(), names.end(), [this](const std::string& name) {
      return wanted(name) || options_.only.rfind(name, 0) == 0;
    });
  }
  bool met() const { return met_; }
  int ticks() const { return options_.ticks; }

  /// Times a scene's tick along a way; `motions` are the frames of moving
  /// parts, used in turn.
  void run(const Line& line, const haptics::ContactScene& contact, bench::EmbreeYardstick& embree,
           const std::vector<glm::dvec3>& path, double radius,
           const std::vector<std::vector<haptics::PartMotion>>& motions = {}) {
    if (!wanted(line.name)) return;
    const std::size_t counted = path.size() - kApproach;
    std::vector<double> ours(counted, 1e300), theirs(counted, 1e300), raw, nodes(counted), tests(counted);
    std::uint64_t allocations = 0;
    int touching = 0;
    for (int repeat = 0; repeat < options_.repeats; ++repeat) {
      touching = 0;
      play(
          contact, path, radius, motions,
          [&](std::size_t i, double us, const haptics::TickOutput& out, const haptics::QueryWork& work) {
            ours[i] = std::min(ours[i], us);
            raw.push_back(us);
            nodes[i] = static_cast<double>(work.nodes);
            tests[i] = static_cast<double>(work.triangles);
            touching += out.contactCount > 0 ? 1 : 0;
          },
          allocations);
      for (std::size_t i = 0; i < counted; ++i) {
        const bench::Stopwatch watch;
        sum_ += embree.closest(path[i + kApproach]);
        theirs[i] = std::min(theirs[i], 1e6 * watch.seconds());
      }
    }
    const bench::Percentiles tick = bench::percentiles(ours), query = bench::percentiles(theirs);
    report_.row(line.name, "us", tick);
    report_.row("  of all repeats", "us", bench::percentiles(raw));
    report_.row("  nodes visited", "", bench::percentiles(nodes));
    report_.row("  triangles tested exactly", "", bench::percentiles(tests));
    report_.row("  Embree rtcPointQuery", "us", query);
    report_.value("  p50 / Embree p50", "", tick.p50 / query.p50);
    report_.value("  p99 / Embree p99", "", tick.p99 / query.p99);
    report_.value("  in contact", "%", 100.0 * touching / static_cast<double>(ours.size()));
    const auto judge = [&](const char* which, double measured, double target) {
      if (!(target > 0.0)) return;
      const bool met = report_.bound("  " + line.name + which, measured, target);
      met_ = met_ && (met || !line.judged);
    };
    judge(" p50, us", tick.p50, line.target.p50);
    judge(" p99, us", tick.p99, line.target.p99);
    met_ = report_.bound("  allocations", static_cast<double>(allocations), 0.0) && met_;
  }

  void gear() {
    if (!anyWanted({"gear outline point", "gear face point", "gear outline ball 1 mm", "gear hover",
                    "gear in and out"}))
      return;
    const Scene scene = tests::sceneOf(tests::gearMesh(1'000'000, tests::Topology::always));
    const haptics::ContactScene contact(scene);
    const bench::WorldMesh world = bench::flatten(scene);
    bench::EmbreeYardstick embree(world);
    const std::vector<Stance> outline = gearOutline(ticks());
    run({"gear outline point", report::kGearTarget}, contact, embree, press(outline, 0.0), 0.0);
    run({"gear face point", report::kGearTarget}, contact, embree, press(gearFace(ticks()), 0.0), 0.0);
    run({"gear outline ball 1 mm", report::kGearBallTarget}, contact, embree, press(outline, 0.001), 0.001);
    for (const double height : {0.0003, 0.001, 0.002}) {
      const std::string name = "gear hover " + std::to_string(height * 1e3).substr(0, 3) + " mm";
      run({name, report::kGearTarget}, contact, embree, hover(outline, height), 0.0);
    }
    run({"gear in and out point", report::kGearTarget}, contact, embree, swing(outline, 0.0), 0.0);
    run({"gear in and out ball 1 mm", report::kGearBallTarget}, contact, embree, swing(outline, 0.001),
        0.001);
  }

  void sphere() {
    if (!anyWanted({"sphere ball 0 mm", "sphere ball 1 mm", "sphere ball 3 mm", "sphere hover",
                    "sphere in and out"}))
      return;
    const Scene scene = tests::sceneOf(tests::sphereMesh(0.010, 1'000'000, tests::Topology::always));
    const haptics::ContactScene contact(scene);
    const bench::WorldMesh world = bench::flatten(scene);
    bench::EmbreeYardstick embree(world);
    const std::vector<Stance> around = aroundSphere(0.010, ticks());
    for (const int mm : {0, 1, 3}) {
      run({"sphere ball " + std::to_string(mm) + " mm", report::kFineSphereTarget}, contact, embree,
          press(around, 1e-3 * mm), 1e-3 * mm);
    }
    run({"sphere hover 0.3 mm", report::kFineSphereTarget}, contact, embree, hover(around, 0.0003), 0.0);
    run({"sphere in and out", report::kFineSphereTarget}, contact, embree, swing(around, 0.0), 0.0);
  }

  /// Scans whose triangles are as rough as a scanner's noise, 5 % of an edge, makes them, and rougher.
  void scans() {
    if (!anyWanted({"scan 5 % point", "scan 5 % ball 1 mm", "scan 20 % point", "scan 20 % ball 1 mm"}))
      return;
    for (const int percent : {5, 20}) {
      const Scene scene =
          tests::sceneOf(tests::scanMesh(kScanRadius, 1'000'000, 0.01 * percent, 1, tests::Topology::always));
      const haptics::ContactScene contact(scene);
      const bench::WorldMesh world = bench::flatten(scene);
      bench::EmbreeYardstick embree(world);
      const std::string name = "scan " + std::to_string(percent) + " % ";
      const std::vector<Stance> over = overScan(kScanRadius, ticks());
      run({name + "point", report::kScanTarget, false}, contact, embree, press(over, 0.0), 0.0);
      run({name + "ball 1 mm", report::kScanBallTarget, false}, contact, embree, press(over, 0.001), 0.001);
    }
  }

  void tenMillion() {
    if (!options_.large || !wanted("sphere of 10 M")) return;
    const Scene scene = tests::sceneOf(tests::sphereMesh(0.050, 10'000'000, tests::Topology::always));
    const haptics::ContactScene contact(scene);
    const bench::WorldMesh world = bench::flatten(scene);
    bench::EmbreeYardstick embree(world);
    const std::vector<Stance> around = aroundSphere(0.050, ticks());
    run({"sphere of 10 M, point", report::kTenMillionTarget}, contact, embree, press(around, 0.0), 0.0);
    run({"sphere of 10 M, in and out", report::kTenMillionTarget}, contact, embree, swing(around, 0.0), 0.0);
  }

  void parts() {
    if (!wanted("10k parts still") && !wanted("10k parts moving") && !wanted("10k plates")) return;
    for (const bool plates : {false, true}) {
      const Scene scene = plates ? tests::plateGrid(100, 0.005, 0.002) : tests::smallParts(10'000);
      const haptics::ContactScene contact(scene);
      const bench::WorldMesh world = bench::flatten(scene);
      bench::EmbreeYardstick embree(world);
      const std::string name = plates ? "10k plates" : "10k parts";
      const std::vector<glm::dvec3> path = press(overFloor(0.2, plates ? 0.0 : 0.002, ticks()), 0.0);
      run({name + " still", report::kStillPartsTarget}, contact, embree, path, 0.0);
      // Plates that touch cannot swing without cutting into each other.
      if (plates) continue;
      run({name + " moving", report::kMovingPartsTarget, false}, contact, embree, path, 0.0,
          allMoving(scene, 8));
    }
  }

  /// What the thread that ticks pays when a mesh among ten thousand parts is exchanged, a part of the scene:
  /// the mesh of a single part, or of all of them, while they stand still and while they all move.
  void exchange() {
    if (!wanted("exchange")) return;
    Scene scene = tests::smallParts(10'000);
    scene.meshes.push_back(scene.meshes[0]);
    scene.parts[5'000].mesh = 1;
    const haptics::ContactScene contact(scene);
    const std::vector<std::vector<haptics::PartMotion>> motions = allMoving(scene, 2);
    for (const bool moving : {false, true}) {
      for (const std::uint32_t mesh : {1u, 0u}) {
        const std::string which =
            std::string("exchange, ") + (mesh == 1 ? "1 part" : "all parts") + (moving ? ", moving" : "");
        const haptics::ContactScene other =
            contact.withMesh(mesh, std::make_shared<const tandem::assets::Mesh>(scene.meshes[mesh]));
        haptics::TickState state(contact);
        const haptics::ContactScene* now = &contact;
        haptics::TickInput input;
        input.hands[0].device.valid = true;
        input.hands[0].device.worldFromDevice.position.z = 0.1;
        std::vector<double> changed, adopted;
        for (int i = 0; i < 10 * options_.repeats; ++i) {
          if (moving) input.moved = motions[static_cast<std::size_t>(i % 2)];
          haptics::tick(input, *now, {}, state);
          const bench::Stopwatch watch;
          if (i % 2 == 0) {
            state.meshesChanged(mesh);
            changed.push_back(1e9 * watch.seconds() / static_cast<double>(scene.parts.size()));
          } else {
            now = now == &contact ? &other : &contact;
            state.adopt(*now);
            adopted.push_back(1e9 * watch.seconds() / static_cast<double>(scene.parts.size()));
          }
        }
        report_.row(which + ": meshesChanged()", "ns a part", bench::percentiles(changed));
        report_.row(which + ": adopt()", "ns a part", bench::percentiles(adopted));
      }
    }
  }

  /// A mesh that is deformed to and fro: the tree in its old shape.
  void refit() {
    if (!wanted("refit")) return;
    tandem::assets::Mesh mesh = tests::gearMesh(100'000, tests::Topology::never);
    const std::vector<glm::dvec3> still = mesh.positions;
    haptics::TriangleBvh tree(mesh);
    for (const int threads : {1, 2}) {
      std::vector<double> wall;
      for (int i = 0; i < 25; ++i) {
        for (std::size_t k = 0; k < still.size(); ++k) {
          const glm::dvec3& p = still[k];
          mesh.positions[k] = p + 1e-4 * glm::dvec3(std::sin(300.0 * p.y + i), std::sin(200.0 * p.x), 0.0);
        }
        const bench::Stopwatch watch;
        tree.refit(threads);
        wall.push_back(1e3 * watch.seconds());
      }
      report_.row("refit 100 k, " + std::to_string(threads) + " threads", "ms", bench::percentiles(wall));
      if (threads == 2) {
        report_.bound("  refit 100 k, best, ms", *std::min_element(wall.begin(), wall.end()),
                      report::kRefitTarget_ms);
      }
    }
  }

  void build() {
    if (!wanted("build")) return;
    const tandem::assets::Mesh mesh = tests::gearMesh(1'000'000, tests::Topology::never);
    std::vector<double> wall;
    double processor = 1e300;
    for (int i = 0; i < 7; ++i) {
      const std::clock_t before = std::clock();
      const bench::Stopwatch watch;
      const haptics::TriangleBvh tree(mesh);
      wall.push_back(1e3 * watch.seconds());
      processor = std::min(processor, 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
    }
    report_.row("build 1 M", "ms", bench::percentiles(wall));
    report_.value("  processor time", "ms", processor);
    const Scene scene = tests::sceneOf(mesh);
    const bench::WorldMesh world = bench::flatten(scene);
    report_.value("  rtcCommitScene", "ms", 1e3 * bench::EmbreeYardstick(world).buildSeconds());
    met_ = report_.bound("  build 1 M, best, ms", *std::min_element(wall.begin(), wall.end()),
                         report::kBuildTarget_ms) &&
           met_;
  }

 private:
  /// Runs the path once from a fresh state; visit(i, us, out) for every tick
  /// after the approach.
  template <typename Visit>
  void play(const haptics::ContactScene& contact, const std::vector<glm::dvec3>& path, double radius,
            const std::vector<std::vector<haptics::PartMotion>>& motions, Visit&& visit,
            std::uint64_t& allocations) const {
    haptics::TickState state(contact);
    haptics::TickParameters parameters;
    parameters.toolRadius = radius;
    parameters.stiffness = 1000.0;
    haptics::TickInput input;
    input.hands[0].device.valid = true;
    for (std::size_t i = 0; i < path.size(); ++i) {
      input.hands[0].device.worldFromDevice.position = path[i];
      if (!motions.empty()) input.moved = motions[i % motions.size()];
      const tandem::test::AllocationScope scope;
      const haptics::QueryWork before = haptics::queryWork;
      const bench::Stopwatch watch;
      const haptics::TickOutput out = haptics::tick(input, contact, parameters, state);
      const double us = 1e6 * watch.seconds();
      allocations += scope.count();
      if (i >= kApproach) visit(i - kApproach, us, out, haptics::queryWork - before);
    }
  }

  const Options& options_;
  double sum_ = 0.0;  // keeps the queries from being optimised away
  bench::Report& report_;
  bool met_ = true;
};

/// The exit code, where the program is to end now.
std::optional<int> parse(int argc, char** argv, Options& options) {
  tandem::assets::CommandLine line("Ticks of a tool on and beside meshes of up to ten million triangles.",
                                   "bench_contact");
  line.option("--ticks", options.ticks, "ticks that are timed").showDefault().integerFrom(1, 10'000'000);
  line.option("--repeats", options.repeats, "runs, of which the fastest counts a tick")
      .showDefault()
      .integerFrom(1, 1000);
  line.option("--only", options.only, "the one bench that is run").typeName("NAME");
  line.flag("--large", options.large, "also ten million triangles");
  line.option("--json", options.json, "writes the figures").typeName("FILE");
  return line.parse("bench_contact", argc, argv);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const std::optional<int> code = parse(argc, argv, options)) return *code;
  bench::Report report("bench_contact");
  Bench all(options, report);
  all.gear();
  all.sphere();
  all.scans();
  all.tenMillion();
  all.parts();
  all.build();
  all.refit();
  all.exchange();
  if (!options.json.empty() && !report.writeJson(options.json)) {
    std::fprintf(stderr, "%s: cannot be written\n", options.json.c_str());
    return 2;
  }
  return all.met() ? 0 : 1;
}
