// The session's document at sites that take part, each with the connection of a real client, through a real
// session on virtual time.

#include "client/session/session_document.h"

#include <gtest/gtest.h>

#include "assets/document/document_json.h"
#include "client/session/document_words.h"
#include "client/session/server_connection.h"
#include "tests/server/session_rig.h"

namespace tandem::client {
namespace {

using document::Change;
using document::Comment;
using document::Entry;
using document::EntryId;
using document::Note;
using document::NoteStatus;
using document::Removed;
using server::SessionRig;
using sync::kMillisecond;
using sync::kSecond;
using Kind = DocumentWish::Kind;

Note note(const std::string& text, NoteStatus status = NoteStatus::open) {
  Note n;
  n.text = text;
  n.status = status;
  return n;
}

/// A person at a site, and what the window of that site knows.
struct Person {
  std::unique_ptr<Exchange> exchange = std::make_unique<Exchange>();
  std::unique_ptr<ServerConnection> connection;
  document::Document shown;
  std::vector<std::string> notices;

  SessionDocument& document() { return connection->document(); }
  void write(EntryId id, const document::Body& body) {
    const Entry* entry = document().content().find(id);
    document().want({Kind::change, {id, entry == nullptr ? 0 : entry->revision, body}});
  }
  void undo() { document().want({Kind::undo, {}}); }
  void redo() { document().want({Kind::redo, {}}); }
  /// The entry with this text; 0 if there is none.
  EntryId find(const std::string& text) {
    for (const auto& [id, entry] : document().content().entries())
      if (inWords(entry.body).find('"' + text + '"') != std::string::npos) return id;
    return 0;
  }
  bool wasTold(const std::string& words) const {
    return std::any_of(notices.begin(), notices.end(),
                       [&](const std::string& notice) { return notice.find(words) != std::string::npos; });
  }
};

struct SessionDocuments : testing::Test, SessionRig {
  std::vector<std::unique_ptr<Person>> people;

  void afterStep() override {
    for (const auto& person : people) {
      ServerConnection& connection = *person->connection;
      connection.step(now);
      if (connection.stage() == ServerConnection::Stage::needScene) connection.skipTransfer();
      if (connection.stage() == ServerConnection::Stage::haveScene)
        connection.sceneReady(scene, *person->exchange);
      DocumentNews news = connection.document().drainNews();
      if (news.anew) person->shown.clear();
      for (const Entry& entry : news.entries) person->shown.put(entry);
      for (const Notice& notice : connection.drainNotices()) person->notices.push_back(notice.text);
    }
  }
  Person& enter(const std::string& name, sync::Role role = sync::Role::participant) {
    auto person = std::make_unique<Person>();
    ConnectionOptions options;
    options.name = name;
    options.token = token(role);
    person->connection = std::make_unique<ServerConnection>(
        options,
        [this, name]() -> Result<std::unique_ptr<sync::Transport>> { return network.connect(name); });
    people.push_back(std::move(person));
    SessionRig::run(300 * kMillisecond);
    EXPECT_TRUE(people.back()->document().standing().complete) << name;
    return *people.back();
  }
  void settle() { SessionRig::run(200 * kMillisecond); }
  /// Both replicas of everybody are what the server has.
  void expectOneDocument() {
    const std::string truth = toJson(session->document(), "s");
    for (const auto& person : people) {
      EXPECT_TRUE(person->document().standing().complete);
      EXPECT_EQ(person->document().standing().unsent, 0u);
      EXPECT_EQ(toJson(person->document().content(), "s"), truth);
      EXPECT_EQ(toJson(person->shown, "s"), truth);
    }
  }
  const document::Body& truth(EntryId id) { return session->document().find(id)->body; }
  std::string text(EntryId id) { return std::get<Note>(truth(id)).text; }
};

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

}  // namespace
}  // namespace tandem::client
