// Reports of impossible motions: passed on with the name of who says so, bounded, and believed by nobody.

#include "server/motion_reports.h"

#include <gtest/gtest.h>

#include "assets/scene/scene.h"
#include "server/journal/memory_journal.h"
#include "server/session.h"
#include "sync/transport/virtual_network.h"
#include "sync/wire/wire.h"

namespace tandem::server {
namespace {

using namespace sync;

constexpr std::int64_t kUnix = 1700000000;

struct Site {
  std::unique_ptr<Transport> transport;
  SiteId id = kNoSite;
  std::vector<MotionReported> reported;
  bool closed = false;
  std::uint32_t pings = 0;

  void send(const ControlMessage& message) { transport->sendControl(0, encodeControl(message)); }
  void step(Micros now) {
    TransportEvent event;
    while (transport->poll(event)) {
      closed = closed || event.kind == TransportEvent::Kind::closed;
      if (event.kind != TransportEvent::Kind::control) continue;
      const auto message = decodeControl(event.bytes);
      if (const auto* welcome = std::get_if<Welcome>(&*message)) id = welcome->site;
      if (const auto* report = std::get_if<MotionReported>(&*message)) reported.push_back(*report);
    }
    if (now % (100 * kMillisecond) != 0 || id == kNoSite) return;
    std::vector<std::byte> bytes;
    encodeState(Ping{++pings, now}, WireFrame{}, bytes);
    transport->sendState(0, bytes);
  }
};

/// Ann owns part 0; Ben, Cem and an instructor look on.
struct Reports {
  assets::Scene scene;
  VirtualNetwork network{1, NetworkConditions{2 * kMillisecond, 0, 0, 0, 0}};
  MemoryJournal journal;
  std::unique_ptr<Transport> transport = network.listen();
  std::vector<std::byte> package{std::byte{1}};
  std::unique_ptr<Session> session;
  Site ann, ben, cem, instructor;
  Micros now = 0;

  Reports() {
    scene.bounds = {glm::dvec3(-0.5), glm::dvec3(0.5)};
    scene.parts.resize(2);
    for (assets::Part& part : scene.parts) part.movable = true;
    SessionConfig config;
    config.key.seed.fill(7);
    session = std::make_unique<Session>(scene, package, config, *transport, journal, nullptr, now, kUnix);
    for (Site* site : {&ann, &ben, &cem, &instructor}) {
      site->transport = network.connect("site");
      run(20 * kMillisecond);
      const Role role = site == &instructor ? Role::instructor : Role::participant;
      site->send(Hello{kProtocolVersion, false, session->makeToken(role, kUnix + 3600), "site", {1, 2, 3}});
      run(40 * kMillisecond);
      site->send(Ready{});
    }
    ann.send(Grab{1, 0});
    run(100 * kMillisecond);
    EXPECT_EQ(session->ownership().part(0).owner, ann.id);
  }
  void run(Micros length) {
    for (const Micros end = now + length; now < end;) {
      now += kMillisecond;
      network.advanceTo(now);
      journal.advanceTo(now);
      session->step(now, kUnix + now / kSecond);
      for (Site* site : {&ann, &ben, &cem, &instructor})
        if (site->transport) site->step(now);
    }
  }
};

TEST(MotionReports, AreToldToEverybodyWithWhoSaysSo) {
  Reports rig;
  rig.ben.send(MotionReport{0, rig.ann.id});
  rig.run(100 * kMillisecond);
  for (const Site* site : {&rig.ann, &rig.cem, &rig.instructor}) {
    ASSERT_EQ(site->reported.size(), 1u);
    EXPECT_EQ(site->reported[0].reporter, rig.ben.id);
    EXPECT_EQ(site->reported[0].site, rig.ann.id);
    EXPECT_EQ(site->reported[0].part, 0u);
  }
  EXPECT_EQ(rig.session->ownership().part(0).owner, rig.ann.id) << "nothing else follows from it";
  EXPECT_FALSE(rig.ann.closed);
}

TEST(MotionReports, ThatCannotBeTrueAreDropped) {
  Reports rig;
  rig.ben.send(MotionReport{1, rig.ann.id});        // which she does not own
  rig.ben.send(MotionReport{0, rig.cem.id});        // the same
  rig.ben.send(MotionReport{1, kNoSite});           // nobody's
  rig.ben.send(MotionReport{kNoPart, rig.ann.id});  // no part
  rig.ben.send(MotionReport{999, rig.ann.id});
  rig.ann.send(MotionReport{0, rig.ann.id});  // of herself
  rig.run(200 * kMillisecond);
  EXPECT_TRUE(rig.instructor.reported.empty());
  EXPECT_EQ(rig.session->counters().droppedReports, 6u);
  EXPECT_FALSE(rig.ben.closed);
}

TEST(MotionReports, OfOneSiteAreTooFewToFloodAnybody) {
  Reports rig;
  for (int i = 0; i < 300; ++i) {
    rig.ben.send(MotionReport{0, rig.ann.id});
    rig.run(37 * kMillisecond);
  }
  EXPECT_GE(rig.instructor.reported.size(), 2u);
  EXPECT_LE(rig.instructor.reported.size(), 3u) << "in 11 s";
  rig.cem.send(MotionReport{0, rig.ann.id});
  rig.run(100 * kMillisecond);
  EXPECT_EQ(rig.instructor.reported.back().reporter, rig.cem.id) << "another site is heard";
}

}  // namespace
}  // namespace tandem::server
