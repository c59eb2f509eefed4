#pragma once

// The connections of a session, each with its stage and, after its hello, its site.
//
// 1. Iteration goes by connection id, so that a seed of the simulation gives one run.
// 2. A pointer or reference to a Peer holds until that peer is erased.
// 3. `Peer::states` is written by StateRelay and FanOut alone, `Peer::transfer` by SceneTransfer alone,
//    `Peer::document` by DocumentService alone.

#include <limits>
#include <map>
#include <string>
#include <unordered_map>

#include "assets/document/entry.h"
#include "server/interest.h"
#include "server/outbox.h"
#include "server/places.h"
#include "server/site_figures.h"
#include "sync/transport/transport.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/shared_state_sender.h"
#include "sync/wire/state_bundle.h"
#include "sync/wire/state_receiver.h"
#include "sync/wire/state_sender.h"
#include "sync/wire/state_update.h"
#include "sync/wire/time.h"

namespace tandem::server {

/// `hello`: nothing is known of the peer yet. `loading`: it has a site and fetches the scene. `ready`: it
/// takes part.
enum class Stage : std::uint8_t { hello, loading, ready };

/// State messages that a site may send at once after a pause.
inline constexpr double kDatagramBurst = 400.0;

/// When a datagram leaves that has no message in it.
inline constexpr sync::Micros kNotWaiting = std::numeric_limits<sync::Micros>::max();

/// What the others have been shown of a site; see server/fan_out.h.
struct Shown {
  sync::StateUpdate newest, toAll;                                 // of this site; that which went to all
  sync::Micros at = std::numeric_limits<sync::Micros>::min() / 4;  // when something went to all
  bool pending = false;       // `newest` did not go to all, and differs from what did
  bool presenceOwed = false;  // a presence since did not
};

/// The two state streams of one connection; see server/state_relay.h and server/fan_out.h.
struct StateLeg {
  std::uint32_t sequenceOut = 0;  // of StateUpdates to this site
  std::uint32_t updatesIn = 0;    // StateUpdates that came from it
  std::uint32_t lastSequenceIn = 0;
  sync::Presence presence;  // the newest
  sync::StateSender sender;
  sync::SharedReceiver shared;
  sync::StateReceiver receiver{1};
  sync::Micros nextFloodNotice = 0;     // session time before which nobody is told again
  sync::StateBundle unsent;             // messages that have not left yet
  sync::Micros unsentBy = kNotWaiting;  // session time at which they leave
  Shown shown;
  Reach reach;
  std::size_t place = 0;                  // among the ready sites, or the ready observers
  double allowance = kDatagramBurst;      // messages that the site may send at once, without those of links
  double linkAllowance = kDatagramBurst;  // the same, of links
  sync::Micros allowanceAt = 0;           // session time at which both were computed
};

/// How far the scene package has been sent to one connection; see server/scene_transfer.h.
struct TransferProgress {
  bool active = false;
  std::uint64_t offset = 0;  // into the package, of the next chunk
};

/// How far the document has been sent to one connection; see server/document_service.h.
struct DocumentProgress {
  bool active = false;
  bool first = true;              // nothing was sent yet
  document::Revision sent = 0;    // of the last entry that was sent
  document::Revision target = 0;  // of the document when it was asked for
};

struct Peer {
  sync::ConnectionId connection = 0;
  PeerSerial serial = 0;
  Stage stage = Stage::hello;
  SiteId site = kNoSite;  // from the hello on
  sync::Role role = sync::Role::observer;
  sync::Micros lastReceived = 0;  // session time
  std::string address;            // where it connects from, if the transport knows
  std::string claimedName;        // of its Hello
  bool welcomed = false;          // the Welcome has left: chunks may follow it
  SiteFigures figures;
  StateLeg states;
  TransferProgress transfer;
  DocumentProgress document;
  bool doubtsOwed = true;         // it has not heard who doubts whom; see server/doubts.h
  bool presentationsOwed = true;  // it has not heard what all show; see server/presentations.h
  bool saidOwed = true;           // it has not heard what was said before; see server/chat.h
};

class Peers {
 public:
  /// A new connection in the hello stage. The id must not be in use.
  Peer& add(sync::ConnectionId connection, sync::Micros now);
  void erase(sync::ConnectionId connection);
  void clear();
  /// Grows with every peer that is added or erased.
  std::uint64_t changes() const { return changes_; }

  /// Null if there is none.
  Peer* find(sync::ConnectionId connection);
  Peer* bySite(SiteId site);
  Peer* bySerial(PeerSerial serial);

  bool empty() const { return peers_.empty(); }
  /// Connections that have sent no Hello.
  std::size_t strangers() const;
  /// Connections that have a site, by role.
  RoleCounts admitted() const;

  auto begin() { return peers_.begin(); }
  auto end() { return peers_.end(); }
  auto begin() const { return peers_.begin(); }
  auto end() const { return peers_.end(); }

 private:
  std::map<sync::ConnectionId, Peer> peers_;
  std::unordered_map<PeerSerial, sync::ConnectionId> connections_;
  PeerSerial nextSerial_ = kRecordingOnly + 1;
  std::uint64_t changes_ = 0;
};

}  // namespace tandem::server
