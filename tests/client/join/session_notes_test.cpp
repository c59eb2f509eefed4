#include "client/join/session_notes.h"

#include <gtest/gtest.h>

namespace tandem::client {
namespace {

using namespace sync;

TEST(SessionNotes, AGrabIsNotedWithItsAnswerAndAReclaimIsNot) {
  SessionNotes notes;
  notes.onGrab({7, 3});
  notes.onGrabReply({7, Denial::ownedByOther, {3, 2, 5, {}}});
  notes.onGrabReply({8, Denial::none, {4, 1, 6, {}}});  // no person at this site requested it
  const std::vector<GrabNote> grabs = notes.drainGrabs();
  ASSERT_EQ(grabs.size(), 1u);
  EXPECT_EQ(grabs[0].part, 3);
  EXPECT_EQ(grabs[0].owner, 2);
  EXPECT_EQ(grabs[0].denial, Denial::ownedByOther);
  EXPECT_GE(grabs[0].wait_ms, 0.0);
  EXPECT_TRUE(notes.drainGrabs().empty());
}

TEST(SessionNotes, ChangesOfOwnershipAreDrainedOnceAndInOrder) {
  SessionNotes notes;
  notes.onOwnership({1, 2, 1, {}});
  notes.onOwnership({1, kNoSite, 1, {}});
  const std::vector<OwnershipNote> changes = notes.drainOwnership();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].record.owner, 2);
  EXPECT_EQ(changes[1].record.owner, kNoSite);
  EXPECT_LE(changes[0].time, changes[1].time);
  EXPECT_TRUE(notes.drainOwnership().empty());
}

TEST(SessionNotes, APartThatIsSharedAgainCountsOnce) {
  SessionNotes notes;
  EXPECT_EQ(notes.sharedParts(), 0u);
  for (const PartId part : {PartId{3}, PartId{3}, PartId{4}}) {
    sync::EngageReply reply;
    reply.coHolders.part = part;
    notes.onEngaged(reply);
  }
  EXPECT_EQ(notes.sharedParts(), 2u);
}

}  // namespace
}  // namespace tandem::client
