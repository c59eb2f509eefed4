// The checker of the protocol's rules must be able to fail: every rule is broken here once, on purpose.

#include "client/simulation/invariants.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

using sync::PartRecord;

PartRecord record(SiteId owner, Epoch epoch) {
  PartRecord part;
  part.part = 0;
  part.owner = owner;
  part.epoch = epoch;
  return part;
}

sync::PartState state(Epoch epoch, std::uint32_t sequence) {
  sync::PartState part;
  part.part = 0;
  part.epoch = epoch;
  part.sequence = sequence;
  return part;
}

std::string rules(const Invariants& invariants) {
  std::string text;
  for (const Violation& violation : invariants.violations()) text += violation.rule + " ";
  return text;
}

class InvariantsTest : public testing::Test {
 protected:
  Invariants invariants{2, sync::LeaseRules{}};
};

TEST_F(InvariantsTest, AnOrdinaryHandOverBreaksNothing) {
  invariants.onServerRecord(record(1, 1));
  invariants.onOwnership(0, record(1, 1));
  invariants.onOwnership(1, record(1, 1));
  invariants.onPublished(1, state(1, 1));
  invariants.onAccepted(1, state(1, 1));
  invariants.onServerRecord(record(kNoSite, 1));
  invariants.onServerRecord(record(2, 2));
  invariants.onOwnership(0, record(2, 2));
  EXPECT_EQ(rules(invariants), "");
  EXPECT_EQ(invariants.grants().size(), 2u);
}

TEST_F(InvariantsTest, FindsTwoOwnersInOneEpoch) {
  invariants.onOwnership(0, record(1, 1));
  invariants.onOwnership(1, record(2, 1));
  EXPECT_EQ(rules(invariants), "S1 ");
}

TEST_F(InvariantsTest, FindsAnEpochThatGoesBack) {
  invariants.onServerRecord(record(1, 2));
  invariants.onServerRecord(record(2, 1));
  EXPECT_NE(rules(invariants).find("S1"), std::string::npos);
}

TEST_F(InvariantsTest, FindsAStateOfAnOldEpoch) {
  invariants.onOwnership(0, record(1, 2));
  invariants.onAccepted(0, state(1, 5));
  EXPECT_EQ(rules(invariants), "S2 ");
}

TEST_F(InvariantsTest, FindsAStateThatIsNotNewer) {
  invariants.onOwnership(0, record(1, 1));
  invariants.onAccepted(0, state(1, 5));
  invariants.onAccepted(0, state(1, 5));
  EXPECT_EQ(rules(invariants), "S2 ");
}

TEST_F(InvariantsTest, FindsAFormerOwnerThatStillPublishes) {
  invariants.onServerRecord(record(1, 1));
  invariants.onServerRecord(record(2, 2));
  invariants.onPublished(1, state(1, 9));
  EXPECT_EQ(rules(invariants), "S3 ");
}

TEST_F(InvariantsTest, FindsADenialWithoutAWinner) {
  sync::GrabReply reply;
  reply.request = 1;
  reply.denial = sync::Denial::ownedByOther;
  reply.part = record(kNoSite, 1);
  invariants.onGrabReply(0, reply);
  EXPECT_EQ(rules(invariants), "S4 ");
}

TEST_F(InvariantsTest, FindsTwoAnswersToOneRequest) {
  sync::GrabReply reply;
  reply.request = 1;
  reply.part = record(1, 1);
  invariants.onGrabReply(0, reply);
  reply.part = record(1, 2);
  invariants.onGrabReply(0, reply);
  EXPECT_EQ(rules(invariants), "S7 ");
}

TEST_F(InvariantsTest, FindsAnEarlyRegrantAfterARestart) {
  invariants.setTime(sync::kSecond);
  invariants.onServerRecord(record(1, 1));
  invariants.onServerRestart({record(1, 1)});
  invariants.setTime(sync::kSecond + 100 * sync::kMillisecond);
  invariants.onServerRecord(record(2, 2));
  EXPECT_EQ(rules(invariants), "S8 ");
}

TEST_F(InvariantsTest, FindsAJournalThatForgot) {
  invariants.onServerRecord(record(1, 5));
  invariants.onOwnership(0, record(1, 5));
  invariants.onServerRestart({record(1, 4)});
  EXPECT_EQ(rules(invariants), "S1 ");
}

TEST_F(InvariantsTest, FindsAnUnansweredRequest) {
  invariants.onGrab(0, {1, 0});
  invariants.setTime(60 * sync::kSecond);
  invariants.finish({});
  EXPECT_EQ(rules(invariants), "L1 ");
}

TEST_F(InvariantsTest, FindsAPartThatADeadSiteKeeps) {
  invariants.onServerRecord(record(1, 1));
  invariants.onDead(0, 1);
  invariants.setTime(20 * sync::kSecond);
  invariants.onServerRecord(record(1, 1));
  EXPECT_EQ(rules(invariants), "L2 ");
}

TEST_F(InvariantsTest, ADeadSitesLeaseRunsFromTheLastOfItsMessagesToArrive) {
  invariants.onServerRecord(record(1, 1));
  invariants.onDead(0, 1);
  invariants.setTime(6 * sync::kSecond);
  invariants.onHeardFromTheDead(0, 6 * sync::kSecond);
  invariants.setTime(7 * sync::kSecond);
  invariants.onServerRecord(record(1, 1));
  EXPECT_EQ(rules(invariants), "");
  invariants.setTime(9 * sync::kSecond);
  invariants.onServerRecord(record(1, 1));
  EXPECT_EQ(rules(invariants), "L2 ");
}

TEST_F(InvariantsTest, FindsAPartThatIsTakenAwayByNobody) {
  invariants.onServerRecord(record(1, 1));
  invariants.onServerRecord(record(kNoSite, 2));
  invariants.finish({});
  EXPECT_EQ(rules(invariants), "R1 ");
}

/// Release, request and goodbye of site 1 arrive together, after a blackout.
TEST_F(InvariantsTest, AnHeirThatIsGoneWhenItIsGrantedThePartTakesItFromNobody) {
  invariants.onServerRecord(record(1, 1));
  invariants.onRelease({1, 0, 1, {}});
  invariants.onGrab(0, {1, 0});
  invariants.onLeft(0, 1);
  invariants.onServerRecord(record(kNoSite, 2));
  invariants.finish({});
  EXPECT_EQ(rules(invariants), "");
}

TEST_F(InvariantsTest, WhoAskedAndIsGoneExplainsNothingOfAnOwnerThatKeptThePart) {
  invariants.onServerRecord(record(2, 1));
  invariants.onGrab(0, {1, 0});
  invariants.onLeft(0, 1);
  invariants.onServerRecord(record(kNoSite, 2));
  invariants.finish({});
  EXPECT_EQ(rules(invariants), "R1 ");
}

TEST_F(InvariantsTest, FindsReplicasThatDiffer) {
  invariants.finish({{"peg", 1e-3}});
  EXPECT_EQ(rules(invariants), "L4 ");
}

TEST_F(InvariantsTest, ASiteThatRestartsCountsItsRequestsAnew) {
  sync::GrabReply reply;
  reply.request = 1;
  reply.part = record(1, 1);
  invariants.onGrabReply(0, reply);
  invariants.onAccepted(0, state(0, 9));
  reply.part = record(2, 2);
  invariants.onDead(0, 1);
  invariants.onGrabReply(0, reply);
  invariants.onAccepted(0, state(0, 1));
  EXPECT_EQ(rules(invariants), "");
  reply.part = record(2, 3);  // but within one life a second answer is still one too many
  invariants.onGrabReply(0, reply);
  EXPECT_EQ(rules(invariants), "S7 ");
}

}  // namespace
}  // namespace tandem::client
