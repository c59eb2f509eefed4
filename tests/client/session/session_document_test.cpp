// The session's document at sites that take part, each with the connection of a real client, through a real
// session on virtual time.

#include "client/session/session_document.h"

#include <gtest/gtest.h>

#include "tests/client/session/document_people.h"

namespace tandem::client {
namespace {

TEST_F(SessionDocuments, WhoJoinsHasWhatIsThereAndEachLaterChange) {
  Person& ada = enter("ada");
  for (int i = 0; i < 5; ++i) ada.write(0, note("note " + std::to_string(i)));
  settle();
  Person& ben = enter("ben", sync::Role::observer);
  EXPECT_EQ(ben.shown.size(), 5u);
  ada.write(0, Comment{ada.find("note 2"), "which one?"});
  ada.write(ada.find("note 3"), note("note 3", NoteStatus::closed));
  settle();
  EXPECT_EQ(ben.shown.size(), 6u);
  expectOneDocument();
  EXPECT_EQ(inWords(ben.shown), "6 entries, the last by ada: note \"note 3\"");
}

TEST_F(SessionDocuments, ChangesOfOneEntryThatFollowEachOtherQuicklyAreAllMade) {
  Person& ada = enter("ada");
  ada.write(0, note("bolt"));
  settle();
  const EntryId id = ada.find("bolt");
  for (const char* text : {"one", "two", "three"}) ada.write(id, note(text));  // all upon one revision
  EXPECT_EQ(ada.document().standing().unsent, 3u);
  settle();
  EXPECT_EQ(text(id), "three");
  EXPECT_TRUE(ada.notices.empty()) << ada.notices.front();
  expectOneDocument();
}

TEST_F(SessionDocuments, AChangeThatADeadServerDidNotAnswerIsMadeOnceByTheNext) {
  Person& ada = enter("ada");
  Person& ben = enter("ben");
  // Cut at every stage of the way: before it arrives, before it is durable, before the answer is back.
  for (const int wait : {1, 5, 6, 8, 9, 12, 14}) {
    ada.write(0, note("after " + std::to_string(wait)));
    SessionRig::run(wait * kMillisecond);
    crash();
    SessionRig::run(50 * kMillisecond);
    start();
    SessionRig::run(3 * kSecond);
  }
  EXPECT_EQ(session->document().size(), 7u);
  ben.write(ben.find("after 9"), note("changed"));
  settle();
  expectOneDocument();
}

TEST_F(SessionDocuments, WhatHappenedInAnOutageIsThereAfterwards) {
  Person& ada = enter("ada");
  Person& ben = enter("ben");
  ada.write(0, note("one"));
  settle();
  network.blackout("ada", now + 4 * kSecond);
  ben.write(0, note("two"));
  ben.write(ben.find("one"), note("one, changed"));
  ada.write(0, note("written in the dark"));
  SessionRig::run(kSecond);
  EXPECT_EQ(ada.shown.size(), 1u);
  SessionRig::run(8 * kSecond);
  EXPECT_EQ(session->document().size(), 3u);
  expectOneDocument();
}

TEST_F(SessionDocuments, AFullDiskPutsAChangeOffUntilItIsWell) {
  Person& ada = enter("ada");
  journal.fail("no space");
  ada.write(0, note("one"));
  SessionRig::run(2 * kSecond);
  EXPECT_EQ(ada.document().standing().unsent, 1u);
  EXPECT_EQ(session->document().size(), 0u);
  journal.heal();
  SessionRig::run(2 * kSecond);
  expectOneDocument();
  EXPECT_EQ(session->document().size(), 1u);
}

TEST_F(SessionDocuments, WhatIsRefusedIsSaidAndChangesNothing) {
  Person& ada = enter("ada");
  Person& otto = enter("otto", sync::Role::observer);
  otto.write(0, note("mine"));
  settle();
  EXPECT_TRUE(otto.wasTold("not done: note \"mine\": this role may not change it"));
  ada.write(0, note("one"));
  settle();
  Person& ben = enter("ben");
  ben.write(ben.find("one"), Removed{});
  settle();
  EXPECT_TRUE(ben.wasTold("not done: note \"one\": this role may not change it"));
  ada.document().want({Kind::change, {ada.find("one"), 77, note("stale")}});
  settle();
  EXPECT_TRUE(ada.wasTold("not done: note \"stale\": ada has changed it since"));
  EXPECT_EQ(text(ada.find("one")), "one");
  expectOneDocument();
}

TEST_F(SessionDocuments, AnAnswerToNothingAndAWholeBeyondTheLimitsAreRefused) {
  Participants participants;
  MessageSender sender;
  SessionDocument document(participants, sender);
  EXPECT_FALSE(document.handle(sync::PutReply{1, document::Refusal::none, {}, 1, 1}));
  sync::DocumentChunk chunk{true, true, 1, {}};
  for (std::size_t i = 0; i <= document::kMaxEntries; ++i) {
    Entry entry;
    entry.id = entry.revision = i + 1;
    entry.body = document::Group{"g", {}};
    chunk.entries.push_back(entry);
  }
  EXPECT_FALSE(document.handle(chunk));
}

// ---- undo and redo ----

TEST_F(SessionDocuments, UndoTakesBackOnesOwnChangesLastFirstAndRedoMakesThemAgain) {
  Person& ada = enter("ada");
  ada.write(0, note("one"));
  settle();
  const EntryId id = ada.find("one");
  ada.write(id, note("two"));
  ada.write(id, note("three"));
  settle();
  const auto undoneTo = [&](const char* expected) {
    ada.undo();
    settle();
    EXPECT_EQ(text(id), expected);
  };
  undoneTo("two");
  undoneTo("one");
  ada.undo();
  settle();
  EXPECT_TRUE(session->document().find(id)->removed());
  ada.undo();
  settle();
  EXPECT_TRUE(ada.wasTold("nothing to undo"));
  for (const char* expected : {"one", "two", "three"}) {
    ada.redo();
    settle();
    EXPECT_EQ(text(id), expected);
  }
  ada.redo();
  settle();
  EXPECT_TRUE(ada.wasTold("nothing to redo"));
  undoneTo("two");
  ada.write(id, note("four"));  // what was undone cannot be done again after a new change
  settle();
  ada.redo();
  settle();
  EXPECT_EQ(text(id), "four");
  undoneTo("two");
  EXPECT_EQ(session->document().revision(), 12u);  // every step is a revision of its own
  expectOneDocument();
}

TEST_F(SessionDocuments, UndoLeavesAloneWhatAnotherHasChangedSince) {
  Person& ada = enter("ada");
  Person& ben = enter("ben");
  ada.write(0, note("ada's"));
  ada.write(0, note("shared"));
  settle();
  const EntryId id = ada.find("shared");
  ada.write(id, note("shared, by ada"));
  settle();
  EXPECT_EQ(ada.document().standing().undo, "note \"shared, by ada\"");
  EXPECT_EQ(ada.document().standing().redo, "");
  ben.write(id, note("shared, by ben"));
  settle();
  ada.undo();
  settle();
  EXPECT_EQ(text(id), "shared, by ben");
  EXPECT_TRUE(ada.wasTold("ben has changed it since")) << ada.notices.back();
  // The steps of that entry are gone, those of others are not.
  ada.undo();
  settle();
  EXPECT_EQ(ada.find("ada's"), 0u);
  ben.undo();
  settle();
  EXPECT_EQ(text(id), "shared, by ada");
  expectOneDocument();
}

TEST_F(SessionDocuments, UndoOfAnotherStepBetweenIsNotMistakenForTheStateBefore) {
  Person& ada = enter("ada");
  Person& ben = enter("ben");
  ada.write(0, note("one"));
  settle();
  const EntryId id = ada.find("one");
  ben.write(id, note("two"));
  settle();
  ada.write(id, note("three"));
  settle();
  ada.undo();
  settle();
  EXPECT_EQ(text(id), "two");
  ada.undo();  // of the creation: ben has changed the note since
  settle();
  EXPECT_EQ(text(id), "two");
  EXPECT_TRUE(ada.wasTold("not undone")) << ada.notices.back();
  ben.undo();  // ada's undo is a change since
  settle();
  EXPECT_EQ(text(id), "two");
  EXPECT_TRUE(ben.wasTold("ada has changed it since")) << ben.notices.back();
}

TEST_F(SessionDocuments, TheServerRefusesAnUndoThatCrossesAnothersChange) {
  Person& ada = enter("ada");
  Person& ben = enter("ben");
  ada.write(0, note("one"));
  settle();
  const EntryId id = ada.find("one");
  ada.write(id, note("two"));
  settle();
  ben.write(id, note("three"));
  SessionRig::run(2 * kMillisecond);
  ada.undo();  // ben's change is under way: this site does not know of it
  settle();
  EXPECT_EQ(text(id), "three");
  EXPECT_TRUE(ada.wasTold("not undone: note \"two\": another has changed it since")) << ada.notices.back();
}

TEST_F(SessionDocuments, UndoGoesByRolesAndReferences) {
  Person& ada = enter("ada");
  Person& ines = enter("ines", sync::Role::instructor);
  ada.write(0, note("one"));
  settle();
  const EntryId id = ada.find("one");
  ines.write(id, Removed{});
  settle();
  EXPECT_TRUE(session->document().find(id)->removed());
  ines.undo();
  settle();
  EXPECT_EQ(text(id), "one");
  ines.write(0, Comment{id, "why?"});
  ada.write(id, note("two"));
  settle();
  ada.undo();
  settle();
  EXPECT_EQ(text(id), "one") << "a change is taken back though the note has a reply";
  Person& ben = enter("ben");
  ben.write(0, note("ben's"));
  settle();
  ines.write(0, Comment{ben.find("ben's"), "no"});
  settle();
  ben.undo();
  settle();
  EXPECT_NE(ben.find("ben's"), 0u);
  EXPECT_TRUE(ben.wasTold("not undone: note \"ben's\": another entry refers to it")) << ben.notices.back();
  expectOneDocument();
}

TEST_F(SessionDocuments, AnUndoThatADeadServerDidNotAnswerIsMadeOnce) {
  Person& ada = enter("ada");
  ada.write(0, note("one"));
  settle();
  const EntryId id = ada.find("one");
  for (const char* text : {"two", "three", "four"}) ada.write(id, note(text));
  settle();
  for (const int wait : {6, 9, 12}) {
    ada.undo();
    SessionRig::run(wait * kMillisecond);
    crash();
    SessionRig::run(50 * kMillisecond);
    start();
    SessionRig::run(3 * kSecond);
  }
  EXPECT_EQ(text(id), "one");
  expectOneDocument();
}

// ---- poses of parts ----

struct MovedParts : SessionDocuments {
  sync::PartRecord record(PartId part) {
    for (const sync::PartRecord& record : journal.contents().parts)
      if (record.part == part) return record;
    return {};
  }
  /// What a hand does that is asked to move a part back: it grabs the part and releases it there.
  void playHand(Person& person) {
    NetworkEvent event;
    while (person.exchange->events.pop(event)) {
      if (event.kind == NetworkEvent::Kind::place)
        move(person, event.record.part, event.record.worldFromPart);
    }
  }
  /// Grabs a part and releases it at a pose.
  void move(Person& person, PartId part, const Pose& to) {
    ASSERT_TRUE(person.exchange->intents.push({HandIntent::Kind::grab, part, 0, {}, 0}));
    settle();
    const Epoch epoch = record(part).epoch;
    ASSERT_TRUE(person.exchange->intents.push({HandIntent::Kind::release, part, epoch, to, 0}));
    settle();
  }
  void move(Person& person, PartId part, double y) {
    move(person, part, Pose{{0.1 * part, y, 0.0}, {1, 0, 0, 0}});
  }
  double height(PartId part) { return record(part).worldFromPart.position.y; }
  void undo(Person& person) {
    person.undo();
    settle();
    playHand(person);
  }
  void redo(Person& person) {
    person.redo();
    settle();
    playHand(person);
  }
};

TEST_F(MovedParts, ComeBackInTheOrderOfAllThatThisPersonDid) {
  Person& ada = enter("ada");
  move(ada, 0, 0.1);
  ada.write(0, note("one"));
  settle();
  move(ada, 0, 0.2);
  move(ada, 1, 0.3);
  EXPECT_EQ(ada.document().standing().undo, "move of part1");
  undo(ada);
  EXPECT_EQ(height(1), 0.0);
  undo(ada);
  EXPECT_EQ(height(0), 0.1);
  undo(ada);
  EXPECT_EQ(session->document().size(), 0u);
  undo(ada);
  EXPECT_EQ(height(0), 0.0);
  undo(ada);
  EXPECT_TRUE(ada.wasTold("nothing to undo"));
  for (int i = 0; i < 4; ++i) redo(ada);
  EXPECT_EQ(height(0), 0.2);
  EXPECT_EQ(height(1), 0.3);
  EXPECT_EQ(session->document().size(), 1u);
  undo(ada);
  undo(ada);
  EXPECT_EQ(height(0), 0.1);
}

TEST_F(MovedParts, StayWhereAnotherHasLeftOrHoldsThem) {
  Person& ada = enter("ada");
  Person& ben = enter("ben");
  move(ada, 0, 0.1);
  move(ada, 1, 0.1);
  move(ben, 1, 0.5);
  undo(ada);
  EXPECT_EQ(height(1), 0.5);
  EXPECT_TRUE(ada.wasTold("not undone: move of part1: another has moved it since"));
  ASSERT_TRUE(ben.exchange->intents.push({HandIntent::Kind::grab, 0, 0, {}, 0}));
  settle();
  undo(ada);
  EXPECT_TRUE(ada.wasTold("not undone: move of part0: ben holds it"));
  undo(ben);
  EXPECT_EQ(height(1), 0.1);
}

TEST_F(MovedParts, AHandThatDoesNotGetThePartIsNotWaitedForForEver) {
  Person& ada = enter("ada");
  move(ada, 0, 0.1);
  ada.write(0, note("one"));
  settle();
  ada.undo();
  settle();
  ada.undo();
  ada.write(0, note("two"));
  SessionRig::run(SessionDocument::kPlacing + kSecond);
  EXPECT_TRUE(ada.wasTold("not undone: move of part0: the part cannot be had"));
  EXPECT_NE(ada.find("two"), 0u);
  EXPECT_EQ(height(0), 0.1);
}

}  // namespace
}  // namespace tandem::client
