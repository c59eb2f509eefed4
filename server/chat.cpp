#include "server/chat.h"

#include <algorithm>
#include <vector>

#include "assets/base/assert.h"
#include "sync/wire/limits.h"
#include "sync/wire/wire.h"

namespace tandem::server {

using sync::Said;
using sync::SaidLine;

void Chat::restore(const JournalContents& contents) {
  ASSERT(lines_.empty());
  for (const auto& [slot, line] : contents.said) lines_.push_back(line);
  std::sort(lines_.begin(), lines_.end(),
            [](const SaidLine& a, const SaidLine& b) { return a.number < b.number; });
}

bool Chat::isSound(const sync::Say& said) const {
  return !said.text.empty() && std::all_of(said.parts.begin(), said.parts.end(),
                                           [&](PartId part) { return part == kNoPart || part < partCount_; });
}

void Chat::onSay(const Peer& peer, const sync::Say& said) {
  ASSERT(peer.stage == Stage::ready);
  MessageRate& rate = rates_.try_emplace(peer.site, kRate, kBurst).first->second;
  if (!rate.spend(context_.now()) || peer.role == sync::Role::observer || !isSound(said)) {
    ++context_.counts.droppedSays;
    return;
  }
  SaidLine line;
  line.number = lines_.empty() ? 1 : lines_.back().number + 1;
  line.at = std::clamp<std::int64_t>(context_.unixNow(), 0, sync::kMaxUnixTime);
  line.site = peer.site;
  line.name = sites_.all().at(peer.site).info.name;
  line.said = said;
  keep(line);
  const std::vector<std::byte> bytes = sync::encodeControl(Said{false, {line}});
  for (const auto& [connection, other] : peers_)
    if (other.stage == Stage::ready && !other.saidOwed) publisher_.sendNow(connection, bytes);
}

void Chat::keep(const SaidLine& line) {
  lines_.push_back(line);
  if (lines_.size() > sync::kMaxSaidLines) lines_.pop_front();
  if (publisher_.writable()) publisher_.keep(SaidRecord{line});
}

void Chat::flush() {
  for (auto& [connection, peer] : peers_) {
    if (!peer.saidOwed || peer.stage != Stage::ready) continue;
    if (transport_.controlBacklog(connection) >= kMaxBacklog) continue;
    peer.saidOwed = false;
    if (!lines_.empty()) publisher_.sendNow(connection, Said{true, {lines_.begin(), lines_.end()}});
  }
}

}  // namespace tandem::server
