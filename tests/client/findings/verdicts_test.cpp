// Verdicts on clashes through many searches, against a plain model: a table of statuses.

#include "client/findings/verdicts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace tandem::client {
namespace {

using namespace document;

Clash hard(PartId a, PartId b, double depth = 0.001) {
  Clash clash;
  clash.a = a;
  clash.b = b;
  clash.kind = ClashKind::hard;
  clash.depth = depth;
  return clash;
}

struct Verdicts : testing::Test {
  Document document;

  std::size_t merge(const std::vector<Clash>& found, bool complete = true, const std::string& who = "Ada") {
    const std::vector<Change> changes = mergeClashes(document, found, complete, who);
    for (const Change& change : changes) apply(change);
    return changes.size();
  }
  void apply(const Change& change) {
    const Document::Outcome made = document.apply(change, {1, "ada", 1, 0});
    ASSERT_EQ(made.refusal, Refusal::none) << made.reason;
  }
  const ClashVerdict* of(PartId a, PartId b) const {
    const auto verdicts = verdictsByPair(document);
    const auto at = verdicts.find(pairOf(a, b));
    return at == verdicts.end() ? nullptr : &std::get<ClashVerdict>(at->second->body);
  }
  void judged(PartId a, PartId b, ClashStatus status, const VerdictWords& words = {"Ben", "seen"}) {
    apply(judge(*verdictsByPair(document).at(pairOf(a, b)), status, words));
  }
};

TEST_F(Verdicts, ARerunKeepsApprovedResolvesWhatIsGoneAndReopensWhatReturns) {
  EXPECT_EQ(merge({hard(2, 1), hard(3, 4, 0.002)}), 2u);
  EXPECT_EQ(of(1, 2)->status, ClashStatus::fresh);
  EXPECT_EQ(of(1, 2)->text, "") << "the entry has its author";
  EXPECT_EQ(merge({hard(3, 4, 0.002), hard(1, 2)}), 0u) << "the same again";
  judged(1, 2, ClashStatus::approved, {"Ben", "press fit"});
  judged(3, 4, ClashStatus::reviewed);
  EXPECT_EQ(merge({}, true, "Cy"), 1u);
  EXPECT_EQ(of(1, 2)->status, ClashStatus::approved);
  EXPECT_EQ(of(1, 2)->text, "[Ben] press fit");
  EXPECT_EQ(of(3, 4)->status, ClashStatus::resolved);
  EXPECT_EQ(of(3, 4)->text, "[Cy] seen") << "who, and what was remarked before";
  EXPECT_EQ(merge({hard(3, 4, 0.005)}), 1u);
  EXPECT_EQ(of(3, 4)->status, ClashStatus::active);
  EXPECT_EQ(of(3, 4)->depth, 0.005);
}

TEST_F(Verdicts, AStoppedSearchResolvesNothing) {
  merge({hard(1, 2), hard(3, 4)});
  EXPECT_EQ(merge({hard(1, 2), hard(5, 6)}, false), 1u);
  EXPECT_EQ(of(3, 4)->status, ClashStatus::fresh);
  EXPECT_NE(of(5, 6), nullptr);
}

TEST_F(Verdicts, OnlyWhatIsAClashBeyondDoubtIsKept) {
  Clash facets = hard(1, 2), filtered = hard(3, 4), touch = hard(5, 6), near = hard(7, 8), open = hard(9, 10);
  facets.facetSag = facets.depth;
  filtered.mayCollide = false;
  touch.kind = ClashKind::touch;
  near.kind = ClashKind::clearance;
  open.open = true;
  EXPECT_EQ(merge({facets, filtered, touch, near, open}), 1u);
  EXPECT_EQ(of(9, 10)->text, "a shell is open: at least so deep");
}

TEST_F(Verdicts, OfTwoVerdictsOfAPairTheOneChangedLastCounts) {
  merge({hard(1, 2)});
  apply({0, 0, ClashVerdict{2, 1, ClashStatus::reviewed, 0.001, "[Ben]"}});  // made by another at once
  EXPECT_EQ(of(1, 2)->status, ClashStatus::reviewed);
  judged(1, 2, ClashStatus::approved);
  EXPECT_EQ(merge({}), 0u);
}

TEST_F(Verdicts, ItsTextHasWhoAndTheRemark) {
  for (const VerdictWords& words :
       {VerdictWords{"Ada", "as drawn"}, {"Ada", ""}, {"", "as drawn"}, {"", ""}}) {
    const VerdictWords read = verdictWords(verdictText(words));
    EXPECT_EQ(read.who, words.who);
    EXPECT_EQ(read.remark, words.remark);
  }
  EXPECT_EQ(verdictWords(verdictText({"A]b", "x"})).remark, "x");
  EXPECT_EQ(verdictWords("[unfinished").remark, "[unfinished");
  EXPECT_EQ(verdictText({"Ada", std::string(kMaxText, 'x')}).size(), kMaxText);
}

/// The rules as a table: the status after a search that found the pair, missed it, or was stopped without it.
ClashStatus modelled(ClashStatus before, int what) {
  using S = ClashStatus;
  static constexpr S kAfter[5][3] = {{S::fresh, S::resolved, S::fresh},
                                     {S::active, S::resolved, S::active},
                                     {S::reviewed, S::resolved, S::reviewed},
                                     {S::approved, S::approved, S::approved},
                                     {S::active, S::resolved, S::resolved}};
  return kAfter[static_cast<std::size_t>(before)][what];
}

TEST_F(Verdicts, FollowTheModelThroughRandomSearchesAndJudgements) {
  std::mt19937 random(181818);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  std::map<PartPair, ClashStatus> model;
  for (int round = 0; round < 2000; ++round) {
    if (below(2) == 0 && !model.empty()) {
      auto at = model.begin();
      std::advance(at, below(static_cast<std::uint32_t>(model.size())));
      at->second = static_cast<ClashStatus>(below(5));
      judged(at->first.first, at->first.second, at->second);
    } else {
      std::set<PartPair> pairs;
      std::vector<Clash> found;
      for (std::uint32_t n = below(12); n > 0; --n) {
        const PartId a = below(5), b = 5 + below(4);
        pairs.insert({a, b});
        found.push_back(below(2) == 0 ? hard(a, b) : hard(b, a));
      }
      const bool complete = below(3) != 0;
      merge(found, complete);
      for (auto& [pair, status] : model)
        status = modelled(status, pairs.contains(pair) ? 0 : complete ? 1 : 2);
      for (const PartPair& pair : pairs) model.emplace(pair, ClashStatus::fresh);
      ASSERT_TRUE(mergeClashes(document, found, complete, "Ben").empty()) << "round " << round;
    }
    ASSERT_EQ(document.size(), model.size()) << "one entry a pair, round " << round;
    for (const auto& [pair, status] : model)
      ASSERT_EQ(of(pair.first, pair.second)->status, status) << "round " << round;
  }
}

}  // namespace
}  // namespace tandem::client
