// The table of topics: RFC 4180, and no cell that a spreadsheet runs.

#include "client/exchange/topic_csv.h"

#include <gtest/gtest.h>

#include "tests/client/exchange/topic_samples.h"

namespace tandem::client {
namespace {

/// Rows of cells, as RFC 4180 has them; empty if the text breaks it.
std::vector<std::vector<std::string>> readCsv(const std::string& text) {
  std::vector<std::vector<std::string>> rows(1, std::vector<std::string>(1));
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& cell = rows.back().back();
    if (quoted) {
      if (text[i] != '"')
        cell += text[i];
      else if (i + 1 < text.size() && text[i + 1] == '"')
        cell += text[++i];
      else
        quoted = false;
    } else if (text[i] == '"') {
      if (!cell.empty()) return {};
      quoted = true;
    } else if (text[i] == ',') {
      rows.back().emplace_back();
    } else if (text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n') {
      rows.emplace_back(1);
      ++i;
    } else {
      cell += text[i];
    }
  }
  if (quoted || rows.back() != std::vector<std::string>(1)) return {};
  rows.pop_back();
  return rows;
}

TEST(TopicCsv, HasARowATopicWithTheCellsOfItsHeader) {
  const TopicSample sample;
  const std::vector<Topic> topics = sample.topics();
  const auto rows = readCsv(topicCsv(topics));
  ASSERT_EQ(rows.size(), topics.size() + 1);
  for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size());
  EXPECT_EQ(rows[1][0], topics[0].guid);
  EXPECT_EQ(rows[1][4], topics[0].description);
  EXPECT_EQ(rows[1][11],
            "1970-01-01T00:33:20Z Ben: =1+1 is what I measured\n"
            "1970-01-01T00:50:00Z Ada: \"Done\", says Grüße");
  EXPECT_EQ(rows[1][12], "0.11");
  EXPECT_EQ(rows[3][15], "1");
}

TEST(TopicCsv, NoTextIsTakenForAFormula) {
  for (const char* text : {"=1+1", "+1", "-1", "@SUM(A1)", "  =cmd|' /C calc'!A0",
                           "\xef\xbc\x9d"
                           "1+1"}) {
    TopicSample sample;
    sample.add(document::Note{text, kNoPart, {}, text, document::NoteStatus::open}, text);
    const auto row = readCsv(topicCsv(sample.topics())).back();
    EXPECT_EQ(row.at(3).front(), '\'');  // the title has no spaces before it
    for (const std::size_t cell : {4u, 5u, 8u}) EXPECT_EQ(row.at(cell), std::string("'") + text);
  }
  // What is no formula stays as it is.
  TopicSample sample;
  sample.add(document::Note{"1 = 1", kNoPart, {}, "", document::NoteStatus::open});
  EXPECT_EQ(readCsv(topicCsv(sample.topics())).back().at(4), "1 = 1");
}

TEST(TopicCsv, OfNoTopicsIsTheHeader) { EXPECT_EQ(readCsv(topicCsv({})).size(), 1u); }

}  // namespace
}  // namespace tandem::client
