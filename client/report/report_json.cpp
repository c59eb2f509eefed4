#include "client/report/report_json.h"

#include <algorithm>

#include "assets/base/json.h"
#include "client/report/link_json.h"
#include "client/report/measurement_json.h"
#include "client/report/part_json.h"
#include "client/report/stroke_page.h"

namespace tandem::client::report {
namespace {

Json settingJson(const Measurement& m) {
  Json json = {{"id", m.setting}, {"name", m.name}, {"kind", nameOf(m.kind)}};
  putCost(json, m.cost);
  json["hovering_us"] = {{"p50", numberJson(m.hovering.p50)}, {"p99", numberJson(m.hovering.p99)}};
  putError(json, m.error);
  json["step_n"] = {{"max", numberJson(m.step.measured)},
                    {"ideal", numberJson(m.step.ideal)},
                    {"excess", numberJson(m.step.excess)},
                    {"beyond_travel", numberJson(m.step.beyondTravel)},
                    {"jumps", m.step.jumps}};
  json["beyond_depth_n"] = numberJson(m.beyondDepth);
  json["allocations"] = m.allocationsCounted ? Json(m.allocations) : Json(nullptr);
  json["build_ms"] = numberJson(m.build_ms);
  return json;
}

Measurement peerSetting(const Json& json) {
  Measurement m;
  m.setting = json.at("id").text();
  m.name = json.at("name").text();
  m.kind = Kind::peer;
  const Json &step = json.at("step_n"), &hovering = json.at("hovering_us");
  m.cost = costFrom(json);
  m.hovering = {measure(hovering, "p50"), measure(hovering, "p99")};
  m.error = errorFrom(json);
  m.step = {measure(step, "max"), measure(step, "ideal"), measure(step, "excess"),
            measure(step, "beyond_travel"), static_cast<std::uint64_t>(measure(step, "jumps"))};
  m.build_ms = measure(json, "build_ms");
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
                  {"exact", e.info.exact},
                  {"peak_force_n", numberJson(e.peakForce)},
                  {"facet_error_n", numberJson(e.facetError)}};
    entry["settings"] = Json::array();
    for (const Measurement& m : e.settings) entry["settings"].push(settingJson(m));
    json["experiments"].push(std::move(entry));
  }
  json["held"] = Json::array();
  for (const PartExperimentResult& e : result.held) json["held"].push(partExperimentJson(e));
  json["presses"] = Json::array();
  for (const PressResult& e : result.presses) json["presses"].push(pressJson(e));
  json["strokes"] = Json::array();
  for (const StrokeResult& e : result.strokes) json["strokes"].push(strokeJson(e));
  json["links"] = Json::array();
  for (const LinkExperimentResult& e : result.links) json["links"].push(linkExperimentJson(e));
  json["figures"] = Json::array();
  for (const Figure& f : result.figures) {
    Json entry = {{"id", f.id}, {"name", f.name}, {"unit", f.unit}, {"value", numberJson(f.value)}};
    if (f.target > 0.0) entry[f.atLeast ? "at_least" : "at_most"] = f.target;
    json["figures"].push(std::move(entry));
  }
  return json.dump(2) + "\n";
}

Result<SweepResult> peersFromJson(const std::string& text) {
  const Error unusable{"what the peers' program wrote cannot be used: "};
  const Result<Json> parsed = Json::parse(text);
  if (!parsed) return Error{unusable.message + parsed.error().message};
  const Json& json = *parsed;
  try {
    SweepResult result;
    for (const Json& peer : json.at("peers")) result.peers.push_back(peer.text());
    for (const Json& entry : json.at("experiments")) {
      ExperimentResult& e = result.experiments.emplace_back();
      e.info.id = entry.at("id").text();
      for (const Json& setting : entry.at("settings")) e.settings.push_back(peerSetting(setting));
    }
    for (const Json& entry : json.at("held")) result.held.push_back(partPeersFromJson(entry));
    return result;
  } catch (const JsonError& error) {
    return Error{unusable.message + error.what()};
  }
}

namespace {

template <typename Results>
void addSettings(const Results& from, Results& to) {
  for (const auto& e : from) {
    const auto same =
        std::find_if(to.begin(), to.end(), [&](const auto& t) { return t.info.id == e.info.id; });
    if (same != to.end()) same->settings.insert(same->settings.end(), e.settings.begin(), e.settings.end());
  }
}

}  // namespace

void mergePeers(const SweepResult& peers, SweepResult& result) {
  result.peers = peers.peers;
  addSettings(peers.experiments, result.experiments);
  addSettings(peers.held, result.held);
}

}  // namespace tandem::client::report
