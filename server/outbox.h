#pragma once

// Control messages on their way out, in one order for all sites, each held back until every journal record
// that was written before it is durable. So no site learns of anything that a crash could undo, not even by a
// denial.

#include <cstdint>
#include <deque>
#include <memory>
#include <set>
#include <vector>

#include "sync/wire/control_message.h"

namespace tandem::server {

/// A connection's number within this session. Connection ids may be used again; serials are not.
using PeerSerial = std::uint64_t;
/// The addressee of messages that only the recording gets.
inline constexpr PeerSerial kRecordingOnly = 0;

struct Outgoing {
  std::uint64_t after = 0;  // journal record that must be durable first
  PeerSerial to = kRecordingOnly;
  std::shared_ptr<const sync::ControlMessage> message;
};

/// What a failure of the journal kept from the sites.
struct Abandoned {
  std::vector<sync::PartRecord> denied;  // new grants that were answered with a denial
  std::set<PartId> parts;                // whose changes were not published
  std::vector<Outgoing> news;            // other messages, which may leave once the journal is well again

  bool empty() const { return denied.empty() && parts.empty() && news.empty(); }
};

class Outbox {
 public:
  void push(PeerSerial to, std::shared_ptr<const sync::ControlMessage> message, std::uint64_t after) {
    queue_.push_back({after, to, std::move(message)});
  }
  /// The next message that may leave now that the journal is safe up to `durable`, or null.
  const Outgoing* front(std::uint64_t durable) const {
    return queue_.empty() || queue_.front().after > durable ? nullptr : &queue_.front();
  }
  void pop() { queue_.pop_front(); }
  bool empty() const { return queue_.empty(); }

  /// The journal has failed: a reply that depends on it becomes a denial, other messages that depend on it
  /// are taken out, and the rest may leave.
  Abandoned abandon(std::uint64_t durable);

 private:
  std::deque<Outgoing> queue_;
};

}  // namespace tandem::server
