#pragma once

// How long a lease lasts (Gray & Cheriton, "Leases: an efficient fault-tolerant mechanism for distributed
// file cache consistency", SOSP 1989). The server frees a part only when the full lease and the clocks' drift
// have passed since a ping arrived; a site stops earlier than that by drift and a margin, counted from the
// sending of the same ping. So the site has stopped before the server may free the part (S3), whatever the
// delay of the ping was.

#include "sync/wire/time.h"

namespace tandem::sync {

struct LeaseRules {
  Micros lease = 2 * kSecond;
  double driftPpm = 500.0;            // by which two monotonic clocks may disagree
  Micros margin = 50 * kMillisecond;  // by which a site stops earlier than drift alone demands

  /// By how much two clocks may disagree about the length of a lease, rounded up.
  Micros drift() const { return static_cast<Micros>(static_cast<double>(lease) * driftPpm * 1e-6) + 1; }
  /// Lease expiry at the server: how long after the last renewal arrived it may free a part.
  Micros serverLease() const { return lease + drift(); }
  /// Lease expiry at a site: how long after it sent the ping that renewed its lease it must have stopped.
  Micros siteLease() const { return lease - drift() - margin; }
};

}  // namespace tandem::sync
