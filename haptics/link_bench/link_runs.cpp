#include "haptics/link_bench/link_runs.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/base/minimum_jerk.h"

namespace tandem::bench {

using haptics::minimumJerk;
using haptics::SixAxes;

namespace {

constexpr double kWall = 0.005, kPress = 2.0;  // m, N

void noteChanges(const HandBench& bench, Tally& tally) {
  for (std::size_t i = 0; i < bench.siteCount(); ++i) {
    tally.change = std::max(tally.change, bench.site(i).change);
    tally.turnChange = std::max(tally.turnChange, bench.site(i).turnChange);
  }
}

double squareOf(const glm::dvec3& v) { return glm::dot(v, v); }

}  // namespace

void Tally::note(const HandBench& bench) {
  astray = bench.astray();
  created = bench.maxCreated;
  inLinks = bench.maxInLinks;
}

void Tally::worst(const Tally& other) {
  astray = astray || other.astray;
  created = std::max(created, other.created);
  inLinks = std::max(inLinks, other.inLinks);
  change = std::max(change, other.change);
  turnChange = std::max(turnChange, other.turnChange);
}

std::vector<BenchSite> twoHands(const haptics::ArmParameters& first, const haptics::ArmParameters& second,
                                bool offCentre) {
  if (!offCentre) return {{first, {}}, {second, {}}};
  return {{first, {0.03, 0.025, 0.01}}, {second, {-0.04, -0.02, 0.015}}};
}

SixAxes dragPath(double t, double amplitude) {
  const double s = t - 1.0;
  if (s < 0.0) return {};
  const double share = s < 1.0 ? minimumJerk(s) : s > 8.0 ? 1.0 - minimumJerk(s - 8.0) : 1.0;
  return {{amplitude * share * std::sin(3.14159265358979 * s), 0.0, 0.0}, {}};
}

DragFigures drag(HandBench& bench, const DragPlan& plan) {
  DragFigures figures;
  const glm::dvec3 axis{0.6, 0.64, 0.48};
  const auto intent = [&](double t, int who) {
    if (who != 0) return SixAxes{};
    SixAxes displacement = dragPath(t, plan.amplitude);
    displacement.about = (SixAxisArm::kLever * plan.turn / plan.amplitude * displacement.along.x) * axis;
    return displacement;
  };
  double ticks = 0.0;
  while (bench.time() < plan.until && !bench.astray()) {
    bench.step(intent);
    const double t = bench.time();
    if (t > plan.from && t < plan.to) noteChanges(bench, figures);
    if (t < 3.0 || t > 8.0) continue;
    const double gap = bench.gap(0, 1), turn = bench.turnGap(0, 1), off = bench.site(0).offGrip();
    figures.rms += gap * gap;
    figures.turnRms += turn * turn;
    figures.offGrip += off * off;
    figures.most = std::max(figures.most, gap);
    figures.load += squareOf(bench.site(0).onHand.force);
    ticks += 1.0;
  }
  figures.note(bench);
  for (double* square : {&figures.rms, &figures.turnRms, &figures.offGrip, &figures.load})
    *square = std::sqrt(*square / ticks);
  return figures;
}

PullFigures pull(HandBench& bench, LetGo who, double until) {
  PullFigures figures;
  const auto intent = [](double t, int site) {
    return site == 1 ? SixAxes{{0.015 * minimumJerk((t - 1.0) / 0.4), 0.0, 0.0}, {}} : SixAxes{};
  };
  double ticks = 0.0, force = 0.0, displacement = 0.0, low = 1e9, high = -1e9;
  while (bench.time() < until && !bench.astray()) {
    if (std::abs(bench.time() - kLetGo) < 0.5 * kTick) {
      if (who != LetGo::nobody) bench.site(1).arm.letGo();
      if (who == LetGo::both) bench.site(0).arm.letGo();
    }
    bench.step(intent);
    const double t = bench.time();
    if (t > kLetGo - 1.5 && t < kLetGo) {
      force += glm::length(bench.site(0).onHand.force);
      displacement +=
          glm::length(bench.site(1).arm.device().position - bench.site(0).arm.device().position -
                      (bench.site(1).bodyFromGrip.position - bench.site(0).bodyFromGrip.position));
      ticks += 1.0;
    }
    if (t < until - 1.5) continue;
    low = std::min(low, bench.site(0).centre().position.x);
    high = std::max(high, bench.site(0).centre().position.x);
    noteChanges(bench, figures);
  }
  figures.note(bench);
  figures.stiffness = force / std::max(1e-6, displacement);
  figures.rest = high - low;
  figures.restless = figures.change;
  return figures;
}

Block beforeWall(Block block) {
  block.wall = 0.5 * block.size.x + kWall;
  return block;
}

PressFigures press(HandBench& bench, const haptics::ArmParameters& arm) {
  PressFigures figures;
  const double displacement = kWall + kPress / arm.stiffness;
  const auto intent = [&](double t, int site) {
    const double share = t < 5.0 ? minimumJerk((t - 1.0) / 2.0) : 1.0 - minimumJerk((t - 5.0) / 2.0);
    return site == 1 ? SixAxes{{displacement * share, 0.0, 0.0}, {}} : SixAxes{};
  };
  double xx = 0.0, xf = 0.0;
  const glm::dvec3 start = bench.site(1).arm.reading().position;
  while (bench.time() < 7.5 && !bench.astray()) {
    bench.step(intent);
    if (bench.site(1).push < 0.02) continue;
    const double in = bench.site(1).arm.reading().position.x - start.x - kWall;
    xx += in * in;
    xf -= in * bench.site(1).onHand.force.x;
  }
  figures.note(bench);
  figures.stiffness = xf / xx;
  return figures;
}

DragFigures drag(const BenchSetup& setup, const DragPlan& plan) {
  LinkBench bench(setup);
  return drag(bench, plan);
}

PullFigures pull(const BenchSetup& setup, LetGo who) {
  LinkBench bench(setup);
  return pull(bench, who);
}

PressFigures press(const BenchSetup& given) {
  BenchSetup setup = given;
  setup.block = beforeWall(setup.block);
  LinkBench bench(setup);
  return press(bench, setup.sites[1].arm);
}

}  // namespace tandem::bench
