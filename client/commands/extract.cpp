// tandem extract: how a part, or every part, comes out of its assembly.

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/gtc/quaternion.hpp>

#include "assets/base/json.h"
#include "assets/scene/near_names.h"
#include "assets/scene/scene.h"
#include "client/base/readable.h"
#include "client/commands/command.h"
#include "client/commands/way_out.h"
#include "client/extraction/extraction_order.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client {

namespace {

struct ExtractArguments {
  SceneArguments scene;
  std::string part, path, json;
  bool order = false;
  ExtractionOptions options;
};

Json extractionJson(const assets::Scene& scene, const Extraction& extraction) {
  const auto vector = [](const glm::dvec3& v) { return Json{v.x, v.y, v.z}; };
  Json way = Json::array(), blockers = Json::array();
  for (const ExtractionLeg& leg : extraction.way)
    way.push({{"axis", vector(leg.axis)}, {"distance_m", leg.distance}});
  for (const PartId part : extraction.blockedBy) blockers.push(scene.parts[part].name);
  return {{"part", scene.parts[extraction.part].name},
          {"free", extraction.free},
          {"axis", extraction.way.empty() ? Json(nullptr) : vector(extraction.way.front().axis)},
          {"way", way},
          {"force_n", extraction.force},
          {"work_j", extraction.work},
          {"blocked_by", blockers}};
}

/// The way as a path for `tandem probe --tool part:NAME`, one row a millisecond: a pose of the way every
/// 20 ms, and straight lines between them.
std::string pathCsv(const std::vector<Pose>& path) {
  constexpr int kRowsAPose = 20;
  std::string text = "t,x,y,z,qw,qx,qy,qz\n";
  char line[256];
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    for (int k = 0; k < kRowsAPose; ++k) {
      const double share = static_cast<double>(k) / kRowsAPose;
      const glm::dvec3 p = glm::mix(path[i].position, path[i + 1].position, share);
      const glm::dquat q = glm::normalize(glm::slerp(path[i].orientation, path[i + 1].orientation, share));
      std::snprintf(line, sizeof line, "%.3f,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",
                    1e-3 * static_cast<double>(i * kRowsAPose + static_cast<std::size_t>(k)), p.x, p.y, p.z,
                    q.w, q.x, q.y, q.z);
      text += line;
    }
  return text;
}

Result<PartId> partToTake(const ExtractArguments& arguments, const assets::Scene& scene) {
  const PartId part = assets::findPart(scene, arguments.part);
  if (part == kNoPart)
    return Error{"--part " + arguments.part + ": no part has this name" +
                 assets::nearParts(arguments.part, scene)};
  if (!scene.parts[part].movable)
    return Error{"--part " + arguments.part + ": it cannot be moved; add --movable " + arguments.part};
  return part;
}

ExtractionOrder extractAll(PartExtractor& extractor, std::size_t parts) {
  ProgressLine progress;
  return extractionOrder(extractor, parts,
                         [&](double done) { progress.show(done, "trying each part's way out"); });
}

int runExtract(const ExtractArguments& arguments) {
  if (arguments.part.empty() != arguments.order)
    return badInput(Error{"extract: name one of --part NAME and --order"});
  for (const std::string& out : {arguments.json, arguments.path})
    if (Status free = writable(out); !free) return badInput(free.error());
  Result<assets::Scene> scene = loadScene(arguments.scene);
  if (!scene) return badInput(scene.error());
  PartId part = kNoPart;
  if (!arguments.order) {
    Result<PartId> named = partToTake(arguments, *scene);
    if (!named) return badInput(named.error());
    part = *named;
  }
  lightenParts(*scene, arguments.options);
  haptics::ContactScene contact(*scene);
  modelParts(contact, arguments.scene.noCache);
  PartExtractor extractor(contact, arguments.options);
  ExtractionOrder result;
  if (arguments.order) {
    result = extractAll(extractor, scene->parts.size());
    if (result.parts.empty())
      return badInput(Error{"extract: the scene has no part that can be moved (see --movable)"});
  } else if (!extractor.canTake(part)) {
    return badInput(
        Error{"--part " + arguments.part + ": it is a control, or has no surface that others touch"});
  } else {
    result.parts.push_back(extractor.extract(part));
    if (result.parts.front().free) result.order.push_back(part);
  }

  for (const Extraction& extraction : result.parts)
    std::printf("%s %s\n", scene->parts[extraction.part].name.c_str(),
                outcomeInWords(*scene, extraction).c_str());
  if (arguments.order) std::printf("order: %s\n", partNamesInWords(*scene, result.order).c_str());
  if (!arguments.path.empty())
    if (Status written = writeFile(arguments.path, pathCsv(result.parts.front().path)); !written)
      return badInput(written.error());
  if (arguments.json.empty()) return kExitDone;
  Json order = Json::array(), parts = Json::array();
  for (const PartId id : result.order) order.push(scene->parts[id].name);
  for (const Extraction& extraction : result.parts) parts.push(extractionJson(*scene, extraction));
  const Json json = {{"order", order}, {"parts", parts}};
  if (Status written = writeFile(arguments.json, json.dump(2) + "\n"); !written)
    return badInput(written.error());
  return kExitDone;
}

}  // namespace

void addExtract(assets::CommandLine& program, int& exitCode) {
  auto arguments = std::make_shared<ExtractArguments>();
  assets::CommandLine command =
      program.command("extract", "Find how a part comes out of its assembly, or the order in which all do");
  addSceneOptions(command, arguments->scene);
  command.option("--part", arguments->part, "Name of the part to take out");
  command.flag("--order", arguments->order, "Take out all parts that can be moved, one after the other");
  command.option("--force", arguments->options.maxForce, "N, with which a hand draws before it gives up")
      .showDefault()
      .numberFrom(1e-3, 1e6);
  command
      .option("--pulls", arguments->options.maxPulls,
              "Straight pulls tried for a part before it counts as stuck")
      .showDefault()
      .integerFrom(1, 100000);
  command
      .option("--path", arguments->path,
              "With --part: write the way to this CSV file, for `tandem probe --tool part:NAME --path`")
      .needs("--part");
  command.option("--json", arguments->json, "Write the ways, or what blocks them, to this file");
  command.footer(
      "A hand draws the part along axes of the world, of the part and of its bores, by the contact that is "
      "also\n"
      "felt, and gives way sideways and in rotation. From where it gets stuck it tries again, until the part "
      "is\n"
      "out or --pulls are spent. All other parts stand still; weight is left out; nothing is unscrewed.\n"
      "Example: tandem extract assets/scenes/filter_change.glb --order");
  command.onRun([arguments, &exitCode] { exitCode = runExtract(*arguments); });
}

}  // namespace tandem::client
