#include "client/commands/check_contact.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "assets/base/json.h"
#include "assets/base/percentiles.h"
#include "client/base/readable.h"
#include "client/commands/command.h"

namespace tandem::client {
namespace {

const char* nameOf(const ContactModel& model) {
  return !model.made ? "none yet" : model.byFormula ? "exact, by formula" : "field + samples";
}

const char* nameOf(haptics::PartTolerance::From from) {
  switch (from) {
    case haptics::PartTolerance::From::given:
      return "given";
    case haptics::PartTolerance::From::clearance:
      return "clearance";
    case haptics::PartTolerance::From::scene:
      break;
  }
  return "default";
}

/// The origin of a tolerance in words.
std::string originOf(const assets::Scene& scene, const ContactModel& m) {
  std::string text = nameOf(m.toleranceFrom);
  if (m.clearanceTo != kNoPart)
    text += ' ' + readableLength(m.clearance) + " to " + scene.parts[m.clearanceTo].name;
  if (m.toleranceOf != m.part) text += ", of the same mesh's " + scene.parts[m.toleranceOf].name;
  return text;
}

std::size_t missing(const std::vector<ContactModel>& models) {
  return static_cast<std::size_t>(
      std::count_if(models.begin(), models.end(), [](const ContactModel& m) { return !m.made; }));
}

/// Prints the columns of a model after its name and role.
void printModel(const assets::Scene& scene, const ContactModel& m) {
  std::printf("%-17s %9s %10s%c %9s %8zu %9s ", m.byFormula ? "exact, by formula" : "field",
              readableLength(m.tolerance).c_str(), readableLength(m.fieldError).c_str(),
              meetsTolerance(m) ? ' ' : '*', m.byFormula ? "-" : readableLength(m.cell).c_str(), m.samples,
              m.byFormula ? "-" : readableLength(m.sag).c_str());
  if (m.trial_us.empty()) {
    std::printf("%15s ", "-");
  } else {
    const Percentiles cost = percentiles(m.trial_us);
    std::printf("%7s/%7s ", threeDigits(cost.p50).c_str(), threeDigits(cost.p99).c_str());
  }
  char made[32];
  std::snprintf(made, sizeof made, "%.2g s%s", m.seconds, m.cached ? ", cache" : "");
  std::printf("%9s %-14s %.90s\n", readableBytes(m.bytes).c_str(), made, originOf(scene, m).c_str());
}

/// A held part and its predicted tick.
struct HeldCost {
  PartId part = kNoPart;
  Percentiles tick_us;
};

/// Held parts whose predicted tick takes longer than a tick's period, once in a hundred: the worst first.
std::vector<HeldCost> tooCostly(const std::vector<ContactModel>& models) {
  constexpr double kTick = 1000.0;  // us
  std::vector<HeldCost> costly;
  for (const ContactModel& m : models) {
    if (m.trial_us.empty()) continue;
    const HeldCost cost{m.part, percentiles(m.trial_us)};
    if (cost.tick_us.p99 > kTick) costly.push_back(cost);
  }
  std::stable_sort(costly.begin(), costly.end(),
                   [](const HeldCost& l, const HeldCost& r) { return l.tick_us.p99 > r.tick_us.p99; });
  return costly;
}

}  // namespace

Json contactJson(const assets::Scene& scene, const std::vector<ContactModel>& models) {
  Json list = Json::array();
  for (const ContactModel& m : models) {
    Json entry = {{"part", scene.parts[m.part].name}, {"held", m.held}, {"model", nameOf(m)}};
    if (m.made) {
      entry.update({{"samples", m.samples},
                    {"cells", m.cells},
                    {"tolerance_m", m.tolerance},
                    {"tolerance_from", nameOf(m.toleranceFrom)},
                    {"tolerance_of", scene.parts[m.toleranceOf].name},
                    {"clearance_m", nullptr},
                    {"clearance_to", nullptr},
                    {"error_m", m.fieldError},
                    {"meets_tolerance", meetsTolerance(m)},
                    {"cell_m", m.cell},
                    {"sample_spacing_m", m.spacing},
                    {"sag_m", m.sag},
                    {"coarsened", m.coarsened},
                    {"cost_us", nullptr},
                    {"memory_bytes", m.bytes},
                    {"bake_s", m.seconds},
                    {"bake_from", m.byFormula ? "formula"
                                  : m.cached  ? "cache"
                                              : "made"}});
      if (m.clearanceTo != kNoPart) {
        entry["clearance_m"] = m.clearance;
        entry["clearance_to"] = scene.parts[m.clearanceTo].name;
      }
      if (!m.trial_us.empty()) {
        const Percentiles cost = percentiles(m.trial_us);
        entry["cost_us"] = {{"p50", cost.p50}, {"p99", cost.p99}, {"predicted_from", "trial of 180 ticks"}};
      }
    }
    list.push(std::move(entry));
  }
  Json json = Json::object();
  if (!models.empty()) {
    json["too_costly"] = Json::array();
    for (const HeldCost& cost : tooCostly(models)) json["too_costly"].push(scene.parts[cost.part].name);
  }
  json["models"] = std::move(list);
  json["missing"] = missing(models);
  return json;
}

void printTooCostly(const assets::Scene& scene, const std::vector<ContactModel>& models) {
  constexpr std::size_t kShown = 10;
  const auto tried =
      std::count_if(models.begin(), models.end(), [](const ContactModel& m) { return !m.trial_us.empty(); });
  if (tried == 0) return;
  const std::vector<HeldCost> costly = tooCostly(models);
  std::printf("too costly to hold: %zu of %td parts that can be held", costly.size(), tried);
  if (!costly.empty())
    std::printf(" have a predicted tick above 1 ms (p99); a running site spends less effort on them");
  std::printf("\n");
  for (std::size_t i = 0; i < std::min(kShown, costly.size()); ++i)
    std::printf("%3zu  %-40.40s tick us p50/p99 %s/%s\n", i + 1, scene.parts[costly[i].part].name.c_str(),
                threeDigits(costly[i].tick_us.p50).c_str(), threeDigits(costly[i].tick_us.p99).c_str());
  if (costly.size() > kShown) std::printf("     and %zu more\n", costly.size() - kShown);
  std::printf("\n");
}

void printContact(const assets::Scene& scene, const std::vector<ContactModel>& models) {
  if (models.empty()) return;
  const std::size_t lacking = missing(models);
  if (lacking == models.size()) {
    std::printf(
        "contact of parts in the hand: models of %zu parts are made at the first visit to a session, or by "
        "--models\n",
        lacking);
    return;
  }
  std::size_t width = 28;
  for (const ContactModel& m : models)
    width = std::max(width, std::min<std::size_t>(scene.parts[m.part].name.size(), 40));
  const int w = static_cast<int>(width);
  std::printf("\n%-*s %-7s %-17s %9s %10s  %9s %8s %9s %15s %9s %-14s %s\n", w,
              "contact of parts in the hand", "role", "model", "tolerance", "error", "cell", "samples", "sag",
              "tick us p50/p99", "memory", "made", "tolerance from");
  for (const ContactModel& m : models) {
    std::printf("%-*.40s %-7s ", w, scene.parts[m.part].name.c_str(), m.held ? "held" : "touched");
    m.made ? printModel(scene, m) : static_cast<void>(std::printf("not made yet: by --models\n"));
  }
  std::printf(
      "  distance field and samples, refined on the triangles; implicit shapes by formula. tolerance from: "
      "given by the file, an eighth of the\n  smallest clearance to a neighbour at rest, or default, 1/16384 "
      "of the smallest part that can be held. error: proven for the field\n  where the surface is smooth. "
      "sag: facets under the curve that they stand for. tick: predicted, processor time of 180 ticks of a\n"
      "  trial where the part stands (--models).\n"
      "  *: the error is above the tolerance; no defect: contact that near is looked up on the triangles.\n");
}

}  // namespace tandem::client
