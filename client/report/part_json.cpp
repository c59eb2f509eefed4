#include "client/report/part_json.h"

#include "assets/base/json.h"
#include "client/report/measurement_json.h"

namespace tandem::client::report {
namespace {

Json spreadJson(const Spread& s) {
  return {{"p50", numberJson(s.p50)}, {"p99", numberJson(s.p99)}, {"max", numberJson(s.max)}};
}

Json manifoldJson(const std::vector<ManifoldBin>& bins) {
  Json json = Json::array();
  for (const ManifoldBin& bin : bins)
    json.push({{"rows", numberJson(bin.rows)},
               {"ticks", bin.ticks},
               {"cost_us", {{"p50", numberJson(bin.p50)}, {"p99", numberJson(bin.p99)}}}});
  return json;
}

/// `exact`: an exact force is known.
Json partSettingJson(const PartMeasurement& m, bool exact) {
  Json json = {{"id", m.setting}, {"name", m.name}, {"kind", nameOf(m.kind)}};
  json["field_scale"] = m.fieldScale;
  json["sample_scale"] = m.sampleScale;
  json["refined"] = m.effort.exact;
  json["samples_alone"] = !m.effort.descend;
  json["steps"] = m.effort.steps;
  json["sample_queries"] = m.effort.sampleQueries;
  putCost(json, m.cost);
  json[m.kind == Kind::peer ? "depth_error_m" : "penetration_m"] = spreadJson(m.depth);
  json["force_change_n"] = spreadJson(m.forceChange);
  if (exact) {
    putError(json, m.error);
    json["force_step_n"] = spreadJson(m.forceStep);
    json["normal_step_rad"] = spreadJson(m.normalStep);
    json["found_share"] = numberJson(m.found);
  }
  json["cell_m"] = numberJson(m.cell);
  json["spacing_m"] = numberJson(m.spacing);
  json["build_ms"] = numberJson(m.build_ms);
  json["memory_bytes"] = m.memory;
  json["allocations"] = m.allocationsCounted ? Json(m.allocations) : Json(nullptr);
  json["by_active_rows"] = manifoldJson(m.active);
  json["by_solved_rows"] = manifoldJson(m.solved);
  return json;
}

Spread spreadFrom(const Json& json) {
  return {measure(json, "p50"), measure(json, "p99"), measure(json, "max")};
}

}  // namespace

Json partExperimentJson(const PartExperimentResult& e) {
  Json json = {{"id", e.info.id},
               {"title", e.info.title},
               {"about", e.info.about},
               {"triangles", e.triangles},
               {"ticks", e.ticks},
               {"peak_force_n", numberJson(e.peakForce)},
               {"asked_penetration_m", numberJson(e.targetDepth)}};
  json["settings"] = Json::array();
  for (const PartMeasurement& m : e.settings) json["settings"].push(partSettingJson(m, true));
  return json;
}

Json pressJson(const PressResult& e) {
  Json json = {{"id", e.info.id},
               {"title", e.info.title},
               {"about", e.info.about},
               {"presses", e.presses},
               {"least_triangles", e.leastTriangles},
               {"most_triangles", e.mostTriangles},
               {"ticks", e.ticks},
               {"asked_penetration_m", numberJson(e.targetDepth)}};
  json["settings"] = Json::array();
  for (const PressMeasurement& m : e.settings) {
    Json setting = partSettingJson(m.figures, false);
    setting["presses_beyond"] = m.beyond;
    json["settings"].push(std::move(setting));
  }
  return json;
}

PartExperimentResult partPeersFromJson(const Json& entry) {
  PartExperimentResult e;
  e.info.id = entry.at("id").text();
  for (const Json& json : entry.at("settings")) {
    PartMeasurement& m = e.settings.emplace_back();
    m.setting = json.at("id").text();
    m.name = json.at("name").text();
    m.kind = Kind::peer;
    m.cost = costFrom(json);
    m.depth = spreadFrom(json.at("depth_error_m"));
    m.error = errorFrom(json);
    m.forceStep = spreadFrom(json.at("force_step_n"));
    m.normalStep = spreadFrom(json.at("normal_step_rad"));
    m.found = measure(json, "found_share");
    m.build_ms = measure(json, "build_ms");
  }
  return e;
}

}  // namespace tandem::client::report
