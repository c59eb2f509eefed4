#pragma once

// One site's side of the protocol: enters the session, fetches the scene, asks for parts, publishes and
// receives states, keeps its lease and clock, and comes back after an outage. Knows no socket and no thread:
// a connector makes transports, step() is called a thousand times a second or so.
//
// Network thread only; the haptic thread is reached through the Exchange.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "client/base/loss_meter.h"
#include "client/session/exchange.h"
#include "client/session/part_links.h"
#include "client/session/state_publisher.h"
#include "client/session/view_model.h"
#include "sync/replica/clock_offset.h"
#include "sync/replica/ownership.h"
#include "sync/replica/play_out.h"
#include "sync/transport/transport.h"
#include "sync/wire/recording.h"
#include "sync/wire/site_colours.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/state_stream.h"
#include "sync/wire/traffic.h"
#include "sync/wire/wire.h"

namespace tandem::client {

struct ConnectionOptions {
  std::string name = "site";
  sync::SiteColour colour = sync::kAnyColour;
  std::string token;  // of the join link
  PublishRates rates;
  sync::Micros pingInterval = 100 * sync::kMillisecond;
  sync::Micros retryFirst = 100 * sync::kMillisecond, retryLongest = 2 * sync::kSecond;
  sync::LeaseRules lease;  // the length is replaced by the server's
};

/// Watches a site from outside, for the checks of a simulation. Called in the network thread.
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

struct ConnectionStatistics {
  double roundTrip_ms = 0.0;  // 0: no ping of this connection was answered yet
  double lossUp = 0.0, lossDown = 0.0, playOut_ms = 0.0;
  std::uint64_t sentUpdates = 0, receivedUpdates = 0, droppedStates = 0, malformed = 0;
  std::uint64_t droppedBaselines = 0;  // updates told against one that is not here, or that came out wrong
  std::uint64_t reconnects = 0;
  sync::TransportCounters transport;  // of the present connection
  sync::Traffic sent, received;       // of all
};

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
  const sync::Welcome& welcome() const { return welcome_; }

  /// The scene package is in a cache: no transfer.
  void skipTransfer();
  /// Fetches the package, continuing after `have` (bytes of an earlier, broken-off transfer).
  void startTransfer(std::vector<std::byte> have);
  double transferProgress() const;  // 0..1
  const std::vector<std::byte>& scenePackage() const { return package_; }

  /// The scene stands and the hand may touch it. Both must outlive the link.
  void sceneReady(const assets::Scene& scene, Exchange& exchange);

  void revoke(PartId part);
  void resetParts();
  void setCamera(const Pose& worldFromCamera) { worldFromCamera_ = worldFromCamera; }
  /// Says goodbye: this site's parts are free at once.
  void leave();

  sync::Transport* transport() { return transport_.get(); }
  const std::vector<SiteView>& sites() const { return sites_; }
  SiteId owner(PartId part) const { return ownership_ ? ownership_->part(part).owner : kNoSite; }
  ConnectionStatistics statistics() const;
  std::vector<Notice> takeNotices();
  /// Session time at local time `now`, 0 before the first pong.
  sync::Micros sessionTime(sync::Micros now);

  void setObserver(ConnectionObserver* observer) { observer_ = observer; }
  void setRecording(sync::RecordingWriter* recording) { recording_ = recording; }

 private:
  void connect(sync::Micros now);
  void disconnected(const std::string& reason, sync::Micros now);
  void takeEvents(sync::Micros now);
  void takeControl(std::span<const std::byte> bytes, sync::Micros now);
  void takeState(std::span<const std::byte> bytes, sync::Micros now);
  void countDown(std::uint32_t sequence);
  void takeUpdate(const sync::StateUpdate& update, sync::Micros now);
  void takeLink(const sync::LinkUpdate& update, sync::Micros now);

  void take(sync::Welcome& message);
  void take(sync::Refused& message);
  void take(sync::SceneChunk& message);
  void take(sync::SiteChanged& message);
  void take(sync::SiteLeft& message);
  void take(sync::GrabReply& message);
  void take(sync::ReleaseReply& message);
  void take(sync::CommandReply& message);
  void take(sync::OwnershipChanged& message);
  void take(sync::EngageReply& message);
  void take(sync::MembersChanged& message);
  template <typename Unexpected>
  void take(Unexpected& message);  // messages that only a site sends

  void tellDenial(const sync::GrabReply& reply, bool reclaim);
  void tellDenied(const sync::PartRecord& record, const std::string& why);
  void askFor(PartId part, int before);
  bool mayShare(PartId part) const;
  void applyMembers(const sync::MemberRecord& members);
  void followLinks(PartId part);
  void pushOrders();
  void shareAgain();
  void rememberOwnership(const sync::PartRecord& record);
  void applyOwnership(const sync::PartRecord& record);
  void enterReady();
  void recordBeginning();
  void reclaimParts(bool all);
  void pushEvent(const NetworkEvent& event);
  void flushEvents();
  void sendIntents();
  void exchangeLinks(sync::Micros now);
  bool waitsForLink(sync::Micros now) const;
  void tell(sync::Micros now);
  void publish(sync::Micros now);
  void offerParts(sync::Micros now);
  bool othersTouch(PartId part) const;
  void acknowledge(sync::Micros now);
  void publishTimeBase(sync::Micros now);
  void send(const sync::ControlMessage& message);
  void sendState(const sync::StateMessage& message);
  void sendBytes();
  void notice(Notice::Level level, std::string text);
  SiteView* siteView(SiteId site);
  std::string siteName(SiteId site) const;
  std::string partName(PartId part) const;

  ConnectionOptions options_;
  Connector connector_;
  std::unique_ptr<sync::Transport> transport_;
  ConnectionObserver* observer_ = nullptr;
  sync::RecordingWriter* recording_ = nullptr;

  Stage stage_ = Stage::connecting;
  std::string reason_;
  std::string resumeTicket_;
  sync::Micros retryAt_ = 0, retryDelay_;
  sync::Welcome welcome_;
  std::vector<std::byte> package_;

  const assets::Scene* scene_ = nullptr;
  Exchange* exchange_ = nullptr;
  std::optional<sync::WireFrame> frame_;
  std::optional<sync::OwnershipView> ownership_;
  std::vector<Epoch> givenBack_;  // by part, in which it was released last
  std::optional<PartLinks> links_;
  std::vector<NetworkEvent> waitingEvents_;  // ownership events that found the ring full: none may be lost
  sync::ClockOffset clock_;
  sync::PlayOutDelay playOutDelay_;
  sync::Micros playOut_ = 0, now_ = 0;

  sync::RequestId nextRequest_ = 1;
  std::uint32_t lost_ = 0;  // connections, as the hand is told
  struct OpenGrab {
    std::uint32_t lapses = 0;  // of the lease, before it was sent
    sync::RequestId request = 0;
    PartId part = kNoPart;
    enum class Kind : std::uint8_t { grab, reclaim, engage, leave } kind = Kind::grab;
    int before = 0;  // questions that this one follows, as the part came and went
  };
  sync::RequestId open(PartId part, OpenGrab::Kind kind, int before = 0);
  std::optional<OpenGrab> closeGrab(sync::RequestId request, PartId part);
  std::vector<OpenGrab> openGrabs_;
  std::uint32_t pingSequence_ = 0, updateSequence_ = 0;
  sync::Micros nextPing_ = 0;
  sync::Micros linkSentAt_ = -sync::kSecond;
  HandOutput hand_;
  Pose worldFromCamera_;

  std::vector<SiteView> sites_;
  std::vector<Notice> notices_;
  ConnectionStatistics statistics_;
  std::vector<std::pair<SiteId, std::uint32_t>> lastSequence_;  // newest update a site
  // All on this connection, for the losses.
  std::uint64_t expectedUpdates_ = 0, heardUpdates_ = 0, updatesSent_ = 0, updatesAtPing_ = 0;
  std::uint32_t newestUpdate_ = 0;  // its sequence
  LossMeter lossUp_, lossDown_;

  std::optional<StatePublisher> publisher_;
  std::vector<OfferedPart> offered_;
  sync::StateSender statesOut_;
  sync::StateReceiver statesIn_;
  sync::StateMessage incoming_, outgoingMessage_, outgoingUpdate_{sync::StateUpdate{}};
  std::vector<std::byte> bytes_;
  sync::StateBundle unsent_;  // said in this step
};

}  // namespace tandem::client
