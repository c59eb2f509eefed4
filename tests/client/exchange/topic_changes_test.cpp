// What comes back from another program, as changes of the document.

#include "client/exchange/topic_changes.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "assets/document/document_json.h"
#include "assets/document/entry_check.h"
#include "tests/client/exchange/topic_samples.h"

namespace tandem::client {
namespace {

using namespace document;

constexpr std::int64_t kLater = 5000, kMuchLater = 9000;  // Unix time, s; the sample ends at 3000

struct TopicChangesTest : testing::Test {
  TopicSample sample;
  std::vector<Topic> topics = sample.topics();  // as a file has them: a note, a clash, a view, a measure

  TopicChanges changes() const {
    const PartGuids guids(sample.scene);
    return changesOf(topics, {sample.document, sample.scene, guids, sample.worldFromPart, sample.sceneHash},
                     "Cleo");
  }
  /// Brings the topics in, as a DocumentImport does, at a time; returns how many entries that made or
  /// changed.
  int bringIn(std::int64_t time = kMuchLater) {
    std::map<EntryId, EntryId> sessionFromFile;
    int count = 0;
    for (Entry entry : changes().entries) {
      EXPECT_TRUE(check(entry.body)) << check(entry.body).error().message;
      if (auto* comment = std::get_if<Comment>(&entry.body))
        comment->note = sessionFromFile.at(comment->note);
      const Entry* old = sample.document.find(entry.id);
      const bool made = entry.revision == 0;
      const EntryId id = made ? 0 : entry.id;
      sessionFromFile[entry.id] = id;
      if (!made && bytes(old->body) == bytes(entry.body)) continue;
      const auto outcome = sample.document.apply({id, entry.revision, entry.body}, {2, "Cleo", 100u, time});
      EXPECT_EQ(outcome.refusal, Refusal::none) << outcome.reason;
      sessionFromFile[entry.id] = outcome.entry.id;
      ++count;
    }
    return count;
  }
  static std::string bytes(const Body& body) {
    const Entry entry = [&] {
      Entry e;
      e.id = e.revision = 1;
      e.body = body;
      return e;
    }();
    Document document;
    document.put(entry);
    return toJson(document, "");
  }
  template <typename T>
  const T& body(EntryId id) const {
    return std::get<T>(sample.document.find(id)->body);
  }
};

TEST_F(TopicChangesTest, WhatWasNotChangedChangesNothing) {
  EXPECT_EQ(bringIn(), 0);
  EXPECT_EQ(changes().kept, 0u);
}

TEST_F(TopicChangesTest, AStatusAnAssigneeAndACommentComeBack) {
  topics[0].status = "RESOLVED";
  topics[0].assignee = "Dan";
  topics[0].comments.push_back({"other-guid", "dan@x.example", "It is cut", kLater, kLater, 0});
  topics[1].status = "Closed";
  topics[0].changed = topics[1].changed = kLater;
  EXPECT_EQ(bringIn(), 3);
  EXPECT_EQ(body<Note>(1).status, NoteStatus::resolved);
  EXPECT_EQ(body<Note>(1).assignee, "Dan");
  EXPECT_EQ(body<Note>(1).part, 1) << "what a topic does not hold stays";
  EXPECT_EQ(body<Note>(1).place, glm::dvec3(0.01, 0.02, 0.03));
  EXPECT_EQ(body<ClashVerdict>(4).status, ClashStatus::resolved);
  EXPECT_EQ(body<ClashVerdict>(4).depth, 0.0012);
  EXPECT_EQ(body<Comment>(8).note, 1u);
  EXPECT_EQ(body<Comment>(8).text, "[dan@x.example] It is cut");
  EXPECT_EQ(bringIn(), 0) << "the same file again";
}

TEST_F(TopicChangesTest, TextsComeBack) {
  topics[0].description = "Cut it by 3 mm";
  topics[0].comments[0].text = "It was 2.9 mm";
  topics[0].comments[0].changed = kLater;
  topics[1].description = "Not accepted";
  topics[2].title = "From the right";
  topics[3].title = "Pitch";
  for (Topic& topic : topics) topic.changed = kLater;
  EXPECT_EQ(bringIn(), 5);
  EXPECT_EQ(body<Note>(1).text, "Cut it by 3 mm");
  EXPECT_EQ(body<Comment>(2).text, "It was 2.9 mm");
  EXPECT_EQ(body<ClashVerdict>(4).text, "Not accepted");
  EXPECT_EQ(body<NamedView>(5).name, "From the right");
  EXPECT_EQ(body<Measure>(6).name, "Pitch");
  EXPECT_EQ(bringIn(), 0) << "the same file again";
}

TEST_F(TopicChangesTest, ATitleOfAnotherProgramStandsBeforeTheText) {
  topics[0].title = "Shaft";
  topics[0].changed = kLater;
  EXPECT_EQ(bringIn(), 1);
  EXPECT_EQ(body<Note>(1).text, "Shaft: The shaft is too long. Cut it by 2 mm & <check>");
}

TEST_F(TopicChangesTest, WhatTheSessionHasChangedSinceStays) {
  const Entry* note = sample.document.find(1);
  Note closed = std::get<Note>(note->body);
  closed.status = NoteStatus::closed;
  sample.document.apply({1, note->revision, closed}, {1, "Ada", 50, kMuchLater});
  EXPECT_EQ(bringIn(), 0);  // the file still says what it was
  EXPECT_EQ(body<Note>(1).status, NoteStatus::closed);
  EXPECT_EQ(changes().kept, 1u);
  topics[0].changed = kMuchLater + 1;  // unless the file is newer
  EXPECT_EQ(changes().kept, 0u);
  EXPECT_EQ(bringIn(), 1);
  EXPECT_EQ(body<Note>(1).status, NoteStatus::inProgress);
}

TEST_F(TopicChangesTest, AStrangersTopicBecomesANoteAndItsView) {
  Topic topic;
  topic.guid = "stranger";
  topic.title = "Leak";
  topic.description = "It leaks here";
  topic.author = "dan@x.example";
  topic.status = "no such word";
  topic.made = topic.changed = kLater;
  topic.view = topics[2].view;
  topic.view->selected = {"0000000000000000000000", PartGuids(sample.scene).guid(2)};
  topic.comments.push_back({"c", "eve", "Yes", kLater, kLater, 0});
  topics = {topic};
  EXPECT_EQ(bringIn(), 3);
  EXPECT_EQ(body<NamedView>(8).name, "Leak");
  EXPECT_LT(glm::length(body<NamedView>(8).worldFromCamera.position - glm::dvec3(1.0, 2.0, 3.0)), 1e-12);
  EXPECT_EQ(body<Note>(9).text, "[dan@x.example] Leak: It leaks here");
  EXPECT_EQ(body<Note>(9).status, NoteStatus::open);
  EXPECT_EQ(body<Comment>(10).note, 9u);
  EXPECT_EQ(bringIn(), 0) << "the same file again";
  topics[0].status = "Closed";
  topics[0].changed = kMuchLater + 1;
  EXPECT_EQ(bringIn(), 1) << "it is known by its text";
  EXPECT_EQ(body<Note>(9).status, NoteStatus::closed);
}

TEST_F(TopicChangesTest, ANewSessionTakesTheTopicsOfAnother) {
  for (Topic& topic : topics) topic.changed = topic.made = kLater;
  TopicSample empty;
  empty.document.clear();
  sample = empty;
  // A note with two comments; a verdict; a view of the note and of the measure each, and the named one; a
  // note for the measure, which has lost its anchors.
  EXPECT_EQ(bringIn(), 8);
  int verdicts = 0, views = 0;
  for (const auto& [id, entry] : sample.document.entries()) {
    verdicts += std::holds_alternative<ClashVerdict>(entry.body) ? 1 : 0;
    views += std::holds_alternative<NamedView>(entry.body) ? 1 : 0;
  }
  EXPECT_EQ(verdicts, 1);
  EXPECT_EQ(views, 3);
  EXPECT_EQ(bringIn(), 0) << "the same file again";
}

TEST_F(TopicChangesTest, AVerdictGoesWithItsPairByNameToALaterScene) {
  topics[1].description = "[Ben] press fit";
  topics[1].status = "Approved";
  topics = {topics[1]};
  TopicSample later;
  later.document.clear();
  later.sceneHash = std::string(64, 'b');
  assets::Part bracket = later.scene.parts[0];
  bracket.name = "Bracket";
  later.scene.parts.insert(later.scene.parts.begin(), bracket);
  later.worldFromPart.insert(later.worldFromPart.begin(), Pose{});
  sample = later;
  EXPECT_EQ(bringIn(), 1);
  int verdicts = 0;
  for (const auto& [id, entry] : sample.document.entries()) {
    const auto* verdict = std::get_if<ClashVerdict>(&entry.body);
    if (verdict == nullptr) continue;
    ++verdicts;
    EXPECT_EQ(verdict->a, 1u);
    EXPECT_EQ(verdict->b, 2u);
    EXPECT_EQ(verdict->status, ClashStatus::approved);
    EXPECT_EQ(verdict->text, "[Ben] press fit");
  }
  EXPECT_EQ(verdicts, 1);
}

TEST_F(TopicChangesTest, RemarksOnWhatHasNoThreadGetANoteBesideIt) {
  topics[1].comments.push_back({"c", "eve", "Really?", kLater, kLater, 0});
  EXPECT_EQ(bringIn(), 2);
  EXPECT_EQ(body<Note>(8).text, "Remarks on Clash of Housing and Shaft, 1.2 mm deep");
  EXPECT_EQ(body<Note>(8).part, 0);
  EXPECT_EQ(body<Comment>(9).note, 8u);
  EXPECT_EQ(bringIn(), 0) << "the same file again";
}

TEST_F(TopicChangesTest, ACommentUnderAnotherTopicStaysWithItsNote) {
  std::swap(topics[0].comments, topics[3].comments);
  topics[3].comments[0].text = "changed";
  topics[3].comments[0].changed = kLater;
  topics = {topics[3]};
  EXPECT_EQ(bringIn(), 1);
  EXPECT_EQ(body<Comment>(2).note, 1u);
  EXPECT_EQ(body<Comment>(2).text, "changed");
}

TEST_F(TopicChangesTest, WhatIsAlikeIsSoughtAmongTheTextsAsTheFileMakesThem) {
  Topic other = topics[0];  // of another program: it says what the note and its comment said before
  other.guid = "other";
  other.author.clear();
  other.comments.clear();
  other.view.reset();
  topics[0].comments.push_back({"other comment", "", topics[0].comments[0].text, kLater, kLater, 0});
  topics[0].title = "The bore is too narrow";
  topics[0].description.clear();
  topics[0].comments[0].text = "It was 2.9 mm";
  topics[0].changed = topics[0].comments[0].changed = kLater;
  topics.push_back(other);
  EXPECT_EQ(bringIn(), 4);
  EXPECT_EQ(body<Note>(1).text, "The bore is too narrow");
  EXPECT_EQ(body<Comment>(2).text, "It was 2.9 mm");
  EXPECT_EQ(bringIn(), 0) << "the same file again";
}

TEST_F(TopicChangesTest, TopicsOfOneTextAreKnownAgainByWhoWroteThem) {
  Topic ofDan, ofNobody;
  ofDan.guid = "a";
  ofNobody.guid = "b";
  ofDan.title = ofNobody.title = "Loose";
  ofDan.author = "Dan";
  ofDan.comments.push_back({"c", "Dan", "By 1 mm", kLater, kLater, 0});
  topics = {ofDan, ofNobody};
  EXPECT_EQ(bringIn(), 3);
  EXPECT_EQ(bringIn(), 0) << "the same file again";
}

TEST_F(TopicChangesTest, TextsAtTheLimitStayWithinIt) {
  topics[0].guid = "stranger";
  topics[0].title.assign(kMaxText, 't');
  topics[0].description.assign(kMaxText, 'd');
  topics[0].author.assign(kMaxName, 'a');
  topics[0].comments[0] = {"c", std::string(kMaxName, 'b'), std::string(kMaxText, 'c'), kLater, kLater, 0};
  EXPECT_GT(bringIn(), 0);  // which checks every body
}

}  // namespace
}  // namespace tandem::client
