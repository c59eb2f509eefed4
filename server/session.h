#pragma once

// One session: admits sites, arbitrates parts, relays state, hands out the scene. It knows no socket, clock
// or disk: they come in as a Transport, a time and a Journal, so the same code runs in tandem-server and in
// `tandem simulate`.
//
// 1. Every message is checked against the sender's role and stage (hello, loading, ready) before it has any
//    effect. A message that does not belong closes that connection with a Refused, and changes nothing.
// 2. A reply that depends on a journal record leaves only after that record is durable; replies keep their
//    order.
// 3. State is relayed in the step in which it came, to every other ready site, if ownership accepts it. The
//    rest is dropped and counted.
// 4. Session time runs with the caller's clock, from the latest time in the journal on, so it survives
//    restarts.
// 5. A step's work is bounded. What is left over waits for the next step, which nextDeadline() then asks for
//    at once.
// 6. While the journal fails, nothing is granted, kept or admitted; state is still relayed among those
//    present. When it is well again the session goes on, and what was denied meanwhile stays denied.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/document/document.h"
#include "assets/scene/scene.h"
#include "server/admission.h"
#include "server/journal/journal.h"
#include "server/session_config.h"
#include "server/session_context.h"
#include "server/session_figures.h"
#include "sync/replica/ownership_table.h"
#include "sync/transport/transport.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/recording.h"
#include "sync/wire/time.h"
#include "sync/wire/traffic.h"

namespace tandem::server {

class Session {
 public:
  /// `scene` and `package` (its bytes as sent to sites) must outlive the session. It restores itself from the
  /// journal. `recording` may be null. `now` is any monotonic clock of the caller, the same in step() and
  /// nextDeadline(); `unixNow` is the wall clock in s at that time.
  Session(const assets::Scene& scene, std::span<const std::byte> package, const SessionConfig& config,
          sync::Transport& transport, Journal& journal, sync::RecordingWriter* recording, sync::Micros now,
          std::int64_t unixNow);
  ~Session();

  /// A join token for this role, valid until `expires` (Unix time, s), usable once.
  std::string makeToken(sync::Role role, std::int64_t expires) const;

  /// Parts from a site, named by its number or its name: it is told, and its parts are free at once as by a
  /// goodbye. Its ticket still admits it, unless `ban`. What was done, or why nothing was.
  Result<std::string> kick(const std::string& who, bool ban);
  /// A site's ticket admits nobody any more; if the site is connected it stays until its connection ends.
  Result<std::string> revokeTicket(const std::string& who);
  /// Every token made before is void. The caller has made the key durable.
  std::string replaceLinkKey(const SigningKey& key);
  /// Every token and ticket made before is void; the sites that are connected get new tickets.
  std::string replaceKeys(const SigningKey& ticketKey, const SigningKey& linkKey);
  /// A token was made at an operator's wish.
  void noteInvitation(sync::Role role);

  /// Whether a knock is of a token or ticket made with the present key. Cheap, and no right to enter.
  bool knows(const sync::Knock& knock) const;

  /// Handles every event that the transport has, then does what is due: durable replies, leases, chunks.
  void step(sync::Micros now, std::int64_t unixNow);
  /// When, on the caller's clock, step() must be called next even if nothing arrives.
  sync::Micros nextDeadline() const;
  /// Session time at the last step.
  sync::Micros sessionTime() const;
  /// Keeps the poses and closes every connection, without a refusal: sites come back when the server does.
  /// The transport must run a little longer afterwards; no step() may follow.
  void shutDown();

  /// Everybody who is connected, or was a short while ago.
  const std::vector<sync::SiteInfo>& sites() const;
  const sync::OwnershipTable& ownership() const;
  /// The document, with changes that are not durable yet.
  const document::Document& document() const;
  const SessionCounters& counters() const;

  /// A copy of all figures, for metrics.
  SessionFigures figures() const;
  /// Lines for the log (a site joined, left, was refused, was granted a part) since the last call.
  std::vector<LogLine> drainLog();
  /// Who came, went, was refused or made to go since the last call, for the audit log.
  std::vector<AuditEntry> drainAudit();
  /// The roles of the join tokens used since the last call: each may want a new link.
  std::vector<sync::Role> drainUsedTokens();

 private:
  class Dispatcher;
  std::unique_ptr<Dispatcher> dispatcher_;
};

}  // namespace tandem::server
