#pragma once

// The way out of a session: what it writes to the journal, what it sends as control messages, and what it
// records.
//
// 1. A message of sendTo() or publish() leaves only when every record kept before it is durable; all of them
//    keep one order.
// 2. While the journal fails, writable() is false: a reply that waited for it becomes a denial. What else
//    waited is published when the journal is well again.

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <string>

#include "server/journal/journal.h"
#include "server/outbox.h"
#include "server/peers.h"
#include "server/session_context.h"
#include "sync/transport/transport.h"
#include "sync/wire/recording.h"

namespace tandem::server {

class Publisher {
 public:
  /// `recording` may be null. All outlive this.
  Publisher(SessionContext& context, sync::Transport& transport, Journal& journal, Peers& peers,
            sync::RecordingWriter* recording);

  /// Appends a record to the journal. Only while writable().
  void keep(const JournalRecord& record);
  /// The number of the last record that was kept, and of the last that is durable.
  std::uint64_t lastKept() const { return appended_; }
  std::uint64_t durableUpTo() { return journal_.durableUpTo(); }
  /// Whether the journal still takes records. The network thread does not wait for it.
  bool writable() const { return journalFailure_.empty(); }
  /// Notices that the journal has failed, or is well again; then it returns what the failure kept from the
  /// sites. Called at the beginning of every step.
  std::optional<Abandoned> watchJournal();

  /// Queues a message to one connection.
  void sendTo(const Peer& peer, sync::ControlMessage message);
  /// Queues a message to every connection past the hello stage, and to the recording.
  void publish(sync::ControlMessage message);
  /// Sends at once, past the queue: for what depends on no record.
  void sendNow(sync::ConnectionId connection, const sync::ControlMessage& message);
  /// The same of a message that is encoded already.
  void sendNow(sync::ConnectionId connection, std::span<const std::byte> encoded);

  /// Whether messages wait for the disk.
  bool waiting() const { return !outbox_.empty(); }
  /// Sends what may leave now, a bounded number of messages. `onClosed` is given each connection that ends
  /// with its Refused.
  template <typename OnClosed>
  void flush(const OnClosed& onClosed) {
    const std::uint64_t durable = journal_.durableUpTo();
    timeJournal(durable);
    for (int i = 0; i < kMaxMessagesPerStep; ++i) {
      // After a failure nothing new waits for the disk: what is made then depends on no record.
      const Outgoing* item = outbox_.front(writable() ? durable : ~std::uint64_t{0});
      if (item == nullptr) return;
      const Outgoing next = *item;
      outbox_.pop();
      if (const auto closed = send(next)) onClosed(*closed);
    }
  }

  /// Messages that publish() has queued so far, and those expected of it, each addressee counted.
  std::uint64_t published() const { return published_; }
  /// Counts a message to all that will be published at the end of the step.
  void expectPublish();

  bool recording() const { return recording_ != nullptr; }
  /// Writes a message to the recording, if there is one, at the current session time.
  void record(const sync::ControlMessage& message);
  void record(const sync::StateMessage& message);
  /// Gives up the recording if it cannot be written any more.
  void flushRecording();

 private:
  static constexpr int kMaxMessagesPerStep = 4096;

  static constexpr std::size_t kMaxTimed = 1024;  // records whose time to the disk is taken at once

  struct Appended {
    std::uint64_t number = 0;
    sync::Micros at = 0;  // session time
  };
  /// Counts how long the records took that are durable now.
  void timeJournal(std::uint64_t durable);
  /// The connection that this message closed, if it did.
  std::optional<sync::ConnectionId> send(const Outgoing& item);

  SessionContext& context_;
  sync::Transport& transport_;
  Journal& journal_;
  Peers& peers_;
  sync::RecordingWriter* recording_;
  Outbox outbox_;
  std::deque<Appended> unfinished_;
  std::uint64_t published_ = 0;
  std::uint64_t appended_ = 0;  // number of the last record given to the journal
  std::string journalFailure_;
  Abandoned abandoned_;  // by the failure that lasts
};

}  // namespace tandem::server
