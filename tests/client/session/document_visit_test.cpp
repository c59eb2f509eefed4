// The session's document as a visitor fetches it and brings entries in, through a real session on virtual
// time.

#include "client/session/document_visit.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "assets/document/document_json.h"
#include "assets/scene/scene_package.h"
#include "tests/server/session_rig.h"

namespace tandem::client {
namespace {

using server::SessionRig;
using sync::kMillisecond;

struct Visitor {
  std::unique_ptr<sync::Transport> transport;
  std::unique_ptr<DocumentVisit> visit;
};

struct DocumentVisits : testing::Test {
  SessionRig rig;

  Visitor begin(const std::string& name, sync::Role role = sync::Role::participant) {
    Visitor visitor;
    visitor.transport = rig.network.connect(name);
    visitor.visit = std::make_unique<DocumentVisit>(
        *visitor.transport, sync::Hello{sync::kProtocolVersion, false, rig.token(role), name, {}});
    return visitor;
  }
  /// Whether `done` holds within `patience`.
  template <typename Done>
  bool run(const Visitor& visitor, sync::Micros patience, const Done& done) {
    for (const sync::Micros end = rig.now + patience; rig.now < end && !done();) {
      rig.run(kMillisecond);
      visitor.visit->step(rig.now);
    }
    return done();
  }
  bool arrive(const Visitor& visitor) {
    return run(visitor, sync::kSecond, [&] { return visitor.visit->stage() == DocumentVisit::Stage::there; });
  }
  bool bringIn(const Visitor& visitor, std::vector<document::Entry> entries, sync::Micros patience) {
    visitor.visit->bringIn(std::move(entries));
    return run(visitor, patience, [&] { return visitor.visit->bringing()->done(); });
  }
};

/// Notes, each with a comment behind all of them.
std::vector<document::Entry> file(std::size_t notes) {
  std::vector<document::Entry> entries(2 * notes);
  for (std::size_t i = 0; i < notes; ++i) {
    document::Note note;
    note.text = "note " + std::to_string(i);
    entries[i].id = 1000 + i;
    entries[i].body = note;
    entries[notes + i].id = 5000 + i;
    entries[notes + i].body = document::Comment{1000 + i, "comment " + std::to_string(i)};
  }
  return entries;
}

TEST_F(DocumentVisits, FindsAnEmptyDocumentComplete) {
  const Visitor a = begin("a", sync::Role::observer);
  ASSERT_TRUE(arrive(a));
  EXPECT_EQ(a.visit->content().size(), 0u);
}

TEST_F(DocumentVisits, BringsEntriesInWithTheirReferencesAndNeverTwice) {
  const Visitor a = begin("a");
  ASSERT_TRUE(arrive(a));
  ASSERT_TRUE(bringIn(a, file(20), 5 * sync::kSecond));
  EXPECT_EQ(a.visit->bringing()->made(), 40u);
  for (const auto& [id, entry] : rig.session->document().entries())
    if (const auto* comment = std::get_if<document::Comment>(&entry.body)) {
      const auto* note = rig.session->document().find(comment->note);
      ASSERT_NE(note, nullptr);
      EXPECT_EQ(comment->text.substr(8), std::get<document::Note>(note->body).text.substr(5));
    }
  const Visitor b = begin("b");
  ASSERT_TRUE(arrive(b));
  EXPECT_EQ(toJson(b.visit->content(), "s"), toJson(rig.session->document(), "s"));
  // What was exported comes back as what is there already, but for one entry that is new.
  auto again = document::fromJson(toJson(b.visit->content(), "s"), "export");
  ASSERT_TRUE(again.ok()) << again.error().message;
  document::Entry extra;
  extra.id = 77777;
  extra.body = document::Group{"extra", {1}};
  again->entries.push_back(extra);
  ASSERT_TRUE(bringIn(b, again->entries, 5 * sync::kSecond));
  EXPECT_EQ(b.visit->bringing()->known(), 40u);
  EXPECT_EQ(b.visit->bringing()->made(), 1u);
  EXPECT_EQ(rig.session->document().size(), 41u);
}

TEST_F(DocumentVisits, ALongImportKeepsToWhatTheServerAllowsASite) {
  const Visitor a = begin("a");
  ASSERT_TRUE(arrive(a));
  ASSERT_TRUE(bringIn(a, file(750), 20 * sync::kSecond));
  EXPECT_EQ(a.visit->bringing()->made(), 1500u);
  EXPECT_EQ(rig.session->counters().holds, 0u);
}

TEST_F(DocumentVisits, CountsWhatIsRefusedAndSaysWhy) {
  const Visitor a = begin("a", sync::Role::observer);
  ASSERT_TRUE(arrive(a));
  ASSERT_TRUE(bringIn(a, file(2), 5 * sync::kSecond));
  EXPECT_EQ(a.visit->bringing()->refused(), 4u);
  EXPECT_EQ(a.visit->bringing()->reason(), "this role may not change it");
}

TEST_F(DocumentVisits, ChangesEntriesOfTheSessionThatAreNotSoAlready) {
  const Visitor a = begin("a");
  ASSERT_TRUE(arrive(a));
  ASSERT_TRUE(bringIn(a, file(2), 5 * sync::kSecond));
  const Visitor b = begin("b");
  ASSERT_TRUE(arrive(b));
  const std::size_t size = b.visit->content().size();
  std::vector<document::Entry> entries;
  for (const auto& [id, entry] : b.visit->content().entries()) entries.push_back(entry);
  const auto note = std::find_if(entries.begin(), entries.end(), [](const document::Entry& entry) {
    return std::holds_alternative<document::Note>(entry.body);
  });
  ASSERT_NE(note, entries.end());
  std::get<document::Note>(note->body).status = document::NoteStatus::closed;
  document::Entry comment, stale = *note;
  comment.id = 1000;
  comment.body = document::Comment{stale.id, "closed"};
  entries.push_back(comment);
  ASSERT_TRUE(bringIn(b, entries, 5 * sync::kSecond));
  EXPECT_EQ(b.visit->bringing()->changed(), 1u);
  EXPECT_EQ(b.visit->bringing()->made(), 1u);
  EXPECT_EQ(b.visit->bringing()->known(), size - 1);
  const Visitor c = begin("c");
  ASSERT_TRUE(arrive(c));
  EXPECT_EQ(std::get<document::Note>(c.visit->content().find(stale.id)->body).status,
            document::NoteStatus::closed);
  // Upon a revision that is no more, a change is refused.
  std::get<document::Note>(stale.body).status = document::NoteStatus::resolved;
  ASSERT_TRUE(bringIn(c, {stale}, 5 * sync::kSecond));
  EXPECT_EQ(c.visit->bringing()->refused(), 1u);
}

TEST_F(DocumentVisits, FetchesTheSceneAndGoesOnWhereItWasBrokenOff) {
  const Visitor a = begin("a", sync::Role::observer);
  ASSERT_TRUE(arrive(a));
  a.visit->fetchScene({});
  ASSERT_TRUE(run(a, 5 * sync::kSecond, [&] { return a.visit->scene().complete(); }));
  const std::vector<std::byte> package = a.visit->scene().package();
  EXPECT_EQ(assets::contentHash(package), a.visit->welcome().sceneHash);
  const Visitor b = begin("b", sync::Role::observer);
  ASSERT_TRUE(arrive(b));
  b.visit->fetchScene({package.begin(), package.begin() + static_cast<std::ptrdiff_t>(package.size() / 2)});
  ASSERT_TRUE(run(b, 5 * sync::kSecond, [&] { return b.visit->scene().complete(); }));
  EXPECT_EQ(b.visit->scene().package(), package);
}

TEST(DocumentReplica, KeepsWhatChangedBeforeTheFirstChunkOfAnOlderWhole) {
  const auto entry = [](document::EntryId id, document::Revision revision) {
    document::Entry e;
    e.id = id;
    e.revision = revision;
    e.body = document::Group{"g", {}};
    return e;
  };
  DocumentReplica replica;
  replica.handle(sync::DocumentChanged{entry(1, 11)});
  replica.handle(sync::DocumentChunk{true, false, 10, {entry(2, 3)}});
  EXPECT_FALSE(replica.complete());
  replica.handle(sync::DocumentChunk{false, true, 10, {entry(3, 10)}});
  EXPECT_TRUE(replica.complete());
  EXPECT_EQ(replica.content().size(), 3u);
  EXPECT_EQ(replica.content().find(1)->revision, 11u);
  // What is no longer there when the whole comes anew is forgotten.
  replica.connectionLost();
  EXPECT_EQ(replica.request().known, 11u);
  replica.handle(sync::DocumentChunk{true, true, 20, {entry(1, 20)}});
  EXPECT_EQ(replica.content().size(), 1u);
}

}  // namespace
}  // namespace tandem::client
