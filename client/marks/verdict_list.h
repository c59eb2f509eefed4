#pragma once

// Clashes with their status, apart from how they are drawn: what a search found and what the session's
// document keeps, as one list by status.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/findings/verdicts.h"
#include "client/marks/clash_list.h"

namespace tandem::client {

/// A pair of parts in the list.
struct ClashLine {
  ClashRow row;                            // its `found` is null where the last search did not find the pair
  PartId a = kNoPart, b = kNoPart;         // the smaller first, as in the findings
  std::optional<document::Entry> verdict;  // none: it is not kept
};
/// The lines of one status, in the order of the findings, then by pair.
struct ClashGroup {
  std::string title;  // "new", "approved"; "not kept"
  glm::vec3 colour{0.0f};
  std::vector<ClashLine> lines;
};

/// New and active ones first, then what is not kept, then what is settled; groups without lines are left out.
/// Either may be null. Points into the findings.
std::vector<ClashGroup> clashGroups(const ClashFindings* findings, const document::Document* document,
                                    const assets::Scene& scene, bool touches);

/// The same lines by part: the part with the most pairs first, each pair under one of its parts; pairs of
/// parts that have no other come last, under no title.
std::vector<ClashGroup> byPart(const std::vector<ClashGroup>& groups);

/// The changes that keep what the findings have; none without findings.
std::vector<document::Change> changesToKeep(const ViewModel& model);
/// The list as the panel shows it, made anew only when search or document have changed: with 10,000 clashes
/// that takes longer than a frame.
class ClashListing {
 public:
  void update(const ViewModel& model, const ClashUi& ui);
  const std::vector<ClashGroup>& groups() const { return groups_; }
  const std::vector<document::Change>& changes() const { return changes_; }  // to keep

 private:
  struct Made {
    std::shared_ptr<const ClashFindings> findings;
    bool document = false, touches = false, byPart = false;
    document::Revision revision = 0;
    std::size_t entries = 0;
    bool operator==(const Made&) const = default;
  };
  std::optional<Made> made_;
  std::vector<ClashGroup> groups_;
  std::vector<document::Change> changes_;
};

/// "approved by Ada, 5 min ago"; `now` in Unix time, s.
std::string judgedBy(const document::Entry& verdict, std::int64_t now);
/// sRGB of a status.
glm::vec3 statusColour(document::ClashStatus status);

/// A camera that keeps both parts in view: the smaller one whole, the larger one as far as that goes. With a
/// witness it looks there, across the line.
Camera cameraForPair(const Camera& from, const std::optional<ClashWitness>& witness, const assets::Bounds& a,
                     const assets::Bounds& b, double aspect);

}  // namespace tandem::client
