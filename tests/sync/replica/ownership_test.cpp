
#include <gtest/gtest.h>

#include "sync/replica/lease_rules.h"
#include "sync/replica/ownership_table.h"
#include "sync/replica/ownership_view.h"
#include "sync/wire/ownership_messages.h"
#include "sync/wire/participant_messages.h"
#include "sync/wire/state_update.h"
#include "sync/wire/time.h"

namespace tandem::sync {
namespace {

constexpr SiteId kAnn = 1, kBen = 2;
constexpr Role kRole = Role::participant;

class Ownership : public ::testing::Test {
 protected:
  LeaseRules rules;
  OwnershipTable table{{true, true, false}, std::vector<Pose>(3), rules};

  static Pose at(double x) { return {{x, 0.0, 0.0}, glm::dquat(1.0, 0.0, 0.0, 0.0)}; }
  static PartState state(PartId part, Epoch epoch, std::uint32_t sequence, double x = 0.0) {
    return {part, epoch, sequence, at(x), {}};
  }
};

TEST_F(Ownership, TwoGrabsAtOnceHaveOneWinner) {
  const auto first = table.grab(kAnn, kRole, {1, 0}, 0);
  const auto second = table.grab(kBen, kRole, {1, 0}, 0);
  EXPECT_EQ(first.reply.denial, Denial::none);
  EXPECT_TRUE(first.changed);
  EXPECT_EQ(second.reply.denial, Denial::ownedByOther);
  EXPECT_FALSE(second.changed);
  EXPECT_EQ(second.reply.part.owner, kAnn);
}

TEST_F(Ownership, ARepeatedRequestGetsTheSameAnswerWithoutANewGrant) {
  const auto first = table.grab(kAnn, kRole, {1, 0}, 0);
  table.release(kAnn, {2, 0, 1, at(1)});
  const auto again = table.grab(kAnn, kRole, {1, 0}, 2);
  EXPECT_TRUE(again.repeated);
  EXPECT_FALSE(again.changed);
  EXPECT_EQ(again.reply.part.epoch, first.reply.part.epoch);
  EXPECT_EQ(table.part(0).owner, kNoSite);
  EXPECT_FALSE(table.release(kAnn, {2, 0, 1, at(5)}).changed);
  EXPECT_EQ(table.part(0).worldFromPart.position.x, 1.0);
}

TEST_F(Ownership, DeniesWithTheReason) {
  EXPECT_EQ(table.grab(kAnn, Role::observer, {1, 0}, 0).reply.denial, Denial::roleForbids);
  EXPECT_EQ(table.grab(kAnn, kRole, {2, 2}, 0).reply.denial, Denial::notMovable);
  EXPECT_EQ(table.grab(kAnn, kRole, {3, 9}, 0).reply.denial, Denial::unknownPart);
  EXPECT_EQ(table.reclaim(kAnn, kRole, {4, 0, 1, {}}, 0).reply.denial, Denial::stale);
  EXPECT_EQ(table.release(kAnn, {5, 0, 0, {}}).reply.denial, Denial::stale);
}

TEST_F(Ownership, ANewEpochIsLargerThanAnyBefore) {
  Epoch last = 0;
  for (RequestId i = 0; i < 200; i += 2) {
    const auto grant = table.grab(i % 4 == 0 ? kAnn : kBen, kRole, {i, 0}, i);
    ASSERT_TRUE(grant.changed);
    EXPECT_GT(grant.reply.part.epoch, last);
    last = grant.reply.part.epoch;
    ASSERT_TRUE(table.release(grant.reply.part.owner, {i + 1, 0, last, at(0)}).changed);
  }
}

TEST_F(Ownership, ALeaseRunsOutAfterItsFullLengthAndDrift) {
  table.grab(kAnn, kRole, {1, 0}, 0);
  table.renew(kAnn, kSecond);
  const Micros end = kSecond + rules.lease + rules.drift();
  EXPECT_EQ(table.nextExpiry(), end);
  EXPECT_TRUE(table.expire(end - 1).empty());
  EXPECT_EQ(table.grab(kBen, kRole, {1, 0}, end - 1).reply.denial, Denial::ownedByOther);
  EXPECT_EQ(table.grab(kBen, kRole, {2, 0}, end).reply.denial, Denial::none) << "L2";
  table.renew(kBen, end);
  EXPECT_EQ(table.expire(end + rules.lease).size(), 0u);
  EXPECT_EQ(table.expire(end + 2 * rules.lease).size(), 1u);
}

TEST_F(Ownership, AcceptsOnlyNewStatesOfTheOwnersEpoch) {
  table.grab(kAnn, kRole, {1, 0}, 0);
  EXPECT_FALSE(table.accept(kBen, state(0, 1, 1)));
  EXPECT_FALSE(table.accept(kAnn, state(0, 2, 1)));
  EXPECT_FALSE(table.accept(kAnn, state(1, 0, 1)));
  EXPECT_TRUE(table.accept(kAnn, state(0, 1, 5, 0.5)));
  EXPECT_FALSE(table.accept(kAnn, state(0, 1, 5)));
  EXPECT_FALSE(table.accept(kAnn, state(0, 1, 4)));
  EXPECT_EQ(table.part(0).worldFromPart.position.x, 0.5);
  EXPECT_EQ(table.leave(kAnn).at(0).worldFromPart.position.x, 0.5)
      << "S6: the last state travels with the end";
  EXPECT_FALSE(table.accept(kAnn, state(0, 1, 9)));
}

TEST_F(Ownership, RevokeAndResetBeginNewEpochs) {
  table.grab(kAnn, kRole, {1, 0}, 0);
  EXPECT_FALSE(table.reset(0).has_value()) << "owned";
  EXPECT_FALSE(table.revoke(1).has_value()) << "nobody owns it";
  table.accept(kAnn, state(0, 1, 1, 0.7));
  const auto revoked = table.revoke(0);
  ASSERT_TRUE(revoked.has_value());
  EXPECT_EQ(revoked->epoch, 2u);
  EXPECT_EQ(revoked->worldFromPart.position.x, 0.7);
  const auto reset = table.reset(0);
  ASSERT_TRUE(reset.has_value());
  EXPECT_EQ(reset->epoch, 3u);
  EXPECT_EQ(reset->worldFromPart.position.x, 0.0);
}

TEST_F(Ownership, ARestartedServerGrantsNothingUntilHoldersAreBack) {
  const std::vector<PartRecord> journal{{0, kAnn, 7, at(1)}, {1, kNoSite, 3, at(2)}};
  table.restore(journal, 100);
  EXPECT_TRUE(table.recovering(100));
  EXPECT_EQ(table.grab(kBen, kRole, {1, 1}, 101).reply.denial, Denial::recovering);
  EXPECT_EQ(table.grab(kBen, kRole, {2, 0}, 101).reply.denial, Denial::ownedByOther);
  const auto back = table.reclaim(kAnn, kRole, {1, 0, 7, at(4)}, 102);
  EXPECT_EQ(back.reply.denial, Denial::none);
  EXPECT_FALSE(back.changed);
  EXPECT_EQ(back.reply.part.epoch, 7u);
  EXPECT_FALSE(table.recovering(103));
  EXPECT_EQ(table.grab(kBen, kRole, {3, 1}, 103).reply.part.epoch, 4u);
}

TEST_F(Ownership, ARestartedServerWaitsForTheLeaseOfAHolderThatNeverComes) {
  const std::vector<PartRecord> journal{{0, kAnn, 7, at(1)}};
  table.restore(journal, 100);
  const Micros end = 100 + rules.serverLease();
  EXPECT_EQ(table.grab(kBen, kRole, {1, 1}, end - 1).reply.denial, Denial::recovering);
  EXPECT_EQ(table.expire(end).size(), 1u);
  EXPECT_EQ(table.grab(kBen, kRole, {2, 0}, end).reply.part.epoch, 8u);
  EXPECT_EQ(table.reclaim(kAnn, kRole, {9, 0, 7, at(1)}, end).reply.denial, Denial::stale);
}

TEST_F(Ownership, AGrabRepeatedAfterARestartKeepsItsEpoch) {
  const std::vector<PartRecord> journal{{0, kAnn, 7, at(1)}};
  table.restore(journal, 0);
  const auto again = table.grab(kAnn, kRole, {1, 0}, 1);
  EXPECT_EQ(again.reply.denial, Denial::none);
  EXPECT_EQ(again.reply.part.epoch, 7u);
  EXPECT_FALSE(again.changed);
}

TEST_F(Ownership, AViewOrdersRecordsByEpochAndEnd) {
  OwnershipView view(3, rules);
  EXPECT_TRUE(view.apply({0, kAnn, 4, at(0)}));
  EXPECT_FALSE(view.apply({0, kAnn, 4, at(1)})) << "nothing new";
  EXPECT_FALSE(view.apply({0, kBen, 3, at(0)}));
  EXPECT_TRUE(view.apply({0, kNoSite, 4, at(0)}));
  EXPECT_FALSE(view.apply({0, kAnn, 4, at(0)})) << "the grant, repeated after its end";
  EXPECT_TRUE(view.apply({0, kBen, 5, at(0)}));
  EXPECT_FALSE(view.apply({0, kNoSite, 4, at(0)}));
  EXPECT_FALSE(view.apply({9, kBen, 5, at(0)}));
}

TEST_F(Ownership, AViewAcceptsOnlyWhatIsNewFromTheOwner) {
  using Verdict = OwnershipView::Verdict;
  OwnershipView view(3, rules);
  view.setSelf(kBen);
  view.apply({0, kAnn, 4, at(0)});
  view.apply({1, kBen, 2, at(0)});
  EXPECT_EQ(view.accept(kAnn, state(0, 4, 1)), Verdict::accepted);
  EXPECT_EQ(view.accept(kAnn, state(0, 4, 1)), Verdict::oldSequence);
  EXPECT_EQ(view.accept(kAnn, state(0, 3, 9)), Verdict::oldEpoch);
  EXPECT_EQ(view.accept(kAnn, state(0, 5, 9)), Verdict::futureEpoch);
  EXPECT_EQ(view.accept(3, state(0, 4, 9)), Verdict::notOwner);
  EXPECT_EQ(view.accept(kAnn, state(1, 2, 9)), Verdict::ownPart);
  EXPECT_EQ(view.accept(kAnn, state(7, 1, 1)), Verdict::unknownPart);
}

TEST_F(Ownership, AnOwnerStopsPublishingBeforeTheServerMayFreeThePart) {
  OwnershipView view(3, rules);
  view.setSelf(kAnn);
  view.apply({0, kAnn, 1, at(0)});
  view.confirmed(0, 1);
  EXPECT_FALSE(view.mayPublish(0, 0)) << "no pong yet";
  view.renewed(1000);
  view.renewed(500);  // the pong of an older ping arrives late
  const Micros end = 1000 + rules.lease - rules.drift() - rules.margin;
  EXPECT_TRUE(view.mayPublish(0, end - 1));
  EXPECT_FALSE(view.mayPublish(0, end));
  EXPECT_FALSE(view.mayPublish(1, 1000)) << "not its part";
}

/// The grant is in a stream that stalls for longer than a lease, while pings and pongs pass.
TEST_F(Ownership, AGrantThatIsReadAfterALapseIsReclaimedFirst) {
  const Micros lease = rules.siteLease(), later = 2 * lease + 20;
  OwnershipView view(3, rules);
  view.setSelf(kAnn);
  view.renewed(0, 10);
  const std::uint32_t asked = view.lapses();
  view.renewed(2 * lease, 2 * lease + 10);
  EXPECT_NE(view.lapses(), asked) << "so the answer to what was asked confirms nothing";
  view.apply({0, kAnn, 1, at(0)});
  EXPECT_FALSE(view.mayPublish(0, later)) << "the server may have ended it";
  EXPECT_TRUE(view.needsReclaim(0));
  view.confirmed(0, 1);
  EXPECT_TRUE(view.mayPublish(0, later));
}

/// An heir publishes at once, unless no ping of it was answered since it became a co-holder.
TEST_F(Ownership, APartIsPassedToAnHeirWhoseLeaseHasNotLapsed) {
  const Micros lease = rules.siteLease();
  OwnershipView view(3, rules);
  view.setSelf(kBen);
  view.renewed(0, 10);
  for (const PartId part : {PartId{0}, PartId{1}}) {
    view.apply(PartRecord{part, kAnn, 1, at(0)});
    view.coHoldingConfirmed(part);
  }
  view.apply(PartRecord{0, kBen, 2, at(0)});
  EXPECT_TRUE(view.mayPublish(0, 100));
  view.renewed(2 * lease, 2 * lease + 10);
  view.apply(PartRecord{1, kBen, 2, at(0)});
  EXPECT_TRUE(view.needsReclaim(1));
}

}  // namespace
}  // namespace tandem::sync
