#include "client/report/part_sweep.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <initializer_list>
#include <map>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/temporary_folder.h"
#include "client/base/thread_clock.h"
#include "haptics/measure/held_depth.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/tick.h"
#include "haptics/tick_data.h"

namespace tandem::client::report {
namespace {

constexpr int kRuns = 2;  // each tick's cost is the least of them
// Ticks between measurements of the depth: of large meshes they take ten milliseconds each.
constexpr int kDepthEvery = 7, kLarge = 9'000;
constexpr int kFewQueries = 30;

/// The experiment's coupling, without any limit that would hide the effect of contact.
haptics::TickParameters partParameters(const PartExperiment& e, const haptics::ContactEffort& effort) {
  haptics::TickParameters p;
  p.effort = effort;
  p.effort.taking = haptics::ContactEffort::kTakeAtOnce;
  p.graspStiffness = e.stiffness;
  p.graspDamping = e.damping;
  p.forceLimit = p.torqueLimit = 1e9;
  p.slewLimit = p.torqueSlewLimit = 1e12;
  return p;
}

/// The direction of the sum of all contact forces; zero without contacts.
glm::dvec3 directionOf(const haptics::TickOutput& out) {
  glm::dvec3 sum(0.0);
  for (int i = 0; i < out.contactCount; ++i)
    sum += out.contacts[static_cast<std::size_t>(i)].force * out.contacts[static_cast<std::size_t>(i)].normal;
  const double length = glm::length(sum);
  return length > 0.0 ? sum / length : glm::dvec3(0.0);
}

/// A hand that takes the part in the first tick and leads it along the path.
class PartRun {
 public:
  PartRun(const PartExperiment& experiment, const haptics::ContactScene& contact,
          const haptics::ContactEffort& effort, std::uint64_t (*counter)())
      : experiment_(experiment),
        contact_(contact),
        allocations_(counter),
        parameters_(partParameters(experiment, effort)),
        state_(contact) {}

  /// `meter` may be null: then no depth is measured.
  std::vector<PartSample> run(haptics::HeldPartDepthMeter* meter, int depthEvery) {
    std::vector<PartSample> samples;
    samples.reserve(experiment_.path.size());
    for (std::size_t i = 0; i < experiment_.path.size(); ++i) {
      samples.push_back(step(i));
      if (meter != nullptr && experiment_.path[i].depth && i % static_cast<std::size_t>(depthEvery) == 0)
        samples.back().depth = std::max(0.0, meter->measure(state_).depth);
    }
    return samples;
  }

  std::uint64_t allocations() const { return count_; }

 private:
  PartSample step(std::size_t i) {
    using Kind = haptics::PartCommand::Kind;
    const Pose& start = experiment_.scene.parts[kHeldPart].worldFromPart;
    const PartPathPoint& point = experiment_.path[i];
    const auto gripOf = [&](const PartPathPoint& p) {
      return p.turned * start.orientation * experiment_.grip;
    };
    haptics::TickInput input;
    Twist& twist = input.hands[0].device.twist;
    input.hands[0].device.worldFromDevice = {point.goal + gripOf(point), point.turned * start.orientation};
    if (i > 0) {
      const PartPathPoint& last = experiment_.path[i - 1];
      twist.linear = ((point.goal - last.goal) + (gripOf(point) - gripOf(last))) / parameters_.dt;
      twist.angular = rotationVector(point.turned * glm::conjugate(last.turned)) / parameters_.dt;
    }
    input.hands[0].device.time = parameters_.dt * static_cast<double>(i);
    input.hands[0].device.valid = true;
    const haptics::PartCommand take[2] = {{Kind::own, kHeldPart, start}, {Kind::grasp, kHeldPart, {}}};
    if (i == 0) input.commands = take;
    const std::uint64_t before = allocations_ != nullptr ? allocations_() : 0;
    const double begin = threadMicroseconds();
    const haptics::TickOutput out = haptics::tick(input, contact_, parameters_, state_);
    const double end = threadMicroseconds();
    if (allocations_ != nullptr) count_ += allocations_() - before;
    PartSample sample{end - begin, out.hands[0].toHand.force, directionOf(out)};
    if (const haptics::PartContact* contact = state_.data().partContact.get(); contact != nullptr) {
      sample.active = static_cast<int>(contact->touches().size());
      sample.solved = contact->work().iterations;
    }
    return sample;
  }

  const PartExperiment& experiment_;
  const haptics::ContactScene& contact_;
  std::uint64_t (*allocations_)();
  const haptics::TickParameters parameters_;
  haptics::TickState state_;
  std::uint64_t count_ = 0;
};

std::vector<Making> makingsOf(const SweepOptions& options) {
  if (options.quick) return {{1.0, 1.0}, {1.0, 4.0}, {4.0, 1.0}};
  std::vector<Making> all{{1.0, 1.0}};
  for (const double field : {0.5, 1.0, 2.0, 4.0, 8.0})
    for (const double samples : {0.5, 1.0, 2.0, 4.0})
      if (const Making making{field, samples}; !making.asUsed()) all.push_back(making);
  return all;
}

/// The efforts of the tick on such a model, first the one in use. Refinement is turned off on every field at
/// two densities of samples. Steps and queries are cut on three models, to compare that with coarser cells
/// and samples.
std::vector<haptics::ContactEffort> effortsOf(const Making& making, const SweepOptions& options) {
  const haptics::ContactEffort used;
  std::vector<haptics::ContactEffort> all{used};
  const auto cut = [&](std::initializer_list<int> steps, std::initializer_list<int> queries, bool exact) {
    for (const int n : steps) all.push_back({n, used.sampleQueries, exact});
    for (const int n : queries) all.push_back({used.steps, n, exact});
  };
  if (options.quick) {
    if (!making.asUsed()) return all;
    all.push_back({used.steps, used.sampleQueries, false});
    cut({1}, {kFewQueries}, true);
    return all;
  }
  if (making.samples == 1.0 || making.samples == 4.0) all.push_back({used.steps, used.sampleQueries, false});
  const bool corner =
      (making.field == 4.0 && making.samples == 1.0) || (making.field == 1.0 && making.samples == 4.0);
  if (making.asUsed() || corner) cut({1, 2}, {kFewQueries, 100}, true);
  if (making.asUsed()) cut({1, 2}, {kFewQueries, 100}, false);
  return all;
}

}  // namespace

PartMeasurement named(const Making& making, const haptics::ContactEffort& effort) {
  PartMeasurement out;
  out.fieldScale = making.field;
  out.sampleScale = making.samples;
  out.effort = effort;
  const haptics::ContactEffort used;
  char text[80];
  std::string setting;
  const auto add = [&](const char* id, const char* name, auto value) {
    std::snprintf(text, sizeof text, id, value);
    if (!setting.empty()) setting += '-';
    setting += text;
    std::snprintf(text, sizeof text, name, value);
    out.name += std::string(", ") + text;
  };
  out.name = "Tandem";
  if (!making.asUsed()) {
    add("field-%g", "field x %g", making.field);
    add("samples-%g", "samples x %g", making.samples);
  }
  if (effort.steps != used.steps) add("steps-%d", "steps %d", effort.steps);
  if (effort.sampleQueries != used.sampleQueries) add("queries-%d", "queries %d", effort.sampleQueries);
  if (!effort.exact) add("unrefined%s", "not refined%s", "");
  if (!effort.descend) add("samples-alone%s", "at the samples alone%s", "");
  out.setting = setting.empty() ? std::string("tandem") : setting;
  return out;
}

std::vector<std::vector<PartSample>> runPart(const PartExperiment& experiment,
                                             const haptics::ContactScene& contact, int runs, int depthEvery,
                                             std::uint64_t (*allocations)(), PartMeasurement& out) {
  ASSERT(runs > 0 && depthEvery > 0 && &contact.scene() == &experiment.scene);
  haptics::HeldPartDepthMeter meter(contact, kHeldPart);
  std::vector<std::vector<PartSample>> all;
  for (int i = 0; i < runs; ++i) {
    PartRun run(experiment, contact, out.effort, allocations);
    all.push_back(run.run(i == 0 ? &meter : nullptr, depthEvery));
    out.allocations += run.allocations();
  }
  out.allocationsCounted = allocations != nullptr;
  return all;
}

void measureTick(const PartExperiment& experiment, const haptics::ContactScene& contact, int runs,
                 int depthEvery, std::uint64_t (*allocations)(), PartMeasurement& out) {
  judgePart(experiment, runPart(experiment, contact, runs, depthEvery, allocations, out), out);
}

std::vector<ExperimentInfo> chosenPartExperiments(const SweepOptions& options) {
  return chosenOf(allPartExperiments(), options);
}

int partTicksOf(const SweepOptions& options) { return options.quick ? 800 : 2000; }

PartExperimentResult sweepPart(const ExperimentInfo& info, const SweepOptions& options) {
  const PartExperiment experiment = buildPartExperiment(info.id, partTicksOf(options), options.quick);
  PartExperimentResult result;
  result.info = info;
  result.triangles = assets::triangleCount(experiment.scene);
  result.ticks = experiment.path.size();
  result.targetDepth = experiment.targetDepth;
  for (const PartPathPoint& p : experiment.path)
    if (p.force) result.peakForce = std::max(result.peakForce, glm::length(p.exactForce));
  const int depthEvery = result.triangles > kLarge ? kDepthEvery : 1;
  const assets::TemporaryFolder folder("tandem-report-");  // keeps fields that settings share
  std::map<double, double> built;                          // ms, of the fields of a scale
  for (const Making& making : makingsOf(options)) {
    const auto start = std::chrono::steady_clock::now();
    haptics::ContactScene contact(experiment.scene);
    haptics::ModelOptions modelling;
    modelling.cacheDirectory = folder.path();
    modelling.fieldScale = making.field;
    modelling.sampleScale = making.samples;
    contact.modelParts(modelling);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    for (const haptics::ContactEffort& effort : effortsOf(making, options)) {
      PartMeasurement& out = result.settings.emplace_back(named(making, effort));
      out.build_ms = built.emplace(making.field, took.count()).first->second;
      const haptics::PartModel& held = *contact.data().colliders[kHeldPart].model;
      out.cell = held.field.smallestCell();
      out.spacing = held.samples.spacing();
      out.memory = contact.memory();
      measureTick(experiment, contact, kRuns, depthEvery, options.allocations, out);
    }
  }
  return result;
}

}  // namespace tandem::client::report
