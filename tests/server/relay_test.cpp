// The cost and the record of the relay: no heap use per update once its buffers have grown, join links that
// are replaced when they are used, and a recording that holds what was relayed.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <optional>

#include "server/journal/memory_journal.h"
#include "server/program/invitations.h"
#include "server/session.h"
#include "sync/wire/state_receiver.h"
#include "sync/wire/state_sender.h"
#include "sync/wire/wire.h"
#include "tests/support/allocation_counter.h"

namespace tandem::server {
namespace {

using namespace sync;

constexpr std::int64_t kUnixNow = 1000000;

/// A transport without a network: a test puts events in, and what the session sends is counted.
class HandFedTransport final : public Transport {
 public:
  void connected(ConnectionId from) { pending_.push_back({TransportEvent::Kind::connected, from, {}}); }
  void control(ConnectionId from, const ControlMessage& message) {
    pending_.push_back({TransportEvent::Kind::control, from, encodeControl(message)});
  }
  /// The bytes must live until the session's next step.
  void state(ConnectionId from, std::span<const std::byte> bytes) {
    state_ = bytes;
    stateFrom_ = from;
  }

  bool poll(TransportEvent& event) override {
    if (!state_.empty()) {
      event.kind = TransportEvent::Kind::state;
      event.connection = stateFrom_;
      event.bytes = std::exchange(state_, {});
      return true;
    }
    if (pending_.empty()) return false;
    current_ = std::move(pending_.front());
    pending_.pop_front();
    event.kind = current_.kind;
    event.connection = current_.from;
    event.bytes = current_.bytes;
    return true;
  }
  void sendControl(ConnectionId, std::span<const std::byte>) override {}
  void sendState(ConnectionId to, std::span<const std::byte> bytes) override {
    ++statesOut;
    bytesOut += bytes.size();
    Last& last = last_[to % last_.size()];
    std::copy(bytes.begin(), bytes.end(), last.bytes.begin());
    last.size = bytes.size();
  }
  /// The newest datagram that was sent to this connection.
  std::span<const std::byte> lastTo(ConnectionId to) const {
    const Last& last = last_[to % last_.size()];
    return std::span(last.bytes).first(last.size);
  }
  std::size_t controlBacklog(ConnectionId) const override { return 0; }
  void hold(ConnectionId, bool) override {}
  void close(ConnectionId) override {}
  const TransportCounters& counters() const override { return counters_; }

  std::uint64_t statesOut = 0, bytesOut = 0;

 private:
  struct Pending {
    TransportEvent::Kind kind = TransportEvent::Kind::connected;
    ConnectionId from = 0;
    std::vector<std::byte> bytes;
  };
  std::deque<Pending> pending_;
  Pending current_;
  std::span<const std::byte> state_;
  ConnectionId stateFrom_ = 0;
  TransportCounters counters_;
  struct Last {
    std::array<std::byte, kMaxStateBytes> bytes{};
    std::size_t size = 0;
  };
  std::array<Last, 8> last_{};
};

/// Four ready sites; the first holds part 0.
struct Relay {
  assets::Scene scene;
  std::vector<std::byte> package{std::byte{1}};
  HandFedTransport transport;
  MemoryJournal journal;
  std::unique_ptr<Session> session;
  Micros now = 0;
  std::uint32_t sequence = 0;
  std::vector<std::byte> bytes;

  explicit Relay(RecordingWriter* recording = nullptr, std::size_t parts = 1) {
    scene.bounds = {glm::dvec3(-0.5), glm::dvec3(0.5)};
    scene.parts.resize(parts);
    for (assets::Part& part : scene.parts) {
      part.name = "part " + std::to_string(&part - scene.parts.data());
      part.movable = true;
    }
    SessionConfig config;
    config.key = SigningKey({7});
    session = std::make_unique<Session>(scene, package, config, transport, journal, recording, now, kUnixNow);
    for (ConnectionId site = 1; site <= 4; ++site) {
      transport.connected(site);
      transport.control(site, Hello{kProtocolVersion,
                                    false,
                                    session->makeToken(Role::participant, kUnixNow + 3600),
                                    "site",
                                    {1, 2, 3}});
      step();
      step();
      transport.control(site, Ready{});
      step();
    }
    transport.control(1, Grab{1, 0});
    step();
    step();
  }
  void step() {
    now += 4 * kMillisecond;
    journal.advanceTo(now);
    session->step(now, kUnixNow);
  }
  /// Renews the lease every tenth of a second.
  void pingNow(int period) {
    if (period % 25 != 0) return;
    encodeState(Ping{static_cast<std::uint32_t>(period), now}, wireFrame(scene.bounds), bytes);
    transport.state(1, bytes);
    step();
  }
  void relayOne() {
    encodeUpdate();
    transport.state(1, bytes);
    step();
  }
  void encodeUpdate() {
    StateUpdate update;
    update.sequence = ++sequence;
    update.time = session->sessionTime();
    update.parts.resize(1);
    update.parts[0].part = 0;
    update.parts[0].epoch = session->ownership().part(0).epoch;
    update.parts[0].sequence = sequence;
    update.parts[0].worldFromPart.position.x = 1e-4 * (sequence % 1000);
    encodeState(update, wireFrame(scene.bounds), bytes);
  }
};

TEST(Relay, AllocatesNothingForAnUpdateOnceItsBuffersHaveGrown) {
  Relay relay;
  for (int i = 0; i < 300; ++i) {
    relay.pingNow(i);
    relay.relayOne();
  }
  const std::uint64_t before = relay.session->counters().relayedParts;
  std::uint64_t allocations = 0;
  int stepsThatAllocate = 0;
  for (int i = 0; i < 1000; ++i) {
    relay.pingNow(i);
    relay.encodeUpdate();
    relay.transport.state(1, relay.bytes);
    relay.now += 4 * kMillisecond;
    relay.journal.advanceTo(relay.now);
    const test::AllocationScope scope;
    relay.session->step(relay.now, kUnixNow);
    allocations += scope.count();
    stepsThatAllocate += scope.count() > 0 ? 1 : 0;
  }
  EXPECT_EQ(relay.session->counters().relayedParts - before, 1000u);
  EXPECT_EQ(relay.session->counters().expiries, 0u);
  // In these four seconds, the pose of a moving part goes into the journal once a second.
  EXPECT_LE(stepsThatAllocate, 4) << allocations << " allocations";
  // The control: a step whose allocations the counter must count.
  const test::AllocationScope scope;
  relay.transport.control(2, Grab{1, 0});
  relay.step();
  EXPECT_GT(scope.count(), 0u);
}

TEST(Relay, RecordsWhatItRelays) {
  std::string pattern = (std::filesystem::temp_directory_path() / "tandem-relay-XXXXXX").string();
  const int file = ::mkstemp(pattern.data());
  ASSERT_GE(file, 0);
  ::close(file);
  {
    auto writer = RecordingWriter::create(pattern, {{}, wireFrame({glm::dvec3(-0.5), glm::dvec3(0.5)})});
    ASSERT_TRUE(writer.ok()) << writer.error().message;
    Relay relay(&*writer);
    for (int i = 0; i < 50; ++i) relay.relayOne();
  }
  auto reader = RecordingReader::open(pattern);
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  int updates = 0, grants = 0;
  while (const auto entry = reader->next()) {
    if (const auto* state = std::get_if<StateMessage>(&entry->message)) {
      const auto* update = std::get_if<StateUpdate>(state);
      ASSERT_NE(update, nullptr);
      ASSERT_EQ(update->parts.size(), 1u);
      EXPECT_EQ(update->site, 1u);
      ++updates;
    } else if (const auto* changed =
                   std::get_if<OwnershipChanged>(&std::get<ControlMessage>(entry->message))) {
      grants += changed->part.owner == 1 ? 1 : 0;
    }
  }
  EXPECT_EQ(reader->damaged(), "");
  EXPECT_EQ(updates, 50);
  EXPECT_EQ(grants, 1);
  std::filesystem::remove(pattern);
}

/// The parts that reach site 2 of sixty moving ones of site 1. Site 2 has acknowledged nothing, so they do
/// not all fit.
std::vector<PartId> partsThatReach(Relay& relay, const std::optional<Presence>& presence) {
  const WireFrame frame = wireFrame(relay.scene.bounds);
  for (PartId part = 1; part < 60; ++part) {
    relay.transport.control(1, Grab{1u + part, part});
    relay.step();
    relay.step();
  }
  StateUpdate view;
  view.sequence = 1;
  view.time = relay.session->sessionTime();
  if (presence) {
    view.presence = *presence;
    encodeState(view, frame, relay.bytes);
    relay.transport.state(2, relay.bytes);
    relay.step();
  }
  StateSender sender;
  StateReceiver receiver;
  StateMessage message;
  std::vector<PartId> reached;
  for (int round = 0; round < 60; ++round) {
    relay.pingNow(round);
    StateUpdate update;
    update.site = 1;
    update.sequence = ++relay.sequence;
    update.time = relay.session->sessionTime();
    update.newPresence = round == 0;
    for (PartId part = 0; part < 60; ++part) {
      PartState state;
      state.part = part;
      state.epoch = relay.session->ownership().part(part).epoch;
      state.sequence = update.sequence;
      state.worldFromPart.position = {0.002 * part, 0.0, part % 2 == 0 ? -0.3 : 0.3};
      state.twist.linear.x = 0.1;
      update.parts.push_back(state);
    }
    sender.encode(update, frame, relay.bytes);
    relay.transport.state(1, relay.bytes);
    relay.step();
    if (decodeState(relay.transport.lastTo(1), frame, message))
      if (const auto* ack = std::get_if<StateAck>(&message)) sender.acknowledged(*ack);
    if (receiver.decode(relay.transport.lastTo(2), frame, message) != StateReceiver::Outcome::decoded)
      continue;
    reached.clear();
    for (const PartState& state : std::get<StateUpdate>(message).parts) reached.push_back(state.part);
  }
  return reached;
}

TEST(Relay, WhatAReceiverTouchesAndLooksAtGoesFirst) {
  const auto has = [](const std::vector<PartId>& parts, PartId part) {
    return std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  Presence presence;  // its camera looks along -z, at the even ones
  presence.touched = 51;
  Relay relay(nullptr, 60);
  const std::vector<PartId> reached = partsThatReach(relay, presence);
  ASSERT_GT(reached.size(), 31u);
  ASSERT_LT(reached.size(), 60u);
  EXPECT_TRUE(has(reached, 51));
  for (PartId part = 0; part < 60; part += 2) EXPECT_TRUE(has(reached, part)) << part;
  // Control: for a camera that looks in the other direction it sends others.
  presence.worldFromCamera.orientation = fromRotationVector({0.0, 3.14159265358979, 0.0});
  Relay turned(nullptr, 60);
  const std::vector<PartId> others = partsThatReach(turned, presence);
  EXPECT_TRUE(has(others, 51));
  EXPECT_FALSE(has(others, 0));
}

TEST(Relay, CountsBytesByWhatTheyAreFor) {
  Relay relay;
  const Traffic before = relay.session->counters().received;
  for (int i = 0; i < 50; ++i) relay.relayOne();
  relay.pingNow(0);
  const SessionCounters& counts = relay.session->counters();
  EXPECT_EQ(counts.received.parts.packets - before.parts.packets, 50u);
  EXPECT_EQ(counts.received.presence.bytes - before.presence.bytes, 50u * 40);
  EXPECT_EQ(counts.received.pings.packets, 1u);
  EXPECT_EQ(counts.sent.pings.packets, 1u);
  EXPECT_EQ(counts.sent.parts.packets, 150u) << "to three others";
  EXPECT_GT(counts.sent.control.bytes, counts.received.control.bytes);
  EXPECT_EQ(counts.received.unknown.packets, 0u);
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0, end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
    lines.push_back(text.substr(at, end - at));
  return lines;
}

TEST(Invitations, ReplaceAUsedLinkByANewOneOfItsRole) {
  Relay relay;
  Options options;
  options.invites = {0, 2, 0};
  Invitations invitations(options, "127.0.0.1", 7480, std::string(64, 'a'));
  testing::internal::CaptureStdout();
  invitations.open(*relay.session, kUnixNow);
  const auto first = linesOf(testing::internal::GetCapturedStdout());
  ASSERT_EQ(first.size(), 2u);
  EXPECT_NE(first[0], first[1]);
  testing::internal::CaptureStdout();
  invitations.renew(*relay.session, {}, kUnixNow);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  testing::internal::CaptureStdout();
  invitations.renew(*relay.session, {Role::participant, Role::observer}, kUnixNow);
  const auto second = linesOf(testing::internal::GetCapturedStdout());
  ASSERT_EQ(second.size(), 1u);  // this run printed no link for observers, so none is replaced
  EXPECT_EQ(second[0].rfind("participant ", 0), 0u);
  EXPECT_NE(second[0], first[0]);
  EXPECT_NE(second[0], first[1]);
}

}  // namespace
}  // namespace tandem::server
