// How the entries of a document are exported as topics.

#include "client/exchange/document_topics.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "tests/client/exchange/topic_samples.h"

namespace tandem::client {
namespace {

glm::dvec3 direction(const Topic& topic) {
  return topic.view->worldFromCamera.orientation * glm::dvec3(0.0, 0.0, -1.0);
}

TEST(DocumentTopics, ANoteHasItsThreadItsPartAndACameraThatLooksAtIt) {
  const TopicSample sample;
  const std::vector<Topic> topics = sample.topics();
  ASSERT_EQ(topics.size(), 4u);
  const Topic& note = topics[0];
  EXPECT_EQ(note.kind, TopicKind::note);
  EXPECT_EQ(note.title, "The shaft is too long");
  EXPECT_EQ(note.description, "The shaft is too long. Cut it by 2 mm & <check>");
  EXPECT_EQ(note.status, "In progress");
  EXPECT_EQ(note.author, "Ada");
  EXPECT_EQ(note.assignee, "Ben");
  EXPECT_EQ(note.parts, std::vector<std::string>{"Shaft"});
  ASSERT_EQ(note.comments.size(), 2u);
  EXPECT_EQ(note.comments[0].author, "Ben");
  EXPECT_EQ(note.comments[0].made, 2000);
  const glm::dvec3 place(0.11, 0.02, 0.03);
  const glm::dvec3 sight = place - note.view->worldFromCamera.position;
  EXPECT_LT(glm::length(glm::cross(glm::normalize(sight), direction(note))), 1e-9);
  EXPECT_GT(glm::dot(sight, direction(note)), 0.0);
}

TEST(DocumentTopics, AClashShowsBothPartsAlone) {
  const TopicSample sample;
  const Topic clash = sample.topics()[1];
  const PartGuids guids(sample.scene);
  EXPECT_EQ(clash.title, "Clash of Housing and Shaft, 1.2 mm deep");
  EXPECT_EQ(clash.status, "Reviewed");
  EXPECT_TRUE(clash.view->onlyThese);
  EXPECT_EQ(clash.view->selected, (std::vector<std::string>{guids.guid(0), guids.guid(1)}));
  // The boxes meet in the plane x = 0.05.
  const glm::dvec3 sight = glm::dvec3(0.05, 0.0, 0.0) - clash.view->worldFromCamera.position;
  EXPECT_LT(glm::length(glm::cross(glm::normalize(sight), direction(clash))), 1e-9);
}

TEST(DocumentTopics, AViewKeepsItsCameraAndAMeasureDrawsItsLine) {
  const TopicSample sample;
  const std::vector<Topic> topics = sample.topics();
  EXPECT_EQ(topics[2].title, "From the left");
  EXPECT_EQ(topics[2].view->worldFromCamera.position, glm::dvec3(1.0, 2.0, 3.0));
  EXPECT_EQ(topics[2].view->sections.size(), 1u);
  EXPECT_EQ(topics[2].view->exceptions.size(), 1u);
  EXPECT_EQ(topics[3].title, "distance 100 mm");
  ASSERT_EQ(topics[3].view->lines.size(), 1u);
  EXPECT_EQ(topics[3].view->lines[0].second, glm::dvec3(0.1, 0.0, 0.0));
}

TEST(DocumentTopics, APartIsCalledAsTheSessionCallsIt) {
  TopicSample sample;
  sample.add(document::PartName{1, "Axle"});
  EXPECT_EQ(sample.topics()[0].parts, std::vector<std::string>{"Axle"});
  EXPECT_EQ(sample.topics()[0].view->selected, TopicSample().topics()[0].view->selected);
}

TEST(DocumentTopics, PartsThatTheSceneDoesNotHaveAreNoError) {
  TopicSample sample;
  sample.add(document::ClashVerdict{7, 8, document::ClashStatus::fresh, 0.0, ""});
  sample.add(document::Note{"x", 9, {}, "", document::NoteStatus::open});
  for (const Topic& topic : sample.topics()) {
    EXPECT_TRUE(isValid(topic.view->worldFromCamera));
    EXPECT_FALSE(topic.title.empty());
  }
}

TEST(DocumentTopics, ATitleIsTheFirstSentenceOrALine) {
  EXPECT_EQ(titleOf("Short"), "Short");
  EXPECT_EQ(titleOf("One. Two."), "One");
  const std::string longText = std::string(60, 'a') + ' ' + std::string(60, 'b');
  EXPECT_EQ(titleOf(longText), longText.substr(0, 60) + "...");
  const std::string umlauts = [] {
    std::string text;
    for (int i = 0; i < 100; ++i) text += "\xc3\xbc";
    return text;
  }();
  EXPECT_EQ(titleOf(umlauts), umlauts.substr(0, 80) + "...");
}

}  // namespace
}  // namespace tandem::client
