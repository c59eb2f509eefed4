#include <filesystem>

#include "assets/base/assert.h"
#include "client/base/json_input.h"
#include "client/simulation/scenario_fields.h"

namespace tandem::client {

namespace {

Json armJson(const ScenarioSite& site) {
  return {{"mass", site.arm.mass},
          {"stiffness", site.arm.stiffness},
          {"damping", site.arm.damping},
          {"grip_stiffness", site.arm.gripStiffness},
          {"grip_damping", site.arm.gripDamping}};
}

Json deviceJson(const ScenarioSite& site) {
  return {{"mass", site.device.mass},
          {"damping", site.device.damping},
          {"friction", site.device.friction},
          {"quantum_m", site.device.quantum},
          {"force_max", site.device.forceMax}};
}

Json siteJson(const ScenarioSite& site) {
  Json entry = Json::object();
  entry["name"] = site.name;
  entry["role"] = site.role;
  entry["joins"] = site.joins;
  entry["deadband"] = site.deadband;
  if (site.stiffness > 0.0) entry["stiffness"] = site.stiffness;
  if (site.fit) entry["fit"] = true;
  if (site.hasStart) entry["start"] = {site.start.x, site.start.y, site.start.z};
  if (const Json arm = armJson(site); arm.dump() != armJson({}).dump()) entry["arm"] = arm;
  if (const Json device = deviceJson(site); device.dump() != deviceJson({}).dump()) entry["device"] = device;
  const Result<Json> script = parseJson(site.script, site.name);
  ASSERT(script.ok());
  entry["script"] = *script;
  return entry;
}

double milliseconds(sync::Micros micros) { return static_cast<double>(micros) * 1e-3; }

Json networkJson(const Scenario& scenario) {
  const sync::NetworkConditions& network = scenario.network;
  Json entry = Json::object();
  entry["one_way_ms"] = milliseconds(network.oneWay);
  entry["jitter"] = network.jitter;
  entry["loss"] = network.loss;
  entry["duplicate"] = network.duplicate;
  entry["reorder"] = network.reorder;
  entry["packet_hz"] = scenario.packetHz;
  for (const Blackout& blackout : scenario.blackouts)
    entry["blackouts"].push({{"site", blackout.site}, {"at", blackout.at}, {"for_s", blackout.lasts}});
  for (const DelayStep& step : scenario.steps)
    entry["steps"].push({{"at", step.at}, {"one_way_ms", milliseconds(step.oneWay)}});
  return entry;
}

}  // namespace

std::string toJson(const Scenario& scenario) {
  Json json = Json::object();
  json["scene"] = std::filesystem::path(scenario.scene).filename().string();
  json["duration_s"] = scenario.duration;
  if (scenario.calmFrom >= 0.0) json["calm_from_s"] = scenario.calmFrom;
  if (scenario.load.allMovable) json["movable"] = "all";
  for (const ScenarioSite& site : scenario.sites) json["sites"].push(siteJson(site));
  json["network"] = networkJson(scenario);
  for (const Fault& fault : scenario.faults) json["faults"].push(faultJson(fault));
  return json.dump(1);
}

}  // namespace tandem::client
