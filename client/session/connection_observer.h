#pragma once

// Who looks on while a site is in a session: the checks of a simulation, the reports of `join`, a recording.

#include "sync/wire/ownership_messages.h"
#include "sync/wire/recording.h"
#include "sync/wire/state_update.h"

namespace tandem::client {

/// Watches a site from outside. Called in the network thread.
class ConnectionObserver {
 public:
  virtual ~ConnectionObserver() = default;
  virtual void onOwnership(const sync::PartRecord&) {}
  virtual void onGrab(const sync::Grab&) {}
  virtual void onRelease(const sync::Release&) {}
  virtual void onGrabReply(const sync::GrabReply&) {}
  virtual void onAccepted(SiteId, const sync::PartState&) {}
  virtual void onPublished(const sync::PartState&) {}
  virtual void onConnection(bool) {}
};

/// Both may be null, and may change while the connection lives.
struct Watchers {
  ConnectionObserver* observer = nullptr;
  sync::RecordingWriter* recording = nullptr;
};

}  // namespace tandem::client
