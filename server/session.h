#pragma once

// One session: admits sites, arbitrates parts, relays state, hands out the scene. Pure of sockets, clocks and disks: they
// come in as a Transport, a time and a Journal, so the same code runs in tandem-server and in `tandem simulate`.
//
// 1. Every message is checked against the sender's role and stage (hello, loading, ready) before it has any effect;
//    a message that does not belong closes that connection with a Refused, and changes nothing.
// 2. A reply that depends on a journal record leaves only after that record is durable; replies keep their order.
// 3. State is relayed at once, to every other ready site, if ownership accepts it; the rest is dropped and counted.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assets/scene.h"
#include "server/admission.h"
#include "server/journal.h"
#include "sync/ownership.h"
#include "sync/recording.h"
#include "sync/transport.h"

namespace tandem::server {

struct SessionConfig {
  sync::LeaseRules lease;
  SigningKey key;
  std::size_t maxSites = 16;
  std::size_t chunkBytes = 32 * 1024;          // of the scene transfer
  std::size_t maxBacklogBytes = 512 * 1024;    // queued to a loading site before the next chunk waits
  std::int64_t ticketLifetime_s = 24 * 3600;   // of resume tickets
};

struct SessionCounters {
  std::uint64_t relayedUpdates = 0, relayedParts = 0;
  std::uint64_t droppedStates = 0;        // old epoch, not the owner, not newer
  std::uint64_t droppedMalformed = 0;     // datagrams that did not decode or named unknown parts
  std::uint64_t refusedHellos = 0, refusedMessages = 0;
  std::uint64_t grants = 0, denials = 0, releases = 0, expiries = 0;
};

class Session {
 public:
  /// `scene` and `package` (its bytes as sent to sites) must outlive the session. Restores itself from the journal.
  /// `recording` may be null. `unixNow` is the wall clock in s at session time `now`.
  Session(const assets::Scene& scene, std::span<const std::byte> package, const SessionConfig& config,
          sync::Transport& transport, Journal& journal, sync::RecordingWriter* recording, sync::Micros now,
          std::int64_t unixNow);
  ~Session();

  /// A join token for this role, valid until `expires` (Unix time, s), usable once.
  std::string makeToken(sync::Role role, std::int64_t expires) const;

  /// Takes in every event that the transport has, then does what is due: durable replies, leases, chunks.
  void step(sync::Micros now, std::int64_t unixNow);
  /// Session time at which step() must be called next even if nothing arrives.
  sync::Micros nextDeadline() const;

  const std::vector<sync::SiteInfo>& sites() const;
  const sync::OwnershipTable& ownership() const;
  const SessionCounters& counters() const;

  /// Things worth a line in the log or a new link (a site joined, left, a token was used, a grant), drained by the caller.
  std::vector<std::string> takeLog();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem::server
