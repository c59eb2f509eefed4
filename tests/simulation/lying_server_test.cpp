// What a server that lies can make a site do: nothing that exhausts its memory or takes a part out of reach.

#include <gtest/gtest.h>

#include <memory>

#include "client/session/server_connection.h"
#include "sync/transport/virtual_network.h"
#include "sync/wire/wire.h"

namespace tandem::client {
namespace {

using namespace sync;

/// A site, and a server that says what a test gives it.
struct Lied {
  assets::Scene scene;
  VirtualNetwork network{1, NetworkConditions{2 * kMillisecond, 0, 0, 0, 0}};
  std::unique_ptr<Transport> server = network.listen();
  std::unique_ptr<ServerConnection> site;
  Exchange exchange;
  ConnectionId peer = 0;
  Micros now = 0;
  bool asked = false;  // for the scene

  explicit Lied(const ConnectionOptions& options = {}) {
    scene.bounds = {glm::dvec3(-0.5), glm::dvec3(0.5)};
    scene.parts.resize(1);
    scene.parts[0].movable = true;
    scene.parts[0].worldFromPart.position.x = 0.1;
    site = std::make_unique<ServerConnection>(
        options, [this]() -> Result<std::unique_ptr<Transport>> { return network.connect("site"); });
    run(20 * kMillisecond);
  }
  void run(Micros length) {
    for (const Micros end = now + length; now < end;) {
      now += kMillisecond;
      network.advanceTo(now);
      TransportEvent event;
      while (server->poll(event)) {
        if (event.kind == TransportEvent::Kind::connected) peer = event.connection;
        if (event.kind != TransportEvent::Kind::control) continue;
        const auto message = decodeControl(event.bytes);
        asked = asked || (message && std::holds_alternative<SceneRequest>(*message));
      }
      site->step(now);
    }
  }
  void say(const ControlMessage& message) {
    server->sendControl(peer, encodeControl(message));
    run(10 * kMillisecond);
  }
  static Welcome welcome(std::uint64_t sceneBytes) {
    Welcome welcome;
    welcome.site = 1;
    welcome.role = Role::participant;
    welcome.resumeTicket = "ticket";
    welcome.sceneBytes = sceneBytes;
    welcome.lease = kSecond;
    return welcome;
  }
};

TEST(LyingServer, IsLeftWhenItsSceneIsLargerThanTheSiteTakes) {
  for (const std::uint64_t bytes : {std::uint64_t{1} << 33, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
    Lied rig;
    rig.say(Lied::welcome(bytes));
    EXPECT_EQ(rig.site->stage(), ServerConnection::Stage::ended) << bytes;
    EXPECT_NE(rig.site->reason().find("--max-scene"), std::string::npos) << rig.site->reason();
  }
  Lied rig;
  rig.say(Lied::welcome(std::uint64_t{1} << 30));
  EXPECT_EQ(rig.site->stage(), ServerConnection::Stage::needScene);
}

TEST(LyingServer, ReservesNoMemoryForBytesThatDoNotCome) {
  ConnectionOptions options;
  options.maxSceneBytes = ~std::uint64_t{0};
  Lied rig(options);
  rig.say(Lied::welcome(std::uint64_t{1} << 40));
  ASSERT_EQ(rig.site->stage(), ServerConnection::Stage::needScene);
  rig.site->startTransfer({});
  rig.run(10 * kMillisecond);
  EXPECT_TRUE(rig.asked);
  EXPECT_LE(rig.site->scenePackage().capacity(), std::size_t{1} << 27);
}

TEST(LyingServer, BringsNobodyBackWhoHasLeft) {
  Lied rig;
  rig.server->sendControl(rig.peer, encodeControl(Lied::welcome(0)));
  rig.server->close(rig.peer);
  rig.now += 10 * kMillisecond;
  rig.network.advanceTo(rig.now);  // the Welcome waits to be read on a connection that is over
  rig.site->leave();
  rig.run(10 * kMillisecond);
  EXPECT_EQ(rig.site->stage(), ServerConnection::Stage::ended);
  EXPECT_EQ(rig.site->reason(), "left");
}

TEST(LyingServer, TakesNoPartOutOfReach) {
  Lied rig;
  rig.say(Lied::welcome(0));
  ASSERT_EQ(rig.site->stage(), ServerConnection::Stage::needScene);
  rig.site->skipTransfer();
  rig.site->sceneReady(rig.scene, rig.exchange);
  rig.run(10 * kMillisecond);
  ASSERT_EQ(rig.site->stage(), ServerConnection::Stage::ready);
  const auto poseAfter = [&](double x, Epoch epoch) {
    PartRecord record{0, 2, epoch, {}};
    record.worldFromPart.position.x = x;
    rig.say(OwnershipChanged{record});
    double shown = -1.0;
    NetworkEvent event;
    while (rig.exchange.events.pop(event))
      if (event.kind == NetworkEvent::Kind::ownership) shown = event.record.worldFromPart.position.x;
    return shown;
  };
  EXPECT_EQ(poseAfter(0.3, 1), 0.3);
  EXPECT_EQ(poseAfter(9.9e8, 2), 0.1) << "the pose in the scene";
}

}  // namespace
}  // namespace tandem::client
