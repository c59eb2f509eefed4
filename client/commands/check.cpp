#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

#include "assets/base/assert.h"
#include "assets/base/json.h"
#include "assets/base/percentiles.h"
#include "assets/mesh/fit_findings.h"
#include "assets/scene/scene_size.h"
#include "assets/scene/stated_tolerances.h"
#include "client/base/readable.h"
#include "client/commands/check_clashes.h"
#include "client/commands/check_contact.h"
#include "client/commands/check_measure.h"
#include "client/commands/command.h"
#include "client/review/device_class.h"
#include "client/review/part_stroke.h"
#include "client/review/scene_features.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/safety/device_defaults.h"
#include "haptics/tick.h"

namespace tandem::client {

namespace {

struct CheckArguments {
  SceneArguments scene;
  std::string device = "desktop";
  double delay_ms = 0.0;
  bool json = false, models = false;
  ClashArguments clashes;
  MeasureArguments measures;
};

/// The coupling to a held part on a device.
struct GraspFit {
  haptics::CouplingGains stiffest, used;
  bool kept = false;  // the defaults are stable
};

GraspFit fitGrasp(const haptics::DeviceLimits& limits, double delay) {
  const haptics::TickParameters defaults;
  haptics::TickParameters fitted;
  haptics::fitToDevice(limits, delay, fitted);
  return {haptics::stiffestGrasp(limits, defaults.dt, delay),
          {fitted.graspStiffness, fitted.graspDamping, fitted.graspRotStiffness, fitted.graspRotDamping},
          fitted.graspStiffness == defaults.graspStiffness && fitted.graspDamping == defaults.graspDamping &&
              fitted.graspRotStiffness == defaults.graspRotStiffness &&
              fitted.graspRotDamping == defaults.graspRotDamping};
}

/// The model of a part for the stylus, and its cost.
struct StylusModel {
  std::string name, model;
  std::size_t triangles = 0, bytes = 0;
  double error = 0.0;  // m, PartStroke::error: without the tessellation error of the file's own surfaces
  std::size_t touching = 0;  // ticks over which `error` is the maximum; 0: nothing can touch the part
  double cost_us_p50 = 0.0, cost_us_p99 = 0.0;
  bool movable = false;
  double mass = 0.0;
};

StylusModel modelOf(const haptics::ContactScene& contact, const haptics::ContactWorld& world,
                    haptics::TickState& state, PartId id) {
  const assets::Scene& scene = contact.scene();
  const assets::Part& part = scene.parts[id];
  StylusModel model;
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

Json remarksJson(const Feature& feature) {
  Json list = Json::array();
  for (const Remark& remark : feature.remarks) list.push(remark.text);
  return list;
}

Json effectsJson(const Feature& feature) {
  Json effects = Json::object();
  for (const Effect& effect : feature.effects) {
    Json& entry = effects[effect.name] = Json::object();
    if (!effect.text.empty()) entry["is"] = effect.text;
    for (const Quantity& quantity : effect.quantities) entry[jsonKey(quantity)] = quantity.value;
  }
  return effects;
}

Json featureJson(const Feature& feature, const char* name, const char* kind) {
  Json json = {{name, feature.name}, {kind, feature.kind}};
  json["effects"] = effectsJson(feature);
  json["remarks"] = remarksJson(feature);
  return json;
}

void printGrasp(const DeviceClass& device, const CheckArguments& arguments) {
  const GraspFit fit = fitGrasp(device.limits, arguments.delay_ms * 1e-3);
  std::printf("stiffest stable grasp: %.0f N/m", fit.stiffest.stiffness);
  if (fit.stiffest.rotStiffness > 0.0)
    std::printf(" and %.3g N*m/rad (damping %.2g N*m*s/rad)", fit.stiffest.rotStiffness,
                device.limits.rotDamping);
  else
    std::printf("; the device drives no torque, so turning has no limit of its own");
  std::printf("; %.0f N/m and %.3g N*m/rad in use, %s\n", fit.used.stiffness, fit.used.rotStiffness,
              fit.kept ? "the defaults" : "lowered from the defaults");
}

Json graspJson(const DeviceClass& device, const CheckArguments& arguments) {
  const GraspFit fit = fitGrasp(device.limits, arguments.delay_ms * 1e-3);
  const bool turns = fit.stiffest.rotStiffness > 0.0;
  return {{"stiffest_n_per_m", fit.stiffest.stiffness},
          {"stiffest_n_m_per_rad", turns ? Json(fit.stiffest.rotStiffness) : nullptr},
          {"used_n_per_m", fit.used.stiffness},
          {"used_n_m_per_rad", fit.used.rotStiffness},
          {"defaults_kept", fit.kept}};
}

Json checkJson(const assets::Scene& scene, const std::vector<StylusModel>& models,
               const std::vector<ContactModel>& contact, const Features& features, const DeviceClass& device,
               const CheckArguments& arguments, const FeatureLimits& limits) {
  Json json;
  json["parts"] = Json::array();
  for (const StylusModel& m : models)
    json["parts"].push({{"name", m.name},
                        {"model", m.model},
                        {"triangles", m.triangles},
                        {"error_m", m.error},
                        {"ticks_touching", m.touching},
                        {"cost_us", {{"p50", m.cost_us_p50}, {"p99", m.cost_us_p99}}},
                        {"memory_bytes", m.bytes},
                        {"movable", m.movable},
                        {"mass_kg", m.mass}});
  json["contact"] = contactJson(scene, contact);
  json["findings"] = Json::array();
  for (const assets::Finding& f : scene.findings)
    json["findings"].push({{"severity", severity(f.severity)},
                           {"code", f.code},
                           {"where", f.where},
                           {"count", f.count},
                           {"message", f.message}});
  json["surfaces"] = Json::array();
  for (const Feature& feature : features.surfaces)
    json["surfaces"].push(featureJson(feature, "part", "material"));
  ASSERT(features.fields.size() == scene.fields.size());
  json["fields"] = Json::array();
  for (std::size_t i = 0; i < scene.fields.size(); ++i) {
    const assets::ForceField& f = scene.fields[i];
    json["fields"].push({{"name", f.name},
                         {"kind", assets::nameOf(f.kind)},
                         {"energy", assets::nameOf(assets::passivity(f))},
                         {"part", f.part == kNoPart ? "" : scene.parts[f.part].name},
                         {"max_force_n", f.maxForce},
                         {"stiffness_n_per_m", assets::steepest(f)},
                         {"effects", effectsJson(features.fields[i])},
                         {"remarks", remarksJson(features.fields[i])}});
  }
  ASSERT(features.controls.size() == scene.controls.size());
  json["controls"] = Json::array();
  for (const Feature& feature : features.controls) {
    json["controls"].push(featureJson(feature, "name", "kind"));
    json["controls"].back()["part"] = feature.part;
  }
  json["triangles"] = assets::triangleCount(scene);
  const glm::dvec3 size = scene.bounds.max - scene.bounds.min;
  json["size_m"] = {size.x, size.y, size.z};
  json["unit_doubt"] = assets::unitDoubt(scene, arguments.scene.units);
  json["device"] = device.name;
  json["delay_ms"] = arguments.delay_ms;
  json["stiffest_stable_n_per_m"] = limits.stiffest;
  json["stiffest_controlled_n_per_m"] = limits.contact;
  json["grasp"] = graspJson(device, arguments);
  return json;
}

void printFeatures(const char* what, const std::vector<Feature>& features) {
  for (const Feature& feature : features) std::printf("%s %s\n", what, inOneLine(feature).c_str());
}

/// Prints one line for each kind of remark, with the first feature that has it.
void printRemarks(const char* what, const std::vector<Feature>& features) {
  for (const RemarkGroup& group : groupRemarks(features)) {
    std::string where = group.example;
    if (group.features > 1) where += " and " + std::to_string(group.features - 1) + " more";
    if (group.materials > 1) where += " (" + std::to_string(group.materials) + " materials)";
    std::printf("remark          %s %s: %s\n", what, where.c_str(), group.text.c_str());
  }
}

void printCheck(const assets::Scene& scene, const std::vector<StylusModel>& models,
                const std::vector<ContactModel>& contact, const Features& features, const DeviceClass& device,
                const CheckArguments& arguments, const FeatureLimits& limits) {
  std::size_t width = 8;
  for (const StylusModel& m : models) width = std::max(width, std::min<std::size_t>(m.name.size(), 40));
  const int w = static_cast<int>(width);
  printTooCostly(scene, contact);
  std::printf("%-*s %-9s %9s %10s %15s %9s %s\n", w, "part", "model", "triangles", "error", "tick us p50/p99",
              "memory", "movable");
  for (const StylusModel& m : models) {
    std::printf("%-*.40s %-9s %9zu ", w, m.name.c_str(), m.model.c_str(), m.triangles);
    std::printf("%10s %7s/%7s %9s ", m.touching > 0 ? readableLength(m.error).c_str() : "-",
                threeDigits(m.cost_us_p50).c_str(), threeDigits(m.cost_us_p99).c_str(),
                readableBytes(m.bytes).c_str());
    std::printf("%s\n", m.movable ? readableMass(m.mass).c_str() : "-");
  }
  printContact(scene, contact);
  std::printf("\nscene %s, %zu parts, %zu triangles\n", assets::sizeInWords(scene).c_str(),
              scene.parts.size(), assets::triangleCount(scene));
  if (const std::string doubt = assets::unitDoubt(scene, arguments.scene.units); !doubt.empty())
    std::printf("warning         %s\n", doubt.c_str());
  printFeatures("surface", oneEachMaterial(features.surfaces));
  printFeatures("field", features.fields);
  printFeatures("control", features.controls);
  printRemarks("surface", features.surfaces);
  printRemarks("field", features.fields);
  printRemarks("control", features.controls);
  const auto isTolerance = [](const assets::Finding& f) { return f.code == assets::kStatedTolerance; };
  for (const assets::Finding& f : scene.findings)
    if (isTolerance(f)) std::printf("tolerance %s: %s\n", f.where.c_str(), f.message.c_str());
  if (std::all_of(scene.findings.begin(), scene.findings.end(), isTolerance))
    std::printf("no findings: a clean file\n");
  for (const assets::Finding& f : scene.findings)
    if (!isTolerance(f))
      std::printf("%-8s %6llu  %s%s%s\n", severity(f.severity), static_cast<unsigned long long>(f.count),
                  f.message.c_str(), f.where.empty() ? "" : "  in ", f.where.c_str());
  std::printf(
      "\nstiffest stable contact: %.0f N/m on %s (damping %.2f N*s/m, 1 kHz, delay in the loop %.1f ms); "
      "%.0f N/m under the passivity controller, as 'tandem join' has it\n",
      limits.stiffest, device.what, device.limits.damping, arguments.delay_ms, limits.contact);
  printGrasp(device, arguments);
}

/// Makes the contact models; without --models only those in the cache.
void makeModels(haptics::ContactScene& contact, const CheckArguments& arguments) {
  if (arguments.models) {
    modelParts(contact, arguments.scene.noCache);
  } else if (!arguments.scene.noCache) {
    haptics::ModelOptions options;
    options.cacheDirectory = assets::defaultCacheDirectory();
    options.onlyCached = true;
    static_cast<void>(contact.modelParts(options));
  }
}

int runCheck(const CheckArguments& arguments) {
  const DeviceClass* device = findDeviceClass(arguments.device);
  if (!device)
    return badInput(Error{"--device " + arguments.device + ": must be one of " + deviceClassNames()});
  Result<assets::Scene> scene = loadScene(arguments.scene);
  if (!scene) return badInput(scene.error());
  if (arguments.measures.requested()) return runMeasure(*scene, arguments.measures);
  if (arguments.clashes.requested()) return runClashes(*scene, arguments.clashes);
  for (assets::Finding& finding : assets::fitFindings(*scene)) scene->findings.push_back(std::move(finding));
  haptics::ContactScene contact(*scene);
  makeModels(contact, arguments);
  const haptics::ContactWorld world(contact);
  haptics::TickState state(contact);
  std::vector<StylusModel> models;
  for (std::size_t i = 0; i < scene->parts.size(); ++i)
    models.push_back(modelOf(contact, world, state, static_cast<PartId>(i)));
  const std::vector<ContactModel> held = contactModels(contact, arguments.models);
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
    std::printf("%s\n",
                checkJson(*scene, models, held, features, *device, arguments, limits).dump(2).c_str());
  else
    printCheck(*scene, models, held, features, *device, arguments, limits);
  return kExitDone;
}

}  // namespace

void addCheck(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<CheckArguments>();
  assets::CommandLine command =
      program.command("check", "Say what is wrong with a scene, and how each part will be felt");
  addSceneOptions(command, arguments->scene);
  command.option("--device", arguments->device, "Device class: " + deviceClassNames()).showDefault();
  command.option("--delay-ms", arguments->delay_ms, "Delay between device and loop").numberFrom(0.0, 1e6);
  command.flag("--json", arguments->json, "Print JSON instead of a table");
  command.flag("--models", arguments->models,
               "Make what parts in the hand need to collide, where the cache does not have it (large scenes: "
               "minutes), and try each part; without it, what the cache has is shown");
  const assets::CommandLineOption clash = command.flag(
      "--clash", arguments->clashes.all,
      "Instead of the above: which parts overlap and how deep, which touch, standing as in the file");
  command
      .option("--clearance", arguments->clashes.clearance,
              "With --clash: also pairs of parts nearer to each other than this, m")
      .numberFrom(0.0, 1e6)
      .needs(clash);
  command
      .option("--tolerance", arguments->clashes.tolerance,
              "With --clash: overlaps no deeper than this are touches, m [a millionth of the larger part]")
      .numberFrom(0.0, 1e6)
      .needs(clash);
  assets::CommandLineOption distance =
      command.option("--distance", arguments->clashes.distance,
                     "Instead of the above: how far two parts are from each other, or how deep they overlap");
  distance.values(2).typeName("PART PART");
  command
      .option("--measure", arguments->measures.places,
              "Instead of the above: the face, cylinder and edge nearest to a place (m); given twice, also "
              "distance and angle between both and the clearance of their parts")
      .oneValue()
      .typeName("X,Y,Z")
      .excludes(clash)
      .excludes(distance);
  command.footer(
      "Examples:\n"
      "  tandem check engine.glb --units mm --movable all\n"
      "      What is wrong with a CAD file in millimetres, and what each part costs to feel.\n"
      "  tandem check engine.glb --units mm --clash --clearance 0.0005\n"
      "      Which parts overlap, touch, or stand nearer than half a millimetre to each other.");
  command.onRun([arguments, &exitCode] {
    arguments->clashes.json = arguments->measures.json = arguments->json;
    exitCode = runCheck(*arguments);
  });
}

}  // namespace tandem::client
