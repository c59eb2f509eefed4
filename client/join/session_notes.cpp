#include "client/join/session_notes.h"

#include <utility>

#include "assets/base/assert.h"
#include "client/join/local_time.h"

namespace tandem::client {

using namespace sync;

SessionNotes::SessionNotes() : start_(localTime()) {}

double SessionNotes::elapsed() const { return toSeconds(localTime() - start_); }

void SessionNotes::onOwnership(const PartRecord& record) {
  const std::lock_guard lock(mutex_);
  ownership_.push_back({elapsed(), record});
}

void SessionNotes::onGrab(const Grab& grab) { requestedAt_[grab.request] = localTime(); }

void SessionNotes::onGrabReply(const GrabReply& reply) {
  const auto requested = requestedAt_.find(reply.request);
  if (requested == requestedAt_.end()) return;  // the answer to a reclaim: no person waited for it
  const double wait_ms = toSeconds(localTime() - requested->second) * 1e3;
  ASSERT(wait_ms >= 0.0);
  requestedAt_.erase(requested);
  const std::lock_guard lock(mutex_);
  grabs_.push_back({elapsed(), wait_ms, reply.part.part, reply.denial, reply.part.owner});
}

void SessionNotes::onEngaged(const EngageReply& reply) {
  const std::lock_guard lock(mutex_);
  shared_.insert(reply.coHolders.part);
}

std::size_t SessionNotes::sharedParts() {
  const std::lock_guard lock(mutex_);
  return shared_.size();
}

std::vector<OwnershipNote> SessionNotes::drainOwnership() {
  const std::lock_guard lock(mutex_);
  return std::exchange(ownership_, {});
}

std::vector<GrabNote> SessionNotes::drainGrabs() {
  const std::lock_guard lock(mutex_);
  return std::exchange(grabs_, {});
}

}  // namespace tandem::client
