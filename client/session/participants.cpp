#include "client/session/participants.h"

#include <utility>

namespace tandem::client {

using namespace sync;

void Participants::reset(SiteId self, const std::vector<SiteInfo>& sites) {
  self_ = self;
  sites_.clear();
  for (const SiteInfo& info : sites) sites_.push_back({info, info.site == self, false, {}});
}

void Participants::handle(const SiteChanged& message) {
  if (SiteView* known = find(message.site.site)) {
    if (known->info.connected && !message.site.connected)
      notice(Notice::Level::info, message.site.name + " lost the connection");
    known->info = message.site;
    return;
  }
  if (message.site.site != self_) notice(Notice::Level::info, message.site.name + " joined");
  sites_.push_back({message.site, message.site.site == self_, false, {}, {}});
}

void Participants::handle(const SiteLeft& message) {
  notice(Notice::Level::info, nameOf(message.site) + " left");
  std::erase_if(sites_, [&](const SiteView& site) { return site.info.site == message.site; });
  for (SiteView& site : sites_) std::erase(site.doubtedBy, message.site);
}

void Participants::handle(const Doubt& message) {
  SiteView* about = find(message.about);
  if (about == nullptr || find(message.site) == nullptr) return;
  const bool first = about->doubtedBy.empty();
  std::erase(about->doubtedBy, message.site);
  if (!message.holds) return;
  about->doubtedBy.push_back(message.site);
  const std::string who = message.site == self_ ? " say you" : " says " + nameOf(message.site);
  if (first)
    notice(Notice::Level::warning, about->info.name + " does not move or push as a hand does," + who);
}

void Participants::connectionLost() {
  for (SiteView& site : sites_) site.info.connected = site.self;
}

void Participants::show(SiteId id, const Presence& presence) {
  SiteView* site = find(id);
  if (site == nullptr) return;
  site->presence = presence;
  site->seen = true;
}

SiteView* Participants::find(SiteId site) {
  for (SiteView& view : sites_)
    if (view.info.site == site) return &view;
  return nullptr;
}

std::string Participants::nameOf(SiteId site) const {
  for (const SiteView& view : sites_)
    if (view.info.site == site) return view.info.name;
  return "somebody";
}

void Participants::notice(Notice::Level level, std::string text) {
  notices_.push_back({level, 0.0, std::move(text)});
}

std::vector<Notice> Participants::drainNotices() { return std::exchange(notices_, {}); }

}  // namespace tandem::client
