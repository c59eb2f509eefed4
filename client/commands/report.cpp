#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "assets/base/allocation_counter.h"
#include "client/commands/command.h"
#include "client/report/html.h"
#include "client/report/link_page.h"
#include "client/report/link_sweep.h"
#include "client/report/part_experiment.h"
#include "client/report/peers.h"
#include "client/report/press_experiment.h"
#include "client/report/report_json.h"
#include "client/report/sweep.h"

namespace tandem::client {
namespace {

struct ReportArguments {
  std::string out = "report.html", json, peers;
  std::vector<std::string> scenes, models;
  int strokes = 0;
  bool quick = false, thoroughLinks = false, noPeers = false;
};

std::vector<report::ExperimentInfo> everyExperiment() {
  std::vector<report::ExperimentInfo> all = report::allExperiments();
  for (report::ExperimentInfo& info : report::allPartExperiments()) all.push_back(std::move(info));
  for (report::ExperimentInfo& info : report::allPressExperiments()) all.push_back(std::move(info));
  for (report::ExperimentInfo& info : report::allLinkExperiments()) all.push_back(std::move(info));
  return all;
}

Status knownScenes(const std::vector<std::string>& scenes) {
  const std::vector<report::ExperimentInfo> all = everyExperiment();
  for (const std::string& scene : scenes) {
    if (std::any_of(all.begin(), all.end(), [&](const report::ExperimentInfo& i) { return i.id == scene; }))
      continue;
    std::string names;
    for (const report::ExperimentInfo& info : all) names += " " + info.id;
    return Error{"--scenes " + scene + ": there is no such scene; there are:" + names};
  }
  return {};
}

Status loadModels(const ReportArguments& arguments, report::SweepOptions& options) {
  for (const std::string& path : arguments.models) {
    SceneArguments file;
    file.path = path;
    Result<assets::Scene> scene = loadScene(file);
    if (!scene) return Error{"--models " + path + ": " + scene.error().message};
    if (assets::triangleCount(*scene) == 0) return Error{"--models " + path + ": has no triangles"};
    options.models.push_back({std::filesystem::path(path).filename().string(),
                              std::make_shared<const assets::Scene>(std::move(*scene))});
  }
  options.strokes = arguments.strokes;
  return {};
}

std::uint64_t allocationsOf(const report::SweepResult& result) {
  std::uint64_t count = 0;
  for (const report::ExperimentResult& e : result.experiments)
    for (const report::Measurement& m : e.settings) count += m.allocations;
  for (const report::PartExperimentResult& e : result.held)
    for (const report::PartMeasurement& m : e.settings) count += m.allocations;
  for (const report::PressResult& e : result.presses)
    for (const report::PressMeasurement& m : e.settings) count += m.figures.allocations;
  return count;
}

void printLinks(const report::SweepResult& result) {
  std::printf("%-32s %9s %14s %7s %9s %7s\n", "Two sites on one part", "apart mm", "hand to hand", "wall",
              "leader x", "kB/s");
  for (const report::LinkExperimentResult& e : result.links)
    for (const report::LinkMeasurement& m : e.settings)
      if (m.setting.inUse)
        std::printf("%-32s %9.2f %10.0f N/m %7.0f %9.2f %7.1f\n", report::delayInWords(e).c_str(),
                    1e3 * m.apart, m.handToHand, m.wall, m.load, 1e-3 * m.bytes);
}

void printPresses(const report::SweepResult& result) {
  std::printf("%-24s %9s %9s %9s %14s %11s\n", "Irregular parts, pressed", "p50 us", "p99 us", "max us",
              "penetration um", "change N");
  for (const report::PressResult& e : result.presses)
    for (const report::PressMeasurement& m : e.settings)
      if (m.figures.setting == "tandem")
        std::printf("%-24s %9.1f %9.1f %9.1f %14.3f %11.2e\n", e.info.title.c_str(), m.figures.cost.p50,
                    m.figures.cost.p99, m.figures.cost.max, 1e6 * m.figures.depth.max,
                    m.figures.forceChange.p99);
}

void printSweep(const report::SweepResult& result) {
  if (!result.links.empty()) printLinks(result);
  for (const report::StrokeResult& e : result.strokes)
    for (const report::StrokeMeasurement& m : e.settings)
      std::printf(
          "%s, %s: %d of %d strokes go where no ball does, %d into a part; tick %.2f us p50, %.2f us p99\n",
          e.model.c_str(), m.name.c_str(), m.fallen, e.strokes, m.inside, m.cost.p50, m.cost.p99);
  if (!result.presses.empty()) printPresses(result);
  if (result.experiments.empty() && result.held.empty()) return;
  std::printf("%-44s %9s %9s %11s %9s\n", "Tandem", "p50 us", "p99 us", "error p99 N", "build ms");
  for (const report::ExperimentResult& e : result.experiments)
    for (const report::Measurement& m : e.settings)
      if (m.setting == "tandem")
        std::printf("%-44s %9.2f %9.2f %11.2e %9.1f\n", e.info.title.c_str(), m.cost.p50, m.cost.p99,
                    m.error.p99, m.build_ms);
  if (result.held.empty()) return;
  std::printf("%-24s %9s %9s %9s %14s %11s\n", "Tandem, a part in hand", "p50 us", "p99 us", "max us",
              "penetration um", "error p99 N");
  for (const report::PartExperimentResult& e : result.held)
    for (const report::PartMeasurement& m : e.settings)
      if (m.setting == "tandem")
        std::printf("%-24s %9.1f %9.1f %9.1f %14.3f %11.2e\n", e.info.title.c_str(), m.cost.p50, m.cost.p99,
                    m.cost.max, 1e6 * m.depth.max, m.error.p99);
}

int runReport(const ReportArguments& arguments) {
  for (const std::string& out : {arguments.out, arguments.json})
    if (Status free = writable(out); !free) return badInput(free.error());
  if (Status known = knownScenes(arguments.scenes); !known) return badInput(known.error());
  std::string peers = arguments.noPeers ? "" : arguments.peers;
  if (!peers.empty() && ::access(peers.c_str(), X_OK) != 0)
    return badInput({"--peers " + peers + ": is not a program that can be run"});
  if (peers.empty() && !arguments.noPeers) peers = report::peersProgramBesideThis();

  report::SweepOptions options;
  options.quick = arguments.quick;
  options.thoroughLinks = arguments.thoroughLinks;
  options.only = arguments.scenes;
  if (Status loaded = loadModels(arguments, options); !loaded) return badInput(loaded.error());
  options.allocations = &allocationsOfThisThread;
  options.progress = [](std::size_t done, std::size_t all, const report::ExperimentInfo& info) {
    std::fprintf(stderr, "%2zu of %zu: %s\n", done + 1, all, info.title.c_str());
  };
  report::SweepResult result = report::sweep(options);
  if (!peers.empty()) {
    std::fprintf(stderr, "peers: %s\n", peers.c_str());
    Result<report::SweepResult> measured = report::measurePeers(peers, options);
    if (!measured) {
      std::fprintf(stderr, "tandem: %s\n", measured.error().message.c_str());
      return kExitFailed;
    }
    report::mergePeers(*measured, result);
  }
  const std::string json = report::toJson(result);
  if (!arguments.json.empty())
    if (Status written = writeFile(arguments.json, json); !written) return badInput(written.error());
  if (Status written = writeFile(arguments.out, report::htmlPage(result, json)); !written)
    return badInput(written.error());
  printSweep(result);
  std::fprintf(stderr, "written: %s\n", arguments.out.c_str());
  if (allocationsOf(result) == 0) return kExitDone;
  std::fprintf(stderr, "tandem: a tick used the heap\n");
  return kExitFailed;
}

}  // namespace

void addReport(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<ReportArguments>();
  assets::CommandLine command =
      program.command("report",
                      "Measure cost and error of the haptic tick on scenes with exact "
                      "answers, and what two people on one part "
                      "feel across the network; write them as one page");
  command.option("--out", arguments->out, "The page: HTML that needs no other file").showDefault();
  command.option("--json", arguments->json, "Write the figures to this file too");
  command.option("--scenes", arguments->scenes,
                 "Only these scenes, by id (sphere-1k, gear-100k, plane, ...) [all]");
  command.option(
      "--models", arguments->models,
      "Draw a point through these glTF files at random, and count where it goes though no ball does "
      "[none]");
  command.option("--strokes", arguments->strokes, "Strokes through each model [200; 20 with --quick]")
      .integerFrom(0, 1'000'000);
  command.option("--peers", arguments->peers,
                 "Program that measures other libraries on the same scenes [bench_peers beside this "
                 "program, if it is there]");
  command.flag("--no-peers", arguments->noPeers, "Measure no other libraries");
  command.flag("--quick", arguments->quick, "Small scenes and short paths: seconds instead of minutes");
  command.flag("--thorough-links", arguments->thoroughLinks,
               "Across the network: three seeds, and the best gains of what links replace searched for "
               "anew: minutes");
  std::string scenes;
  for (const report::ExperimentInfo& info : everyExperiment()) scenes += " " + info.id;
  command.footer("Scenes:" + scenes +
                 "\nExit code 1: a tick used the heap, or the peers' program failed.\n"
                 "Figures mean little on a busy machine: let nothing else run.\n"
                 "Example: tandem report --quick --out report.html --json report.json");
  command.onRun([arguments, &exitCode] { exitCode = runReport(*arguments); });
}

}  // namespace tandem::client
