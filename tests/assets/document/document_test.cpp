#include "assets/document/document.h"

#include <gtest/gtest.h>

#include <random>

#include "assets/document/document_json.h"
#include "assets/document/entry_check.h"
#include "tests/support/random_entries.h"

namespace tandem::document {
namespace {

Note note(const std::string& text) {
  Note note;
  note.text = text;
  return note;
}

const By kAda{1, "ada", 1, 1000}, kBen{2, "ben", 1, 2000};

TEST(Document, KeepsWhoMadeAnEntryAndWhoChangedIt) {
  Document document;
  const Entry made = document.apply({0, 0, note("a")}, kAda).entry;
  EXPECT_EQ(made.id, 1u);
  EXPECT_EQ(made.revision, 1u);
  const Entry changed = document.apply({made.id, made.revision, note("b")}, kBen).entry;
  EXPECT_EQ(changed.author, 1);
  EXPECT_EQ(changed.authorName, "ada");
  EXPECT_EQ(changed.made, 1000);
  EXPECT_EQ(changed.editor, 2);
  EXPECT_EQ(changed.changed, 2000);
  EXPECT_EQ(changed.revision, 2u);
  EXPECT_EQ(document.size(), 1u);
}

TEST(Document, RefusesAChangeUponAnOlderRevision) {
  Document document;
  const Entry made = document.apply({0, 0, note("a")}, kAda).entry;
  ASSERT_EQ(document.apply({made.id, made.revision, note("ben's")}, kBen).refusal, Refusal::none);
  EXPECT_EQ(document.apply({made.id, made.revision, note("a again")}, kAda).refusal, Refusal::changedSince);
  EXPECT_EQ(document.apply({made.id, made.revision, Removed{}}, kAda).refusal, Refusal::changedSince);
  EXPECT_EQ(std::get<Note>(document.find(made.id)->body).text, "ben's");
}

TEST(Document, ARemovedEntryCanBeRestoredUnderItsIdAndAuthor) {
  Document document;
  const Entry made = document.apply({0, 0, note("a")}, kAda).entry;
  const Entry gone = document.apply({made.id, made.revision, Removed{}}, kBen).entry;
  EXPECT_EQ(document.size(), 0u);
  EXPECT_EQ(document.apply({made.id, gone.revision, Removed{}}, kBen).refusal, Refusal::noSuchEntry);
  const Entry back = document.apply({made.id, gone.revision, note("a")}, kBen).entry;
  EXPECT_EQ(back.id, made.id);
  EXPECT_EQ(back.author, 1);
  EXPECT_EQ(document.size(), 1u);
}

TEST(Document, ANoteStaysWhileCommentsReferToIt) {
  Document document;
  const Entry thread = document.apply({0, 0, note("a")}, kAda).entry;
  EXPECT_EQ(document.apply({0, 0, Comment{thread.id + 1, "?"}}, kBen).refusal, Refusal::noSuchEntry);
  const Entry comment = document.apply({0, 0, Comment{thread.id, "yes"}}, kBen).entry;
  EXPECT_EQ(document.apply({0, 0, Comment{comment.id, "no thread"}}, kBen).refusal, Refusal::noSuchEntry);
  EXPECT_EQ(document.apply({thread.id, thread.revision, Removed{}}, kAda).refusal, Refusal::referredTo);
  const Entry gone = document.apply({comment.id, comment.revision, Removed{}}, kBen).entry;
  ASSERT_EQ(document.apply({thread.id, thread.revision, Removed{}}, kAda).refusal, Refusal::none);
  EXPECT_EQ(document.apply({comment.id, gone.revision, Comment{thread.id, "yes"}}, kBen).refusal,
            Refusal::noSuchEntry);
}

TEST(Document, RefusesWhatBreaksALimit) {
  Document document;
  Note bad = note(std::string(kMaxText + 1, 'a'));
  EXPECT_EQ(document.apply({0, 0, bad}, kAda).refusal, Refusal::unsound);
  bad = note("bell \x07");
  EXPECT_EQ(document.apply({0, 0, bad}, kAda).refusal, Refusal::unsound);
  bad = note("a");
  bad.place.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(document.apply({0, 0, bad}, kAda).refusal, Refusal::unsound);
  EXPECT_EQ(document.apply({0, 0, Group{"g", std::vector<PartId>(kMaxListed + 1, 1)}}, kAda).refusal,
            Refusal::unsound);
  EXPECT_EQ(document.apply({0, 0, PartName{kNoPart, "n"}}, kAda).refusal, Refusal::unsound);
  EXPECT_EQ(document.apply({0, 3, note("a")}, kAda).refusal, Refusal::unsound);
  const Entry made = document.apply({0, 0, note("a")}, kAda).entry;
  EXPECT_EQ(document.apply({made.id, made.revision, Group{}}, kAda).refusal, Refusal::unsound);
  EXPECT_EQ(document.revision(), 1u);
}

TEST(Document, IsFullAtItsLimitAndForgetsTheOldestRemovedEntries) {
  Document document;
  for (std::size_t i = 0; i < kMaxEntries; ++i)
    ASSERT_EQ(document.apply({0, 0, note("a")}, kAda).refusal, Refusal::none);
  EXPECT_EQ(document.apply({0, 0, note("a")}, kAda).refusal, Refusal::full);
  for (EntryId id = 1; id <= kMaxRemoved + 2; ++id)
    ASSERT_EQ(document.apply({id, id, Removed{}}, kAda).refusal, Refusal::none);
  for (EntryId id = 1; id <= 2; ++id)
    EXPECT_EQ(document.apply({0, 0, note("b")}, kAda).forgotten, id == 1 ? 1u : 2u);
  EXPECT_EQ(document.apply({0, 0, note("b")}, kAda).forgotten, 0u);
  EXPECT_EQ(document.find(2), nullptr);
  EXPECT_NE(document.find(3), nullptr);
}

/// A replica that takes the entries in any order ends with the same document.
TEST(Document, ReplicasAgreeWhateverTheOrderInWhichEntriesCome) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    testing::RandomEntries random(seed);
    Document document;
    std::vector<Entry> told;
    for (std::uint32_t i = 0; i < 200; ++i) {
      const Document::Outcome outcome =
          document.apply(random.change(document), {static_cast<SiteId>(1 + i % 3), "x", i, i});
      if (outcome.refusal == Refusal::none) told.push_back(outcome.entry);
    }
    ASSERT_GT(told.size(), 50u);
    std::shuffle(told.begin(), told.end(), std::mt19937_64(seed));
    Document replica;
    for (const Entry& entry : told) replica.put(entry);
    EXPECT_EQ(toJson(replica, "s"), toJson(document, "s")) << seed;
    EXPECT_EQ(replica.revision(), document.revision());
    EXPECT_EQ(replica.bytes(), document.bytes());
  }
}

TEST(Document, WhatIsRefusedChangesNothing) {
  testing::RandomEntries random(7);
  Document document;
  std::size_t refused = 0;
  for (std::uint32_t i = 0; i < 500; ++i) {
    Change change = random.change(document);
    if (random.number(3) == 0) change.base += 1;
    const std::string before = toJson(document, "s");
    const Revision revision = document.revision();
    const Document::Outcome outcome = document.apply(change, kAda);
    if (outcome.refusal == Refusal::none) continue;
    ++refused;
    EXPECT_FALSE(outcome.reason.empty());
    EXPECT_EQ(toJson(document, "s"), before);
    EXPECT_EQ(document.revision(), revision);
  }
  EXPECT_GT(refused, 50u);
}

TEST(DocumentJson, ReadsBackWhatItWrites) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    testing::RandomEntries random(seed);
    Document document;
    for (std::uint32_t i = 0; i < 100; ++i)
      document.apply(random.change(document), {1, "ada \xc3\xa9", i, i});
    const std::string text = toJson(document, "abc");
    const auto file = fromJson(text, "f");
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->scene, "abc");
    ASSERT_EQ(file->entries.size(), document.size());
    Document again;
    Revision revision = 0;
    for (Entry entry : file->entries) {
      entry.revision = ++revision;
      ASSERT_TRUE(again.put(entry));
    }
    EXPECT_EQ(toJson(again, "abc"), text);
  }
}

TEST(DocumentJson, RefusesWhatIsNoDocumentWithItsPlace) {
  const auto refused = [](const std::string& text) {
    const auto file = fromJson(text, "f.json");
    return file ? std::string("accepted") : file.error().message;
  };
  const std::string head = R"({"tandem_document": 1, "scene": "s", "entries": [)";
  const std::string entry = R"("author": "a", "made": 1, "changed": 1, )";
  EXPECT_EQ(refused(head + "]}"), "accepted");
  EXPECT_EQ(refused(R"({"tandem_document": 2, "scene": "s", "entries": []})"),
            "f.json: is of an unknown version");
  EXPECT_EQ(refused(head + R"({"id": 1, "kind": "spell", )" + entry + R"("text": ""}]})"),
            "f.json: entries[0]: is of no known kind");
  EXPECT_EQ(refused(head + R"({"id": 1, "kind": "comment", )" + entry + R"("note": 3, "text": "t"}]})"),
            "f.json: entry 1 refers to no note of the file");
  EXPECT_EQ(
      refused(head + R"({"id": 1, "kind": "group", )" + entry + R"("name": "g", "parts": [], "x": 1}]})"),
      "f.json: entries[0]: has an unknown member 'x'");
  EXPECT_EQ(refused(head + R"({"id": 1, "kind": "group", )" + entry + R"("name": "g", "parts": [-1]}]})"),
            "f.json: entries[0]: parts is not a whole number");
  EXPECT_NE(refused("{"), "accepted");
  EXPECT_NE(refused("[]"), "accepted");
}

/// What came later may be missing, and is not written where it says nothing.
TEST(DocumentJson, AViewWithoutAStyleIsAsMadeAndAnUnknownPartOfOneIsRefused) {
  const std::string head =
      R"({"tandem_document": 1, "scene": "s", "entries": [{"id": 1, "kind": "view", "author": "a", )"
      R"("made": 1, "changed": 1, "name": "v", "camera": )"
      R"({"position_m": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0]}, )"
      R"("distance_m": 1, "sections": [], "only_these": false, "parts": [])";
  const auto read = [&](const std::string& style) { return fromJson(head + style + "}]}", "f"); };
  const auto old = read("");
  ASSERT_TRUE(old) << old.error().message;
  const NamedView& view = std::get<NamedView>(old->entries[0].body);
  EXPECT_EQ(view.style, PartStyle{});
  Document document;
  document.apply({0, 0, view}, kAda);
  EXPECT_EQ(toJson(document, "s").find("style"), std::string::npos);
  const auto styled =
      read(R"(, "style": {"explode": 0.5, "apart": [1], "colours": "by body", "ghosts": true})");
  ASSERT_TRUE(styled) << styled.error().message;
  const auto through = read(R"(, "seen_through": {"all_but": true, "parts": [2]})");
  ASSERT_TRUE(through) << through.error().message;
  EXPECT_EQ(std::get<NamedView>(through->entries[0].body).seenThrough, (SeenThrough{true, {2}}));
  EXPECT_EQ(std::get<NamedView>(through->entries[0].body).style, PartStyle{});
  EXPECT_EQ(std::get<NamedView>(styled->entries[0].body).style,
            (PartStyle{0.5, {1}, PartColouring::byBody, true}));
  for (const char* wrong :
       {R"(, "style": {"explode": 1.5, "apart": [], "colours": "by body", "ghosts": true})",
        R"(, "style": {"explode": 0.5, "apart": [], "colours": "by size", "ghosts": true})",
        R"(, "style": {"explode": 0.5, "apart": [], "colours": "by body", "ghosts": true, "glow": 1})",
        R"(, "style": {"explode": 0.5})", R"(, "style": 1)"})
    EXPECT_FALSE(read(wrong)) << wrong;
}

/// Damaged files are read whole or refused; nothing is asserted.
TEST(DocumentJson, SurvivesDamage) {
  testing::RandomEntries random(3);
  Document document;
  for (std::uint32_t i = 0; i < 30; ++i) document.apply(random.change(document), kAda);
  const std::string good = toJson(document, "abc");
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    std::mt19937_64 damage(seed);
    std::string text = good;
    for (int i = 0; i < 3; ++i) text[damage() % text.size()] = static_cast<char>(damage());
    const auto file = fromJson(text, "f");
    if (!file) continue;
    for (const Entry& entry : file->entries) EXPECT_TRUE(check(entry.body));
  }
}

}  // namespace
}  // namespace tandem::document
