// A site that takes long to make a scene ready receives what happens meanwhile.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "client/session/server_connection.h"
#include "server/journal/memory_journal.h"
#include "server/session.h"
#include "sync/transport/virtual_network.h"
#include "sync/wire/recording.h"
#include "tests/support/fake_site.h"

namespace tandem::client {
namespace {

using namespace sync;
constexpr std::int64_t kUnix = 1000000;

/// A server, another site that is ready, and a connection that still makes its scene ready.
struct Loading {
  assets::Scene scene;
  std::vector<std::byte> package = std::vector<std::byte>(100);
  VirtualNetwork network{1, NetworkConditions{10 * kMillisecond, 0, 0, 0, 0}};
  server::MemoryJournal journal{kMillisecond};
  std::unique_ptr<Transport> transport;
  std::unique_ptr<server::Session> session;
  std::unique_ptr<ServerConnection> connection;
  test::FakeSite other;
  Exchange exchange;
  Micros now = 0;

  Loading() {
    scene.bounds = {glm::dvec3(-0.5), glm::dvec3(0.5)};
    for (int i = 0; i < 3; ++i) {
      assets::Part part;
      part.name = "part" + std::to_string(i);
      part.movable = true;
      scene.parts.push_back(part);
    }
    server::SessionConfig config;
    config.key = server::SigningKey({7});
    transport = network.listen();
    session =
        std::make_unique<server::Session>(scene, package, config, *transport, journal, nullptr, now, kUnix);
    ConnectionOptions options;
    options.name = "loading";
    options.token = session->makeToken(Role::participant, kUnix + 3600);
    connection = std::make_unique<ServerConnection>(
        options, [this]() -> Result<std::unique_ptr<Transport>> { return network.connect("loading"); });
    join(other, "other");
    other.send(Ready{});
    run(40 * kMillisecond);
  }
  /// Another site enters the session; it is not ready yet.
  void join(test::FakeSite& site, const std::string& name) {
    site.frame = wireFrame(scene.bounds);
    site.transport = network.connect(name);
    run(30 * kMillisecond);
    site.send(
        Hello{kProtocolVersion, false, session->makeToken(Role::participant, kUnix + 3600), name, {1, 2, 3}});
    run(40 * kMillisecond);
  }
  void run(Micros length) {
    for (const Micros end = now + length; now < end;) {
      now += kMillisecond;
      network.advanceTo(now);
      journal.advanceTo(now);
      session->step(now, kUnix + now / kSecond);
      other.listen();
      connection->step(now);
      if (connection->stage() == ServerConnection::Stage::needScene) connection->skipTransfer();
      if (other.last<Welcome>() != nullptr && now % (100 * kMillisecond) == 0) other.ping(now);
    }
  }
};

TEST(LoadingSite, KnowsWhoTookAPartWhileItMadeTheSceneReady) {
  Loading rig;
  ASSERT_EQ(rig.connection->stage(), ServerConnection::Stage::haveScene);
  for (const PartId part : {PartId{0}, PartId{1}}) rig.other.send(Grab{RequestId{1u + part}, part});
  rig.run(60 * kMillisecond);
  Pose left;
  left.position.x = 0.2;
  rig.other.send(Release{9, 1, rig.session->ownership().part(1).epoch, left});
  rig.run(60 * kMillisecond);
  ASSERT_EQ(rig.session->ownership().part(1).owner, kNoSite);

  rig.connection->sceneReady(rig.scene, rig.exchange);
  rig.run(60 * kMillisecond);
  ASSERT_EQ(rig.connection->stage(), ServerConnection::Stage::ready);
  EXPECT_EQ(rig.connection->owner(0), rig.other.last<Welcome>()->site);
  EXPECT_EQ(rig.connection->owner(1), kNoSite);
  EXPECT_EQ(rig.connection->statistics().malformed, 0u);
  double x = 0.0;
  NetworkEvent event;
  while (rig.exchange.events.pop(event))
    if (event.kind == NetworkEvent::Kind::ownership && event.record.part == 1)
      x = event.record.worldFromPart.position.x;
  EXPECT_NEAR(x, 0.2, 1e-6) << "where the other left it";
}

TEST(LoadingSite, RecordsWhoJoinedWhileItMadeTheSceneReady) {
  Loading rig;
  test::FakeSite late;
  rig.join(late, "late");
  rig.run(20 * kMillisecond);
  ASSERT_EQ(rig.connection->sites().size(), 3u);

  const std::string path = testing::TempDir() + "loading_site.rec";
  auto recording = RecordingWriter::create(path, {{}, wireFrame(rig.scene.bounds)});
  ASSERT_TRUE(recording.ok());
  rig.connection->setRecording(&*recording);
  rig.connection->sceneReady(rig.scene, rig.exchange);
  rig.run(60 * kMillisecond);
  rig.connection->setRecording(nullptr);
  ASSERT_TRUE(recording->flush().ok());
  auto reader = RecordingReader::open(recording->path());
  ASSERT_TRUE(reader.ok());
  std::vector<std::string> names;
  while (const auto entry = reader->next()) {
    const auto* message = std::get_if<ControlMessage>(&entry->message);
    const auto* changed = message == nullptr ? nullptr : std::get_if<SiteChanged>(message);
    if (changed != nullptr) names.push_back(changed->site.name);
  }
  EXPECT_EQ(std::count(names.begin(), names.end(), "late"), 1);
  std::remove(recording->path().c_str());
}

TEST(LoadingSite, CountsNoLossWhereSeveralSendAndNothingIsLost) {
  Loading rig;
  test::FakeSite third;
  rig.join(third, "third");
  third.send(Ready{});
  rig.connection->sceneReady(rig.scene, rig.exchange);
  EXPECT_EQ(rig.connection->statistics().roundTrip_ms, 0.0);
  for (int i = 0; i < 100; ++i) {
    for (test::FakeSite* site : {&rig.other, &third}) {
      StateUpdate update;
      update.sequence = ++site->sequence;
      update.time = rig.now;
      site->send(update);
    }
    rig.run(4 * kMillisecond);
  }
  EXPECT_GT(rig.connection->statistics().roundTrip_ms, 0.0);
  EXPECT_GT(rig.connection->statistics().receivedUpdates, 150u);
  EXPECT_EQ(rig.connection->statistics().lossDown, 0.0) << "two senders are no loss";
  EXPECT_EQ(rig.connection->statistics().lossUp, 0.0);
}

}  // namespace
}  // namespace tandem::client
