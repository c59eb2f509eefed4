#include "client/report/report_json.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

namespace tandem::client::report {
namespace {

using Json = nlohmann::ordered_json;

const char* nameOf(Kind kind) {
  switch (kind) {
    case Kind::tandem:
      return "tandem";
    case Kind::baseline:
      return "baseline";
    case Kind::peer:
      return "peer";
  }
  return "tandem";
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json settingJson(const Measurement& m) {
  Json json = {{"id", m.setting}, {"name", m.name}, {"kind", nameOf(m.kind)}};
  json["cost_us"] = {{"p50", number(m.cost.p50)},
                     {"p99", number(m.cost.p99)},
                     {"max", number(m.cost.max)},
                     {"p99_single_run", number(m.cost.p99Single)}};
  json["error_n"] = {
      {"rms", number(m.error.rms)}, {"p99", number(m.error.p99)}, {"max", number(m.error.max)}};
  json["error_share"] = {{"rms", number(m.error.relativeRms)},
                         {"p99", number(m.error.relativeP99)},
                         {"max", number(m.error.relativeMax)}};
  json["step_n"] = {
      {"max", number(m.step.measured)}, {"ideal", number(m.step.ideal)}, {"excess", number(m.step.excess)}};
  json["allocations"] = m.allocationsCounted ? Json(m.allocations) : Json(nullptr);
  json["build_ms"] = number(m.build_ms);
  return json;
}

double finite(const Json& object, const char* key) {
  const double value = object.at(key).get<double>();
  if (!std::isfinite(value) || value < 0.0)
    throw Json::other_error::create(500, std::string(key) + " is not a measure", nullptr);
  return value;
}

Measurement peerSetting(const Json& json) {
  Measurement m;
  m.setting = json.at("id").get<std::string>();
  m.name = json.at("name").get<std::string>();
  m.kind = Kind::peer;
  const Json &cost = json.at("cost_us"), &error = json.at("error_n"), &share = json.at("error_share"),
             &step = json.at("step_n");
  m.cost = {finite(cost, "p50"), finite(cost, "p99"), finite(cost, "max"), finite(cost, "p99_single_run")};
  m.error = {finite(error, "rms"), finite(error, "p99"), finite(error, "max"),
             finite(share, "rms"), finite(share, "p99"), finite(share, "max")};
  m.step = {finite(step, "max"), finite(step, "ideal"), finite(step, "excess")};
  m.build_ms = finite(json, "build_ms");
  return m;
}

}  // namespace

std::string toJson(const SweepResult& result) {
  Json json = {{"report", "speed against error"},
               {"machine", result.machine},
               {"quick", result.quick},
               {"peers", result.peers}};
  json["experiments"] = Json::array();
  for (const ExperimentResult& e : result.experiments) {
    Json entry = {{"id", e.info.id},
                  {"family", e.info.family},
                  {"title", e.info.title},
                  {"about", e.info.about},
                  {"triangles", e.triangles},
                  {"parts", e.parts},
                  {"ticks", e.ticks},
                  {"tool_radius_m", e.info.toolRadius},
                  {"peak_force_n", number(e.peakForce)},
                  {"facet_error_n", number(e.facetError)}};
    entry["settings"] = Json::array();
    for (const Measurement& m : e.settings) entry["settings"].push_back(settingJson(m));
    json["experiments"].push_back(std::move(entry));
  }
  json["figures"] = Json::array();
  for (const Figure& f : result.figures) {
    Json entry = {{"id", f.id}, {"name", f.name}, {"unit", f.unit}, {"value", number(f.value)}};
    if (f.target > 0.0) entry[f.atLeast ? "at_least" : "at_most"] = f.target;
    json["figures"].push_back(std::move(entry));
  }
  return json.dump(2) + "\n";
}

Result<SweepResult> peersFromJson(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    SweepResult result;
    result.peers = json.at("peers").get<std::vector<std::string>>();
    for (const Json& entry : json.at("experiments")) {
      ExperimentResult& e = result.experiments.emplace_back();
      e.info.id = entry.at("id").get<std::string>();
      for (const Json& setting : entry.at("settings")) e.settings.push_back(peerSetting(setting));
    }
    return result;
  } catch (const Json::exception& error) {
    return Error{std::string("what the peers' program wrote cannot be used: ") + error.what()};
  }
}

void mergePeers(const SweepResult& peers, SweepResult& result) {
  result.peers = peers.peers;
  for (const ExperimentResult& from : peers.experiments) {
    const auto to = std::find_if(result.experiments.begin(), result.experiments.end(),
                                 [&](const ExperimentResult& e) { return e.info.id == from.info.id; });
    if (to != result.experiments.end())
      to->settings.insert(to->settings.end(), from.settings.begin(), from.settings.end());
  }
}

}  // namespace tandem::client::report
