#pragma once

// One session: admits sites, arbitrates parts, relays state, hands out the scene. Pure of sockets, clocks and
// disks: they come in as a Transport, a time and a Journal, so the same code runs in tandem-server and in
// `tandem simulate`.
//
// 1. Every message is checked against the sender's role and stage (hello, loading, ready) before it has any
// effect;
//    a message that does not belong closes that connection with a Refused, and changes nothing.
// 2. A reply that depends on a journal record leaves only after that record is durable; replies keep their
// order.
// 3. State is relayed in the step in which it came, to every other ready site, if ownership accepts it; the rest is dropped and
// counted.
// 4. Session time runs with the caller's clock, from the latest time in the journal on, so it survives
// restarts.
// 5. A step's work is bounded; what is left over waits for the next step, which nextDeadline() then asks for
// at once.
// 6. If the journal fails, nothing is granted, kept or admitted any more; state is still relayed among those
// present.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assets/scene/scene.h"
#include "server/admission.h"
#include "server/journal.h"
#include "sync/replica/ownership.h"
#include "sync/transport/transport.h"
#include "sync/wire/recording.h"
#include "sync/wire/traffic.h"

namespace tandem::server {

struct SessionConfig {
  sync::LeaseRules lease;
  SigningKey key;
  std::size_t maxSites = 16;
  std::size_t chunkBytes = 32 * 1024;         // of the scene transfer
  std::size_t maxBacklogBytes = 512 * 1024;   // queued to a loading site before the next chunk waits
  std::int64_t ticketLifetime_s = 24 * 3600;  // of resume tickets
};

struct SessionCounters {
  std::uint64_t relayedUpdates = 0, relayedParts = 0;
  std::uint64_t droppedStates = 0;     // old epoch, not the owner, not newer
  std::uint64_t droppedMalformed = 0;  // datagrams that did not decode, named unknown parts or an absurd time
  std::uint64_t droppedBaselines = 0;  // updates told against one that is not here, or that came out wrong
  std::uint64_t droppedEarly = 0;      // datagrams of a connection that is not ready
  std::uint64_t relayedLinks = 0;      // LinkUpdates passed on
  std::uint64_t droppedLinks = 0;      // LinkUpdates between sites that no part ties
  std::uint64_t droppedFlood = 0;      // messages beyond kMaxDatagramRate
  std::uint64_t refusedHellos = 0, refusedMessages = 0;
  sync::Traffic sent, received;
  std::uint64_t grants = 0, denials = 0, releases = 0, expiries = 0;
};

/// A line for the log. An error means that the session is no longer what it should be: it must reach
/// somebody.
struct LogLine {
  std::string text;
  bool error = false;
};

/// State messages a second that one site may send, however many go in a datagram; the protocol's own rates stay under a quarter of it.
inline constexpr double kMaxDatagramRate = 2000.0;

class Session {
 public:
  /// `scene` and `package` (its bytes as sent to sites) must outlive the session. Restores itself from the
  /// journal. `recording` may be null. `now` is any monotonic clock of the caller, the same in step() and
  /// nextDeadline(); `unixNow` the wall clock in s at that time.
  Session(const assets::Scene& scene, std::span<const std::byte> package, const SessionConfig& config,
          sync::Transport& transport, Journal& journal, sync::RecordingWriter* recording, sync::Micros now,
          std::int64_t unixNow);
  ~Session();

  /// A join token for this role, valid until `expires` (Unix time, s), usable once.
  std::string makeToken(sync::Role role, std::int64_t expires) const;

  /// Takes in every event that the transport has, then does what is due: durable replies, leases, chunks.
  void step(sync::Micros now, std::int64_t unixNow);
  /// When, on the caller's clock, step() must be called next even if nothing arrives.
  sync::Micros nextDeadline() const;
  /// Session time at the last step.
  sync::Micros sessionTime() const;
  /// Keeps the poses and closes every connection, without a refusal: sites come back when the server does.
  /// Run the transport a little longer afterwards; no step() may follow.
  void shutDown();

  /// Everybody who is connected, or was a short while ago.
  const std::vector<sync::SiteInfo>& sites() const;
  const sync::OwnershipTable& ownership() const;
  const SessionCounters& counters() const;

  /// Things worth a line in the log (a site joined, left, was refused, a grant), drained by the caller.
  std::vector<LogLine> takeLog();
  /// The roles of the join tokens used since the last call: each may want a new link.
  std::vector<sync::Role> takeUsedTokens();

  struct State;  // server/session_state.h

 private:
  std::unique_ptr<State> state_;
};

}  // namespace tandem::server
