#include "server/publisher.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"
#include "sync/wire/wire.h"

namespace tandem::server {

Publisher::Publisher(SessionContext& context, sync::Transport& transport, Journal& journal, Peers& peers,
                     sync::RecordingWriter* recording)
    : context_(context),
      transport_(transport),
      journal_(journal),
      peers_(peers),
      recording_(recording),
      appended_(journal.durableUpTo()) {}

void Publisher::keep(const JournalRecord& record) {
  ASSERT(writable());
  const std::uint64_t number = journal_.append(record);
  ASSERT(number > appended_);
  appended_ = number;
  if (unfinished_.size() < kMaxTimed) unfinished_.push_back({number, context_.now()});
}

void Publisher::timeJournal(std::uint64_t durable) {
  while (!unfinished_.empty() && unfinished_.front().number <= durable) {
    context_.counts.journal.add(context_.now() - unfinished_.front().at);
    unfinished_.pop_front();
  }
}

std::optional<Abandoned> Publisher::watchJournal() {
  const bool was = writable();
  journalFailure_ = journal_.failure();
  if (writable() == was) return std::nullopt;
  if (was) {
    context_.log.error("journal: " + journalFailure_ +
                       "; nothing is granted, kept or admitted until it can be written again");
    abandoned_ = outbox_.abandon(journal_.durableUpTo());
    return std::nullopt;
  }
  ASSERT(journal_.durableUpTo() >= appended_);
  context_.log.note("journal: it is written again, and parts are granted again");
  for (Outgoing& item : abandoned_.news) outbox_.push(item.to, std::move(item.message), appended_);
  return std::exchange(abandoned_, {});
}

void Publisher::sendTo(const Peer& peer, sync::ControlMessage message) {
  ASSERT(peer.serial != kRecordingOnly);
  outbox_.push(peer.serial, std::make_shared<const sync::ControlMessage>(std::move(message)), appended_);
}

void Publisher::publish(sync::ControlMessage message) {
  const auto shared = std::make_shared<const sync::ControlMessage>(std::move(message));
  for (const auto& [connection, peer] : peers_) {
    if (peer.stage == Stage::hello) continue;
    outbox_.push(peer.serial, shared, appended_);
    ++published_;
  }
  if (recording()) outbox_.push(kRecordingOnly, shared, appended_);
}

void Publisher::expectPublish() {
  published_ += static_cast<std::uint64_t>(std::count_if(
      peers_.begin(), peers_.end(), [](const auto& entry) { return entry.second.stage != Stage::hello; }));
}

void Publisher::sendNow(sync::ConnectionId connection, const sync::ControlMessage& message) {
  sendNow(connection, sync::encodeControl(message));
}

void Publisher::sendNow(sync::ConnectionId connection, std::span<const std::byte> encoded) {
  context_.counts.sent.countControl(encoded.size());
  transport_.sendControl(connection, encoded);
}

std::optional<sync::ConnectionId> Publisher::send(const Outgoing& item) {
  ASSERT(item.message != nullptr);
  if (item.to == kRecordingOnly) {
    record(*item.message);
    return std::nullopt;
  }
  Peer* peer = peers_.bySerial(item.to);
  if (peer == nullptr) return std::nullopt;  // the connection has ended since
  if (const auto* welcome = std::get_if<sync::Welcome>(item.message.get())) {
    // A site sets its clock by the Welcome, so that it carries the time at which it leaves.
    sync::Welcome timed = *welcome;
    timed.sessionTime = context_.now();
    sendNow(peer->connection, timed);
    peer->welcomed = true;
    return std::nullopt;
  }
  sendNow(peer->connection, *item.message);
  if (!std::holds_alternative<sync::Refused>(*item.message)) return std::nullopt;
  transport_.close(peer->connection);
  return peer->connection;
}

void Publisher::record(const sync::ControlMessage& message) {
  if (recording()) recording_->write(context_.now(), message);
}

void Publisher::record(const sync::StateMessage& message) {
  if (recording()) recording_->write(context_.now(), message);
}

void Publisher::flushRecording() {
  if (!recording() || recording_->flush()) return;
  context_.log.error("recording: cannot be written any more");
  recording_ = nullptr;
}

}  // namespace tandem::server
