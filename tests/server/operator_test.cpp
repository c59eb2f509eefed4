#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

/// A session, and what its audit trail has said.
struct Desk : SessionRig {
  std::vector<AuditEntry> audit;

  Desk() : SessionRig({}, SigningKey({8})) {}
  void afterStep() override {
    for (AuditEntry& entry : session->drainAudit()) audit.push_back(std::move(entry));
  }
  void restart() {
    run(20 * kMillisecond);
    crash();
    start();
  }
  FakeSite& hello(const std::string& name, bool resume, const std::string& credential) {
    FakeSite& site = connect(name);
    site.send(Hello{kProtocolVersion, resume, credential, name, {1, 2, 3}});
    run(40 * kMillisecond);
    if (site.last<Welcome>() != nullptr) site.send(Ready{});
    run(20 * kMillisecond);
    return site;
  }
  FakeSite& join(const std::string& name, Role role = Role::participant) {
    return hello(name, false, token(role));
  }
  Epoch grab(FakeSite& site, PartId part) {
    site.send(Grab{++requests_, part});
    run(40 * kMillisecond);
    EXPECT_EQ(site.last<GrabReply>()->denial, Denial::none);
    return site.last<GrabReply>()->part.epoch;
  }
  std::size_t count(AuditEvent event) const {
    return static_cast<std::size_t>(
        std::count_if(audit.begin(), audit.end(), [&](const auto& entry) { return entry.event == event; }));
  }

 private:
  RequestId requests_ = 0;
};

bool wasRefused(const FakeSite& site, Refusal refusal) {
  const auto* refused = site.last<Refused>();
  return refused != nullptr && refused->refusal == refusal;
}

TEST(Operator, KickTellsTheSiteAndFreesItsPartsAsAGoodbyeDoes) {
  Desk desk;
  FakeSite &ada = desk.join("Ada"), &ben = desk.join("Ben");
  desk.grab(ben, 0);
  const auto done = desk.session->kick("Ben", false);
  ASSERT_TRUE(done.ok());
  EXPECT_NE(done->find("its ticket is still good"), std::string::npos) << *done;
  desk.run(30 * kMillisecond);
  EXPECT_TRUE(wasRefused(ben, Refusal::removed));
  EXPECT_TRUE(ben.closed);
  EXPECT_EQ(desk.session->ownership().part(0).owner, kNoSite);  // far sooner than a lease
  ASSERT_NE(ada.last<SiteLeft>(), nullptr);
  EXPECT_EQ(ada.last<SiteLeft>()->site, ben.last<Welcome>()->site);
  desk.grab(ada, 0);

  FakeSite& again = desk.hello("Ben", true, ben.last<Welcome>()->resumeTicket);
  ASSERT_NE(again.last<Welcome>(), nullptr) << "a kick is no ban";
  EXPECT_EQ(again.last<Welcome>()->site, ben.last<Welcome>()->site);
}

TEST(Operator, ABannedSitesTicketsNeverResumeNotEvenAfterARestart) {
  Desk desk;
  FakeSite& ben = desk.join("Ben");
  const std::string first = ben.last<Welcome>()->resumeTicket;
  ben.transport.reset();
  ben.transport = desk.network.connect("nobody");  // for listen()
  FakeSite& anew = desk.hello("Ben", true, first);
  const std::string second = anew.last<Welcome>()->resumeTicket;
  ASSERT_TRUE(desk.session->kick(std::to_string(anew.last<Welcome>()->site), true).ok());
  desk.run(30 * kMillisecond);
  for (int life = 0; life < 2; ++life) {
    for (const std::string& ticket : {first, second})
      EXPECT_TRUE(wasRefused(desk.hello("Ben", true, ticket), Refusal::badCredential));
    desk.restart();
  }
  EXPECT_EQ(desk.count(AuditEvent::banned), 1u);
}

TEST(Operator, AnAbsentSiteCanBeBannedAndKeepsNothing) {
  Desk desk;
  FakeSite& ben = desk.join("Ben");
  desk.grab(ben, 1);
  const std::string ticket = ben.last<Welcome>()->resumeTicket;
  ben.transport->close(0);
  desk.run(30 * kMillisecond);
  EXPECT_FALSE(desk.session->kick("Ben", false).ok()) << "nobody is there to be parted from";
  ASSERT_TRUE(desk.session->kick("Ben", true).ok());
  EXPECT_EQ(desk.session->ownership().part(1).owner, kNoSite);
  EXPECT_TRUE(wasRefused(desk.hello("Ben", true, ticket), Refusal::badCredential));
}

TEST(Operator, ANameThatSeveralSitesHaveIsRefusedWithTheirNumbers) {
  Desk desk;
  desk.join("Ben");
  desk.join("Ben");
  const auto unclear = desk.session->kick("Ben", true);
  ASSERT_FALSE(unclear.ok());
  EXPECT_NE(unclear.error().message.find("1, 2"), std::string::npos) << unclear.error().message;
  EXPECT_FALSE(desk.session->kick("Eve", false).ok());
  for (const char* wrong : {"0", "3", "65536", "4294967297", ""})
    EXPECT_FALSE(desk.session->kick(wrong, true).ok());
  EXPECT_EQ(desk.session->sites().size(), 2u);
  EXPECT_TRUE(desk.session->kick("2", false).ok());
}

TEST(Operator, ARevokedTicketLeavesTheSiteInUntilItIsPartedFrom) {
  Desk desk;
  FakeSite& ben = desk.join("Ben");
  desk.grab(ben, 0);
  ASSERT_TRUE(desk.session->revokeTicket("Ben").ok());
  desk.run(kSecond);
  EXPECT_FALSE(ben.closed);
  EXPECT_NE(desk.session->ownership().part(0).owner, kNoSite);
  EXPECT_FALSE(desk.session->revokeTicket("Ben").ok()) << "it is void already";
  const auto kicked = desk.session->kick("Ben", false);
  ASSERT_TRUE(kicked.ok());
  EXPECT_NE(kicked->find("admits nobody"), std::string::npos) << *kicked;
  desk.run(30 * kMillisecond);
  EXPECT_TRUE(ben.closed);
  EXPECT_TRUE(wasRefused(desk.hello("Ben", true, ben.last<Welcome>()->resumeTicket), Refusal::badCredential));
}

TEST(Operator, RevokedLinksAdmitNobodyAndTicketsStillDo) {
  Desk desk;
  FakeSite& ben = desk.join("Ben");
  const std::string open = desk.session->makeToken(Role::instructor, kUnix + 3600);
  desk.session->replaceLinkKey(SigningKey({9}));
  EXPECT_TRUE(wasRefused(desk.hello("Eve", false, open), Refusal::badCredential));
  EXPECT_NE(desk.join("Cy").last<Welcome>(), nullptr);
  EXPECT_EQ(ben.last<NewTicket>(), nullptr);
  EXPECT_NE(desk.hello("Ben", true, ben.last<Welcome>()->resumeTicket).last<Welcome>(), nullptr);
}

TEST(Operator, RotatedKeysVoidEveryCredentialButThoseOfTheSitesPresent) {
  Desk desk;
  FakeSite &ada = desk.join("Ada"), &ben = desk.join("Ben"), &cy = desk.join("Cy");
  const std::string open = desk.session->makeToken(Role::participant, kUnix + 3600);
  cy.transport->close(0);
  ASSERT_TRUE(desk.session->revokeTicket("Ada").ok());
  desk.run(30 * kMillisecond);
  desk.session->replaceKeys(SigningKey({17}), SigningKey({18}));
  desk.run(30 * kMillisecond);

  EXPECT_FALSE(ada.closed);
  EXPECT_EQ(ada.last<NewTicket>(), nullptr) << "a void ticket is not made good again";
  ASSERT_NE(ben.last<NewTicket>(), nullptr);
  EXPECT_TRUE(wasRefused(desk.hello("Eve", false, open), Refusal::badCredential));
  EXPECT_TRUE(wasRefused(desk.hello("Cy", true, cy.last<Welcome>()->resumeTicket), Refusal::badCredential));
  EXPECT_TRUE(wasRefused(desk.hello("Ben", true, ben.last<Welcome>()->resumeTicket), Refusal::badCredential));
  const std::string fresh = ben.last<NewTicket>()->resumeTicket;
  FakeSite& back = desk.hello("Ben", true, fresh);
  ASSERT_NE(back.last<Welcome>(), nullptr);
  EXPECT_EQ(back.last<Welcome>()->site, ben.last<Welcome>()->site);
}

TEST(Operator, NothingIsOrderedWhileTheJournalCannotBeWritten) {
  Desk desk;
  FakeSite& ben = desk.join("Ben");
  desk.journal.fail("disk full");
  desk.run(10 * kMillisecond);
  EXPECT_FALSE(desk.session->kick("Ben", true).ok());
  EXPECT_FALSE(desk.session->revokeTicket("Ben").ok());
  desk.run(50 * kMillisecond);
  EXPECT_FALSE(ben.closed);
}

/// Random orders and arrivals: a credential that an order made void never admits anybody afterwards, and
/// every other one does.
TEST(Operator, NoOrderOfOrdersLetsAVoidCredentialIn) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Desk desk;
    std::mt19937 random(seed);
    struct Known {
      std::string name, ticket;
      bool valid = true, present = true;
      FakeSite* site = nullptr;
    };
    std::vector<Known> known;
    std::uint8_t fill = 20;
    for (int step = 0; step < 25; ++step) {
      const std::string name = "s" + std::to_string(step);
      Known* one = known.empty() ? nullptr : &known[random() % known.size()];
      const std::string who = one == nullptr ? "" : std::to_string(one->site->last<Welcome>()->site);
      switch (random() % 6) {
        case 0:
          if (known.size() >= 8) break;
          known.push_back({name, {}, true, true, &desk.join(name)});
          ASSERT_NE(known.back().site->last<Welcome>(), nullptr);
          known.back().ticket = known.back().site->last<Welcome>()->resumeTicket;
          break;
        case 1:
          if (one != nullptr && one->present) {
            one->site->transport->close(0);
            one->present = false;
            desk.run(20 * kMillisecond);
          }
          break;
        case 2:
          if (one != nullptr && desk.session->kick(who, true).ok()) one->valid = one->present = false;
          break;
        case 3:
          if (one != nullptr && desk.session->revokeTicket(who).ok()) one->valid = false;
          break;
        case 4:
          desk.session->replaceKeys(SigningKey({fill}), SigningKey({static_cast<std::uint8_t>(fill + 1)}));
          fill = static_cast<std::uint8_t>(fill + 2);
          desk.run(30 * kMillisecond);
          for (Known& k : known) {
            k.valid = k.valid && k.present;
            if (k.valid) k.ticket = k.site->last<NewTicket>()->resumeTicket;
          }
          break;
        default:
          if (one == nullptr || one->present) break;
          FakeSite& back = desk.hello(one->name, true, one->ticket);
          ASSERT_EQ(back.last<Welcome>() != nullptr, one->valid) << "seed " << seed << " step " << step;
          if (!one->valid) break;
          one->site = &back;
          one->present = true;
          one->ticket = back.last<Welcome>()->resumeTicket;
          break;
      }
    }
  }
}

TEST(AuditTrail, SaysWhoCameWentAndWasRefusedWithNameAndAddress) {
  Desk desk;
  FakeSite& ada = desk.join("Ada", Role::instructor);
  desk.hello("Eve", false, "forged");
  FakeSite& ben = desk.join("Ben");
  desk.grab(ben, 0);
  ada.send(Revoke{1, 0});
  ada.send(ResetParts{2});
  desk.run(40 * kMillisecond);
  ben.transport->close(0);
  desk.run(40 * kMillisecond);
  FakeSite& back = desk.hello("Ben", true, ben.last<Welcome>()->resumeTicket);
  back.send(Goodbye{});
  desk.run(40 * kMillisecond);
  std::string events;
  for (const AuditEntry& entry : desk.audit) {
    events += std::string(toString(entry.event)) + ' ' + entry.name + ' ' + entry.address + '\n';
    EXPECT_GE(entry.unixTime, kUnix);
  }
  EXPECT_EQ(events,
            "joined Ada Ada\nrefused Eve Eve\njoined Ben Ben\nrevoked Ada Ada\nreset Ada Ada\n"
            "lost Ben Ben\nreturned Ben Ben\nleft Ben Ben\n");
  EXPECT_NE(desk.audit[1].detail.find("not signed"), std::string::npos) << desk.audit[1].detail;
  EXPECT_NE(desk.audit[3].detail.find("part0"), std::string::npos) << desk.audit[3].detail;
}

TEST(AuditTrail, AFloodOfRefusalsIsCountedAndHidesNobodyElse) {
  AuditTrail trail;
  std::size_t entries = 0, joins = 0;
  std::uint64_t refusals = 0;  // those with an entry of their own and those that an entry counts
  Micros now = 0;
  const auto drain = [&] {
    for (const AuditEntry& entry : trail.drain(now)) {
      ++entries;
      if (entry.event == AuditEvent::joined)
        ++joins;
      else
        refusals += entry.detail == "no" ? 1 : std::stoull(entry.detail);
    }
  };
  for (int second = 0; second < 100; ++second, now += kSecond) {
    for (int i = 0; i < 700; ++i) trail.note({AuditEvent::refused, 1, kNoSite, "", "", "", "no"}, now);
    trail.note({AuditEvent::joined, 1, 3, "Ada", "", "", ""}, now);
    drain();
  }
  drain();
  EXPECT_EQ(joins, 100u);
  EXPECT_EQ(refusals, 70000u);
  EXPECT_LE(entries, 800u);
}

}  // namespace
}  // namespace tandem::server
