#include "client/marks/shared_view.h"

#include <algorithm>
#include <utility>

#include "client/picture/colours.h"
#include "client/session/holding_words.h"

namespace tandem::client {

using sync::Presentation;
using sync::Shares;

void SharedView::follow(const ViewModel& model, Window window) {
  const PresentingView& presenting = model.presenting;
  if (std::exchange(ended_, presenting.ended) != presenting.ended) shares = Shares::nothing;
  // The person has moved the camera, or pressed Esc.
  if (leader_ != kNoSite && window.camera != leader_) following_.follow(false);
  following_.update(presenting, shares);
  const SiteId leader = following_.followsView() ? presenting.shared.site : kNoSite;
  if (leader != leader_) window.camera = leader;
  if (leader != leader_) selected_ = kNoPart;
  leader_ = leader;
  if (following_.followsSections())
    takeOver(presenting, window);
  else if (own_)
    giveBack(window);
}

void SharedView::stop(Window window) {
  following_.follow(false);
  leader_ = kNoSite;
  if (own_) giveBack(window);
}

void SharedView::takeOver(const PresentingView& presenting, Window window) {
  if (!own_) own_ = Kept{window.sections, {}, {}};
  window.sections = SectionSet(presenting.shared.sections);
  if (!following_.followsView()) {
    if (own_->parts) window.parts = *std::exchange(own_->parts, {});
    takeOverMeasure({}, window.measures);
    return;
  }
  takeOverMeasure(presenting.shared.inspection, window.measures);
  if (!own_->parts) own_->parts = window.parts;
  const PartId selected = window.parts.selected;
  window.parts.showAll();
  window.parts.style = presenting.shared.style;
  for (std::size_t p = 0; p < window.parts.partCount(); ++p) {
    const auto part = static_cast<PartId>(p);
    if (presenting.hides(part)) window.parts.setHidden(part, true);
    if (presenting.seesThrough(part)) window.parts.setTransparent(part, true);
  }
  const PartId theirs = presenting.shared.selected;
  window.parts.selected = std::exchange(selected_, theirs) != theirs ? theirs : selected;
}

/// A measure that the leader has open stands in for the person's own, which comes back when it is closed.
void SharedView::takeOverMeasure(const sync::Inspection& looks, MeasureUi& measures) {
  if (!looks.measuring) {
    if (own_->measures) measures = *std::exchange(own_->measures, {});
    return;
  }
  if (!own_->measures) own_->measures = measures;
  measures.open = true;
  measures.chosen = 0;
  measures.marks = looks.marks;
}

/// Whoever begins to share goes on with what is seen; else the person's own state returns.
void SharedView::giveBack(Window window) {
  const Kept own = *std::exchange(own_, {});
  if (shares != Shares::nothing) return;
  window.sections = own.sections;
  if (own.parts) window.parts = *own.parts;
  if (own.measures) window.measures = *own.measures;
}

Presentation SharedView::shown(const ViewModel& model, const Seen& seen, PartId part,
                               const glm::dvec3& under) const {
  Presentation shown;
  if (model.role == sync::Role::observer || model.replay) return shown;
  shown.shares = shares;
  const PartDisplay& parts = seen.parts;
  const auto hides = [&](PartId each) { return !parts.visible(each); };
  const auto seesThrough = [&](PartId each) { return parts.transparent(each); };
  sync::Inspection looks = scriptClash_.a != kNoPart ? scriptClash_ : seen.clash;
  looks.measuring = seen.measures.open;
  looks.marks = seen.measures.marks;
  shareView(shown, seen.sections.planes(),
            SeenParts<decltype(hides), decltype(seesThrough)>{parts.partCount(), parts.selected, parts.style,
                                                              looks, hides, seesThrough});
  if (scriptPoint_) {
    shown.pointedAt = scriptPoint_->part;
    shown.place = scriptPoint_->point;
    return shown;
  }
  if (part == kNoPart || !(pointing || shares == Shares::view)) return shown;
  shown.pointedAt = part;
  shown.place = transformPoint(inverse(model.worldFromPart[part]), under);
  return shown;
}

std::string sharingInWords(const ViewModel& model, const SharedView& shared) {
  if (shared.shares == Shares::view) return "You present";
  if (shared.shares == Shares::sections) return "You share your sections";
  const Presentation& theirs = model.presenting.shared;
  const SiteView* site = findSite(model, theirs.site);
  if (theirs.shares == Shares::nothing || site == nullptr) return {};
  return site->info.name + (theirs.shares == Shares::view ? " presents" : " shares sections") +
         (shared.following().followsSections() ? ": you follow" : ": you do not follow");
}

void addPoints(const ViewModel& model, GlyphBatch& batch, std::vector<Label>& labels) {
  constexpr double kRadius = 5.0, kRing = 9.0;  // pixels
  for (const Presentation& shown : model.presenting.points) {
    const SiteView* site = findSite(model, shown.site);
    if (site == nullptr || shown.pointedAt >= model.worldFromPart.size()) continue;
    const glm::dvec3 place = transformPoint(model.worldFromPart[shown.pointedAt], shown.place);
    const View& view = batch.view();
    const double pixel = view.metresPerPixel(std::max(view.depthOf(place), view.near));
    const glm::vec3 colour = srgb(site->info.colour);
    const GlyphColour solid(linear(colour), 1.0f);
    const glm::dvec3 towardsEye = view.worldFromEye.orientation * glm::dvec3(0.0, 0.0, 1.0);
    batch.sphere(place, kRadius * pixel, solid);
    batch.ring(place, towardsEye, kRing * pixel, (kRing + 2.0) * pixel, solid);
    labels.push_back({place, {14.0, -10.0}, colour, site->info.name + " points here"});
  }
}

}  // namespace tandem::client
