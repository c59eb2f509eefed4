#pragma once

// What people decided about clashes, as entries of the session's document, and how a new search changes
// that. A clash is known by its pair of parts.
//
// 1. A search adds what it found as new, keeps what is approved whatever it found, resolves what is gone, and
//    makes what has come back active. A search that was stopped resolves nothing.
// 2. Only what is a clash beyond doubt is added: parts that may collide and stand deeper in each other than
//    their facets may be off the surfaces that they stand for.
// 3. The same search again changes nothing.
// 4. A verdict's text begins with who gave its status, "[Ada] as drawn": an entry tells who made it and when
//    it was changed, but not the name of who did that.

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "assets/document/document.h"
#include "client/review/clash_check.h"

namespace tandem::client {

using PartPair = std::pair<PartId, PartId>;  // the smaller first
PartPair pairOf(PartId a, PartId b);

bool isCertain(const Clash& clash);

/// A verdict's text in its two halves.
struct VerdictWords {
  std::string who, remark;
};
VerdictWords verdictWords(const std::string& text);
std::string verdictText(const VerdictWords& words);

/// The verdicts by pair; of several of one pair the one that was changed last. Points into the document.
std::map<PartPair, const document::Entry*> verdictsByPair(const document::Document& document);

/// The changes by which the document's verdicts follow from a search, by `who`. `complete`: it was not
/// stopped. New ones in the order of the search, then the changed ones by pair.
std::vector<document::Change> mergeClashes(const document::Document& document, std::span<const Clash> found,
                                           bool complete, const std::string& who);

/// The change that gives a pair's verdict another status and remark.
document::Change judge(const document::Entry& verdict, document::ClashStatus status,
                       const VerdictWords& words);

/// What a merge does, in numbers.
struct MergeCounts {
  std::size_t added = 0, resolved = 0, reopened = 0, deeper = 0;  // deeper: or less deep than it was
};
MergeCounts countChanges(const document::Document& document, const std::vector<document::Change>& changes);

}  // namespace tandem::client
