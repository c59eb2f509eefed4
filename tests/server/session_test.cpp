#include "server/session.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "server/memory_journal.h"
#include "sync/transport/virtual_network.h"
#include "sync/wire/site_colours.h"
#include "tests/support/fake_site.h"

namespace tandem::server {
namespace {

using namespace sync;
using test::FakeSite;

constexpr std::int64_t kUnix = 1000000;

/// A server and its sites on one virtual network; the journal outlives the server, as a disk does.
struct Rig {
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

  explicit Rig(const Places& places = {}) {
    scene.bounds = {glm::dvec3(-0.5), glm::dvec3(0.5)};
    for (int i = 0; i < 3; ++i) {
      assets::Part part;
      part.name = "part" + std::to_string(i);
      part.movable = i < 2;
      part.worldFromPart.position.x = 0.1 * i;
      scene.parts.push_back(part);
    }
    for (int i = 0; i < 200000; ++i) package.push_back(static_cast<std::byte>(i * 7));
    config.key.seed.fill(7);
    config.places = places;
    config.maxBacklogBytes = 64 * 1024;
    start();
  }
  void start() {
    transport = network.listen();
    session = std::make_unique<Session>(scene, package, config, *transport, journal, nullptr, now, kUnix);
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
      for (auto& site : sites) {
        if (site->transport == nullptr) continue;
        site->listen();
        if (pinging && now % (100 * kMillisecond) == 0 && site->last<Welcome>() != nullptr && !site->closed)
          site->ping(now);
      }
    }
  }
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

TEST(Session, RefusesEachBadHelloForItsReason) {
  Rig rig;
  const std::string good = rig.token(Role::participant);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion + 1, false, good, "a", {}}), Refusal::protocolVersion);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, "nonsense", "a", {}}), Refusal::badCredential);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, true, good, "a", {}}), Refusal::badCredential);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, rig.session->makeToken(Role::observer, kUnix), "a", {}}),
            Refusal::expired);
  EXPECT_EQ(rig.session->counters().refusedHellos, 4u);
  EXPECT_TRUE(rig.session->sites().empty());
}

TEST(Session, LetsATokenInOnceAlsoAcrossACrash) {
  Rig rig;
  const std::string token = rig.token(Role::participant);
  FakeSite& a = rig.connect("a");
  a.send(Hello{kProtocolVersion, false, token, "a", {}});
  rig.run(50 * kMillisecond);
  ASSERT_NE(a.last<Welcome>(), nullptr);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, token, "b", {}}), Refusal::alreadyUsed);
  rig.crash();
  rig.start();
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, token, "c", {}}), Refusal::alreadyUsed);
}

TEST(Session, ObserversTakeNobodysPlace) {
  for (const int observers : {16, 100}) {
    Rig rig;
    rig.pinging = false;
    for (int i = 0; i < observers; ++i) {
      FakeSite& site = rig.connect("o" + std::to_string(i));
      site.send(Hello{kProtocolVersion, false, rig.token(Role::observer), "o", {}});
    }
    rig.run(60 * kMillisecond);
    ASSERT_EQ(rig.session->sites().size(), static_cast<std::size_t>(observers));
    rig.join("participant");
    rig.join("instructor", Role::instructor);
  }
}

TEST(Session, SaysWhichPlacesAreTakenAndKeepsOneForAnInstructor) {
  Rig rig(Places{2, 1});
  const auto refused = [&](Role role) {
    EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, rig.token(role), "late", {}}), Refusal::sessionFull);
    return rig.sites.back()->last<Refused>()->reason;
  };
  rig.join("a");
  rig.join("b");
  EXPECT_EQ(refused(Role::participant), "the session is full: all 2 places for participants are taken");
  rig.join("observer", Role::observer);
  EXPECT_EQ(refused(Role::observer), "the session is full: all 1 places for observers are taken");
  rig.join("instructor", Role::instructor);
  EXPECT_EQ(refused(Role::instructor),
            "the session is full: all 2 places for participants and the one kept for an instructor are "
            "taken");
  EXPECT_EQ(refused(Role::participant), "the session is full: all 2 places for participants are taken");
}

TEST(Session, APlaceIsFreeAsSoonAsItsConnectionEndsAndWhoComesBackNeedsOne) {
  Rig rig(Places{1, 0});
  FakeSite& lost = rig.join("lost");
  const std::string ticket = lost.last<Welcome>()->resumeTicket;
  rig.resume("lost again", ticket);  // its own former connection is in nobody's way
  rig.sites.back()->transport.reset();
  rig.run(kSecond);
  FakeSite& other = rig.join("other");
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, true, ticket, "lost", {}}), Refusal::sessionFull);
  other.send(Goodbye{});
  rig.run(50 * kMillisecond);
  rig.resume("lost", ticket);
}

TEST(Session, A65thParticipantIsRefusedByDefault) {
  Rig rig;
  rig.pinging = false;
  for (int i = 0; i < 64; ++i) {
    FakeSite& site = rig.connect("p" + std::to_string(i));
    site.send(Hello{kProtocolVersion, false, rig.token(Role::participant), "p", {}});
  }
  rig.run(60 * kMillisecond);
  ASSERT_EQ(rig.session->sites().size(), 64u);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, rig.token(Role::participant), "p65", {}}),
            Refusal::sessionFull);
  EXPECT_EQ(rig.sites.back()->last<Refused>()->reason,
            "the session is full: all 64 places for participants are taken");
  rig.join("instructor", Role::instructor);
  rig.join("observer", Role::observer);
}

TEST(Session, GivesSimultaneousGrabsOneWinnerKnownToAll) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b"), &c = rig.join("c", Role::observer);
  a.send(Grab{1, 0});
  b.send(Grab{1, 0});
  rig.run(50 * kMillisecond);
  const auto *ra = a.last<GrabReply>(), *rb = b.last<GrabReply>();
  ASSERT_TRUE(ra != nullptr && rb != nullptr);
  EXPECT_EQ((ra->denial == Denial::none) + (rb->denial == Denial::none), 1);
  EXPECT_TRUE(ra->denial == Denial::ownedByOther || rb->denial == Denial::ownedByOther);
  for (const FakeSite* site : {&a, &b, &c}) {
    ASSERT_EQ(site->count<OwnershipChanged>(), 1u);
    EXPECT_EQ(site->last<OwnershipChanged>()->part.owner, ra->part.owner);
  }
}

TEST(Session, PassesAPartOnToItsCoHolder) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b"), &c = rig.join("c", Role::observer);
  const GrabReply held = rig.grab(a, 0, 1);
  b.send(Engage{1, 0});
  c.send(Engage{1, 0});
  rig.run(40 * kMillisecond);
  EXPECT_EQ(c.last<EngageReply>()->denial, Denial::roleForbids);
  const SiteId ben = b.last<Welcome>()->site;
  for (const FakeSite* site : {&a, &b, &c}) {
    ASSERT_EQ(site->count<MembersChanged>(), 1u);
    EXPECT_EQ(site->last<MembersChanged>()->coHolders.sites, std::vector<SiteId>{ben});
  }
  a.send(Release{2, 0, held.part.epoch, {}});
  rig.run(40 * kMillisecond);
  for (const FakeSite* site : {&a, &b, &c}) {
    EXPECT_EQ(site->last<OwnershipChanged>()->part.owner, ben);
    EXPECT_EQ(site->last<OwnershipChanged>()->part.epoch, held.part.epoch + 1);
    EXPECT_TRUE(site->last<MembersChanged>()->coHolders.sites.empty());
    EXPECT_EQ(site->last<MembersChanged>()->coHolders.epoch, held.part.epoch + 1);
  }
}

TEST(Session, PassesLinksOnBetweenThoseThatAPartTies) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b"), &c = rig.join("c");
  const SiteId ann = a.last<Welcome>()->site, ben = b.last<Welcome>()->site;
  rig.grab(a, 0, 1);
  LinkUpdate link;
  link.part = 0;
  link.epoch = 3;
  link.energy = 77;
  const auto sendLink = [&](FakeSite& from, SiteId to) {
    link.peer = to;
    from.send(link);
    rig.run(40 * kMillisecond);
  };
  sendLink(b, ann);
  EXPECT_EQ(rig.session->counters().droppedLinks, 1u) << "not a co-holder yet";
  b.send(Engage{1, 0});
  rig.run(40 * kMillisecond);
  sendLink(b, ann);
  ASSERT_EQ(a.links.size(), 1u);
  EXPECT_EQ(a.links[0].peer, ben);
  EXPECT_EQ(a.links[0].energy, 77u);
  sendLink(a, ben);
  ASSERT_EQ(b.links.size(), 1u);
  EXPECT_EQ(b.links[0].peer, ann);
  sendLink(c, ann);
  sendLink(b, 999);
  link.part = 9999;
  sendLink(b, ann);
  EXPECT_EQ(rig.session->counters().droppedLinks, 4u);
  EXPECT_TRUE(c.links.empty());
}

TEST(Session, SendsTheCoHoldersToASiteThatJoinsLater) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  rig.grab(a, 0, 1);
  b.send(Engage{1, 0});
  rig.run(40 * kMillisecond);
  FakeSite& c = rig.join("c");
  ASSERT_EQ(c.count<MembersChanged>(), 1u);
  EXPECT_EQ(c.last<MembersChanged>()->coHolders, b.last<MembersChanged>()->coHolders);
}

TEST(Session, AnswersARepeatedRequestAlike) {
  Rig rig;
  FakeSite& a = rig.join("a");
  const auto first = rig.grab(a, 0, 5), again = rig.grab(a, 0, 5);
  EXPECT_EQ(first.part.epoch, again.part.epoch);
  EXPECT_EQ(rig.session->counters().grants, 1u);
}

TEST(Session, HoldsGrantAndDenialUntilTheRecordIsDurable) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const Micros asked = rig.now;
  a.send(Grab{1, 0});
  b.send(Grab{1, 0});
  rig.run(11 * kMillisecond);  // 5 ms to the server, 2 ms to the disk, 5 ms back
  EXPECT_EQ(a.last<GrabReply>(), nullptr) << rig.now - asked;
  EXPECT_EQ(b.last<GrabReply>(), nullptr);
  rig.run(4 * kMillisecond);
  EXPECT_NE(a.last<GrabReply>(), nullptr);
  EXPECT_NE(b.last<GrabReply>(), nullptr);
}

TEST(Session, ChecksRoles) {
  Rig rig;
  FakeSite &o = rig.join("o", Role::observer), &p = rig.join("p"), &i = rig.join("i", Role::instructor);
  EXPECT_EQ(rig.grab(o, 0, 1).denial, Denial::roleForbids);
  EXPECT_EQ(rig.grab(p, 2, 1).denial, Denial::notMovable);
  EXPECT_EQ(rig.grab(p, 99, 2).denial, Denial::unknownPart);
  const auto held = rig.grab(p, 0, 3);
  ASSERT_EQ(held.denial, Denial::none);
  o.send(Release{9, 0, held.part.epoch, {}});
  p.send(Revoke{4, 0});
  rig.run(40 * kMillisecond);
  EXPECT_EQ(o.last<ReleaseReply>()->denial, Denial::roleForbids);
  EXPECT_FALSE(p.last<CommandReply>()->done);
  EXPECT_EQ(rig.session->ownership().part(0).owner, held.part.owner);
  i.send(Revoke{1, 0});
  rig.run(40 * kMillisecond);
  EXPECT_TRUE(i.last<CommandReply>()->done);
  EXPECT_EQ(p.last<OwnershipChanged>()->part.owner, kNoSite);
}

TEST(Session, GrantsAControlOnlyToTheRolesThatMaySetIt) {
  Rig rig;
  assets::Control control;
  control.part = 1;
  control.max = 1.0;
  control.inertia = 1.0;
  control.roles = 1u << static_cast<unsigned>(Role::instructor);
  rig.scene.controls.push_back(control);
  FakeSite &p = rig.join("p"), &i = rig.join("i", Role::instructor);
  const auto refused = rig.grab(p, 1, 1);
  EXPECT_EQ(refused.denial, Denial::roleForbids);
  EXPECT_EQ(refused.part.owner, kNoSite);
  EXPECT_EQ(rig.grab(p, 1, 1).denial, Denial::roleForbids) << "the same request, the same answer";
  EXPECT_EQ(rig.session->ownership().part(1).owner, kNoSite);
  EXPECT_EQ(rig.grab(p, 0, 2).denial, Denial::none) << "other parts are as free as ever";
  EXPECT_EQ(rig.grab(i, 1, 1).denial, Denial::none);
  EXPECT_EQ(rig.session->counters().grants, 2u);
}

TEST(Session, RelaysTheOwnersStateAndNobodyElses) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const auto granted = rig.grab(a, 0, 1);
  a.send(rig.update(a, 0, granted.part.epoch, 0.2));
  rig.run(20 * kMillisecond);
  ASSERT_EQ(b.updates.size(), 1u);
  EXPECT_EQ(b.updates[0].site, granted.part.owner);
  ASSERT_EQ(b.updates[0].parts.size(), 1u);
  EXPECT_NEAR(b.updates[0].parts[0].worldFromPart.position.x, 0.2, 1e-5);
  EXPECT_TRUE(a.updates.empty());
  b.send(rig.update(b, 0, granted.part.epoch, 0.4));      // not the owner
  a.send(rig.update(a, 0, granted.part.epoch + 1, 0.4));  // an epoch that was never granted
  a.send(rig.update(a, 77, granted.part.epoch, 0.4));     // no such part
  rig.run(20 * kMillisecond);
  EXPECT_NEAR(rig.session->ownership().part(0).worldFromPart.position.x, 0.2, 1e-5);
  EXPECT_EQ(rig.session->counters().droppedStates, 2u);
  EXPECT_EQ(rig.session->counters().droppedMalformed, 1u);
}

TEST(Session, FreesALostSitesPartAfterItsLeaseWithItsLastPose) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const auto granted = rig.grab(a, 0, 1);
  a.send(rig.update(a, 0, granted.part.epoch, 0.3));
  rig.run(20 * kMillisecond);
  a.transport.reset();
  rig.run(kSecond);
  EXPECT_EQ(rig.grab(b, 0, 1).denial, Denial::ownedByOther);
  rig.run(2 * kSecond);
  ASSERT_EQ(b.last<OwnershipChanged>()->part.owner, kNoSite);
  EXPECT_NEAR(b.last<OwnershipChanged>()->part.worldFromPart.position.x, 0.3, 1e-5);
  EXPECT_EQ(rig.grab(b, 0, 2).denial, Denial::none);
}

TEST(Session, FreesPartsAtOnceOnGoodbyeAndVoidsTheTicket) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const std::string ticket = a.last<Welcome>()->resumeTicket;
  rig.grab(a, 0, 1);
  a.send(Goodbye{});
  rig.run(40 * kMillisecond);
  EXPECT_EQ(b.last<OwnershipChanged>()->part.owner, kNoSite);
  EXPECT_EQ(b.count<SiteLeft>(), 1u);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, true, ticket, "a", {}}), Refusal::badCredential);
}

TEST(Session, GivesEachSiteThatChoseNoColourOneThatNobodyHas) {
  Rig rig;
  FakeSite& a = rig.join("a", Role::participant, kAnyColour);
  rig.join("b", Role::participant, kSiteColours[1]);
  FakeSite& c = rig.join("c", Role::participant, kAnyColour);
  FakeSite& d = rig.join("d", Role::participant, {9, 8, 7});
  const auto colours = [](FakeSite& site) {
    std::vector<SiteColour> all;
    for (const SiteInfo& info : site.last<Welcome>()->sites) all.push_back(info.colour);
    return all;
  };
  EXPECT_EQ(colours(d),
            (std::vector<SiteColour>{kSiteColours[0], kSiteColours[1], kSiteColours[2], {9, 8, 7}}));
  // A site that leaves frees its colour; a site that comes back has its earlier one.
  const std::string ticket = c.last<Welcome>()->resumeTicket;
  a.send(Goodbye{});
  rig.run(50 * kMillisecond);
  FakeSite& back = rig.resume("c", ticket, kAnyColour);
  EXPECT_EQ(colours(back), (std::vector<SiteColour>{kSiteColours[1], kSiteColours[2], {9, 8, 7}}));
  FakeSite& e = rig.join("e", Role::participant, kAnyColour);
  EXPECT_EQ(colours(e).back(), kSiteColours[0]);
}

TEST(Session, ColoursRepeatOnlyWhenAllAreTaken) {
  Rig rig;
  for (std::size_t i = 0; i < kSiteColours.size() + 2; ++i)
    rig.join(std::to_string(i), Role::participant, kAnyColour);
  std::map<SiteColour, int> uses;
  for (const SiteInfo& info : rig.sites.back()->last<Welcome>()->sites) ++uses[info.colour];
  ASSERT_EQ(uses.size(), kSiteColours.size());
  for (const auto& [colour, count] : uses) EXPECT_LE(count, 2);
}

TEST(Session, ResumesTheSameSiteAndReplacesItsOldConnection) {
  Rig rig;
  FakeSite& a = rig.join("a");
  const SiteId id = a.last<Welcome>()->site;
  const auto granted = rig.grab(a, 0, 1);
  FakeSite& again = rig.resume("a2", a.last<Welcome>()->resumeTicket);
  EXPECT_EQ(again.last<Welcome>()->site, id);
  EXPECT_TRUE(a.closed);
  EXPECT_EQ(rig.session->sites().size(), 1u);
  ASSERT_EQ(again.last<Welcome>()->parts.size(), 1u);
  EXPECT_EQ(again.last<Welcome>()->parts[0].epoch, granted.part.epoch);
  again.send(Reclaim{2, 0, granted.part.epoch, {}});
  rig.run(40 * kMillisecond);
  EXPECT_EQ(again.last<GrabReply>()->denial, Denial::none);
}

TEST(Session, AfterACrashGrantsNothingUntilTheHolderIsBackAndEpochsGrow) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const std::string ticketA = a.last<Welcome>()->resumeTicket, ticketB = b.last<Welcome>()->resumeTicket;
  const Micros before = rig.session->sessionTime();
  const auto held = rig.grab(a, 0, 1);
  rig.crash();
  rig.run(100 * kMillisecond);
  rig.start();
  EXPECT_GE(rig.session->sessionTime(), before);
  FakeSite& b2 = rig.resume("b2", ticketB);
  EXPECT_EQ(rig.grab(b2, 1, 7).denial, Denial::recovering);
  FakeSite& a2 = rig.resume("a2", ticketA);
  a2.send(Reclaim{2, 0, held.part.epoch, held.part.worldFromPart});
  rig.run(40 * kMillisecond);
  EXPECT_EQ(a2.last<GrabReply>()->denial, Denial::none);
  EXPECT_EQ(rig.grab(b2, 1, 8).denial, Denial::none);
  a2.send(Release{3, 0, held.part.epoch, held.part.worldFromPart});
  rig.run(40 * kMillisecond);
  EXPECT_GT(rig.grab(b2, 0, 9).part.epoch, held.part.epoch);
}

TEST(Session, KeepsAReleasedPoseAcrossACrash) {
  Rig rig;
  FakeSite& a = rig.join("a");
  const auto held = rig.grab(a, 0, 1);
  Pose pose;
  pose.position = glm::dvec3(0.25, -0.125, 0.5);
  a.send(Release{2, 0, held.part.epoch, pose});
  rig.run(40 * kMillisecond);
  ASSERT_EQ(a.last<ReleaseReply>()->denial, Denial::none);
  rig.crash();
  rig.start();
  EXPECT_EQ(rig.session->ownership().part(0).worldFromPart.position, pose.position);
  FakeSite& late = rig.join("late");
  ASSERT_EQ(late.last<Welcome>()->parts.size(), 1u);
  EXPECT_EQ(late.last<Welcome>()->parts[0].worldFromPart.position, pose.position);
}

TEST(Session, SendsTheSceneFromTheOffsetAskedFor) {
  Rig rig;
  FakeSite& a = rig.connect("a");
  a.send(Hello{kProtocolVersion, false, rig.token(Role::observer), "a", {}});
  rig.run(40 * kMillisecond);
  for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{123457}}) {
    a.received.clear();
    a.send(SceneRequest{offset});
    rig.run(100 * kMillisecond);
    std::vector<std::byte> got;
    for (const auto& message : a.received)
      if (const auto* chunk = std::get_if<SceneChunk>(&message)) {
        EXPECT_EQ(chunk->offset, offset + got.size());
        for (const std::uint8_t byte : chunk->bytes) got.push_back(std::byte{byte});
      }
    EXPECT_EQ(got, std::vector<std::byte>(rig.package.begin() + static_cast<std::ptrdiff_t>(offset),
                                          rig.package.end()));
  }
  a.send(SceneRequest{rig.package.size() + 1});
  rig.run(60 * kMillisecond);
  EXPECT_TRUE(a.closed);
}

TEST(Session, ClosesOnMessagesOutOfPlaceAndChangesNothing) {
  const ControlMessage wrong[] = {Ready{}, Grab{1, 0}, Welcome{}, GrabReply{}, Goodbye{}, SceneRequest{}};
  for (const auto& message : wrong) {
    Rig rig;
    FakeSite& a = rig.connect("a");
    a.send(message);
    rig.run(60 * kMillisecond);
    EXPECT_TRUE(a.closed);
    EXPECT_TRUE(rig.session->sites().empty());
  }
  const ControlMessage late[] = {Hello{}, Ready{}, SceneRequest{}, OwnershipChanged{}, SiteLeft{3}};
  for (const auto& message : late) {
    Rig rig;
    FakeSite &a = rig.join("a"), &b = rig.join("b");
    const auto held = rig.grab(b, 0, 1);
    a.send(message);
    rig.run(60 * kMillisecond);
    EXPECT_EQ(a.closed,
              !std::holds_alternative<SceneRequest>(message) && !std::holds_alternative<Ready>(message));
    EXPECT_FALSE(b.closed);
    EXPECT_EQ(rig.session->ownership().part(0).owner, held.part.owner);
  }
}

TEST(Session, SurvivesNoiseOnBothChannels) {
  Rig rig;
  FakeSite& good = rig.join("good");
  const auto held = rig.grab(good, 0, 1);
  std::mt19937 random(3);
  for (int round = 0; round < 60; ++round) {
    FakeSite& bad = rig.join("bad" + std::to_string(round));
    std::vector<std::byte> noise(1 + random() % 200);
    for (auto& byte : noise) byte = static_cast<std::byte>(random());
    bad.transport->sendState(0, noise);
    noise[0] = std::byte{0xff};
    bad.transport->sendControl(0, noise);
    rig.run(60 * kMillisecond);
    EXPECT_TRUE(bad.closed);
    rig.sites.pop_back();
  }
  EXPECT_EQ(rig.session->counters().refusedMessages, 60u);
  EXPECT_GT(rig.session->counters().droppedMalformed, 0u);
  EXPECT_EQ(rig.session->ownership().part(0).owner, held.part.owner);
  EXPECT_FALSE(good.closed);
}

TEST(Session, KeepsThePoseThatItKnowsWhereAReleaseIsOutOfReach) {
  Rig rig;
  FakeSite& a = rig.join("a");
  const auto held = rig.grab(a, 0, 1);
  a.send(rig.update(a, 0, held.part.epoch, 0.25));
  rig.run(40 * kMillisecond);
  Pose away;
  away.position.x = 9.9e8;
  a.send(Release{2, 0, held.part.epoch, away});
  rig.run(40 * kMillisecond);
  EXPECT_EQ(rig.session->ownership().part(0).owner, kNoSite);
  EXPECT_NEAR(rig.session->ownership().part(0).worldFromPart.position.x, 0.25, 1e-5);
  EXPECT_EQ(rig.session->counters().refusedPoses, 1u);
  // Anything within the frame, a cube of 8 m around this scene, is taken.
  const auto again = rig.grab(a, 0, 3);
  away.position.x = 3.9;
  a.send(Release{4, 0, again.part.epoch, away});
  rig.run(40 * kMillisecond);
  EXPECT_EQ(rig.session->ownership().part(0).worldFromPart.position.x, 3.9);
  EXPECT_EQ(rig.session->counters().refusedPoses, 1u);
}

/// Sends `perSecond` grabs and releases of a part for a while, as a program without patience does.
void flood(Rig& rig, FakeSite& site, int perSecond, Micros length) {
  RequestId request = 1000;
  for (Micros t = 0; t < length && !site.closed; t += 10 * kMillisecond) {
    for (int i = 0; i < perSecond / 200; ++i) {
      site.send(Grab{++request, 0});
      site.send(Release{++request, 0, 0, Pose{}});
    }
    rig.run(10 * kMillisecond);
  }
}

TEST(Session, SlowsASiteThatFloodsItWithRequestsThenPartsFromIt) {
  Rig rig;
  FakeSite &flooder = rig.join("flooder"), &honest = rig.join("honest");
  const auto held = rig.grab(honest, 1, 1);
  const auto answered = [&] { return flooder.count<GrabReply>() + flooder.count<ReleaseReply>(); };
  flood(rig, flooder, 58000, 2 * kSecond);
  EXPECT_FALSE(flooder.closed);
  EXPECT_GE(answered(), 600u);
  EXPECT_LE(answered(), 400u + 2 * 200u + 40u);
  EXPECT_EQ(rig.session->ownership().part(1).owner, held.part.owner);
  // An honest request is answered within its round trip, the journal's 2 ms and two steps.
  honest.send(Release{2, 1, held.part.epoch, Pose{}});
  rig.run(15 * kMillisecond);
  EXPECT_EQ(honest.count<ReleaseReply>(), 1u);
  flood(rig, flooder, 58000, 12 * kSecond);
  EXPECT_TRUE(flooder.closed);
  ASSERT_NE(flooder.last<Refused>(), nullptr);
  EXPECT_EQ(flooder.last<Refused>()->reason, "more requests than a site may send");
  EXPECT_FALSE(honest.closed);
  EXPECT_GT(rig.session->counters().holds, 0u);
  int said = 0;
  for (const LogLine& line : rig.session->drainLog())
    said += line.text.find("it is slowed") != std::string::npos;
  EXPECT_GE(said, 1);
  EXPECT_LE(said, 2);
}

TEST(Session, AnswersAHundredRequestsAtOnceWithoutPause) {
  Rig rig;
  FakeSite& busy = rig.join("busy");
  for (RequestId i = 1; i <= 100; ++i) busy.send(Grab{i, 0});
  rig.run(30 * kMillisecond);
  EXPECT_EQ(busy.count<GrabReply>(), 100u);
  EXPECT_EQ(rig.session->counters().holds, 0u);
}

TEST(Session, RefillsNoBudgetOfASiteThatConnectsAnew) {
  Rig rig;
  FakeSite* site = &rig.join("again");
  const std::string ticket = site->last<Welcome>()->resumeTicket;
  bool refused = false;
  int admitted = 0;
  for (int i = 0; i < 40 && !refused; ++i) {
    site = &rig.connect("again");
    site->send(Hello{kProtocolVersion, true, ticket, "again", {1, 2, 3}});
    rig.run(30 * kMillisecond);
    admitted += site->last<Welcome>() != nullptr;
    refused = site->last<Refused>() != nullptr;
  }
  // Each entry counts for 40 of 400 messages, and 12 come back in its 60 ms.
  EXPECT_TRUE(refused);
  EXPECT_GE(admitted, 8);
  EXPECT_LE(admitted, 16);
  rig.run(3 * kSecond);
  rig.resume("again", ticket);
}

TEST(Session, ATokenStaysUsedWhenTheWallClockIsPutForwardAndBack) {
  Rig rig;
  const std::string token = rig.token(Role::participant);
  FakeSite& first = rig.connect("a");
  first.send(Hello{kProtocolVersion, false, token, "a", {}});
  rig.run(40 * kMillisecond);
  ASSERT_NE(first.last<Welcome>(), nullptr);
  rig.wallStep = 2 * 3600;
  rig.run(3 * kSecond);
  rig.wallStep = 0;
  rig.run(100 * kMillisecond);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, token, "b", {}}), Refusal::expired);
}

TEST(Session, HearsTheEndOfAConnectionThatIsHeld) {
  Rig rig;
  FakeSite &flooder = rig.join("flooder"), &honest = rig.join("honest");
  const SiteId number = flooder.last<Welcome>()->site;
  flood(rig, flooder, 58000, 200 * kMillisecond);
  flooder.transport.reset();
  rig.run(2 * kSecond);
  const auto& sites = rig.session->sites();
  const auto listed =
      std::find_if(sites.begin(), sites.end(), [&](const SiteInfo& info) { return info.site == number; });
  ASSERT_NE(listed, sites.end());
  EXPECT_FALSE(listed->connected);
  EXPECT_FALSE(honest.closed);
}

TEST(Session, AnswersButGrantsNothingOnceTheJournalHasFailed) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const auto held = rig.grab(a, 0, 1);
  rig.journal.fail("disk full");
  EXPECT_EQ(rig.grab(b, 1, 1).denial, Denial::recovering);
  a.send(Release{2, 0, held.part.epoch, {}});
  a.send(rig.update(a, 0, held.part.epoch, 0.3));
  rig.run(40 * kMillisecond);
  EXPECT_EQ(a.last<ReleaseReply>()->denial, Denial::recovering);
  EXPECT_EQ(b.updates.size(), 1u);
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, rig.token(Role::observer), "c", {}}),
            Refusal::sessionFull);
}

TEST(Session, TellsNobodyOfAGrantThatTheDiskDidNotKeep) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const Epoch known = rig.grab(a, 0, 1).part.epoch;
  a.send(Release{2, 0, known, {}});
  rig.run(50 * kMillisecond);
  a.send(Grab{3, 0});
  rig.network.advanceTo(rig.now += 5 * kMillisecond);  // the request has come, the record is not durable yet
  rig.session->step(rig.now, kUnix);
  rig.journal.fail("disk full");
  rig.run(50 * kMillisecond);
  ASSERT_EQ(a.last<GrabReply>()->denial, Denial::recovering);
  b.send(Grab{1, 0});
  b.send(Engage{2, 0});
  rig.run(50 * kMillisecond);
  EXPECT_EQ(a.last<GrabReply>()->part.epoch, 0u);
  EXPECT_EQ(b.last<GrabReply>()->denial, Denial::recovering);
  EXPECT_EQ(b.last<GrabReply>()->part.epoch, 0u) << "the next server gives this epoch to another";
  EXPECT_EQ(b.last<GrabReply>()->part.owner, kNoSite);
  EXPECT_EQ(b.last<EngageReply>()->denial, Denial::recovering);
  EXPECT_EQ(b.last<EngageReply>()->coHolders.epoch, 0u);
}

TEST(Session, GrantsAgainWhenTheJournalIsWellAndWhatWasDeniedStaysDenied) {
  for (int seed = 0; seed < 20; ++seed) {
    Rig rig;
    FakeSite &a = rig.join("a"), &b = rig.join("b");
    const auto held = rig.grab(a, 0, 1);
    ASSERT_EQ(held.denial, Denial::none);
    // The request is in the journal's hands when the disk fails, or comes later.
    b.send(Grab{1, 1});
    rig.run(seed * kMillisecond / 4);
    const bool answered = b.last<GrabReply>() != nullptr;
    rig.journal.fail("disk full");
    rig.run(40 * kMillisecond);
    ASSERT_NE(b.last<GrabReply>(), nullptr);
    const GrabReply first = *b.last<GrabReply>();
    EXPECT_EQ(first.denial == Denial::none, answered) << seed;
    rig.journal.heal();
    rig.run(40 * kMillisecond);
    EXPECT_EQ(rig.session->ownership().part(0).owner, held.part.owner);
    const auto now = rig.session->ownership().part(1);
    EXPECT_EQ(now.owner == kNoSite, first.denial != Denial::none) << seed;
    if (first.denial == Denial::none) continue;
    // The same request, repeated, is no grant of the epoch that was withdrawn; a new one is granted.
    const auto again = rig.grab(a, 1, 2);
    EXPECT_EQ(again.denial, Denial::none);
    EXPECT_GT(again.part.epoch, now.epoch);
    const auto repeated = rig.grab(b, 1, 1);
    EXPECT_EQ(repeated.denial, Denial::ownedByOther);
  }
}

TEST(Session, TellsOfAReleaseThatTheDiskKeptBack) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const auto held = rig.grab(a, 0, 1);
  a.send(Release{2, 0, held.part.epoch, {}});
  rig.run(kMillisecond);
  rig.journal.fail("disk full");
  rig.run(40 * kMillisecond);
  rig.journal.heal();
  rig.run(40 * kMillisecond);
  ASSERT_NE(b.last<OwnershipChanged>(), nullptr);
  EXPECT_EQ(b.last<OwnershipChanged>()->part.owner, rig.session->ownership().part(0).owner);
  EXPECT_EQ(rig.grab(b, 0, 1).denial == Denial::none,
            rig.session->ownership().part(0).owner != held.part.owner);
}

TEST(MemoryJournal, NoticesALyingDiskAndRotAndRecoversBeyondWhatWasTold) {
  for (const bool lies : {false, true}) {
    MemoryJournal journal;
    const auto part = [](Epoch epoch) { return PartRecord{2, 7, epoch, {}}; };
    journal.append(part(1));
    journal.advanceTo(kSecond);
    journal.lie(lies);
    journal.append(part(2));
    const auto told = journal.durableUpTo();
    EXPECT_EQ(told, lies ? 2u : 1u);
    journal.crash();
    EXPECT_EQ(journal.damage().empty(), !lies);
    if (!lies) {
      EXPECT_EQ(journal.contents().parts.at(0).epoch, 1u);
      journal.rot(2);
      EXPECT_FALSE(journal.damage().empty());
    }
    journal.recover();
    EXPECT_TRUE(journal.damage().empty());
    EXPECT_GE(journal.contents().epochFloor, 2u);
    EXPECT_EQ(journal.generation(), 1u);
    for (const auto& record : journal.contents().parts) EXPECT_EQ(record.owner, kNoSite);
  }
}

TEST(Session, CallsAFailedJournalAnErrorOnceAndNothingElse) {
  Rig rig;
  rig.grab(rig.join("a"), 0, 1);
  for (const LogLine& line : rig.session->drainLog()) EXPECT_FALSE(line.error) << line.text;
  rig.journal.fail("disk full");
  rig.run(2 * kSecond);
  int errors = 0;
  for (const LogLine& line : rig.session->drainLog()) {
    if (!line.error) continue;
    ++errors;
    EXPECT_NE(line.text.find("journal: disk full"), std::string::npos) << line.text;
  }
  EXPECT_EQ(errors, 1);
}

TEST(Session, RenewsLeasesOnlyForPings) {
  Rig rig;
  FakeSite& a = rig.join("a");
  rig.grab(a, 0, 1);
  rig.run(5 * kSecond);
  EXPECT_NE(rig.session->ownership().part(0).owner, kNoSite);
  EXPECT_FALSE(a.pongs.empty());
  rig.pinging = false;  // the control: without pings the same wait frees the part
  rig.run(3 * kSecond);
  EXPECT_EQ(rig.session->ownership().part(0).owner, kNoSite);
}

TEST(Session, PutsUnownedPartsBackForAnInstructor) {
  Rig rig;
  FakeSite& i = rig.join("i", Role::instructor);
  const auto held = rig.grab(i, 0, 1);
  Pose away;
  away.position.x = 0.4;
  i.send(Release{2, 0, held.part.epoch, away});
  i.send(ResetParts{3});
  i.send(ResetParts{3});  // repeated: one reset, answered again
  rig.run(60 * kMillisecond);
  ASSERT_NE(i.last<CommandReply>(), nullptr);
  EXPECT_TRUE(i.last<CommandReply>()->done);
  EXPECT_EQ(rig.session->ownership().part(0).worldFromPart.position.x, 0.0);
}

}  // namespace
}  // namespace tandem::server
