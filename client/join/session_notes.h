#pragma once

// Notes for reports of what happened to parts at this site: changes of ownership, and how its grabs were
// answered. Written in the network thread, drained in the main thread.

#include <map>
#include <mutex>
#include <set>
#include <vector>

#include "client/session/connection_observer.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/time.h"

namespace tandem::client {

/// A change of ownership, when its record arrived here.
struct OwnershipNote {
  double time = 0.0;  // s since the site started
  sync::PartRecord record;
};

/// How this site's grabs were answered.
struct GrabNote {
  double time = 0.0;     // s since the site started
  double wait_ms = 0.0;  // from the request to its answer
  PartId part = kNoPart;
  sync::Denial denial = sync::Denial::none;
  SiteId owner = kNoSite;  // who has it now
};

class SessionNotes : public ConnectionObserver {
 public:
  SessionNotes();

  void onOwnership(const sync::PartRecord& record) override;
  void onGrab(const sync::Grab& grab) override;
  void onGrabReply(const sync::GrabReply& reply) override;
  void onEngaged(const sync::EngageReply& reply) override;

  /// The notes since the last call, oldest first.
  std::vector<OwnershipNote> drainOwnership();
  std::vector<GrabNote> drainGrabs();
  /// How many parts of others this site has been a co-holder of.
  std::size_t sharedParts();

 private:
  double elapsed() const;  // s since the site started

  sync::Micros start_;
  std::map<sync::RequestId, sync::Micros> requestedAt_;  // network thread
  std::mutex mutex_;                                     // guards what follows
  std::vector<OwnershipNote> ownership_;
  std::vector<GrabNote> grabs_;
  std::set<PartId> shared_;
};

}  // namespace tandem::client
