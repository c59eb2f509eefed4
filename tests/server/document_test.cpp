// The session's document at the server: order, roles, durability, and what a joiner gets.

#include <gtest/gtest.h>

#include <map>

#include "tests/server/session_rig.h"

namespace tandem::server {
namespace {

using document::Change;
using document::EntryId;
using document::Note;
using document::Removed;
using document::Revision;
using PutRefusal = document::Refusal;

Note note(const std::string& text) {
  Note n;
  n.text = text;
  return n;
}

struct DocumentSession : testing::Test {
  SessionRig rig;

  PutReply put(FakeSite& site, RequestId request, const Change& change) {
    const std::size_t before = site.count<PutReply>();
    site.send(PutEntry{request, change});
    rig.run(40 * kMillisecond);
    EXPECT_EQ(site.count<PutReply>(), before + 1);
    const auto* reply = site.last<PutReply>();
    return reply == nullptr ? PutReply{} : *reply;
  }
  /// What a site knows of the document, by what it was told since its last request.
  static std::map<EntryId, document::Entry> replica(const FakeSite& site, bool& complete) {
    document::Document known;
    complete = false;
    for (const ControlMessage& message : site.received) {
      if (const auto* chunk = std::get_if<DocumentChunk>(&message)) {
        if (chunk->first) {
          document::Document newer;
          for (auto at = known.after(chunk->revision); at != known.byRevision().end(); ++at)
            newer.put(*known.find(at->second));
          known = newer;
        }
        for (const document::Entry& entry : chunk->entries) known.put(entry);
        complete = chunk->last;
      }
      if (const auto* changed = std::get_if<DocumentChanged>(&message)) known.put(changed->entry);
    }
    return known.entries();
  }
  void expectSameDocument(const FakeSite& site) const {
    bool complete = false;
    const auto known = replica(site, complete);
    EXPECT_TRUE(complete);
    ASSERT_EQ(known.size(), rig.session->document().entries().size());
    for (const auto& [id, entry] : rig.session->document().entries())
      EXPECT_EQ(known.at(id).revision, entry.revision) << id;
  }
};

TEST_F(DocumentSession, TellsEverybodyOfAChangeAndItsAuthorTheRevision) {
  FakeSite& a = rig.join("a");
  FakeSite& b = rig.join("b");
  const PutReply made = put(a, 1, {0, 0, note("leaks")});
  EXPECT_EQ(made.refusal, PutRefusal::none);
  ASSERT_NE(b.last<DocumentChanged>(), nullptr);
  const document::Entry& entry = b.last<DocumentChanged>()->entry;
  EXPECT_EQ(entry.id, made.entry);
  EXPECT_EQ(entry.revision, made.revision);
  EXPECT_EQ(entry.authorName, "a");
  EXPECT_EQ(std::get<Note>(entry.body).text, "leaks");
  EXPECT_EQ(a.count<DocumentChanged>(), 1u);
}

TEST_F(DocumentSession, RefusesAChangeOfWhatAnotherHasChangedSince) {
  FakeSite& a = rig.join("a");
  FakeSite& b = rig.join("b");
  const PutReply made = put(a, 1, {0, 0, note("one")});
  const PutReply changed = put(b, 1, {made.entry, made.revision, note("two")});
  EXPECT_EQ(changed.refusal, PutRefusal::none);
  EXPECT_EQ(put(a, 2, {made.entry, made.revision, note("three")}).refusal, PutRefusal::changedSince);
  EXPECT_EQ(std::get<Note>(rig.session->document().find(made.entry)->body).text, "two");
}

TEST_F(DocumentSession, GoesByRoles) {
  FakeSite& observer = rig.join("o", Role::observer);
  FakeSite& a = rig.join("a");
  FakeSite& b = rig.join("b");
  FakeSite& instructor = rig.join("i", Role::instructor);
  EXPECT_EQ(put(observer, 1, {0, 0, note("x")}).refusal, PutRefusal::roleForbids);
  const PutReply made = put(a, 1, {0, 0, note("one")});
  EXPECT_EQ(put(observer, 2, {made.entry, made.revision, note("x")}).refusal, PutRefusal::roleForbids);
  EXPECT_EQ(put(b, 1, {made.entry, made.revision, Removed{}}).refusal, PutRefusal::roleForbids);
  const PutReply changed = put(b, 2, {made.entry, made.revision, note("two")});
  EXPECT_EQ(changed.refusal, PutRefusal::none);
  EXPECT_EQ(put(a, 2, {made.entry, changed.revision, Removed{}}).refusal, PutRefusal::none);
  const PutReply second = put(a, 3, {0, 0, note("two")});
  EXPECT_EQ(put(instructor, 1, {second.entry, second.revision, Removed{}}).refusal, PutRefusal::none);
}

TEST_F(DocumentSession, ARequestThatIsSentAgainHasOneEffectAlsoAfterARestart) {
  FakeSite& a = rig.join("a");
  const std::string ticket = a.last<Welcome>()->resumeTicket;
  const PutReply made = put(a, 7, {0, 0, note("one")});
  const PutReply again = put(a, 7, {0, 0, note("one")});
  EXPECT_EQ(again.entry, made.entry);
  EXPECT_EQ(again.revision, made.revision);
  const PutReply changed = put(a, 8, {made.entry, made.revision, note("two")});
  rig.crash();
  rig.start();
  FakeSite& back = rig.resume("a", ticket);
  EXPECT_EQ(put(back, 7, {0, 0, note("one")}).entry, made.entry);
  const PutReply changedAgain = put(back, 8, {made.entry, made.revision, note("two")});
  EXPECT_EQ(changedAgain.refusal, PutRefusal::none);
  EXPECT_EQ(changedAgain.revision, changed.revision);
  EXPECT_EQ(rig.session->document().size(), 1u);
  EXPECT_EQ(rig.session->document().revision(), changed.revision);
}

/// A rig whose disk takes its time.
struct SlowDisk : DocumentSession {
  SlowDisk() {
    rig.crash();
    rig.journal = MemoryJournal{200 * kMillisecond};
    rig.start();
  }
  FakeSite& joinSlowly(const std::string& name) {
    FakeSite& site = rig.connect(name);
    site.send(Hello{kProtocolVersion, false, rig.token(Role::participant), name, {1, 2, 3}});
    rig.run(300 * kMillisecond);
    site.send(Ready{});
    rig.run(20 * kMillisecond);
    return site;
  }
};

TEST_F(SlowDisk, NobodyLearnsOfAChangeThatACrashCanUndo) {
  FakeSite& a = joinSlowly("a");
  FakeSite& b = joinSlowly("b");
  a.send(PutEntry{1, {0, 0, note("one")}});
  rig.run(50 * kMillisecond);
  ASSERT_EQ(rig.session->document().size(), 1u);
  b.send(DocumentRequest{0});
  rig.run(100 * kMillisecond);
  EXPECT_EQ(a.count<PutReply>(), 0u);
  for (const FakeSite* site : {&a, &b}) {
    EXPECT_EQ(site->count<DocumentChanged>(), 0u);
    EXPECT_EQ(site->count<DocumentChunk>(), 0u);
  }
  rig.run(200 * kMillisecond);
  EXPECT_EQ(a.count<PutReply>(), 1u);
  EXPECT_EQ(b.count<DocumentChanged>(), 1u);
  expectSameDocument(b);
  // What is lost with the server was told to nobody; the next change has its number.
  a.send(PutEntry{2, {0, 0, note("two")}});
  rig.run(50 * kMillisecond);
  rig.crash();
  EXPECT_EQ(b.count<DocumentChanged>(), 1u);
  rig.start();
  EXPECT_EQ(rig.session->document().size(), 1u);
}

TEST_F(DocumentSession, AJoinerGetsTheWholeDocumentWhileOthersChangeIt) {
  rig.config.maxBacklogBytes = 16 * 1024;
  rig.crash();
  rig.start();
  FakeSite& a = rig.join("a");
  RequestId request = 0;
  for (int i = 0; i < 300; ++i) {
    a.send(PutEntry{++request, {0, 0, note(std::string(500, 'x'))}});
    rig.run(6 * kMillisecond);
  }
  rig.run(100 * kMillisecond);
  ASSERT_EQ(rig.session->document().size(), 300u);
  FakeSite& b = rig.join("b");
  b.send(DocumentRequest{0});
  // The first entries move behind what the joiner has been sent, and new ones come.
  for (EntryId id = 1; id <= 20; ++id) {
    a.send(PutEntry{++request, {id, id, note("changed")}});
    a.send(PutEntry{++request, {0, 0, note("new")}});
    rig.run(2 * kMillisecond);
  }
  rig.run(2 * kSecond);
  expectSameDocument(b);
  EXPECT_GT(b.count<DocumentChunk>(), 3u);
  // Who has it all gets nothing again.
  const std::size_t chunks = b.count<DocumentChunk>();
  b.send(DocumentRequest{rig.session->document().revision()});
  rig.run(100 * kMillisecond);
  EXPECT_EQ(b.count<DocumentChunk>(), chunks + 1);
  EXPECT_TRUE(b.last<DocumentChunk>()->last);
  EXPECT_FALSE(b.last<DocumentChunk>()->first);
  EXPECT_TRUE(b.last<DocumentChunk>()->entries.empty());
}

TEST_F(DocumentSession, AnEmptyDocumentIsCompleteAtOnce) {
  FakeSite& a = rig.join("a");
  EXPECT_EQ(a.count<DocumentChunk>(), 0u) << "nobody asked";
  a.send(DocumentRequest{0});
  rig.run(40 * kMillisecond);
  ASSERT_EQ(a.count<DocumentChunk>(), 1u);
  EXPECT_TRUE(a.last<DocumentChunk>()->first);
  EXPECT_TRUE(a.last<DocumentChunk>()->last);
}

TEST_F(DocumentSession, WhileTheJournalFailsNothingIsTakenAndWhatWasIsToldLater) {
  FakeSite& a = rig.join("a");
  FakeSite& b = rig.join("b");
  rig.journal.fail("disk full");
  a.send(PutEntry{1, {0, 0, note("early")}});
  // The session has not noticed yet, or notices now: either way nothing is told.
  rig.run(100 * kMillisecond);
  EXPECT_EQ(b.count<DocumentChanged>(), 0u);
  EXPECT_EQ(put(a, 2, {0, 0, note("late")}).refusal, PutRefusal::notNow);
  rig.journal.heal();
  rig.run(100 * kMillisecond);
  const PutReply again = put(a, 2, {0, 0, note("late")});
  EXPECT_EQ(again.refusal, PutRefusal::none);
  b.send(DocumentRequest{0});
  rig.run(100 * kMillisecond);
  expectSameDocument(b);
}

}  // namespace
}  // namespace tandem::server
