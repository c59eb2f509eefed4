#include "client/findings/verdicts.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "assets/base/assert.h"
#include "assets/base/printable.h"

namespace tandem::client {

using namespace document;

namespace {

constexpr double kSameDepth = 1e-6;  // m, by which a depth may differ without a word

/// The status that a search leaves a verdict with.
ClashStatus after(ClashStatus before, bool found, bool complete) {
  if (before == ClashStatus::approved) return before;
  if (found) return before == ClashStatus::resolved ? ClashStatus::active : before;
  return complete ? ClashStatus::resolved : before;
}

}  // namespace

PartPair pairOf(PartId a, PartId b) { return {std::min(a, b), std::max(a, b)}; }

bool isCertain(const Clash& clash) {
  return clash.kind == ClashKind::hard && clash.mayCollide && clash.depth > clash.facetSag;
}

VerdictWords verdictWords(const std::string& text) {
  const std::size_t end = text.find(']');
  if (text.empty() || text.front() != '[' || end == std::string::npos) return {{}, text};
  const std::size_t remark = text.find_first_not_of(' ', end + 1);
  return {text.substr(1, end - 1), remark == std::string::npos ? std::string() : text.substr(remark)};
}

std::string verdictText(const VerdictWords& words) {
  std::string who = words.who;
  std::erase(who, ']');
  if (who.empty()) return printable(words.remark, kMaxText);
  return printable('[' + who + ']' + (words.remark.empty() ? "" : ' ' + words.remark), kMaxText);
}

std::map<PartPair, const Entry*> verdictsByPair(const Document& document) {
  std::map<PartPair, const Entry*> verdicts;
  for (const auto& [revision, id] : document.byRevision()) {
    const Entry* entry = document.find(id);
    if (const auto* verdict = std::get_if<ClashVerdict>(&entry->body))
      verdicts[pairOf(verdict->a, verdict->b)] = entry;
  }
  return verdicts;
}

std::vector<Change> mergeClashes(const Document& document, std::span<const Clash> found, bool complete,
                                 const std::string& who) {
  std::map<PartPair, double> depths;
  std::vector<Change> changes;
  const std::map<PartPair, const Entry*> verdicts = verdictsByPair(document);
  for (const Clash& clash : found) {
    const PartPair pair = pairOf(clash.a, clash.b);
    if (!isCertain(clash) || !depths.emplace(pair, clash.depth).second || verdicts.contains(pair)) continue;
    const std::string remark = clash.open ? "a shell is open: at least so deep" : "";
    changes.push_back({0, 0, ClashVerdict{pair.first, pair.second, ClashStatus::fresh, clash.depth, remark}});
  }
  for (const auto& [pair, entry] : verdicts) {
    ClashVerdict verdict = std::get<ClashVerdict>(entry->body);
    const auto depth = depths.find(pair);
    const ClashStatus status = after(verdict.status, depth != depths.end(), complete);
    const bool moved = status != ClashStatus::approved && depth != depths.end() &&
                       std::abs(depth->second - verdict.depth) > kSameDepth;
    if (status == verdict.status && !moved) continue;
    if (status != verdict.status) verdict.text = verdictText({who, verdictWords(verdict.text).remark});
    if (depth != depths.end()) verdict.depth = depth->second;
    verdict.status = status;
    changes.push_back({entry->id, entry->revision, std::move(verdict)});
  }
  return changes;
}

Change judge(const Entry& verdict, ClashStatus status, const VerdictWords& words) {
  ClashVerdict changed = std::get<ClashVerdict>(verdict.body);
  changed.status = status;
  changed.text = verdictText(words);
  return {verdict.id, verdict.revision, std::move(changed)};
}

MergeCounts countChanges(const Document& document, const std::vector<Change>& changes) {
  MergeCounts counts;
  for (const Change& change : changes) {
    const Entry* entry = document.find(change.id);
    if (entry == nullptr) {
      ++counts.added;
      continue;
    }
    const ClashStatus before = std::get<ClashVerdict>(entry->body).status;
    const ClashStatus now = std::get<ClashVerdict>(change.body).status;
    ++(before == now ? counts.deeper : now == ClashStatus::resolved ? counts.resolved : counts.reopened);
  }
  return counts;
}

}  // namespace tandem::client
