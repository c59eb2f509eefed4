#include "server/doubts.h"

#include <algorithm>
#include <string>
#include <vector>

#include "assets/base/assert.h"
#include "sync/wire/wire.h"

namespace tandem::server {

using sync::Doubt;
using sync::Micros;

namespace {

constexpr Micros kLookPeriod = sync::kSecond;  // for what has ended

}  // namespace

bool Doubts::isListed(SiteId site) const {
  const std::vector<sync::SiteInfo>& listed = sites_.listed();
  return std::any_of(listed.begin(), listed.end(),
                     [site](const sync::SiteInfo& info) { return info.site == site; });
}

bool Doubts::isSound(const Peer& peer, const Doubt& message, const Doubter& doubter) const {
  return peer.role != sync::Role::observer && message.holds && message.about != peer.site &&
         isListed(message.about) &&
         (doubter.about.size() < kMostAtOnce || doubter.about.contains(message.about));
}

void Doubts::onDoubt(const Peer& peer, const Doubt& message) {
  ASSERT(peer.stage == Stage::ready);
  Doubter& doubter = doubters_[peer.site];
  if (!doubter.rate.spend(context_.now()) || !isSound(peer, message, doubter)) {
    ++context_.counts.droppedDoubts;
    return;
  }
  const bool begins = !doubter.about.contains(message.about);
  doubter.about[message.about] = context_.now();
  if (!begins) return;
  ++context_.counts.doubts;
  note(peer, message.about);
  tellAll({peer.site, message.about, true});
}

void Doubts::note(const Peer& peer, SiteId about) {
  const sync::SiteInfo& info = sites_.all().at(about).info;
  const Peer* accused = peers_.bySite(about);
  const std::string who = sites_.nameOf(peer.site);
  context_.log.note(who + " does not believe the motion of " + sites_.nameOf(about), about);
  context_.audit.note({AuditEvent::doubted, context_.unixNow(), about, info.name, sync::toString(info.role),
                       accused != nullptr ? accused->address : std::string(), "by " + who},
                      context_.now());
}

/// Ends what has not been said for kHolds, and what a site says that is not there any more, or of one.
void Doubts::endOld() {
  for (auto doubter = doubters_.begin(); doubter != doubters_.end();) {
    const bool there = isListed(doubter->first);
    auto& about = doubter->second.about;
    for (auto at = about.begin(); at != about.end();) {
      const bool listed = isListed(at->first);
      if (there && listed && context_.now() - at->second < kHolds) {
        ++at;
        continue;
      }
      if (there && listed) tellAll({doubter->first, at->first, false});  // who has left is forgotten by all
      at = about.erase(at);
    }
    // While it is listed, its rate goes on to count.
    doubter = there ? std::next(doubter) : doubters_.erase(doubter);
  }
}

void Doubts::flush() {
  for (auto& [connection, peer] : peers_) {
    if (!peer.doubtsOwed || peer.stage != Stage::ready) continue;
    peer.doubtsOwed = false;
    for (const auto& [site, doubter] : doubters_)
      for (const auto& [about, at] : doubter.about) send(peer, {site, about, true});
  }
  if (context_.now() < nextLook_) return;
  nextLook_ = context_.now() + kLookPeriod;
  endOld();
}

std::size_t Doubts::about(SiteId site) const {
  return static_cast<std::size_t>(
      std::count_if(doubters_.begin(), doubters_.end(),
                    [site](const auto& entry) { return entry.second.about.contains(site); }));
}

void Doubts::tellAll(const Doubt& doubt) {
  for (const auto& [connection, peer] : peers_)
    if (peer.stage == Stage::ready && !peer.doubtsOwed) send(peer, doubt);
}

void Doubts::send(const Peer& peer, const Doubt& doubt) {
  const std::vector<std::byte> bytes = sync::encodeControl(doubt);
  context_.counts.sent.countControl(bytes.size());
  transport_.sendControl(peer.connection, bytes);
}

}  // namespace tandem::server
