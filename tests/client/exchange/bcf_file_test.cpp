// BCF archives: what is written comes back, in both versions; what is hostile is refused in one line.

#include "client/exchange/bcf_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include <glm/geometric.hpp>

#include "tests/client/exchange/topic_samples.h"
#include "tests/support/temporary_folder.h"

namespace tandem::client {
namespace {

struct BcfFile : testing::TestWithParam<BcfVersion> {
  test::TemporaryFolder folder;
  std::string path = (folder.path() / "review.bcf").string();

  std::string bytesOf(const std::vector<Topic>& topics) const {
    const Status written = writeBcf(path, topics, GetParam(), "Review", std::string(64, 'a'));
    EXPECT_TRUE(written) << written.error().message;
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static Result<std::vector<Topic>> read(const std::string& bytes) {
    return readBcf(std::as_bytes(std::span(bytes)), "review.bcf");
  }
  /// The error of reading, which is one line that names the file.
  static std::string refusal(const std::string& bytes) {
    const Result<std::vector<Topic>> topics = read(bytes);
    if (topics) return "it was read";
    EXPECT_TRUE(topics.error().message.starts_with("review.bcf: "));
    EXPECT_EQ(topics.error().message.find('\n'), std::string::npos);
    return topics.error().message;
  }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

const Topic& find(const std::vector<Topic>& topics, const std::string& guid) {
  for (const Topic& topic : topics)
    if (topic.guid == guid) return topic;
  static const Topic kNone;
  return kNone;
}

TEST_P(BcfFile, WhatIsWrittenComesBack) {
  const std::vector<Topic> topics = TopicSample().topics();
  bytesOf(topics);
  const Result<std::vector<Topic>> back = readBcf(path);
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_EQ(back->size(), topics.size());
  for (const Topic& topic : topics) {
    const Topic& same = find(*back, topic.guid);
    EXPECT_EQ(same.kind, topic.kind);
    EXPECT_EQ(same.title, topic.title);
    EXPECT_EQ(same.description, topic.description);
    EXPECT_EQ(same.status, topic.status);
    EXPECT_EQ(same.author, topic.author);
    EXPECT_EQ(same.assignee, topic.assignee);
    EXPECT_EQ(same.made, topic.made);
    EXPECT_EQ(same.changed, topic.changed);
    ASSERT_EQ(same.comments.size(), topic.comments.size());
    for (std::size_t i = 0; i < topic.comments.size(); ++i) {
      EXPECT_EQ(same.comments[i].guid, topic.comments[i].guid);
      EXPECT_EQ(same.comments[i].author, topic.comments[i].author);
      EXPECT_EQ(same.comments[i].text, topic.comments[i].text);
      EXPECT_EQ(same.comments[i].made, topic.comments[i].made);
    }
  }
}

TEST_P(BcfFile, AViewComesBackThroughTheOtherAxes) {
  const std::vector<Topic> topics = TopicSample().topics();
  bytesOf(topics);
  const Result<std::vector<Topic>> back = readBcf(path);
  ASSERT_TRUE(back) << back.error().message;
  for (const Topic& topic : topics) {
    const TopicView &view = *topic.view, &same = *find(*back, topic.guid).view;
    EXPECT_EQ(same.guid, view.guid);
    EXPECT_LT(glm::length(same.worldFromCamera.position - view.worldFromCamera.position), 1e-12);
    EXPECT_GT(std::abs(glm::dot(same.worldFromCamera.orientation, view.worldFromCamera.orientation)),
              1.0 - 1e-12);
    EXPECT_EQ(same.selected, view.selected);
    EXPECT_EQ(same.onlyThese, view.onlyThese);
    EXPECT_EQ(same.exceptions, view.exceptions);
    ASSERT_EQ(same.sections.size(), view.sections.size());
    for (std::size_t i = 0; i < view.sections.size(); ++i) {
      EXPECT_LT(glm::length(same.sections[i].point - view.sections[i].point), 1e-12);
      EXPECT_LT(glm::length(same.sections[i].normal - view.sections[i].normal), 1e-12);
    }
    ASSERT_EQ(same.lines.size(), view.lines.size());
    for (std::size_t i = 0; i < view.lines.size(); ++i)
      EXPECT_LT(glm::length(same.lines[i].second - view.lines[i].second), 1e-12);
    const bool exact = GetParam() == BcfVersion::v3_0;
    EXPECT_NEAR(same.fieldOfView, exact ? view.fieldOfView : 0.785398, 1e-6);
  }
}

TEST_P(BcfFile, TheSameTopicsMakeTheSameArchive) {
  EXPECT_EQ(bytesOf(TopicSample().topics()), bytesOf(TopicSample().topics()));
}

TEST_P(BcfFile, NoTopicsAreAnArchiveToo) {
  const Result<std::vector<Topic>> back = read(bytesOf({}));
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(back->empty());
}

TEST_P(BcfFile, HoldsPicturesAsTheyAre) {
  std::vector<Topic> topics = TopicSample().topics();
  topics[0].picture.assign(1000, 0x5a);
  const std::string bytes = bytesOf(topics);
  EXPECT_NE(bytes.find(std::string(1000, '\x5a')), std::string::npos);
  EXPECT_NE(bytes.find(topics[0].guid + "/snapshot.png"), std::string::npos);
  EXPECT_EQ(bytes.find(topics[1].guid + "/snapshot.png"), std::string::npos);
  EXPECT_TRUE(read(bytes));
}

TEST_P(BcfFile, CannotBeWrittenWhereThereIsNoFolder) {
  EXPECT_FALSE(writeBcf("/nowhere/review.bcf", {}, GetParam(), "Review", ""));
  EXPECT_FALSE(readBcf(std::string("/nowhere/review.bcf")));
}

TEST_P(BcfFile, NamesThatLeadOutOfTheArchiveRefuseIt) {
  const std::vector<Topic> topics = TopicSample().topics();
  const std::string bytes = bytesOf(topics), folderName = topics[0].guid;
  // The same change to a harmless name is read.
  EXPECT_TRUE(read(replaced(bytes, folderName, "x" + folderName.substr(1))));
  for (const std::string& begin :
       {std::string("../"), std::string("/ab"), std::string("C:\\"), std::string("a\\b"), std::string("./a")})
    EXPECT_NE(refusal(replaced(bytes, folderName, begin + folderName.substr(3))).find("leads out"),
              std::string::npos)
        << begin;
}

TEST_P(BcfFile, AFileThatUnpacksToTooMuchRefusesIt) {
  std::vector<Topic> topics = TopicSample().topics();
  topics[0].description.assign(kMaxXmlBytes, 'a');
  const std::string bytes = bytesOf(topics);
  EXPECT_LT(bytes.size(), 100000u);  // it is small until it is unpacked
  EXPECT_NE(refusal(bytes).find("larger than 4 MiB"), std::string::npos);
  topics[0].description.assign(kMaxXmlBytes / 2, 'a');
  EXPECT_TRUE(read(bytesOf(topics)));
}

TEST_P(BcfFile, TextsAreCutToWhatTheDocumentTakes) {
  std::vector<Topic> topics = TopicSample().topics();
  topics[0].description = "line one\n\tline two " + std::string(5000, 'x');
  topics[0].author.assign(500, 'y');
  const Result<std::vector<Topic>> back = read(bytesOf(topics));
  ASSERT_TRUE(back) << back.error().message;
  const Topic& topic = find(*back, topics[0].guid);
  EXPECT_TRUE(topic.description.starts_with("line one  line two xxx"));
  EXPECT_LE(topic.description.size(), document::kMaxText);
  EXPECT_EQ(topic.author.size(), document::kMaxName);
}

TEST_P(BcfFile, WhatIsNoArchiveIsRefused) {
  EXPECT_NE(refusal("").find("no BCF archive"), std::string::npos);
  EXPECT_NE(refusal("hello").find("no BCF archive"), std::string::npos);
  const std::string bytes = bytesOf(TopicSample().topics());
  EXPECT_NE(refusal(replaced(bytes, "bcf.version", "bcf.versiom")).find("no bcf.version"), std::string::npos);
  EXPECT_NE(refusal(bytes.substr(0, bytes.size() / 2)).find("no BCF archive"), std::string::npos);
  const std::string viewpoint = TopicSample().topics()[0].guid + "/viewpoint.bcfv";
  EXPECT_NE(refusal(replaced(bytes, viewpoint, viewpoint.substr(0, 37) + "viewpoint.bcfx"))
                .find("names a viewpoint"),
            std::string::npos);
}

TEST_P(BcfFile, ReadsOrRefusesWhateverIsDamaged) {
  const std::string bytes = bytesOf(TopicSample().topics());
  int refused = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    std::string damaged = bytes;
    for (unsigned i = 0; i <= seed % 8; ++i)
      damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    if (seed % 10 == 9) damaged.resize(random() % damaged.size());
    const Result<std::vector<Topic>> read = readBcf(std::as_bytes(std::span(damaged)), "review.bcf");
    if (!read) {
      ++refused;
      refusal(damaged);
    } else {
      EXPECT_LE(read->size(), 4u) << seed;
    }
  }
  EXPECT_GT(refused, 150);  // most bytes are of packed files, which have sums
  EXPECT_LT(refused, 300);
}

INSTANTIATE_TEST_SUITE_P(Versions, BcfFile, testing::Values(BcfVersion::v2_1, BcfVersion::v3_0),
                         [](const auto& version) {
                           return version.param == BcfVersion::v2_1 ? "V21" : "V30";
                         });

}  // namespace
}  // namespace tandem::client
