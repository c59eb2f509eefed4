#pragma once

// A server session and its sites on one virtual network, for tests.

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/journal/memory_journal.h"
#include "server/session.h"
#include "sync/transport/virtual_network.h"
#include "sync/wire/site_colours.h"
#include "tests/support/fake_site.h"

namespace tandem::server {

using namespace sync;
using test::FakeSite;

inline constexpr std::int64_t kUnix = 1000000;

/// A server and its sites on one virtual network; the journal outlives the server, as a disk does.
struct SessionRig {
  assets::Scene scene;
  std::vector<std::byte> package;
  SessionConfig config;
  VirtualNetwork network{1, NetworkConditions{10 * kMillisecond, 0, 0, 0, 0}};
  MemoryJournal journal{2 * kMillisecond};
  std::unique_ptr<Transport> transport;
  std::unique_ptr<Session> session;
  std::vector<std::unique_ptr<FakeSite>> sites;
  Micros now = 0;
  std::int64_t wallStep = 0;  // s, by which the wall clock was put forward
  bool pinging = true;

  explicit SessionRig(const Places& places = {}, const std::optional<SigningKey>& linkKey = {}) {
    scene.bounds = {glm::dvec3(-0.5), glm::dvec3(0.5)};
    for (int i = 0; i < 3; ++i) {
      assets::Part part;
      part.name = "part" + std::to_string(i);
      part.movable = i < 2;
      part.worldFromPart.position.x = 0.1 * i;
      scene.parts.push_back(part);
    }
    for (int i = 0; i < 200000; ++i) package.push_back(static_cast<std::byte>(i * 7));
    config.key = SigningKey({7});
    config.linkKey = linkKey;
    config.places = places;
    config.maxBacklogBytes = 64 * 1024;
    start();
  }
  virtual ~SessionRig() = default;
  void start() {
    transport = network.listen();
    session = std::make_unique<Session>(scene, package, config, *transport, journal, nullptr, now,
                                        kUnix + wallStep + now / kSecond);
  }
  void crash() {
    session.reset();
    transport.reset();
    journal.crash();
  }
  void run(Micros length) {
    for (const Micros end = now + length; now < end;) {
      now += kMillisecond;
      network.advanceTo(now);
      journal.advanceTo(now);
      if (session) session->step(now, kUnix + wallStep + now / kSecond);
      afterStep();
      for (auto& site : sites) {
        if (site->transport == nullptr) continue;
        site->listen();
        if (pinging && now % (100 * kMillisecond) == 0 && site->last<Welcome>() != nullptr && !site->closed)
          site->ping(now);
      }
    }
  }
  /// Is called in every millisecond after the session's step.
  virtual void afterStep() {}
  FakeSite& connect(const std::string& name) {
    sites.push_back(std::make_unique<FakeSite>());
    sites.back()->frame = wireFrame(scene.bounds);
    sites.back()->transport = network.connect(name);
    run(30 * kMillisecond);
    return *sites.back();
  }
  std::string token(Role role) { return session->makeToken(role, kUnix + 3600); }
  FakeSite& join(const std::string& name, Role role = Role::participant, SiteColour colour = {1, 2, 3}) {
    FakeSite& site = connect(name);
    site.send(Hello{kProtocolVersion, false, token(role), name, colour});
    run(40 * kMillisecond);
    EXPECT_NE(site.last<Welcome>(), nullptr);
    site.send(Ready{});
    run(20 * kMillisecond);
    return site;
  }
  FakeSite& resume(const std::string& name, const std::string& ticket, SiteColour colour = {1, 2, 3}) {
    FakeSite& site = connect(name);
    site.send(Hello{kProtocolVersion, true, ticket, name, colour});
    run(40 * kMillisecond);
    EXPECT_NE(site.last<Welcome>(), nullptr);
    site.send(Ready{});
    run(20 * kMillisecond);
    return site;
  }
  GrabReply grab(FakeSite& site, PartId part, RequestId request) {
    site.send(Grab{request, part});
    run(40 * kMillisecond);
    const auto* reply = site.last<GrabReply>();
    EXPECT_NE(reply, nullptr);
    return reply == nullptr ? GrabReply{} : *reply;
  }
  StateUpdate update(FakeSite& site, PartId part, Epoch epoch, double x) {
    StateUpdate u;
    u.sequence = ++site.sequence;
    u.time = session->sessionTime();
    PartState state;
    state.part = part;
    state.epoch = epoch;
    state.sequence = site.sequence;
    state.worldFromPart.position.x = x;
    u.parts.push_back(state);
    return u;
  }
  Refusal refusalOf(const Hello& hello) {
    FakeSite& site = connect("stranger" + std::to_string(sites.size()));
    site.send(hello);
    run(60 * kMillisecond);
    const auto* refused = site.last<Refused>();
    EXPECT_NE(refused, nullptr);
    EXPECT_TRUE(site.closed);
    EXPECT_EQ(site.last<Welcome>(), nullptr);
    return refused == nullptr ? Refusal::unexpectedMessage : refused->refusal;
  }
};

}  // namespace tandem::server
