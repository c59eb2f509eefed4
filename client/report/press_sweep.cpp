#include "client/report/press_sweep.h"

#include <algorithm>
#include <chrono>

#include "assets/base/temporary_folder.h"
#include "client/report/part_sweep.h"
#include "haptics/scene/contact_scene_data.h"

namespace tandem::client::report {
namespace {

/// How many pairs of a family are pressed, and in how many poses each.
struct Extent {
  unsigned pairs, poses;
  int depthEvery;  // ticks
};
constexpr Extent kQuickExtent{1, 2, 10}, kFullExtent{3, 3, 5};

constexpr int kPressRuns = 2;  // each tick's cost is the least of them

/// A setting, and what all presses with it came to.
struct PressSetting {
  Making making;
  haptics::ContactEffort effort;
  PressMeasurement out;
  std::vector<std::vector<PartSample>> runs = std::vector<std::vector<PartSample>>(kPressRuns);
};

std::vector<PressSetting> settingsOf(const SweepOptions& options) {
  const haptics::ContactEffort used;
  haptics::ContactEffort samplesAlone;
  samplesAlone.descend = false;
  std::vector<PressSetting> all;
  const auto add = [&](double samples, const haptics::ContactEffort& effort) {
    PressSetting& setting = all.emplace_back();
    setting.making.samples = samples;
    setting.effort = effort;
    setting.out.figures = named(setting.making, effort);
  };
  add(1.0, used);
  add(1.0, samplesAlone);
  for (const double samples : {0.5, 2.0, 4.0})
    if (!options.quick || samples == 4.0) add(samples, used);
  return all;
}

double deepestOf(const std::vector<PartSample>& run) {
  double deepest = 0.0;
  for (const PartSample& sample : run) deepest = std::max(deepest, sample.depth);
  return deepest;
}

/// One press with every setting; the samples go behind those of the presses before.
class PressRun {
 public:
  PressRun(const PartExperiment& experiment, const SweepOptions& options, const std::string& fields)
      : experiment_(experiment), options_(options) {
    modelling_.cacheDirectory = fields;
  }

  void add(std::vector<PressSetting>& settings, int depthEvery) {
    for (PressSetting& setting : settings) {
      haptics::ContactScene contact(experiment_.scene);
      modelling_.fieldScale = setting.making.field;
      modelling_.sampleScale = setting.making.samples;
      const auto start = std::chrono::steady_clock::now();
      contact.modelParts(modelling_);
      const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
      setting.out.figures.build_ms += took.count();
      const haptics::PartModel& held = *contact.data().colliders[kHeldPart].model;
      setting.out.figures.spacing = std::max(setting.out.figures.spacing, held.samples.spacing());
      setting.out.figures.cell = std::max(setting.out.figures.cell, held.field.smallestCell());
      std::vector<std::vector<PartSample>> runs =
          runPart(experiment_, contact, kPressRuns, depthEvery, options_.allocations, setting.out.figures);
      setting.out.beyond += deepestOf(runs.front()) > experiment_.targetDepth ? 1 : 0;
      for (std::size_t k = 0; k < runs.size(); ++k) {
        // Nothing is said of the change from the last tick of one press to the first one of the next.
        runs[k].front().us = -1.0;
        setting.runs[k].insert(setting.runs[k].end(), runs[k].begin(), runs[k].end());
      }
    }
  }

 private:
  const PartExperiment& experiment_;
  const SweepOptions& options_;
  haptics::ModelOptions modelling_;
};

}  // namespace

std::vector<ExperimentInfo> chosenPressExperiments(const SweepOptions& options) {
  return chosenOf(allPressExperiments(), options);
}

PressResult sweepPresses(const ExperimentInfo& info, const SweepOptions& options) {
  const Extent extent = options.quick ? kQuickExtent : kFullExtent;
  PressResult result;
  result.info = info;
  std::vector<PressSetting> settings = settingsOf(options);
  PartExperiment all;                                      // the paths of all presses
  const assets::TemporaryFolder folder("tandem-report-");  // keeps fields that settings share
  for (unsigned pair = 0; pair < extent.pairs; ++pair)
    for (unsigned pose = 0; pose < extent.poses; ++pose) {
      const PartExperiment press = buildPress(familyOf(info.id), pair, pose);
      const std::size_t triangles = assets::triangleCount(press.scene);
      result.leastTriangles = result.presses == 0 ? triangles : std::min(result.leastTriangles, triangles);
      result.mostTriangles = std::max(result.mostTriangles, triangles);
      result.targetDepth = press.targetDepth;
      ++result.presses;
      PressRun(press, options, folder.path()).add(settings, extent.depthEvery);
      all.path.insert(all.path.end(), press.path.begin(), press.path.end());
    }
  result.ticks = all.path.size();
  for (PressSetting& setting : settings) {
    judgePart(all, setting.runs, setting.out.figures);
    result.settings.push_back(std::move(setting.out));
  }
  return result;
}

}  // namespace tandem::client::report
