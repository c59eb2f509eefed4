#include <cstdio>
#include <memory>
#include <utility>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "assets/percentiles.h"
#include "client/commands/command.h"
#include "client/device_class.h"
#include "client/part_stroke.h"
#include "client/scene_features.h"
#include "haptics/device_defaults.h"
#include "haptics/tick.h"
#include "haptics/virtual_coupling.h"

namespace tandem::client {

namespace {

struct Arguments {
  SceneArguments scene;
  std::string device = "desktop";
  double delay_ms = 0.0;
  bool json = false;
};

/// How a part is modelled for contact, and what that costs.
struct PartModel {
  std::string name, model;
  std::size_t triangles = 0, bytes = 0;
  double error = 0.0;        // m, PartStroke::error: tessellation of the file's own surfaces is not in it
  std::size_t touching = 0;  // ticks of which that is the most; 0: nothing can touch the part
  double cost_us_p50 = 0.0, cost_us_p99 = 0.0;
  bool movable = false;
  double mass = 0.0;
};

PartModel modelOf(const haptics::ContactScene& contact, const haptics::ContactWorld& world,
                  haptics::TickState& state, PartId id) {
  const assets::Scene& scene = contact.scene();
  const assets::Part& part = scene.parts[id];
  PartModel model;
  model.name = part.name;
  model.triangles = assets::triangleCount(scene, part);
  model.bytes = part.mesh == assets::kNone ? 0 : contact.memory(part.mesh);
  model.movable = part.movable;
  model.mass = part.massProperties.mass;
  model.model = part.shapes.empty() ? (part.mesh == assets::kNone ? "none" : "triangles") : "shapes";
  PartStroke stroke = strokePart(contact, world, state, id);
  model.error = stroke.error;
  model.touching = stroke.touching;
  const Percentiles cost = percentiles(std::move(stroke.tick_us));
  model.cost_us_p50 = cost.p50;
  model.cost_us_p99 = cost.p99;
  return model;
}

const char* severity(assets::Finding::Severity severity) {
  switch (severity) {
    case assets::Finding::Severity::note:
      return "note";
    case assets::Finding::Severity::warning:
      return "warning";
    case assets::Finding::Severity::error:
      return "error";
  }
  return "note";
}

/// Everything about how a scene feels beyond its shape.
struct Features {
  std::vector<Feature> surfaces, fields, controls;
};

nlohmann::ordered_json remarksJson(const Feature& feature) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Remark& remark : feature.remarks) list.push_back(remark.text);
  return list;
}

nlohmann::ordered_json effectsJson(const Feature& feature) {
  nlohmann::ordered_json effects = nlohmann::ordered_json::object();
  for (const Effect& effect : feature.effects) {
    nlohmann::ordered_json& entry = effects[effect.name] = nlohmann::ordered_json::object();
    if (!effect.text.empty()) entry["is"] = effect.text;
    for (const Quantity& quantity : effect.quantities) entry[jsonKey(quantity)] = quantity.value;
  }
  return effects;
}

nlohmann::ordered_json featureJson(const Feature& feature, const char* name, const char* kind) {
  nlohmann::ordered_json json = {{name, feature.name}, {kind, feature.kind}};
  json["effects"] = effectsJson(feature);
  json["remarks"] = remarksJson(feature);
  return json;
}

nlohmann::ordered_json toJson(const assets::Scene& scene, const std::vector<PartModel>& models,
                              const Features& features, const DeviceClass& device, const Arguments& arguments,
                              const FeatureLimits& limits) {
  nlohmann::ordered_json json;
  json["parts"] = nlohmann::ordered_json::array();
  for (const PartModel& m : models)
    json["parts"].push_back({{"name", m.name},
                             {"model", m.model},
                             {"triangles", m.triangles},
                             {"error_m", m.error},
                             {"ticks_touching", m.touching},
                             {"cost_us", {{"p50", m.cost_us_p50}, {"p99", m.cost_us_p99}}},
                             {"memory_bytes", m.bytes},
                             {"movable", m.movable},
                             {"mass_kg", m.mass}});
  json["findings"] = nlohmann::ordered_json::array();
  for (const assets::Finding& f : scene.findings)
    json["findings"].push_back({{"severity", severity(f.severity)},
                                {"code", f.code},
                                {"where", f.where},
                                {"count", f.count},
                                {"message", f.message}});
  json["surfaces"] = nlohmann::ordered_json::array();
  for (const Feature& feature : features.surfaces)
    json["surfaces"].push_back(featureJson(feature, "part", "material"));
  json["fields"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < scene.fields.size(); ++i) {
    const assets::ForceField& f = scene.fields[i];
    json["fields"].push_back({{"name", f.name},
                              {"kind", assets::nameOf(f.kind)},
                              {"energy", assets::nameOf(assets::passivity(f))},
                              {"part", f.part == kNoPart ? "" : scene.parts[f.part].name},
                              {"max_force_n", f.maxForce},
                              {"stiffness_n_per_m", assets::steepest(f)},
                              {"effects", effectsJson(features.fields[i])},
                              {"remarks", remarksJson(features.fields[i])}});
  }
  json["controls"] = nlohmann::ordered_json::array();
  for (const Feature& feature : features.controls) {
    json["controls"].push_back(featureJson(feature, "name", "kind"));
    json["controls"].back()["part"] = feature.part;
  }
  json["triangles"] = assets::triangleCount(scene);
  json["device"] = device.name;
  json["delay_ms"] = arguments.delay_ms;
  json["stiffest_stable_n_per_m"] = limits.stiffest;
  json["stiffest_controlled_n_per_m"] = limits.contact;
  return json;
}

void printFeatures(const char* what, const std::vector<Feature>& features) {
  for (const Feature& feature : features) std::printf("%s %s\n", what, inOneLine(feature).c_str());
}

/// One line for each kind of remark, with the first that it is true of.
void printRemarks(const char* what, const std::vector<Feature>& features) {
  for (const RemarkGroup& group : groupRemarks(features)) {
    std::string where = group.example;
    if (group.features > 1) where += " and " + std::to_string(group.features - 1) + " more";
    if (group.materials > 1) where += " (" + std::to_string(group.materials) + " materials)";
    std::printf("remark          %s %s: %s\n", what, where.c_str(), group.text.c_str());
  }
}

void print(const assets::Scene& scene, const std::vector<PartModel>& models, const Features& features,
           const DeviceClass& device, const Arguments& arguments, const FeatureLimits& limits) {
  std::size_t width = 8;
  for (const PartModel& m : models) width = std::max(width, std::min<std::size_t>(m.name.size(), 40));
  const int w = static_cast<int>(width);
  std::printf("%-*s %-9s %9s %8s %15s %9s %s\n", w, "part", "model", "triangles", "error um",
              "tick us p50/p99", "memory kB", "movable");
  for (const PartModel& m : models) {
    std::printf("%-*.40s %-9s %9zu ", w, m.name.c_str(), m.model.c_str(), m.triangles);
    m.touching > 0 ? std::printf("%8.2g", m.error * 1e6) : std::printf("%8s", "-");
    std::printf(" %7.2f/%7.2f %9.1f ", m.cost_us_p50, m.cost_us_p99, static_cast<double>(m.bytes) / 1e3);
    if (m.movable)
      std::printf("%.3g kg\n", m.mass);
    else
      std::printf("-\n");
  }
  std::printf("\n%zu parts, %zu triangles\n", scene.parts.size(), assets::triangleCount(scene));
  printFeatures("surface", oneEachMaterial(features.surfaces));
  printFeatures("field", features.fields);
  printFeatures("control", features.controls);
  printRemarks("surface", features.surfaces);
  printRemarks("field", features.fields);
  printRemarks("control", features.controls);
  if (scene.findings.empty()) std::printf("no findings: a clean file\n");
  for (const assets::Finding& f : scene.findings)
    std::printf("%-8s %6llu  %s%s%s\n", severity(f.severity), static_cast<unsigned long long>(f.count),
                f.message.c_str(), f.where.empty() ? "" : "  in ", f.where.c_str());
  std::printf(
      "\nstiffest stable contact: %.0f N/m on %s (damping %.2f N*s/m, 1 kHz, delay in the loop %.1f ms); "
      "%.0f N/m under the passivity controller, as 'tandem join' has it\n",
      limits.stiffest, device.what, device.limits.damping, arguments.delay_ms, limits.contact);
}

int run(const Arguments& arguments) {
  const DeviceClass* device = findDeviceClass(arguments.device);
  if (!device)
    return badInput(Error{"--device " + arguments.device + ": must be one of " + deviceClassNames()});
  Result<assets::Scene> scene = loadScene(arguments.scene);
  if (!scene) return badInput(scene.error());
  const haptics::ContactScene contact(*scene);
  const haptics::ContactWorld world(contact);
  haptics::TickState state(contact);
  std::vector<PartModel> models;
  for (std::size_t i = 0; i < scene->parts.size(); ++i)
    models.push_back(modelOf(contact, world, state, static_cast<PartId>(i)));
  const double stiffest =
      haptics::stiffestContact(device->limits, haptics::TickParameters{}.dt, arguments.delay_ms * 1e-3);
  const double contactLimit =
      haptics::stiffestControlled(device->limits, haptics::TickParameters{}.dt, arguments.delay_ms * 1e-3);
  haptics::TickParameters fitted;
  haptics::fitToDevice(device->limits, arguments.delay_ms * 1e-3, fitted);
  const FeatureLimits limits{stiffest, contactLimit, device->limits.maxForce,
                             1.0 / haptics::TickParameters{}.dt, fitted.dampingLimit};
  const Features features{surfaceFeatures(*scene, limits), fieldFeatures(*scene, limits),
                          controlFeatures(*scene, limits)};
  if (arguments.json)
    std::printf("%s\n", toJson(*scene, models, features, *device, arguments, limits).dump(2).c_str());
  else
    print(*scene, models, features, *device, arguments, limits);
  return kExitDone;
}

}  // namespace

void addCheck(CLI::App& app, int& exitCode) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("check", "Say what is wrong with a scene, and how each part will be felt");
  addSceneOptions(*command, arguments->scene);
  command->add_option("--device", arguments->device, "Device class: " + deviceClassNames())
      ->capture_default_str();
  command->add_option("--delay-ms", arguments->delay_ms, "Delay between device and loop")
      ->check(numberFrom(0.0, 1e6));
  command->add_flag("--json", arguments->json, "Print JSON instead of a table");
  command->callback([arguments, &exitCode] { exitCode = run(*arguments); });
}

}  // namespace tandem::client
