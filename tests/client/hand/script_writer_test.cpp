#include "client/hand/script_writer.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace tandem::client {
namespace {

using namespace document;
using Kind = DocumentWish::Kind;

/// A hand in a scene with a ball of 0.1 m that was moved, and a document that it writes in at once.
struct ScriptWriters : testing::Test {
  assets::Scene scene;
  ViewModel model;
  Document document;
  std::unique_ptr<haptics::ContactScene> contact;
  std::unique_ptr<ScriptWriter> writer;
  double now = 0.0;

  ScriptWriters() {
    assets::Part ball;
    ball.name = "ball";
    ball.shapes.resize(1);
    ball.shapes[0].kind = assets::ImplicitShape::Kind::sphere;
    ball.shapes[0].radiusTop = ball.shapes[0].radiusBottom = 0.1;
    scene.parts.push_back(ball);
    contact = std::make_unique<haptics::ContactScene>(scene, 1);
    model.scene = &scene;
    model.worldFromPart = {{{1.0, 0.0, 0.0}, glm::angleAxis(0.5, glm::dvec3(0.0, 0.0, 1.0))}};
    model.document = &document;
    model.documentStanding.complete = true;
    model.hand.worldFromProxy.position = {1.0, 0.3, 0.0};
  }
  void script(const std::string& json) {
    const Result<HandScript> read = parseHandScript(json, "test", scene);
    ASSERT_TRUE(read.ok()) << read.error().message;
    writer = std::make_unique<ScriptWriter>(*read, *contact);
  }
  /// Comes to the `begun`th step, and makes the changes that it wants. Returns all that it wrote.
  ScriptWriter::Written come(std::uint32_t begun) {
    ScriptWriter::Written written = writer->write(now, begun, model, Camera{});
    for (const DocumentWish& wish : written.wishes)
      if (wish.kind == Kind::change) {
        EXPECT_EQ(document.apply(wish.change, {1, "ada", 0, 0}).refusal, Refusal::none);
      }
    return written;
  }
  const Note& note(EntryId id) { return std::get<Note>(document.find(id)->body); }
};

TEST_F(ScriptWriters, ANoteIsPinnedToTheTouchedPartOrTheNamedOneOrTheWorld) {
  script(R"([{"t": 0, "do": "note", "text": "here"}, {"t": 1, "do": "note", "text": "there", "part": "ball"},
             {"t": 2, "do": "note", "text": "touched"}])");
  EXPECT_TRUE(come(0).wishes.empty());
  come(1);
  EXPECT_EQ(note(1).part, kNoPart);
  EXPECT_EQ(note(1).place, glm::dvec3(1.0, 0.3, 0.0));
  come(2);
  EXPECT_EQ(note(2).part, 0);
  EXPECT_LT(glm::length(transformPoint(model.worldFromPart[0], note(2).place) - glm::dvec3(1.0, 0.1, 0.0)),
            1e-12);
  model.hand.touched = 0;
  model.hand.worldFromProxy.position = {1.0, 0.0, 0.1};
  come(3);
  EXPECT_EQ(note(3).part, 0);
  EXPECT_LT(glm::length(transformPoint(model.worldFromPart[0], note(3).place) - glm::dvec3(1.0, 0.0, 0.1)),
            1e-12);
}

TEST_F(ScriptWriters, AnswersTheNoteThatBeginsSoOrTheLastOne) {
  script(R"([{"t": 0, "do": "note", "text": "bolt is loose"}, {"t": 0, "do": "note", "text": "lid is bent"},
             {"t": 1, "do": "reply", "text": "which?", "to": "bolt"}, {"t": 1, "do": "reply", "text": "yes"},
             {"t": 2, "do": "status", "status": "in progress", "to": "bolt"},
             {"t": 2, "do": "view", "name": "v"},
             {"t": 3, "do": "undo"}, {"t": 3, "do": "redo"}])");
  come(2);
  come(6);
  EXPECT_EQ(std::get<Comment>(document.find(3)->body).note, 1u);
  EXPECT_EQ(std::get<Comment>(document.find(4)->body).note, 2u);
  EXPECT_EQ(note(1).status, NoteStatus::inProgress);
  EXPECT_EQ(note(1).text, "bolt is loose");
  EXPECT_EQ(std::get<NamedView>(document.find(5)->body).name, "v");
  const ScriptWriter::Written last = come(8);
  ASSERT_EQ(last.wishes.size(), 2u);
  EXPECT_EQ(last.wishes[0].kind, Kind::undo);
  EXPECT_EQ(last.wishes[1].kind, Kind::redo);
}

TEST_F(ScriptWriters, AnAnswerWaitsForItsNoteAndIsPassedOverIfThereIsNone) {
  script(R"([{"t": 0, "do": "note", "text": "bolt"}, {"t": 0, "do": "reply", "text": "which?"},
             {"t": 1, "do": "reply", "text": "what?", "to": "nut"}, {"t": 1, "do": "undo"}])");
  EXPECT_EQ(come(4).wishes.size(),
            1u);  // the note; it is not in the document yet when the reply is to be written
  now = 0.1;
  EXPECT_EQ(come(4).wishes.size(), 1u);
  now = 2.0;
  EXPECT_TRUE(come(4).problems.empty());
  now = 0.1 + ScriptWriter::kPatience;
  const ScriptWriter::Written written = come(4);
  EXPECT_EQ(written.problems, std::vector<std::string>{"there is no note that begins with \"nut\""});
  EXPECT_EQ(written.wishes.size(), 1u);
}

TEST_F(ScriptWriters, WaitsUntilTheDocumentIsThere) {
  script(R"([{"t": 0, "do": "note", "text": "bolt"}])");
  model.documentStanding.complete = false;
  EXPECT_TRUE(come(1).wishes.empty());
  model.documentStanding.complete = true;
  EXPECT_EQ(come(1).wishes.size(), 1u);
  EXPECT_TRUE(come(1).wishes.empty());
}

TEST_F(ScriptWriters, MeasuresPlacesAndWhereTheHandIs) {
  script(R"([{"t": 0, "do": "measure", "measures": "distance", "at": [[1, -0.5, 0]], "name": "across"},
             {"t": 1, "do": "measure", "measures": "diameter"},
             {"t": 2, "do": "measure", "measures": "clearance", "at": [[0, 0, 0]]}])");
  come(1);
  const auto& measure = std::get<Measure>(document.find(1)->body);
  EXPECT_EQ(measure.kind, MeasureKind::distance);
  EXPECT_EQ(measure.name, "across");
  EXPECT_NEAR(measure.value, 0.2, 0.001) << "facets stand for the ball of the scene";
  ASSERT_EQ(measure.anchors.size(), 2u);
  EXPECT_LT(glm::distance(transformPoint(model.worldFromPart[0], measure.anchors[1].point),
                          glm::dvec3(1.0, 0.1, 0.0)),
            0.01);
  EXPECT_EQ(come(2).problems, std::vector<std::string>{"there is no diameter to measure"});
  EXPECT_EQ(come(3).problems, std::vector<std::string>{"there is no clearance to measure"});
}

TEST_F(ScriptWriters, FindsClashesAndJudgesThem) {
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].name = "other";
  contact = std::make_unique<haptics::ContactScene>(scene, 1);
  model.worldFromPart.push_back({{1.15, 0.0, 0.0}, glm::dquat(1, 0, 0, 0)});
  SiteView self;
  self.self = true;
  self.info.name = "Ada";
  model.sites = {self};
  script(R"([{"t": 0, "do": "find_clashes"},
             {"t": 1, "do": "judge", "parts": ["other", "ball"], "status": "approved", "text": "meant"},
             {"t": 2, "do": "find_clashes"}])");
  come(1);
  const auto verdict = [&] { return std::get<ClashVerdict>(document.find(1)->body); };
  EXPECT_EQ(verdict().status, ClashStatus::fresh);
  EXPECT_NEAR(verdict().depth, 0.05, 0.002);
  come(2);
  EXPECT_EQ(verdict().status, ClashStatus::approved);
  EXPECT_EQ(verdict().text, "[Ada] meant");
  model.worldFromPart[1].position.x = 3.0;
  EXPECT_TRUE(come(3).wishes.empty()) << "what is approved stays";
}

TEST_F(ScriptWriters, AJudgementWithoutItsClashIsPassedOver) {
  scene.parts.push_back(scene.parts[0]);
  scene.parts[1].name = "other";
  model.worldFromPart.push_back({});
  script(R"([{"t": 0, "do": "judge", "parts": ["other", "ball"], "status": "active"}])");
  model.documentStanding.unsent = 3;
  come(1);
  now = 10.0;
  EXPECT_TRUE(come(1).problems.empty()) << "what was found may still be on its way";
  model.documentStanding.unsent = 0;
  now += ScriptWriter::kPatience;
  EXPECT_EQ(come(1).problems, std::vector<std::string>{"there is no clash of these parts to judge"});
}

TEST_F(ScriptWriters, WhatCannotBeWrittenIsRefusedWithTheScript) {
  const auto refusal = [&](const std::string& json) {
    const Result<HandScript> read = parseHandScript(json, "test", scene);
    return read.ok() ? std::string() : read.error().message;
  };
  EXPECT_EQ(refusal(R"([{"t": 0, "do": "note"}])"), "test: step 1: needs \"text\": \"...\"");
  EXPECT_NE(refusal(R"([{"t": 0, "do": "note", "text": "x", "part": "lid"}])"), "");
  EXPECT_NE(refusal(R"([{"t": 0, "do": "note", "text": "a\u0007b"}])"), "");
  EXPECT_NE(refusal(R"([{"t": 0, "do": "view", "name": ")" + std::string(129, 'x') + R"("}])"), "");
  EXPECT_EQ(refusal(R"([{"t": 0, "do": "measure", "measures": "volume"}])"),
            "test: step 1: \"measures\" must be length, diameter, distance, across, angle or clearance");
  EXPECT_NE(refusal(R"([{"t": 0, "do": "measure", "measures": "length", "at": [[0,0,0], [1,0,0]]}])"), "");
  EXPECT_NE(refusal(R"([{"t": 0, "do": "measure", "measures": "clearance", "parts": ["ball", "ball"]}])"),
            "");
  EXPECT_NE(refusal(R"([{"t": 0, "do": "measure", "measures": "angle", "parts": ["ball", "ball"]}])"), "");
  EXPECT_EQ(refusal(R"([{"t": 0, "do": "status", "status": "done"}])"),
            "test: step 1: \"status\" must be open, in progress, resolved or closed");
}

TEST_F(ScriptWriters, StepsThatTheOthersSeeAreHandedOnInTheirOrder) {
  using Verb = ScriptStep::Verb;
  script(R"([{"t": 0, "do": "section", "planes": [[0, 0, 2, 0.5], [1, 0, 0, -1]]},
             {"t": 1, "do": "share", "what": "view"}, {"t": 1, "do": "note", "text": "n"},
             {"t": 1, "do": "hide", "parts": ["ball"]}, {"t": 1, "do": "select", "part": "ball"},
             {"t": 1, "do": "look", "from": [1, 2, 3], "to": [0, 0, 0]}, {"t": 1, "do": "point"},
             {"t": 1, "do": "follow", "what": "nothing"}, {"t": 1, "do": "say", "text": "see [ball]"}])");
  const ScriptWriter::Written written = come(9);
  EXPECT_EQ(written.wishes.size(), 1u) << "the note";
  ASSERT_EQ(written.shown.size(), 8u);
  const std::vector<ScriptStep>& shown = written.shown;
  ASSERT_EQ(shown[0].planes.size(), 2u);
  EXPECT_EQ(shown[0].planes[0].point, glm::dvec3(0.0, 0.0, 0.5));
  EXPECT_EQ(shown[0].planes[1].point, glm::dvec3(-1.0, 0.0, 0.0));
  EXPECT_EQ(shown[1].shares, sync::Shares::view);
  EXPECT_EQ(shown[2].parts, std::vector<PartId>{0});
  EXPECT_EQ(shown[3].part, 0);
  EXPECT_EQ(shown[4].from, glm::dvec3(1.0, 2.0, 3.0));
  EXPECT_EQ(shown[5].verb, Verb::point);
  EXPECT_EQ(shown[5].part, kNoPart);
  EXPECT_EQ(shown[6].shares, sync::Shares::nothing);
  EXPECT_EQ(shown[7].text, "see [ball]");
}

TEST_F(ScriptWriters, StepsThatTheOthersSeeAreChecked) {
  const auto refuses = [&](const std::string& step) {
    return !parseHandScript("[{\"t\": 0, " + step + "}]", "test", scene).ok();
  };
  EXPECT_TRUE(refuses(R"("do": "section")"));
  EXPECT_TRUE(refuses(R"("do": "section", "planes": [[0, 0, 0, 1]])"));
  EXPECT_TRUE(refuses(R"("do": "section", "planes": [[0, 0, 1]])"));
  EXPECT_TRUE(refuses(R"("do": "section", "planes": [[0, 0, "z", 1]])"));
  EXPECT_TRUE(refuses(R"("do": "section", "planes": [[0, 0, 1, 1e9]])"));
  EXPECT_TRUE(refuses(R"("do": "share", "what": "everything")"));
  EXPECT_TRUE(refuses(R"("do": "hide", "parts": ["lid"])"));
  EXPECT_TRUE(refuses(R"("do": "look", "from": [1, 1, 1], "to": [1, 1, 1])"));
  EXPECT_TRUE(refuses(R"("do": "say", "text": ")" + std::string(281, 'x') + '"'));
}

}  // namespace
}  // namespace tandem::client
