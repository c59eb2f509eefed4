#include "client/report/sweep.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include <glm/geometric.hpp>

#include "client/report/bare_spring.h"
#include "client/report/baseline_proxy.h"
#include "client/report/link_sweep.h"
#include "client/report/part_sweep.h"
#include "client/report/press_sweep.h"
#include "haptics/scene/contact_scene.h"
#include "haptics/tick.h"
#include "haptics/tick_data.h"

namespace tandem::client::report {
namespace {

using Clock = std::chrono::steady_clock;

// rad: far above the angle between facets of a sphere of 1000 triangles, and between those of a scan
constexpr double kSmoothBelow = 0.6;

constexpr int kStrokes = 200, kQuickStrokes = 20;  // through a model

double microseconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::micro>(to - from).count();
}

/// Options of a Tandem setting.
struct Knobs {
  bool remember = true;    // known planes are kept from tick to tick
  bool floatData = false;  // the device's position is rounded to single precision
};

/// Runs Tandem's tick over a path.
class TandemRun {
 public:
  TandemRun(const Experiment& experiment, const haptics::ContactScene& contact, const Knobs& knobs,
            std::uint64_t (*counter)())
      : experiment_(experiment),
        contact_(contact),
        knobs_(knobs),
        allocations_(counter),
        parameters_(bareSpring(experiment.stiffness, experiment.info.toolRadius)),
        state_(contact) {
    if (!experiment.partsMove) return;
    for (std::size_t i = 0; i < experiment.scene.parts.size(); ++i)
      moved_.push_back({static_cast<PartId>(i), experiment.scene.parts[i].worldFromPart, {}});
  }

  Samples run() {
    Samples samples;
    samples.us.reserve(experiment_.path.size());
    samples.force.reserve(experiment_.path.size());
    samples.depth.reserve(experiment_.path.size());
    double lift = 0.0;
    for (const PathPoint& point : experiment_.path) {
      liftParts(point.lift, lift);
      lift = point.lift;
      const glm::dvec3 device =
          knobs_.floatData ? glm::dvec3(glm::vec<3, float>(point.device)) : point.device;
      step(device, samples);
    }
    return samples;
  }

  std::uint64_t allocations() const { return count_; }

 private:
  void liftParts(double lift, double before) {
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      moved_[i].worldFromPart.position =
          experiment_.scene.parts[i].worldFromPart.position + glm::dvec3(0.0, 0.0, lift);
      moved_[i].twist.linear = glm::dvec3(0.0, 0.0, (lift - before) / parameters_.dt);
    }
  }

  /// Resets the proxy except for the state on which friction and the path depend: its position and whether it
  /// slides.
  static void forget(haptics::Proxy& proxy) {
    haptics::Proxy fresh;
    fresh.position = proxy.position;
    fresh.sliding = proxy.sliding;
    proxy = fresh;
  }

  void step(const glm::dvec3& device, Samples& samples) {
    haptics::TickInput input;
    input.hands[0].device.worldFromDevice.position = device;
    input.hands[0].device.time = parameters_.dt * static_cast<double>(samples.us.size());
    input.hands[0].device.valid = true;
    input.moved = moved_;
    if (!knobs_.remember) forget(state_.data().tool.proxy());
    const std::uint64_t before = allocations_ ? allocations_() : 0;
    const Clock::time_point start = Clock::now();
    const haptics::TickOutput out = haptics::tick(input, contact_, parameters_, state_);
    const Clock::time_point end = Clock::now();
    if (allocations_) count_ += allocations_() - before;
    samples.us.push_back(microseconds(start, end));
    samples.force.push_back(out.hands[0].toHand.force);
    samples.depth.push_back(glm::length(out.worldFromProxy.position - device));
  }

  const Experiment& experiment_;
  const haptics::ContactScene& contact_;
  const Knobs knobs_;
  std::uint64_t (*allocations_)();
  const haptics::TickParameters parameters_;
  haptics::TickState state_;
  std::vector<haptics::PartMotion> moved_;
  std::uint64_t count_ = 0;
};

/// A scene whose vertices are world coordinates in single precision, as many libraries store them.
assets::Scene floatCopy(const assets::Scene& scene) {
  assets::Scene copy = scene;
  assets::Part& part = copy.parts.front();
  for (glm::dvec3& p : copy.meshes[part.mesh].positions)
    p = glm::dvec3(glm::vec<3, float>(transformPoint(part.worldFromPart, p)));
  part.worldFromPart = Pose{};
  return copy;
}

class ExperimentSweep {
 public:
  ExperimentSweep(const Experiment& experiment, const SweepOptions& options)
      : experiment_(experiment), options_(options) {}

  std::vector<Measurement> run() {
    const Clock::time_point start = Clock::now();
    const haptics::ContactScene contact(experiment_.scene);
    const double build_ms = 1e-3 * microseconds(start, Clock::now());
    tandem("tandem", "Tandem", contact, {}).build_ms = build_ms;
    tandem("no-memory", "Tandem, contacts forgotten every tick", contact, {false, false}).build_ms = build_ms;
    if (experiment_.scene.parts.size() == 1) singlePrecisionData();
    if (experiment_.curved) shaded();
    if (!experiment_.partsMove && !(experiment_.info.toolRadius > 0.0) &&
        !(experiment_.info.friction > 0.0)) {
      baselines<double>("double", "double");
      baselines<float>("float", "float");
    }
    return std::move(results_);
  }

 private:
  Measurement& tandem(const char* id, const char* name, const haptics::ContactScene& contact,
                      const Knobs& knobs) {
    Measurement& out = results_.emplace_back();
    out.setting = id;
    out.name = name;
    out.kind = Kind::tandem;
    out.allocationsCounted = options_.allocations != nullptr;
    std::vector<Samples> runs;
    for (int i = 0; i < runsOf(options_); ++i) {
      TandemRun run(experiment_, contact, knobs, options_.allocations);
      runs.push_back(run.run());
      out.allocations += run.allocations();
    }
    judge(experiment_, runs, out);
    return out;
  }

  void singlePrecisionData() {
    const assets::Scene rounded = floatCopy(experiment_.scene);
    const Clock::time_point start = Clock::now();
    const haptics::ContactScene contact(rounded);
    const double build_ms = 1e-3 * microseconds(start, Clock::now());
    tandem("float-data", "Tandem, coordinates stored as float", contact, {true, true}).build_ms = build_ms;
  }

  void shaded() {
    assets::Scene smooth = experiment_.scene;
    smooth.surfaces.emplace_back().creaseAngle = kSmoothBelow;
    for (assets::Material& material : smooth.materials) material.surface = 0;
    const Clock::time_point start = Clock::now();
    const haptics::ContactScene contact(smooth);
    const double build_ms = 1e-3 * microseconds(start, Clock::now());
    tandem("shading", "Tandem, force shading", contact, {}).build_ms = build_ms;
  }

  template <typename Real>
  void baselines(const std::string& id, const std::string& precision) {
    const Clock::time_point start = Clock::now();
    const SegmentTree<Real> tree(experiment_.scene);
    const double build_ms = 1e-3 * microseconds(start, Clock::now());
    baseline<Real>("three-planes-" + id, "Baseline, three planes a tick, " + precision, tree,
                   PlaneOrder::threePlanesATick, build_ms);
    baseline<Real>("one-plane-" + id, "Baseline, one plane a tick, " + precision, tree,
                   PlaneOrder::onePlaneATick, build_ms);
  }

  template <typename Real>
  void baseline(const std::string& id, const std::string& name, const SegmentTree<Real>& tree,
                PlaneOrder order, double build_ms) {
    Measurement& out = results_.emplace_back();
    out.setting = id;
    out.name = name;
    out.kind = Kind::baseline;
    out.build_ms = build_ms;
    std::vector<Samples> runs;
    for (int i = 0; i < runsOf(options_); ++i) {
      BaselineProxy<Real> proxy(tree, order, experiment_.path.front().device);
      Samples& samples = runs.emplace_back();
      for (const PathPoint& point : experiment_.path) {
        const Clock::time_point from = Clock::now();
        const glm::dvec3 force = springForce(experiment_.stiffness, proxy.follow(point.device), point.device);
        samples.us.push_back(microseconds(from, Clock::now()));
        samples.force.push_back(force);
      }
    }
    judge(experiment_, runs, out);
  }

  const Experiment& experiment_;
  const SweepOptions& options_;
  std::vector<Measurement> results_;
};

/// The error of the force that the facets of a sphere cause by their depth and, at the depth of the stroke,
/// by their tilt.
double facetError(const Experiment& e) {
  double deepest = 0.0;
  for (const PathPoint& p : e.path) deepest = std::max(deepest, glm::length(p.exactProxy - p.device));
  // A proxy keeps its facet until the goal has left the facet's prism, so that at most twice the tilt counts.
  return e.stiffness * (e.facetDepth + 2.0 * e.facetTilt * (deepest + e.facetDepth));
}

}  // namespace

std::vector<ExperimentInfo> chosenExperiments(const SweepOptions& options) {
  return chosenOf(allExperiments(), options);
}

int ticksOf(const SweepOptions& options) { return options.quick ? 800 : 4000; }
int runsOf(const SweepOptions& options) { return options.quick ? 2 : 3; }

SweepResult sweep(const SweepOptions& options) {
  SweepResult result;
  result.quick = options.quick;
  result.machine = machineLine();
  const std::vector<ExperimentInfo> chosen = chosenExperiments(options),
                                    held = chosenPartExperiments(options),
                                    presses = chosenPressExperiments(options),
                                    links = chosenLinkExperiments(options);
  const std::size_t all = chosen.size() + held.size() + presses.size() + links.size() + options.models.size();
  std::size_t done = 0;
  const auto next = [&](const ExperimentInfo& info) {
    if (options.progress) options.progress(done, all, info);
    ++done;
  };
  for (const ExperimentInfo& info : chosen) {
    next(info);
    const Experiment experiment = buildExperiment(info.id, ticksOf(options));
    ExperimentResult& out = result.experiments.emplace_back();
    out.info = experiment.info;
    out.triangles = assets::triangleCount(experiment.scene);
    out.parts = experiment.scene.parts.size();
    out.ticks = experiment.path.size();
    out.facetError = facetError(experiment);
    for (const PathPoint& p : experiment.path)
      out.peakForce =
          std::max(out.peakForce, glm::length(springForce(experiment.stiffness, p.exactProxy, p.device)));
    out.settings = ExperimentSweep(experiment, options).run();
  }
  for (const ExperimentInfo& info : held) {
    next(info);
    result.held.push_back(sweepPart(info, options));
  }
  for (const ExperimentInfo& info : presses) {
    next(info);
    result.presses.push_back(sweepPresses(info, options));
  }
  for (const ExperimentInfo& info : links) {
    next(info);
    result.links.push_back(sweepLinks(info, options));
  }
  for (const StrokedModel& model : options.models) {
    ExperimentInfo info;
    info.title = "Strokes through " + model.name;
    next(info);
    const int usual = options.quick ? kQuickStrokes : kStrokes;
    result.strokes.push_back(
        sweepStrokes(model, options.strokes > 0 ? options.strokes : usual, runsOf(options)));
  }
  if (options.only.empty()) result.figures = measureFigures(options.quick);
  return result;
}

std::string machineLine() {
  std::string model = "unknown processor", line;
  std::ifstream info("/proc/cpuinfo");
  while (std::getline(info, line)) {
    if (line.rfind("model name", 0) != 0 || line.find(": ") == std::string::npos) continue;
    model = line.substr(line.find(": ") + 2);
    break;
  }
  std::string load;
  std::ifstream("/proc/loadavg") >> load;
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores, load " + load;
}

}  // namespace tandem::client::report
