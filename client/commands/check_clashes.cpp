#include "client/commands/check_clashes.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <span>
#include <string>

#include "assets/base/assert.h"
#include "assets/base/json.h"
#include "assets/scene/near_names.h"
#include "client/base/readable.h"
#include "client/commands/command.h"
#include "client/review/clash_check.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client {

namespace {

const char* wordFor(const Clash& clash) {
  switch (clash.kind) {
    case ClashKind::hard:
      return clash.contained ? "inside" : "overlap";
    case ClashKind::touch:
      return "touch";
    case ClashKind::clearance:
      return "near";
  }
  return "near";
}

/// Whether the facets of curved surfaces alone may explain an overlap.
bool withinFacets(const Clash& clash) {
  return clash.kind == ClashKind::hard && !clash.open && clash.depth <= clash.facetSag;
}

struct Counts {
  std::size_t hard = 0, open = 0, withinFacets = 0, touches = 0, clearance = 0, mayNot = 0;
};
Counts countOf(const ClashReport& report) {
  Counts counts;
  for (const Clash& clash : report.clashes) {
    if (!clash.mayCollide) {
      ++counts.mayNot;
    } else if (clash.kind == ClashKind::hard) {
      ++counts.hard;
      counts.open += clash.open ? 1 : 0;
      counts.withinFacets += withinFacets(clash) ? 1 : 0;
    } else {
      ++(clash.kind == ClashKind::touch ? counts.touches : counts.clearance);
    }
  }
  return counts;
}

/// The deepest hard clashes, then those of unknown depth; ten at most.
std::span<const Clash> worstOf(const ClashReport& report) {
  constexpr std::size_t kMaxListed = 10;
  std::size_t count = 0;
  while (count < std::min(kMaxListed, report.clashes.size()) && report.clashes[count].mayCollide &&
         report.clashes[count].kind == ClashKind::hard)
    ++count;
  return {report.clashes.data(), count};
}

Json clashesJson(const assets::Scene& scene, const ClashReport& report, double clearance) {
  const Counts counts = countOf(report);
  Json json = {{"clearance_m", clearance},
               {"pairs", report.pairs},
               {"hard", counts.hard},
               {"open", counts.open},
               {"within_facets", counts.withinFacets},
               {"touches", counts.touches},
               {"clearance", counts.clearance},
               {"may_not_collide", counts.mayNot}};
  json["worst"] = Json::array();
  for (const Clash& clash : worstOf(report))
    json["worst"].push({{"a", scene.parts[clash.a].name},
                        {"b", scene.parts[clash.b].name},
                        {"depth_m", clash.open ? Json(nullptr) : Json(clash.depth)}});
  json["found"] = Json::array();
  for (const Clash& clash : report.clashes) json["found"].push(clashJson(scene, clash));
  return json;
}

/// What there is to say of a clash beside its depth.
std::string noteOn(const Clash& clash) {
  if (clash.sheets) return "  (open surfaces that cross)";
  if (clash.open && clash.depth > 0.0)
    return "  (a shell is open; at least " + readableLength(clash.depth) + ')';
  if (clash.open) return "  (a shell is open)";
  return withinFacets(clash) ? "  (within the facets' sag)" : "";
}

void printTable(const assets::Scene& scene, std::span<const Clash> clashes) {
  std::size_t width = 4;
  for (const Clash& clash : clashes) {
    for (const PartId part : {clash.a, clash.b}) width = std::max(width, scene.parts[part].name.size());
  }
  const int w = static_cast<int>(std::min<std::size_t>(width, 32));
  std::printf("%-8s %9s  %-*s %-*s %s\n", "", "by", w, "part", w, "part", "at x y z in m");
  for (std::size_t i = 0; i < clashes.size(); ++i) {
    const Clash& clash = clashes[i];
    if (!clash.mayCollide && (i == 0 || clashes[i - 1].mayCollide))
      std::printf("may not collide, by collision filter or joint:\n");
    const glm::dvec3 at = clash.kind == ClashKind::hard ? clash.deepest : 0.5 * (clash.onA + clash.onB);
    const std::string by = clash.open ? "unknown" : readableLength(std::max(clash.depth, clash.distance));
    std::printf("%-8s %9s  %-*.32s %-*.32s %.4g %.4g %.4g%s\n", wordFor(clash), by.c_str(), w,
                scene.parts[clash.a].name.c_str(), w, scene.parts[clash.b].name.c_str(), at.x, at.y, at.z,
                noteOn(clash).c_str());
  }
}

/// The summary: how many there are of each kind.
void printCounts(const assets::Scene& scene, const ClashReport& report, double clearance) {
  const Counts counts = countOf(report);
  std::printf("%zu hard clashes", counts.hard);
  if (counts.withinFacets > 0 || counts.open > 0)
    std::printf(" (%zu no deeper than facets are off curved surfaces", counts.withinFacets);
  if (counts.open > 0)
    std::printf("; of %zu the depth cannot be known, because a shell is open", counts.open);
  if (counts.withinFacets > 0 || counts.open > 0) std::printf(")");
  std::printf(", %zu touches", counts.touches);
  if (clearance > 0.0)
    std::printf(", %zu pairs nearer than %s", counts.clearance, readableLength(clearance).c_str());
  if (counts.mayNot > 0) std::printf(", %zu pairs that may not collide", counts.mayNot);
  std::printf("; %zu parts, %zu pairs measured\n", scene.parts.size(), report.pairs);
  if (counts.hard > 0)
    std::printf("Parts stand in each other like this in the file: who takes one is not pushed out of it.\n");
}

void printClashes(const assets::Scene& scene, const ClashReport& report, double clearance) {
  printCounts(scene, report, clearance);
  const std::span<const Clash> worst = worstOf(report);
  if (!worst.empty() && worst.size() < report.clashes.size()) {
    std::printf("\nthe worst\n");
    printTable(scene, worst);
  }
  if (report.clashes.empty()) return;
  std::printf("\nall\n");
  printTable(scene, report.clashes);
}

/// The two parts that --distance names.
Result<std::pair<PartId, PartId>> namedPair(const assets::Scene& scene,
                                            const std::vector<std::string>& names) {
  ASSERT(names.size() == 2);
  PartId parts[2];
  for (std::size_t i = 0; i < 2; ++i) {
    parts[i] = assets::findPart(scene, names[i]);
    if (parts[i] == kNoPart)
      return Error{"--distance: the scene has no part '" + names[i] + "'" +
                   assets::nearParts(names[i], scene)};
  }
  if (parts[0] == parts[1]) return Error{"--distance: '" + names[0] + "' is named twice"};
  return std::pair{parts[0], parts[1]};
}

ClashReport findWithProgress(const haptics::ContactScene& contact, const ClashArguments& arguments) {
  ClashOptions options;
  options.clearance = arguments.clearance;
  options.tolerance = arguments.tolerance;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  if (terminal)
    options.progress = [](std::size_t done, std::size_t pairs) {
      std::fprintf(stderr, "\r\033[K%3.0f %% of %zu pairs",
                   100.0 * static_cast<double>(done) / static_cast<double>(pairs), pairs);
      std::fflush(stderr);
    };
  ClashReport report = findClashes(contact, options);
  if (terminal) std::fputs("\r\033[K", stderr);
  return report;
}

}  // namespace

Json pointJson(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

Json clashJson(const assets::Scene& scene, const Clash& clash) {
  ASSERT(clash.a < scene.parts.size() && clash.b < scene.parts.size());
  return {{"a", scene.parts[clash.a].name},
          {"b", scene.parts[clash.b].name},
          {"kind", wordFor(clash)},
          {"depth_m", clash.open ? Json(nullptr) : Json(clash.depth)},
          {"open", clash.open},
          {"at_least_m", clash.depth},
          {"distance_m", clash.distance},
          {"deepest_m", clash.kind == ClashKind::hard ? pointJson(clash.deepest) : Json(nullptr)},
          {"point_a_m", pointJson(clash.onA)},
          {"point_b_m", pointJson(clash.onB)},
          {"facet_sag_m", clash.facetSag},
          {"sheets", clash.sheets},
          {"may_collide", clash.mayCollide}};
}

void printClash(const assets::Scene& scene, const Clash& clash) {
  const char *a = scene.parts[clash.a].name.c_str(), *b = scene.parts[clash.b].name.c_str();
  const char* how = clash.contained ? "stand inside each other" : "overlap";
  if (clash.open)
    std::printf("%s and %s %s, how deep cannot be known because a shell is open; at least %s\n", a, b, how,
                readableLength(clash.depth).c_str());
  else if (clash.kind == ClashKind::hard)
    std::printf("%s and %s %s, %s deep\n", a, b, how, readableLength(clash.depth).c_str());
  else if (clash.kind == ClashKind::touch)
    std::printf("%s and %s touch\n", a, b);
  else
    std::printf("%s and %s are %s apart\n", a, b, readableLength(clash.distance).c_str());
  for (const auto& [name, p] : {std::pair{a, clash.onA}, std::pair{b, clash.onB}})
    std::printf("  %s at %.6g %.6g %.6g m\n", name, p.x, p.y, p.z);
  if (withinFacets(clash))
    std::printf("  no deeper than the facets there may be off curved surfaces: %s\n",
                readableLength(clash.facetSag).c_str());
  if (clash.sheets) std::printf("  open surfaces that cross: by so much facets stand through each other\n");
  if (!clash.mayCollide) std::printf("  may not collide, by collision filter or joint\n");
}

int runClashes(const assets::Scene& scene, const ClashArguments& arguments) {
  std::pair<PartId, PartId> pair{kNoPart, kNoPart};
  if (!arguments.distance.empty()) {
    const Result<std::pair<PartId, PartId>> named = namedPair(scene, arguments.distance);
    if (!named) return badInput(named.error());
    pair = *named;
  }
  const haptics::ContactScene contact(scene);
  Json json;
  if (pair.first != kNoPart) {
    const PartClosings closings(contact);
    const std::optional<Clash> clash =
        measurePair(closings, pair.first, scene.parts[pair.first].worldFromPart, pair.second,
                    scene.parts[pair.second].worldFromPart);
    if (!clash) return badInput(Error{"--distance: one of the parts has nothing that could be touched"});
    if (arguments.json)
      json["distance"] = clashJson(scene, *clash);
    else
      printClash(scene, *clash);
  }
  if (arguments.all) {
    const ClashReport report = findWithProgress(contact, arguments);
    if (arguments.json)
      json["clashes"] = clashesJson(scene, report, arguments.clearance);
    else
      printClashes(scene, report, arguments.clearance);
  }
  if (arguments.json) std::printf("%s\n", json.dump(2).c_str());
  return kExitDone;
}

}  // namespace tandem::client
