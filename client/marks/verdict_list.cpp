#include "client/marks/verdict_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "client/marks/note_list.h"
#include "client/session/document_words.h"

namespace tandem::client {

using namespace document;

namespace {

constexpr double kSmallersShown =
    2.5;                          // half of the view's height, in diagonals of the smaller part, at most
constexpr double kMargin = 1.15;  // around parts
constexpr std::size_t kNotKept = kClashStatusNames.size();
/// In which order the statuses are listed.
constexpr std::array<std::size_t, kNotKept + 1> kOrder{0, 1, kNotKept, 2, 3, 4};

std::string nameOf(const assets::Scene& scene, PartId part) {
  if (part >= scene.parts.size() || scene.parts[part].name.empty()) return "part " + std::to_string(part);
  return scene.parts[part].name;
}

/// A verdict whose clash the last search did not find.
ClashLine lineOf(const PartPair& pair, const Entry& entry, const assets::Scene& scene) {
  const ClashVerdict& verdict = std::get<ClashVerdict>(entry.body);
  Clash was;
  was.kind = ClashKind::hard;
  was.depth = verdict.depth;
  const bool gone = verdict.status == ClashStatus::resolved;
  return {{nullptr, nameOf(scene, pair.first), nameOf(scene, pair.second), "was " + measureOf(was),
           gone ? "" : "not found"},
          pair.first,
          pair.second,
          entry};
}

double reach(const glm::dvec3& from, const assets::Bounds& box) {
  return glm::length(glm::max(glm::abs(box.min - from), glm::abs(box.max - from)));
}

}  // namespace

glm::vec3 statusColour(ClashStatus status) {
  switch (status) {
    case ClashStatus::fresh:
      return {0.80f, 0.16f, 0.13f};
    case ClashStatus::active:
      return {0.80f, 0.47f, 0.02f};
    case ClashStatus::reviewed:
      return {0.16f, 0.42f, 0.82f};
    case ClashStatus::approved:
      return {0.10f, 0.55f, 0.29f};
    case ClashStatus::resolved:
      break;
  }
  return {0.42f, 0.46f, 0.51f};
}

std::vector<ClashGroup> clashGroups(const ClashFindings* findings, const Document* document,
                                    const assets::Scene& scene, bool touches) {
  std::map<PartPair, const Entry*> verdicts;
  if (document != nullptr) verdicts = verdictsByPair(*document);
  std::array<ClashGroup, kNotKept + 1> groups;
  const auto statusOf = [](const Entry* entry) {
    return entry == nullptr ? kNotKept : static_cast<std::size_t>(std::get<ClashVerdict>(entry->body).status);
  };
  if (findings != nullptr)
    for (ClashRow& row : clashRows(*findings, scene, touches)) {
      const PartPair pair = pairOf(row.found->clash.a, row.found->clash.b);
      const auto at = verdicts.find(pair);
      const Entry* entry = at == verdicts.end() ? nullptr : at->second;
      if (entry != nullptr) verdicts.erase(at);
      ClashLine line{std::move(row), pair.first, pair.second, std::nullopt};
      if (entry != nullptr) line.verdict = *entry;
      groups[statusOf(entry)].lines.push_back(std::move(line));
    }
  for (const auto& [pair, entry] : verdicts)
    if (pair.second < scene.parts.size())
      groups[statusOf(entry)].lines.push_back(lineOf(pair, *entry, scene));
  std::vector<ClashGroup> listed;
  for (const std::size_t status : kOrder) {
    ClashGroup& group = groups[status];
    if (group.lines.empty()) continue;
    group.title = status == kNotKept ? "not kept" : kClashStatusNames[status];
    group.colour =
        statusColour(status == kNotKept ? ClashStatus::resolved : static_cast<ClashStatus>(status));
    listed.push_back(std::move(group));
  }
  return listed;
}

std::vector<ClashGroup> byPart(const std::vector<ClashGroup>& groups) {
  std::vector<ClashLine> left;
  std::map<PartId, std::size_t> counts;  // of lines that are left
  for (const ClashGroup& group : groups)
    for (const ClashLine& line : group.lines) {
      left.push_back(line);
      ++counts[line.a];
      ++counts[line.b];
    }
  std::vector<ClashGroup> listed;
  while (!left.empty()) {
    const auto most = std::max_element(counts.begin(), counts.end(), [](const auto& one, const auto& other) {
      return one.second < other.second;
    });
    const PartId part = most->first;
    const bool single = most->second < 2;
    ClashGroup& group = listed.emplace_back();
    group.colour = statusColour(ClashStatus::resolved);
    std::vector<ClashLine> others;
    for (ClashLine& line : left) {
      const bool here = single || line.a == part || line.b == part;
      if (here && !single) group.title = line.a == part ? line.row.first : line.row.second;
      if (here) --counts[line.a], --counts[line.b];
      (here ? group.lines : others).push_back(std::move(line));
    }
    left = std::move(others);
  }
  return listed;
}

std::vector<Change> changesToKeep(const ViewModel& model) {
  const ClashFindings* findings = model.clashes.findings.get();
  if (findings == nullptr || model.document == nullptr) return {};
  std::vector<Clash> found;
  found.reserve(findings->found.size());
  for (const FoundClash& each : findings->found) found.push_back(each.clash);
  return mergeClashes(*model.document, found, findings->complete, ownName(model));
}

void ClashListing::update(const ViewModel& model, const ClashUi& ui) {
  Made made{model.clashes.findings, model.document != nullptr, ui.touches, ui.byPart, 0, 0};
  if (made.document) {
    made.revision = model.document->revision();
    made.entries = model.document->entries().size();
  }
  if (made_ == made) return;
  groups_ = clashGroups(made.findings.get(), model.document, *model.scene, ui.touches);
  if (ui.byPart) groups_ = byPart(groups_);
  changes_ = changesToKeep(model);
  made_ = std::move(made);
}

std::string judgedBy(const Entry& verdict, std::int64_t now) {
  const ClashVerdict& clash = std::get<ClashVerdict>(verdict.body);
  const std::string who = verdictWords(clash.text).who;
  const std::string& by = who.empty() ? verdict.authorName : who;
  return kClashStatusNames[static_cast<std::size_t>(clash.status)] + (by.empty() ? "" : " by " + by) + ", " +
         ageInWords(verdict.changed, now);
}

Camera cameraForPair(const Camera& from, const std::optional<ClashWitness>& witness, const assets::Bounds& a,
                     const assets::Bounds& b, double aspect) {
  const double smaller = std::min(glm::length(a.max - a.min), glm::length(b.max - b.min));
  const assets::Bounds both{glm::min(a.min, b.min), glm::max(a.max, b.max)};
  if (!witness) return fitFrom(from, both, aspect);
  Camera camera = cameraFor(from, *witness, smaller, aspect);
  const double half = kMargin * std::min(std::max(reach(camera.target, a), reach(camera.target, b)),
                                         kSmallersShown * smaller);
  const double tangent = std::tan(0.5 * camera.fieldOfView) * std::min(1.0, std::max(aspect, 1e-3));
  camera.distance = std::max(camera.distance, half / tangent);
  return camera;
}

}  // namespace tandem::client
