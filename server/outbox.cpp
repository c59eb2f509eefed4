#include "server/outbox.h"

#include <algorithm>
#include <optional>
#include <string>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

/// The part's record as a site may know it: without the owner and the epoch that were not kept.
sync::PartRecord withoutOwner(const sync::PartRecord& record) {
  return {record.part, kNoSite, 0, record.worldFromPart};
}

/// The answer in place of a reply whose record could not be kept; nothing for a change that never took
/// effect.
std::optional<sync::ControlMessage> withoutRecord(const sync::ControlMessage& message) {
  if (const auto* grab = std::get_if<sync::GrabReply>(&message)) {
    sync::GrabReply denied = *grab;
    denied.part = withoutOwner(grab->part);
    denied.denial = sync::Denial::recovering;
    return denied;
  }
  if (const auto* release = std::get_if<sync::ReleaseReply>(&message)) {
    sync::ReleaseReply denied = *release;
    denied.part = withoutOwner(release->part);
    denied.denial = sync::Denial::recovering;
    return denied;
  }
  if (const auto* command = std::get_if<sync::CommandReply>(&message))
    return sync::CommandReply{command->request, false, "the server cannot write its journal"};
  if (std::holds_alternative<sync::Welcome>(message))
    return sync::Refused{sync::Refusal::sessionFull, "the server cannot write its journal and admits nobody"};
  return std::nullopt;
}

}  // namespace

Abandoned Outbox::abandon(std::uint64_t durable) {
  Abandoned abandoned;
  std::vector<sync::PartRecord> replies, changes;
  std::deque<Outgoing> kept;
  for (Outgoing& item : queue_) {
    if (item.after <= durable) {
      kept.push_back(std::move(item));
      continue;
    }
    const auto* grab = std::get_if<sync::GrabReply>(item.message.get());
    if (grab != nullptr && grab->denial == sync::Denial::none) replies.push_back(grab->part);
    if (const auto* change = std::get_if<sync::OwnershipChanged>(item.message.get())) {
      changes.push_back(change->part);
      abandoned.parts.insert(change->part.part);
    } else if (auto other = withoutRecord(*item.message)) {
      kept.push_back({durable, item.to, std::make_shared<const sync::ControlMessage>(std::move(*other))});
    } else {
      abandoned.news.push_back(std::move(item));
    }
  }
  // A reply without a change, as to a reclaim, speaks of a grant that was told before: that one stands.
  for (const sync::PartRecord& reply : replies) {
    const auto same = [&](const sync::PartRecord& change) {
      return change.part == reply.part && change.epoch == reply.epoch && change.owner == reply.owner;
    };
    if (std::any_of(changes.begin(), changes.end(), same)) abandoned.denied.push_back(reply);
  }
  ASSERT(kept.size() <= queue_.size());
  queue_ = std::move(kept);
  return abandoned;
}

}  // namespace tandem::server
