#include "client/session/presentations.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"
#include "client/session/said_parts.h"
#include "sync/wire/limits.h"

namespace tandem::client {

using namespace sync;

namespace {

bool same(const document::SectionPlane& a, const document::SectionPlane& b) {
  return a.point == b.point && a.normal == b.normal;
}

bool same(const Presentation& a, const Presentation& b) {
  return a.shares == b.shares && a.selected == b.selected && a.pointedAt == b.pointedAt &&
         a.place == b.place && a.hidden == b.hidden && a.transparent == b.transparent && a.style == b.style &&
         a.inspection == b.inspection &&
         std::equal(a.sections.begin(), a.sections.end(), b.sections.begin(), b.sections.end(),
                    [](const auto& x, const auto& y) { return same(x, y); });
}

const char* sharingWords(Shares shares) { return shares == Shares::view ? " presents" : " shares sections"; }

}  // namespace

void Presentations::handle(const Presentation& message) {
  if (message.site == people_.self()) {
    // Only a sharing that the server has ended comes back.
    if (message.shares != Shares::nothing || own_.shares == Shares::nothing) return;
    ++ended_;
    stopping_ = true;
    show(own_);
    return;
  }
  if (!known(message.site)) return;  // it has left
  Presentation& known = others_[message.site];
  const Presentation before = known;
  known = message;
  if (message.shares != Shares::nothing && before.shares != message.shares) {
    // What goes on after an outage is nothing new: who did not follow it does not follow it now.
    const bool goesOn = message.site == interrupted_.site && message.shares == interrupted_.shares;
    interrupted_ = {};
    sharer_ = message.site;
    if (goesOn) return;
    ++begun_;
  } else if (message.shares == Shares::nothing && sharer_ == message.site) {
    sharer_ = kNoSite;
  }
  tellOfChange(before, message);
}

void Presentations::tellOfChange(const Presentation& before, const Presentation& now) {
  if (before.shares == now.shares) return;
  const std::string name = people_.nameOf(now.site);
  if (now.shares != Shares::nothing)
    people_.notice(Notice::Level::info, name + sharingWords(now.shares));
  else
    people_.notice(
        Notice::Level::info,
        name + " has stopped " + (before.shares == Shares::view ? "presenting" : "sharing sections"));
}

bool Presentations::handle(const Said& message) {
  std::uint64_t before = 0;
  for (const SaidLine& line : message.lines) {
    if (line.number <= before || line.said.text.empty() || line.site == kNoSite) return false;
    before = line.number;
  }
  if (before == 0) return false;
  std::vector<ChatLine> news;
  for (const SaidLine& line : message.lines) {
    if (message.earlier && line.number <= newest_) continue;
    news.push_back({++lines_, message.earlier, line});
    if (!message.earlier && line.site != people_.self())
      people_.notice(Notice::Level::info, line.name + " says: " + inWords(line.said));
  }
  newest_ = message.earlier ? std::max(newest_, before) : before;
  addChat(chat_, std::move(news));
  return true;
}

std::vector<ChatLine> Presentations::drainChat() { return std::exchange(chat_, {}); }

bool Presentations::known(SiteId site) const {
  return std::any_of(people_.sites().begin(), people_.sites().end(),
                     [&](const SiteView& view) { return view.info.site == site; });
}

void Presentations::show(const Presentation& shown) {
  own_ = shown;
  stopping_ = stopping_ && shown.shares != Shares::nothing;
  if (stopping_) own_.endSharing();
}

void Presentations::forget(SiteId site) {
  others_.erase(site);
  if (sharer_ == site) sharer_ = kNoSite;
}

void Presentations::enter() {
  sent_.reset();
  nextAt_ = nextSayAt_ = 0;
}

/// Without a server nobody is known to show anything.
void Presentations::connectionLost() {
  if (sharer_ != kNoSite) interrupted_ = others_.at(sharer_);
  others_.clear();
  sharer_ = kNoSite;
}

void Presentations::say(const Say& said) {
  ASSERT(said.parts.size() <= kMaxSaidParts);
  if (unsaid_.size() < kMaxUnsaid)
    unsaid_.push_back(said);
  else
    people_.notice(Notice::Level::warning, "not said, too much at once: " + said.text);
}

bool Presentations::differs() const { return sent_ ? !same(*sent_, own_) : !same(Presentation{}, own_); }

void Presentations::step(Micros now) {
  if (now >= nextAt_ && differs()) {
    sender_.send(own_);
    sent_ = own_;
    nextAt_ = now + kPeriod * static_cast<Micros>(1 + people_.sites().size() / 32);
  }
  if (unsaid_.empty() || now < nextSayAt_) return;
  sender_.send(unsaid_.front());
  unsaid_.pop_front();
  nextSayAt_ = now + kSayPeriod;
}

PresentingView Presentations::view(std::size_t partCount) const {
  const auto fitted = [partCount](Presentation shown) {
    if (shown.selected >= partCount) shown.selected = kNoPart;
    if (shown.pointedAt >= partCount) shown.pointedAt = kNoPart;
    std::erase_if(shown.style.apart, [&](PartId part) { return part >= partCount; });
    Inspection& looks = shown.inspection;
    if (looks.a >= partCount || looks.b >= partCount || looks.a == looks.b) looks.a = looks.b = kNoPart;
    std::erase_if(looks.marks, [&](const auto& mark) { return mark.part >= partCount; });
    return shown;
  };
  PresentingView view;
  view.begun = begun_;
  view.ended = ended_;
  if (sharer_ != kNoSite) view.shared = fitted(others_.at(sharer_));
  for (const auto& [site, shown] : others_)
    if (shown.pointedAt < partCount) view.points.push_back(shown);
  return view;
}

}  // namespace tandem::client
