#pragma once

// What every class of a session reads or adds to: the session's time, its counters and its log. No thread of
// its own: all of it is called from the thread that calls Session::step().

#include <cstdint>
#include <string>
#include <vector>

#include "server/audit_trail.h"
#include "server/duration_histogram.h"
#include "sync/wire/time.h"
#include "sync/wire/traffic.h"

namespace tandem::server {

struct SessionCounters {
  std::uint64_t relayedUpdates = 0, relayedParts = 0;
  std::uint64_t droppedStates = 0;     // an old epoch, a site that is not the owner, or no newer sequence
  std::uint64_t droppedMalformed = 0;  // datagrams that do not decode, name an unknown part or an absurd time
  std::uint64_t droppedBaselines = 0;  // updates against a baseline that is missing, or with a wrong checksum
  std::uint64_t droppedEarly = 0;      // datagrams of a connection that is not ready
  std::uint64_t relayedLinks = 0;      // LinkUpdates passed on
  std::uint64_t droppedLinks = 0;      // LinkUpdates between sites that are not owner and co-holder
  std::uint64_t droppedFlood = 0;      // messages beyond kMaxDatagramRate or kMaxLinkRate
  std::uint64_t holds = 0;             // times that a site had spent its ControlBudget
  std::uint64_t refusedPoses = 0;      // of releases and reclaims, outside the wire's frame
  std::uint64_t refusedHellos = 0, refusedMessages = 0;
  std::uint64_t refusedReports = 0;  // SiteReports that cannot be true
  std::uint64_t relayedPresentations = 0;
  std::uint64_t droppedPresentations = 0;  // of observers, of unknown parts, or too many
  std::uint64_t droppedSays = 0;           // the same
  std::uint64_t doubts = 0;                // that a site began to hold about another
  std::uint64_t droppedDoubts = 0;         // of observers, of unknown sites, or too many
  sync::Traffic sent, received;
  std::uint64_t grants = 0, denials = 0, releases = 0, expiries = 0;
  DurationHistogram journal;  // from append to durable
};

/// A line for the log. An error means that the session no longer does its whole work, so a person must see
/// it.
struct LogLine {
  std::string text;
  bool error = false;
  SiteId site = kNoSite;  // whom it is about, if it is one site
};

/// Collects lines until the caller of the session drains them; bounded, because the caller need not.
class SessionLog {
 public:
  void note(std::string line, SiteId site = kNoSite);
  /// An error is never left out: there is one a failure of the journal or of the recording.
  void error(std::string line);
  std::vector<LogLine> drain();

 private:
  std::vector<LogLine> lines_;
};

class SessionContext {
 public:
  /// Session time at the current step, in microseconds.
  sync::Micros now() const { return now_; }
  /// The wall clock at the current step, in s; tickets expire by it.
  std::int64_t unixNow() const { return unixNow_; }
  /// Begins a step. Session time never runs backwards; the wall clock may.
  void advance(sync::Micros now, std::int64_t unixNow);

  SessionCounters counts;
  SessionLog log;
  AuditTrail audit;

 private:
  sync::Micros now_ = 0;
  std::int64_t unixNow_ = 0;
};

}  // namespace tandem::server
