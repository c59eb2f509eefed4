#include "client/simulation/scenario.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "assets/base/json.h"
#include "client/base/json_input.h"
#include "client/hand/hand_script.h"
#include "client/simulation/scenario_fields.h"
#include "sync/wire/limits.h"
#include "sync/wire/time.h"

namespace tandem::client {

namespace {

/// Whether a name can stand in a CSV column and in a line of text.
bool plain(const std::string& name) {
  return std::none_of(name.begin(), name.end(),
                      [](unsigned char c) { return c < 32 || c == 127 || c == ',' || c == '"'; });
}

ScenarioSite parseSite(const Json& entry, const std::string& where) {
  Fields fields(entry, where);
  ScenarioSite site;
  site.name = fields.requiredText("name");
  if (site.name.empty() || site.name.size() > sync::kMaxNameLength || !plain(site.name))
    throw where + ": \"name\" must be 1 to " + std::to_string(sync::kMaxNameLength) +
        " bytes without control characters, commas or quotes";
  site.role = fields.text("role", "participant");
  if (site.role != "participant" && site.role != "observer" && site.role != "instructor")
    throw where + ": \"role\" must be instructor, participant or observer";
  site.joins = fields.number("joins", 0.0, 0.0, 1e4);
  if (fields.has("arm")) {
    Fields arm(fields["arm"], where + ".arm");
    site.arm.mass = arm.number("mass", site.arm.mass, 1e-3, 100.0);
    site.arm.stiffness = arm.number("stiffness", site.arm.stiffness, 0.0, 1e5);
    site.arm.damping = arm.number("damping", site.arm.damping, 0.0, 1e4);
    site.arm.gripStiffness = arm.number("grip_stiffness", site.arm.gripStiffness, 0.0, 1e5);
    site.arm.gripDamping = arm.number("grip_damping", site.arm.gripDamping, 0.0, 1e4);
    arm.refuseUnknown();
  }
  if (fields.has("device")) {
    Fields device(fields["device"], where + ".device");
    site.device.mass = device.number("mass", site.device.mass, 1e-3, 100.0);
    site.device.damping = device.number("damping", site.device.damping, 0.0, 1e3);
    site.device.friction = device.number("friction", site.device.friction, 0.0, 100.0);
    site.device.quantum = device.number("quantum_m", site.device.quantum, 0.0, 0.01);
    site.device.forceMax = device.number("force_max", site.device.forceMax, 0.0, 1e3);
    device.refuseUnknown();
  }
  if (fields.has("fit")) {
    if (!fields["fit"].isBoolean()) throw where + ": \"fit\" must be true or false";
    site.fit = fields["fit"].boolean();
  }
  site.stiffness = fields.number("stiffness", 0.0, 0.0, 1e6);
  site.deadband = fields.number("deadband", site.deadband, 0.0, 1.0);
  if (fields.has("start")) {
    const Json& start = fields["start"];
    if (!start.isArray() || start.size() != 3) throw where + ": \"start\" must be [x, y, z]";
    for (std::size_t i = 0; i < 3; ++i) {
      if (!start.at(i).isNumber() || !(std::abs(start.at(i).number()) <= kFarthest))
        throw where + ": \"start\" must hold numbers within " + std::to_string(static_cast<int>(kFarthest)) +
            " m";
      site.start[static_cast<glm::length_t>(i)] = start.at(i).number();
    }
    site.hasStart = true;
  }
  site.script = fields.list("script").dump();
  fields.refuseUnknown();
  return site;
}

void parseNetwork(const Json& entry, Scenario& scenario) {
  Fields fields(entry, "network");
  const auto micros = [](double ms) { return static_cast<sync::Micros>(std::llround(ms * 1e3)); };
  scenario.network.oneWay = micros(fields.number("one_way_ms", 0.0, 0.0, 1e5));
  scenario.network.jitter = fields.number("jitter", 0.0, 0.0, 1.0);
  scenario.network.loss = fields.number("loss", 0.0, 0.0, 1.0);
  scenario.network.duplicate = fields.number("duplicate", 0.0, 0.0, 1.0);
  scenario.network.reorder = fields.number("reorder", 0.0, 0.0, 1.0);
  scenario.packetHz = fields.number("packet_hz", 250.0, 1.0, 1000.0);
  for (const Json& item : fields.list("blackouts")) {
    Fields blackout(item, "network.blackouts");
    scenario.blackouts.push_back({blackout.requiredText("site"), blackout.required("at", 0.0, 1e5),
                                  blackout.required("for_s", 0.0, 1e5)});
    blackout.refuseUnknown();
  }
  for (const Json& item : fields.list("steps")) {
    Fields step(item, "network.steps");
    scenario.steps.push_back({step.required("at", 0.0, 1e5), micros(step.required("one_way_ms", 0.0, 1e5))});
    step.refuseUnknown();
  }
  fields.refuseUnknown();
}

void checkSites(const Scenario& scenario) {
  std::set<std::string> names;
  for (const ScenarioSite& site : scenario.sites)
    if (site.name == "server" || !names.insert(site.name).second)
      throw "sites: the name \"" + site.name + "\" is taken";
  const auto check = [&](const std::string& site, const char* where) {
    if (!names.count(site)) throw std::string(where) + ": no site is named \"" + site + "\"";
  };
  for (const Blackout& blackout : scenario.blackouts) check(blackout.site, "network.blackouts");
  for (const Fault& fault : scenario.faults)
    if (!fault.site.empty() && fault.site != "server" && fault.site != "all") check(fault.site, "faults");
}

Scenario parse(const Json& document, const std::string& path) {
  namespace fs = std::filesystem;
  Fields fields(document, "scenario");
  Scenario scenario;
  scenario.path = path;
  const std::string scene = fields.requiredText("scene");
  const fs::path beside = fs::path(path).parent_path() / scene;
  std::error_code unreadable;  // ignored: loading reports what is wrong with the name
  scenario.scene = fs::exists(beside, unreadable) ? beside.string() : scene;
  scenario.duration = fields.required("duration_s", 0.001, 3600.0);
  Result<double> units = assets::parseUnits(fields.text("units", "m"));
  if (!units) throw "units: " + units.error().message;
  scenario.load.unitScale = *units;
  if (fields.has("movable")) {
    const Json& movable = fields["movable"];
    if (movable.isText() && movable.text() == "all") {
      scenario.load.allMovable = true;
    } else {
      for (const Json& name : fields.list("movable")) {
        if (!name.isText()) throw std::string("movable: must be \"all\" or a list of names");
        scenario.load.movable.push_back(name.text());
      }
    }
  }
  std::size_t index = 0;
  for (const Json& site : fields.list("sites"))
    scenario.sites.push_back(parseSite(site, "sites[" + std::to_string(index++) + "]"));
  if (scenario.sites.empty()) throw std::string("sites: needs at least one");
  if (fields.has("network")) parseNetwork(fields["network"], scenario);
  index = 0;
  for (const Json& fault : fields.list("faults"))
    scenario.faults.push_back(parseFault(fault, "faults[" + std::to_string(index++) + "]"));
  scenario.calmFrom = fields.number("calm_from_s", -1.0, 0.0, 3600.0);
  fields.refuseUnknown();
  checkSites(scenario);
  return scenario;
}

}  // namespace

Result<Scenario> loadScenario(const std::string& path) {
  const Result<std::string> text = readTextFile(path);
  if (!text) return text.error();
  const Result<Json> document = parseJson(*text, path);
  if (!document) return document.error();
  try {
    return parse(*document, path);
  } catch (const std::string& reason) {
    return Error{path + ": " + reason};
  }
}

}  // namespace tandem::client
