#pragma once

// The inside of a Session; only the session*.cpp files include it. Which file holds what:
//   session.cpp            construction, events, timers, the ordered way out
//   session_admission.cpp  hello, resume, refusals, who is here, leaving, the scene transfer
//   session_parts.cpp      grab, release, reclaim, engage, revoke, reset, leases, poses kept in the journal
//   session_relay.cpp      state datagrams and pings

#include <deque>
#include <map>
#include <optional>
#include <unordered_map>

#include "server/outbox.h"
#include "server/session.h"
#include "sync/wire/site_colours.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/state_stream.h"
#include "sync/wire/wire.h"

namespace tandem::server {

enum class Stage : std::uint8_t { hello, loading, ready };

/// State messages that a site may send at once after a pause.
inline constexpr double kDatagramBurst = 400.0;

/// One connection.
struct Peer {
  sync::ConnectionId connection = 0;
  PeerSerial serial = 0;
  Stage stage = Stage::hello;
  SiteId site = kNoSite;  // from the hello on
  sync::Role role = sync::Role::observer;
  sync::Micros since = 0, lastHeard = 0;  // session time
  bool welcomed = false;                  // the Welcome has left: chunks may follow it
  bool transferring = false;
  std::uint64_t transferOffset = 0;  // into the package, of the next chunk
  std::uint32_t sequenceOut = 0;     // of StateUpdates to this site
  std::uint32_t updatesIn = 0;       // StateUpdates that came from it
  std::uint32_t lastSequenceIn = 0;
  sync::Presence presence;  // the newest
  sync::StateSender statesOut;
  sync::StateReceiver statesIn{1};
  sync::StateBundle unsent;           // said in this step
  double allowance = kDatagramBurst;  // messages that it may send at once
  sync::Micros allowanceAt = 0;
};

/// A site that was admitted at some time.
struct KnownSite {
  sync::SiteInfo info;
  bool left = false;    // said goodbye: its ticket is void
  bool listed = false;  // the others are told of it
  sync::Micros disconnectedAt = 0;
  std::deque<sync::CommandReply> answers;  // to the latest commands (S7)
};

struct Session::State {
  const assets::Scene& scene;
  std::span<const std::byte> package;
  SessionConfig config;
  sync::Transport& transport;
  Journal& journal;
  sync::RecordingWriter* recording;

  sync::Micros offset = 0;   // session time minus the caller's clock
  sync::Micros now = 0;      // session time
  std::int64_t unixNow = 0;  // s

  std::array<std::uint8_t, 32> sceneHash{};
  sync::WireFrame frame;
  sync::OwnershipTable table;
  std::map<sync::ConnectionId, Peer> peers;  // ordered, so that a seed gives one run
  std::map<SiteId, KnownSite> known;
  std::vector<sync::SiteInfo> listed;
  std::unordered_map<std::string, std::int64_t> usedNonces;  // and when each expires, Unix time in s
  SiteId nextSite = 1;
  PeerSerial nextSerial = kRecordingOnly + 1;

  Outbox outbox;
  std::uint64_t appended = 0;  // number of the last record given to the journal
  std::string journalFailure;
  bool eventsLeft = false;  // the last step did not get to the end of them

  std::vector<PartId> movedParts;  // owned parts whose pose is newer than the journal's
  std::vector<bool> moved;         // by part
  struct Reset {
    std::vector<PartId> left;  // to be put back, from the back
    SiteId site = kNoSite;
    sync::RequestId request = 0;
  };
  std::optional<Reset> reset;

  sync::Micros nextLeases = 0, nextPoses = 0, nextHousekeeping = 0;  // session time
  sync::StateMessage incoming{sync::StateUpdate{}}, incomingShort{sync::Ping{}};
  std::vector<std::byte> stateBytes;
  SessionCounters counts;
  std::vector<LogLine> log;
  std::vector<sync::Role> usedTokens;

  State(const assets::Scene& scene, std::span<const std::byte> package, const SessionConfig& config,
        sync::Transport& transport, Journal& journal, sync::RecordingWriter* recording);

  // session.cpp
  void restore(sync::Micros callerNow);
  void takeEvents();
  void onConnected(sync::ConnectionId connection);
  void onControl(Peer& peer, std::span<const std::byte> bytes);
  void dispatch(Peer& peer, const sync::ControlMessage& message);
  void watchJournal();
  void runTimers();
  void flushOutbox();
  void send(const Outgoing& item);
  void sendControl(sync::ConnectionId connection, std::span<const std::byte> bytes);
  void tell(const Peer& peer, sync::ControlMessage message);
  void tellAll(sync::ControlMessage message, SiteId except = kNoSite);
  void keep(const JournalRecord& record) { appended = journal.append(record); }
  void say(std::string line);
  void sayError(std::string line);
  Peer* peerOf(SiteId site);
  std::string nameOf(SiteId site) const;

  // session_admission.cpp
  void onHello(Peer& peer, const sync::Hello& hello);
  void join(Peer& peer, const sync::Hello& hello, const Ticket& ticket);
  void resume(Peer& peer, const sync::Hello& hello, const Ticket& ticket);
  void admit(Peer& peer, KnownSite& site, const sync::Hello& hello);
  bool full() const;
  sync::SiteColour freeColour(SiteId except) const;
  sync::Welcome welcomeFor(const KnownSite& site, std::vector<sync::PartRecord>& parts) const;
  void refuse(Peer& peer, sync::Refusal refusal, const std::string& reason);
  void onGoodbye(Peer& peer);
  void forget(sync::ConnectionId connection, const std::string& reason);
  void dropSilent();
  void relist();
  void onSceneRequest(Peer& peer, const sync::SceneRequest& request);
  void sendChunks(Peer& peer);
  void forgetOldNonces();

  // session_parts.cpp
  void onGrab(Peer& peer, const sync::Grab& request);
  void onReclaim(Peer& peer, const sync::Reclaim& request);
  void onRelease(Peer& peer, const sync::Release& request);
  void answerGrab(Peer& peer, const sync::OwnershipTable::Decision& decision);
  void onEngage(Peer& peer, const sync::Engage& request);
  void onDisengage(Peer& peer, const sync::Disengage& request);
  void tellMembers();
  void onRevoke(Peer& peer, const sync::Revoke& request);
  void onReset(Peer& peer, const sync::ResetParts& request);
  void continueReset();
  bool mayCommand(Peer& peer, sync::RequestId request);
  void answerCommand(SiteId site, sync::RequestId request, bool done, const std::string& reason);
  void partChanged(const sync::PartRecord& record);
  void freeParts(const std::vector<sync::PartRecord>& records, const char* why);
  void keepPoses();

  // session_relay.cpp
  bool onState(Peer& peer, std::span<const std::byte> bytes);
  void onPing(Peer& peer, const sync::Ping& ping);
  void onLink(Peer& peer, sync::StateMessage& message);
  void onUpdate(Peer& peer, sync::StateMessage& message);
  void acknowledge(Peer& peer);
  void forgetStates(SiteId origin);
  void sendState(Peer& peer);
  void flushStates(Peer& peer);
  void orderFor(const Peer& peer, std::vector<sync::PartState>& parts) const;
  bool plausible(const sync::StateUpdate& update) const;
  bool withinRate(Peer& peer);
};

}  // namespace tandem::server
