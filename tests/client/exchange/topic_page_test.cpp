// The page of topics: whole in itself, and nothing of its texts becomes markup.

#include "client/exchange/topic_page.h"

#include <gtest/gtest.h>

#include "tests/client/exchange/topic_samples.h"

namespace tandem::client {
namespace {

TEST(TopicPage, ShowsEveryTopicWithItsThread) {
  const TopicSample sample;
  const std::string page = topicPage("Review", sample.topics());
  for (const char* shown : {"The shaft is too long", "In progress", "Ada", "assigned to Ben", "Parts: Shaft",
                            "&quot;Done&quot;, says Grüße", "1970-01-01 00:50 UTC", "Clash of Housing",
                            "From the left", "camera 1 2 3 m"})
    EXPECT_NE(page.find(shown), std::string::npos) << shown;
}

TEST(TopicPage, TextsAreNoMarkup) {
  TopicSample sample;
  const std::string attack = "</p><script>alert('x')</script><img src=\"//evil\" onerror=x>";
  const document::EntryId note =
      sample.add(document::Note{attack, 0, {}, attack, document::NoteStatus::open}, attack);
  sample.add(document::Comment{note, attack}, attack);
  sample.scene.parts[0].name = attack;
  const std::string page = topicPage(attack, sample.topics());
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("<img"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;"), std::string::npos);
}

TEST(TopicPage, HoldsPicturesAndLoadsNothing) {
  TopicSample sample;
  std::vector<Topic> topics = sample.topics();
  topics[0].picture = {'M', 'a', 'n', 'y'};
  topics[1].picture = {'M', 'a', 'n'};
  topics[2].picture = {'M', 'a'};
  const std::string page = topicPage("Review", topics);
  for (const char* data : {"base64,TWFueQ==\"", "base64,TWFu\"", "base64,TWE=\""})
    EXPECT_NE(page.find(data), std::string::npos) << data;
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  for (const char* reference : {"http://", "https://", "url(", "<link", "@import"})
    EXPECT_EQ(page.find(reference), std::string::npos) << reference;
}

}  // namespace
}  // namespace tandem::client
