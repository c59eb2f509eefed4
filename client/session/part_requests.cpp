#include "client/session/part_requests.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr int kMaxRepeats = 4;  // of a request for a part that keeps changing owners

}  // namespace

void PartRequests::sceneReady(PartOwnership& ownership, Exchange& exchange, HandEvents& events) {
  ASSERT(ownership_ == nullptr);
  ownership_ = &ownership;
  exchange_ = &exchange;
  events_ = &events;
  givenBack_.assign(ownership.scene().parts.size(), 0);
}

// ---- requests that wait for their answers ----

/// The number of a request that is about to be sent.
RequestId PartRequests::open(PartId part, OpenRequest::Kind kind, int before) {
  ASSERT(before <= kMaxRepeats);
  open_.push_back({ownership_->view().lapses(), nextRequest_, part, kind, before});
  return nextRequest_++;
}

/// The open request that a reply answers, which is removed; nothing if there is none.
std::optional<PartRequests::OpenRequest> PartRequests::close(RequestId request, PartId part) {
  const auto found =
      std::find_if(open_.begin(), open_.end(), [&](const auto& entry) { return entry.request == request; });
  if (found == open_.end() || !ownership_->exists(part) || found->part != part) return std::nullopt;
  const OpenRequest closed = *found;
  open_.erase(found);
  return closed;
}

bool PartRequests::isReclaiming(PartId part) const {
  return std::any_of(open_.begin(), open_.end(), [&](const OpenRequest& entry) {
    return entry.kind == OpenRequest::Kind::reclaim && entry.part == part;
  });
}

// ---- requests ----

/// Whether this site may become a co-holder of the part.
bool PartRequests::mayEngage(PartId part) const {
  const SiteId owner = ownership_->view().part(part).owner;
  return owner != kNoSite && owner != people_.self() &&
         assets::controlOf(ownership_->scene(), part) == nullptr;
}

/// Grabs a part, or engages in it where another site owns it.
void PartRequests::askFor(PartId part, int before) {
  ASSERT(ownership_->exists(part));
  // The part may have passed to this site meanwhile. A part that was released is requested anew, though, even
  // before the release is answered.
  if (ownership_->view().owns(part) && givenBack_[part] != ownership_->view().part(part).epoch) return;
  const bool engages = mayEngage(part);
  const RequestId request = open(part, engages ? OpenRequest::Kind::engage : OpenRequest::Kind::grab, before);
  if (engages) return sender_.send(Engage{request, part});
  const Grab grab{request, part};
  if (watchers_.observer) watchers_.observer->onGrab(grab);
  sender_.send(grab);
}

void PartRequests::release(const HandIntent& intent) {
  ASSERT(ownership_->exists(intent.part));
  const Release release{nextRequest_++, intent.part, intent.epoch, intent.worldFromPart};
  givenBack_[intent.part] = intent.epoch;
  send(release);
}

void PartRequests::send(const Release& release) {
  unanswered_.push_back(release);
  if (watchers_.observer) watchers_.observer->onRelease(release);
  if (watchers_.undo) watchers_.undo->onRelease(release);
  sender_.send(release);
}

void PartRequests::releaseAgain(Micros now) {
  if (refused_.empty() || now < releaseAgainAt_) return;
  releaseAgainAt_ = now + kReleaseAgain;
  for (Release release : std::exchange(refused_, {})) {
    const PartRecord& record = ownership_->view().part(release.part);
    if (record.owner != people_.self() || record.epoch != release.epoch) continue;  // it is over
    release.request = nextRequest_++;
    send(release);
  }
}

void PartRequests::sendIntents() {
  HandIntent intent;
  while (exchange_->intents.pop(intent)) {
    ASSERT(intent.lost <= lost_);
    if (intent.lost != lost_) continue;  // the hand has been notified that this request gets no answer
    switch (intent.kind) {
      case HandIntent::Kind::grab:
        askFor(intent.part, 0);
        break;
      case HandIntent::Kind::release:
        release(intent);
        break;
      case HandIntent::Kind::leave:
        sender_.send(Disengage{open(intent.part, OpenRequest::Kind::leave), intent.part});
        break;
    }
  }
}

void PartRequests::reclaim(bool all) {
  hand_ = exchange_->output.latest();
  ASSERT(hand_.tick.ownedCount >= 0 && hand_.tick.ownedCount <= haptics::kMaxOwnedParts);
  for (int i = 0; i < hand_.tick.ownedCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const haptics::OwnedPart& part = hand_.tick.owned[index];
    const Epoch epoch = hand_.ownedEpoch[index];
    if (epoch == 0 || !(all || ownership_->view().needsReclaim(part.part))) continue;
    if (isReclaiming(part.part)) continue;
    sender_.send(Reclaim{open(part.part, OpenRequest::Kind::reclaim), part.part, epoch, part.worldFromPart});
  }
}

void PartRequests::engageAgain() {
  for (int i = 0; i < hand_.tick.ownedCount; ++i) {
    const auto index = static_cast<std::size_t>(i);
    if (hand_.ownedEpoch[index] == 0) askFor(hand_.tick.owned[index].part, 0);
  }
}

void PartRequests::connectionLost() {
  open_.clear();
  unanswered_.clear();
  refused_.clear();
  ++lost_;
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::lost;
  events_->push(event);
}

void PartRequests::revoke(PartId part) { sender_.send(Revoke{nextRequest_++, part}); }

void PartRequests::resetParts() { sender_.send(ResetParts{nextRequest_++}); }

// ---- answers ----

bool PartRequests::handle(const GrabReply& message) {
  const PartRecord& record = message.part;
  const std::optional<OpenRequest> asked = close(message.request, record.part);
  if (!asked) return false;
  const bool reclaim = asked->kind == OpenRequest::Kind::reclaim;
  if (watchers_.observer) watchers_.observer->onGrabReply(message);
  ownership_->apply(record);
  if (message.denial == Denial::none) {
    if (asked->lapses == ownership_->view().lapses()) ownership_->view().confirmed(record.part, record.epoch);
  } else if (message.denial == Denial::ownedByOther && !reclaim && asked->before < kMaxRepeats &&
             mayEngage(record.part)) {
    askFor(record.part, asked->before + 1);
  } else {
    reportDenial(message, reclaim);
  }
  return true;
}

bool PartRequests::handle(const EngageReply& message) {
  const PartId part = message.coHolders.part;
  const std::optional<OpenRequest> asked = close(message.request, part);
  if (!asked) return false;
  ownership_->apply(message.coHolders);
  if (asked->kind == OpenRequest::Kind::leave) return true;
  sync::OwnershipView& view = ownership_->view();
  if (message.denial == Denial::none) {
    if (asked->lapses == view.lapses()) view.coHoldingConfirmed(part);
    if (watchers_.observer) watchers_.observer->onEngaged(message);
    people_.notice(Notice::Level::info,
                   partName(part) + " is shared with " + people_.nameOf(view.part(part).owner));
  } else if (message.denial == Denial::notOwned && asked->before < kMaxRepeats) {
    askFor(part, asked->before + 1);
  } else {
    reportDenied(view.part(part), toString(message.denial));
  }
  return true;
}

void PartRequests::handle(const ReleaseReply& message) {
  if (ownership_ == nullptr || !ownership_->exists(message.part.part)) return;
  const auto asked = std::find_if(unanswered_.begin(), unanswered_.end(),
                                  [&](const Release& each) { return each.request == message.request; });
  if (asked != unanswered_.end()) {
    if (message.denial == Denial::recovering) refused_.push_back(*asked);
    unanswered_.erase(asked);
  }
  ownership_->apply(message.part);
}

void PartRequests::handle(const CommandReply& message) {
  if (!message.done) people_.notice(Notice::Level::warning, "not done: " + message.reason);
}

void PartRequests::reportDenial(const GrabReply& reply, bool reclaim) {
  const SiteId owner = reply.part.owner;
  if (!reclaim)
    reportDenied(reply.part, reply.denial == Denial::ownedByOther ? people_.nameOf(owner) + " holds it"
                                                                  : toString(reply.denial));
  else if (owner != kNoSite && owner != people_.self())
    people_.notice(Notice::Level::warning,
                   partName(reply.part.part) + " now belongs to " + people_.nameOf(owner));
}

void PartRequests::reportDenied(const PartRecord& record, const std::string& why) {
  people_.notice(Notice::Level::warning, partName(record.part) + " cannot be taken: " + why);
  NetworkEvent event;
  event.kind = NetworkEvent::Kind::denied;
  event.record = record;
  events_->push(event);
}

std::string PartRequests::partName(PartId part) const { return ownership_->scene().parts[part].name; }

}  // namespace tandem::client
