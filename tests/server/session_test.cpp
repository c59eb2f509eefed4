#include "server/session.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "server/state_relay.h"
#include "sync/wire/site_colours.h"
#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

using Rig = SessionRig;

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

TEST(Session, PassesOnAllLinksOfASiteInARowOfEightOwnersAndNoFlood) {
  Rig rig;
  FakeSite &a = rig.join("a"), &b = rig.join("b");
  const Epoch epoch = rig.grab(a, 0, 1).part.epoch;
  b.send(Engage{1, 0});
  rig.run(40 * kMillisecond);
  LinkUpdate link;
  link.part = 0;
  link.peer = b.last<Welcome>()->site;
  const auto sendFor = [&](int periods, int links, int updates) {  // of 4 ms each
    for (int i = 0; i < periods; ++i) {
      for (int k = 0; k < links; ++k) a.send(link);
      for (int k = 0; k < updates; ++k) a.send(rig.update(a, 0, epoch, 0.0));
      rig.run(4 * kMillisecond);
    }
    rig.run(40 * kMillisecond);
  };
  sendFor(500, 14, 1);  // to each of seven others, of its own part and of theirs
  EXPECT_EQ(rig.session->counters().droppedFlood, 0u);
  EXPECT_EQ(b.links.size(), 7000u);
  sendFor(500, 28, 1);
  EXPECT_NEAR(static_cast<double>(b.links.size()), 7000.0 + 2.0 * kMaxLinkRate + kDatagramBurst, 300.0);
  EXPECT_EQ(rig.session->counters().relayedUpdates, 1000u) << "a flood of links costs no update";
  sendFor(500, 0, 28);
  EXPECT_LE(rig.session->counters().relayedUpdates, 1000.0 + 2.1 * kMaxDatagramRate + kDatagramBurst);
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

}  // namespace
}  // namespace tandem::server
