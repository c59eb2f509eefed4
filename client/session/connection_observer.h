#pragma once

// Observers of a connection: the checks of a simulation, the reports of `join`, a recording.

#include "assets/base/ids.h"

namespace tandem::sync {
struct EngageReply;
struct Grab;
struct GrabReply;
struct PartRecord;
struct PartState;
class RecordingWriter;
struct Release;
}  // namespace tandem::sync

namespace tandem::client {

/// Is called with what a site receives and sends. Network thread.
class ConnectionObserver {
 public:
  virtual ~ConnectionObserver() = default;
  virtual void onOwnership(const sync::PartRecord&) {}
  virtual void onGrab(const sync::Grab&) {}
  virtual void onRelease(const sync::Release&) {}
  virtual void onGrabReply(const sync::GrabReply&) {}
  virtual void onEngaged(const sync::EngageReply&) {}  // this site is a co-holder now
  virtual void onAccepted(SiteId, const sync::PartState&) {}
  virtual void onPublished(const sync::PartState&) {}
  virtual void onDoubt(SiteId) {}  // this site does not believe the motion of that one
  virtual void onConnection(bool) {}
};

/// Each may be null, and may change while the connection lives.
struct Watchers {
  ConnectionObserver* observer = nullptr;
  sync::RecordingWriter* recording = nullptr;
  ConnectionObserver* undo = nullptr;  // is told of ownership and releases
};

}  // namespace tandem::client
