// What a session does under floods, with a sick journal, and at the end of leases.

#include <gtest/gtest.h>

#include "server/control_budget.h"
#include "server/operation/log_limiter.h"
#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

using Rig = SessionRig;

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

TEST(Session, AFloodLeavesAFewLinesThatSayWhoAndHowMuch) {
  for (const int kind : {0, 1, 2}) {
    Rig rig;
    FakeSite &flooder = rig.join("flooder"), &honest = rig.join("honest");
    rig.session->drainLog();
    LogLimiter limiter;
    int written = 0, slowed = 0;
    RequestId request = 1000;
    for (int i = 0; i < 800; ++i) {
      for (int k = 0; k < 30; ++k) {
        if (kind == 0) flooder.send(Grab{++request, 0});
        if (kind == 0) flooder.send(Release{request, 0, 0, Pose{}});
        if (kind == 1)
          flooder.send(k % 2 == 0 ? ControlMessage(Engage{++request, 1}) : Disengage{++request, 1});
        if (kind == 2) flooder.send(StateMessage(rig.update(flooder, 0, 1, 0.1)));
      }
      rig.run(10 * kMillisecond);
      for (const LogLine& line : rig.session->drainLog()) {
        written += limiter.admit(line, rig.now) ? 1 : 0;
        slowed += line.text.find("\"flooder\" sends more") != std::string::npos ? 1 : 0;
      }
    }
    EXPECT_LE(written, 60) << "kind " << kind;
    EXPECT_GE(slowed, 1) << "kind " << kind;
    EXPECT_LE(slowed, 2) << "kind " << kind;
    EXPECT_FALSE(honest.closed);
  }
}

TEST(Session, ARequestThatManyAreToldOfCountsForMore) {
  const auto answeredAmong = [](std::size_t others) {
    Rig rig;
    FakeSite &flooder = rig.join("flooder"), &honest = rig.join("honest");
    rig.grab(honest, 1, 1);
    for (std::size_t i = 0; i < others; ++i) rig.join("other " + std::to_string(i), Role::observer);
    rig.run(3 * kSecond);
    RequestId request = 1000;
    for (int i = 0; i < 2000; ++i) {
      flooder.send(Engage{++request, 1});
      flooder.send(Disengage{++request, 1});
    }
    rig.run(2 * kSecond);
    return flooder.count<EngageReply>();
  };
  const std::size_t alone = answeredAmong(0), among = answeredAmong(60);
  EXPECT_NEAR(static_cast<double>(alone), 800.0 / (1.0 + 2.0 / ControlBudget::kToldPerMessage), 110.0);
  EXPECT_NEAR(static_cast<double>(among), 800.0 / (1.0 + 62.0 / ControlBudget::kToldPerMessage), 60.0);
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
  EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, token, "b", {}}), Refusal::alreadyUsed);
  rig.wallStep = -24 * 3600;  // behind all that has expired: a new link is good nevertheless
  rig.run(100 * kMillisecond);
  FakeSite& second = rig.connect("b");
  second.send(Hello{kProtocolVersion, false, rig.token(Role::participant), "b", {}});
  rig.run(40 * kMillisecond);
  EXPECT_NE(second.last<Welcome>(), nullptr);
}

TEST(Session, ATokenStaysUsedWhenTheWallClockRunsAheadOverARestartAndIsPutBack) {
  for (const std::int64_t ahead : {2 * 3600, 365 * 24 * 3600}) {
    Rig rig;
    const std::string token = rig.token(Role::participant);
    FakeSite& first = rig.connect("a");
    first.send(Hello{kProtocolVersion, false, token, "a", {}});
    rig.run(40 * kMillisecond);
    ASSERT_NE(first.last<Welcome>(), nullptr);
    rig.wallStep = ahead;
    rig.crash();
    rig.start();
    rig.run(3 * kSecond);
    EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, token, "b", {}}), Refusal::expired);
    for (const std::int64_t back : {std::int64_t{0}, std::int64_t{-24 * 3600}}) {
      rig.wallStep = back;
      rig.crash();
      rig.start();
      rig.run(100 * kMillisecond);
      EXPECT_EQ(rig.refusalOf({kProtocolVersion, false, token, "c", {}}), Refusal::alreadyUsed);
    }
  }
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

// A site believes that what is answered has renewed its lease (S3).
TEST(Session, RenewsLeasesForPingsThatOvertakeReady) {
  Rig rig;
  FakeSite& a = rig.join("a");
  const SiteId id = a.last<Welcome>()->site;
  rig.grab(a, 0, 1);
  FakeSite& again = rig.connect("a");
  again.send(Hello{kProtocolVersion, true, a.last<Welcome>()->resumeTicket, "a", {1, 2, 3}});
  rig.run(5 * kSecond);
  EXPECT_FALSE(again.pongs.empty());
  EXPECT_EQ(rig.session->ownership().part(0).owner, id);
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
