#include "assets/base/assert.h"
#include "assets/base/json.h"
#include "client/base/traffic_json.h"
#include "client/simulation/protocol_simulation.h"
#include "client/simulation/simulation.h"

namespace tandem::client {

std::string toJson(const ProtocolResult& result) {
  Json json = Json::object();
  for (std::size_t rule = 0; rule < kRules; ++rule)
    json["checks"][toString(static_cast<Rule>(rule))] = result.checks[rule];
  json["grants"] = Json::array();
  for (const auto& grant : result.grants)
    json["grants"].push(
        {{"t", grant.at}, {"part", grant.part}, {"site", grant.site}, {"epoch", grant.epoch}});
  json["violations"] = Json::array();
  for (const Violation& violation : result.violations)
    json["violations"].push({{"rule", violation.rule}, {"t", violation.at}, {"what", violation.what}});
  json["hash"] = result.hash;
  return json.dump(2);
}

std::string toJson(const SimulationResult& result) {
  Json json;
  json["stable"] = result.stable;
  double excess = 0.0;
  Json energy, stiffness, step, packets, bytes;
  for (const auto& [name, site] : result.sites) {
    energy[name] = site.energyCreated;
    stiffness[name] = site.feltStiffness > 0.0 ? Json(site.feltStiffness) : Json(nullptr);
    step[name] = site.forceStep20ms;
    packets[name] = site.packetsPerSecond;
    bytes[name] = site.bytesPerSecond;
    excess = std::max(excess, site.handoverExcess);
  }
  json["energy_created_j"] = energy;
  json["felt_stiffness"] = stiffness;
  json["energy_created_total_j"] = result.energyCreated;
  json["energy_created_by_links_j"] = result.energyOfLinks;
  const bool shared = result.shared > 0.0;
  json["shared_s"] = result.shared;
  json["discrepancy_m"] = {{"rms", shared ? Json(result.discrepancyRms) : Json(nullptr)},
                           {"max", shared ? Json(result.discrepancyMax) : Json(nullptr)},
                           {"displayed_rms", result.displayedRms},
                           {"displayed_max", result.displayedMax}};
  json["force_step_20ms_n"] = step;
  json["handover_excess_n"] = excess;
  json["leader_load_ratio"] = result.leaderLoadRatio;
  json["packets_per_s"] = packets;
  json["bytes_per_s"] = bytes;
  for (const auto& [name, site] : result.sites) json["sent"][name] = trafficJson(site.sent);
  json["grants"] = Json::array();
  for (const auto& grant : result.grants) {
    ASSERT(grant.part < result.partNames.size());
    const auto name = result.siteNames.find(grant.site);
    json["grants"].push({{"t", grant.at},
                         {"part", result.partNames[grant.part]},
                         {"site", name == result.siteNames.end() ? std::to_string(grant.site) : name->second},
                         {"epoch", grant.epoch}});
  }
  json["denials"] = result.denials;
  json["dropped_states"] = result.droppedStates;
  json["violations"] = Json::array();
  for (const Violation& violation : result.violations)
    json["violations"].push({{"rule", violation.rule}, {"t", violation.at}, {"what", violation.what}});
  for (const auto& [part, pose] : result.finalPoses)
    json["final_poses"][part] = {pose.position.x,    pose.position.y,    pose.position.z,
                                 pose.orientation.w, pose.orientation.x, pose.orientation.y,
                                 pose.orientation.z};
  json["hash"] = result.hash;
  return json.dump(2);
}

}  // namespace tandem::client
