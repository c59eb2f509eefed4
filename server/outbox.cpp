#include "server/outbox.h"

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

void Outbox::abandon(std::uint64_t durable) {
  std::deque<Outgoing> kept;
  for (Outgoing& item : queue_) {
    if (item.after <= durable) {
      kept.push_back(std::move(item));
    } else if (auto other = withoutRecord(*item.message)) {
      kept.push_back({durable, item.to, std::make_shared<const sync::ControlMessage>(std::move(*other))});
    }
  }
  ASSERT(kept.size() <= queue_.size());
  queue_ = std::move(kept);
}

}  // namespace tandem::server
