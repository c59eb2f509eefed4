#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "assets/gltf/cad_file.h"
#include "client/commands/command.h"
#include "client/simulation/protocol_simulation.h"
#include "client/simulation/scenario_scripts.h"
#include "client/simulation/simulation.h"

namespace tandem::client {

namespace {

struct SimulateArguments {
  std::string scenario, json;
  SimulationOptions options;
  bool quiet = false, noPartContact = false, protocol = false;
};

/// The stiffness that a hand felt of a fixed part, N/m; a dash if it pressed none.
std::string feltBy(const SimulatedSiteResult& site) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", site.feltStiffness);
  return site.feltStiffness == 0.0 ? "-" : text;
}

void printSummary(const SimulationResult& result) {
  std::printf("%-14s %12s %12s %12s %10s %10s\n", "site", "energy mJ", "felt N/m", "step N/20ms", "packets/s",
              "kB/s");
  for (const auto& [name, site] : result.sites)
    std::printf("%-14s %12.4f %12s %12.3f %10.1f %10.2f\n", name.c_str(), site.energyCreated * 1e3,
                feltBy(site).c_str(), site.forceStep20ms, site.packetsPerSecond, site.bytesPerSecond / 1e3);
  for (const auto& grant : result.grants) {
    const auto name = result.siteNames.find(grant.site);
    std::printf("%8.3f s  %s -> %s (epoch %u)\n", grant.at, result.partNames[grant.part].c_str(),
                name == result.siteNames.end() ? "a site that is gone" : name->second.c_str(), grant.epoch);
  }
  for (const Violation& violation : result.violations)
    std::printf("%8.3f s  %s broken: %s\n", violation.at, violation.rule.c_str(), violation.what.c_str());
  if (result.shared > 0.0)
    std::printf("shared for %.2f s: replicas apart %.3f mm rms, %.3f mm max; links created %.4f mJ\n",
                result.shared, result.discrepancyRms * 1e3, result.discrepancyMax * 1e3,
                result.energyOfLinks * 1e3);
  std::printf("displayed discrepancy %.3f mm rms, %.3f mm max; %s; %zu violations; hash %s\n",
              result.displayedRms * 1e3, result.displayedMax * 1e3, result.stable ? "stable" : "NOT STABLE",
              result.violations.size(), result.hash.c_str());
}

/// The session without haptics, for the rules of the protocol alone.
int runProtocol(const SimulateArguments& arguments, const Scenario& scenario, const assets::Scene& scene) {
  ProtocolSimulation simulation(scene);
  const Result<ProtocolResult> result = simulation.run(scenario, arguments.options.seed);
  if (!result) return badInput(result.error());
  if (!arguments.json.empty())
    if (Status written = writeFile(arguments.json, toJson(*result) + "\n"); !written)
      return badInput(written.error());
  if (!arguments.quiet) {
    for (const Violation& violation : result->violations)
      std::printf("%8.3f s  %s broken: %s\n", violation.at, violation.rule.c_str(), violation.what.c_str());
    std::printf("%zu grants, %llu got by hands; %zu violations; hash %s\n", result->grants.size(),
                static_cast<unsigned long long>(result->granted), result->violations.size(),
                result->hash.c_str());
  }
  return result->violations.empty() ? kExitDone : kExitFailed;
}

int runSimulate(const SimulateArguments& arguments) {
  for (const std::string& path : {arguments.json, arguments.options.tracePath})
    if (Status free = writable(path); !free) return badInput(free.error());
  Result<Scenario> scenario = loadScenario(arguments.scenario);
  if (!scenario) return badInput(scenario.error());
  Result<assets::Scene> scene =
      assets::loadSceneFile({scenario->scene, "m", assets::defaultCacheDirectory()}, scenario->load);
  if (!scene) return badInput(scene.error());
  if (arguments.protocol) return runProtocol(arguments, *scenario, *scene);
  // What is wrong with a script is said before models are made, which takes longer.
  if (const Result<std::vector<HandScript>> scripts = parseScripts(*scenario, *scene); !scripts)
    return badInput(scripts.error());
  haptics::ContactScene contact(*scene);
  if (!arguments.noPartContact) modelParts(contact, false);
  Result<SimulationResult> result = simulate(*scenario, contact, arguments.options);
  if (!result) return badInput(result.error());
  if (!arguments.json.empty())
    if (Status written = writeFile(arguments.json, toJson(*result) + "\n"); !written)
      return badInput(written.error());
  if (!arguments.quiet) printSummary(*result);
  return result->stable && result->violations.empty() ? kExitDone : kExitFailed;
}

}  // namespace

void addSimulate(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<SimulateArguments>();
  assets::CommandLine command = program.command(
      "simulate", "Run a whole session - server, sites, arms, network, faults - on virtual time");
  command
      .option("scenario", arguments->scenario,
              "Scenario file (JSON; see tests/simulation/scenarios for examples)")
      .required();
  command.option("--seed", arguments->options.seed, "Seed of network and clocks").showDefault();
  command.option("--json", arguments->json, "Write the measures to this file");
  command.option("--trace", arguments->options.tracePath,
                 "Write hands and forces every 10 ms to this CSV file");
  command.flag("--no-part-contact", arguments->noPartContact,
               "Parts in the hand pass through others: nothing is made ready for them to collide");
  command.flag("--protocol", arguments->protocol,
               "Hands without haptics: a thousand times as fast, for the rules of the protocol alone");
  command.flag("--quiet", arguments->quiet, "Print nothing but errors");
  command.footer(
      "A site's hand runs on the plain defaults (800 N/m, no passivity control) whatever its device; "
      "\"fit\": true in\n"
      "the scenario's site takes those of 'tandem join' instead, \"stiffness\": K states one. See "
      "client/README.md.\n"
      "Printed for each site: energy that its device gave for nothing, the stiffness that it felt of a fixed "
      "part,\n"
      "the largest change of force in 20 ms, and what it sent a second (without seals).\n"
      "The same scenario and seed give the same result, to the bit.\n"
      "Exit code 1: the run was not stable, or a rule of the protocol (sync/README.md) was broken.\n"
      "Example: tandem simulate tests/simulation/scenarios/hand_over.json --seed 7 --json out.json");
  command.onRun([arguments, &exitCode] { exitCode = runSimulate(*arguments); });
}

}  // namespace tandem::client
