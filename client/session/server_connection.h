#pragma once

// A site's connection to the server: enters the session, keeps its clock and lease by pings, reconnects after
// an outage, and routes each message to the class that handles it. Knows no socket and no thread: a connector
// makes transports, and step() is called about a thousand times a second.
//
// 1. A message of the server is handled by the one class that has a handle() for it; see route().
// 2. Handlers return false for a message that is not allowed at this point; it is counted as malformed and
//    changes nothing.
// 3. What needs the scene exists from sceneReady() on, and outlives every reconnect.
//
// Network thread only; the haptic thread is reached through the Exchange.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "client/session/backoff.h"
#include "client/session/connection_options.h"
#include "client/session/connection_statistics.h"
#include "client/session/doubts.h"
#include "client/session/part_requests.h"
#include "client/session/pings.h"
#include "client/session/presentations.h"
#include "client/session/scene_fetch.h"
#include "client/session/session_document.h"
#include "client/session/site_reports.h"
#include "client/session/state_publishing.h"
#include "client/session/state_receiving.h"
#include "sync/wire/admission_messages.h"

namespace tandem::client {

class ServerConnection {
 public:
  using Connector = std::function<Result<std::unique_ptr<sync::Transport>>()>;
  enum class Stage : std::uint8_t {
    connecting,  // no connection yet, or trying again
    entering,    // Hello sent
    needScene,   // welcomed: skipTransfer() or startTransfer() is awaited
    transferring,
    haveScene,  // the package is complete: sceneReady() is awaited
    ready,      // in the session
    ended,      // refused, or left; see reason()
  };

  ServerConnection(ConnectionOptions options, Connector connector);
  ~ServerConnection();

  /// Everything that is due at local time `now`.
  void step(sync::Micros now);

  Stage stage() const { return stage_; }
  /// Why the site is not in the session, in words.
  const std::string& reason() const { return reason_; }
  /// Where the people of the session talk, as the server says; empty: it names no place.
  const std::string& voiceUrl() const { return welcome_.voiceUrl; }
  const sync::Welcome& welcome() const { return welcome_; }

  /// The scene package is in a store, so no transfer is needed.
  void skipTransfer();
  /// Fetches the package, continuing after `have` (bytes of an earlier, broken-off transfer).
  void startTransfer(std::vector<std::byte> have);
  double transferProgress() const { return fetch_.progress(); }  // 0..1
  const std::vector<std::byte>& scenePackage() const { return fetch_.package(); }
  /// The package, once it is complete, which is not held here any more.
  std::vector<std::byte> takeScenePackage() { return fetch_.take(); }

  /// The scene is ready for the hand. Called once; both must outlive the connection.
  void sceneReady(const assets::Scene& scene, Exchange& exchange);

  void revoke(PartId part);
  void resetParts();
  void setCamera(const Pose& worldFromCamera) { worldFromCamera_ = worldFromCamera; }
  /// The session's document, as far as it is known here; what is wanted before the site is ready waits.
  SessionDocument& document() { return document_; }
  /// What people show and say to each other.
  Presentations& presentations() { return presentations_; }
  /// Sends a Goodbye: this site's parts are free at once.
  void leave();

  /// What lets the site in now: its ticket, or its token before it has one.
  const std::string& credential() const { return resumeTicket_.empty() ? options_.token : resumeTicket_; }

  sync::Transport* transport() { return transport_.get(); }
  const std::vector<SiteView>& sites() const { return people_.sites(); }
  /// kNoSite before the scene is ready.
  SiteId owner(PartId part) const;
  /// Valid until the next step.
  std::span<const SiteId> coHolders(PartId part) const;
  ConnectionStatistics statistics() const;
  std::vector<Notice> drainNotices() { return people_.drainNotices(); }

  /// What the site reports of its haptic loop. Before sceneReady().
  void setLoopTotals(SiteReports::Source source) { reports_.setSource(std::move(source)); }
  void setObserver(ConnectionObserver* observer) { watchers_.observer = observer; }
  void setRecording(sync::RecordingWriter* recording) { watchers_.recording = recording; }

 private:
  /// What exists from sceneReady() on.
  struct InScene {
    InScene(ServerConnection& connection, const assets::Scene& scene, Exchange& exchange);
    HandEvents events;
    PartOwnership ownership;
    StateReceiving receiving;
    StatePublishing publishing;
  };

  void connect();
  void disconnected(const std::string& reason);
  bool serverIsSilent() const;
  void sendHello();
  void receiveEvents();
  void receiveControl(std::span<const std::byte> bytes);
  void receiveState(std::span<const std::byte> bytes);
  template <typename Message>
  bool route(Message& message);

  void handle(sync::Welcome& message);
  void handle(const sync::Refused& message);
  void handle(sync::NewTicket& message);
  void handle(const sync::SiteLeft& message);
  void handle(const sync::Pong& message);
  bool handleBeforeScene(const sync::OwnershipChanged& message);
  bool handleBeforeScene(const sync::MembersChanged& message);

  void enter(Stage stage);
  void enterReady();
  void recordBeginning();
  void stepInSession();

  ConnectionOptions options_;
  Connector connector_;
  Backoff backoff_;
  std::unique_ptr<sync::Transport> transport_;
  Watchers watchers_;
  Stage stage_ = Stage::connecting;
  std::string reason_;
  std::string resumeTicket_;
  sync::Welcome welcome_;  // its list of parts is kept up to date until the scene is ready
  Pose worldFromCamera_;
  sync::Micros receivedAt_ = 0;  // local time of the newest event of the transport

  SessionClock clock_;
  Pings pings_;
  SiteReports reports_;
  MessageSender sender_;
  Participants people_;
  SceneFetch fetch_;
  SessionDocument document_;
  Presentations presentations_;
  Doubts doubts_;
  PartRequests requests_;
  std::unique_ptr<InScene> inScene_;

  std::uint64_t malformed_ = 0, reconnects_ = 0;
  sync::Traffic received_;
};

}  // namespace tandem::client
