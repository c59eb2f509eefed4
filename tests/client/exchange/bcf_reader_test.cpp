// The XML of BCF as other programs write it, damaged and hostile.

#include "client/exchange/bcf_reader.h"

#include <gtest/gtest.h>

#include <random>

#include <glm/geometric.hpp>

#include "assets/base/printable.h"
#include "client/exchange/bcf_writer.h"
#include "tests/client/exchange/topic_samples.h"

namespace tandem::client {
namespace {

const std::string kHead = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>";

std::string topicXml(const std::string& inside, const std::string& attributes = "Guid=\"A-1\"") {
  return kHead + "<Markup><Topic " + attributes + ">" + inside + "</Topic></Markup>";
}

std::string reasonOf(const std::string& xml, BcfVersion version = BcfVersion::v3_0) {
  const Result<BcfMarkup> read = readBcfMarkup(xml, version);
  return read ? "it was read" : read.error().message;
}

TEST(BcfReader, TakesWhatAnotherProgramWrites) {
  const std::string xml = topicXml(
      "<ReferenceLinks/><Title>A</Title><Unknown><Deep/></Unknown><CreationDate>2021-02-17T10:49:50.286Z"
      "</CreationDate><CreationAuthor>a@b.c</CreationAuthor><Comments><Comment Guid=\"B\"><Date>"
      "2021-02-18T10:49:50+01:00</Date><Author>x</Author><Comment>one&#10;two</Comment></Comment><Comment "
      "Guid=\"C\">"
      "<Date>2021-02-18T10:49:50Z</Date><Author>x</Author><Comment/></Comment></Comments>",
      "Guid=\"ABC\" ServerAssignedId=\"3\" TopicType=\"OTHER\" TopicStatus=\"OPEN\"");
  const Result<BcfMarkup> read = readBcfMarkup(xml, BcfVersion::v3_0);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->topic.guid, "abc");
  EXPECT_EQ(read->topic.kind, TopicKind::note);
  EXPECT_EQ(read->topic.made, 1613558990);
  ASSERT_EQ(read->topic.comments.size(), 1u) << "a comment without text says nothing";
  EXPECT_EQ(read->topic.comments[0].text, "one two");
  EXPECT_EQ(read->viewpointFile, "");
}

TEST(BcfReader, RefusesWhatIsMissing) {
  EXPECT_EQ(reasonOf(topicXml("<Title>A</Title>")), "it was read");
  EXPECT_EQ(reasonOf(topicXml("<Title> </Title>")), "has a Topic without a Title");
  EXPECT_EQ(reasonOf(topicXml("<Title>A</Title>", "")), "has a Topic without a GUID");
  EXPECT_EQ(reasonOf(kHead + "<Markup/>"), "has no Topic");
  EXPECT_EQ(reasonOf(kHead + "<Other/>"), "has no Markup");
  EXPECT_EQ(reasonOf(topicXml("<Title>A</Title><CreationDate>soon</CreationDate>")),
            "has a CreationDate that is no time");
}

TEST(BcfReader, RefusesDocumentTypesAndDepth) {
  const std::string bomb =
      "<!DOCTYPE Markup [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;\">]>";
  const std::string sound = topicXml("<Title>A</Title>");
  EXPECT_EQ(reasonOf(bomb + sound.substr(kHead.size())), "has a document type, which is not read");
  std::string deep = "<Title>A</Title>";
  for (int i = 0; i < kMaxXmlDepth - 2; ++i) deep = "<a>" + deep + "</a>";
  EXPECT_EQ(reasonOf(topicXml("<Title>A</Title>" + deep)), "nests too deeply");
  EXPECT_EQ(reasonOf(topicXml("<Title>A</Title>" + deep.substr(3, deep.size() - 7))), "it was read");
  std::string abyss;
  for (int i = 0; i < 200000; ++i) abyss += "<a>";
  for (int i = 0; i < 200000; ++i) abyss += "</a>";
  EXPECT_EQ(reasonOf(topicXml("<Title>A</Title>" + abyss)), "nests too deeply");
}

TEST(BcfReader, KnowsItsVersions) {
  const auto version = [](const char* id) {
    return readBcfVersion("<Version VersionId=\"" + std::string(id) + "\"/>");
  };
  EXPECT_EQ(*version("2.1"), BcfVersion::v2_1);
  EXPECT_EQ(*version("3.0"), BcfVersion::v3_0);
  EXPECT_FALSE(version("4.0"));
  EXPECT_FALSE(version(""));
}

std::string viewXml(const std::string& camera) {
  return "<VisualizationInfo Guid=\"v\"><Components><Visibility/></Components>" + camera +
         "</VisualizationInfo>";
}
std::string cameraXml(const std::string& direction, const std::string& up, const std::string& field) {
  return "<PerspectiveCamera><CameraViewPoint><X>1</X><Y>2</Y><Z>3</Z></CameraViewPoint><CameraDirection>" +
         direction + "</CameraDirection><CameraUpVector>" + up + "</CameraUpVector><FieldOfView>" + field +
         "</FieldOfView></PerspectiveCamera>";
}
const std::string kNorth = "<X>0</X><Y>1</Y><Z>0</Z>", kUp = "<X>0</X><Y>0</Y><Z>1</Z>";

TEST(BcfReader, TakesAnyCameraThatLooksSomewhere) {
  const auto sound = readBcfViewpoint(viewXml(cameraXml(kNorth, kUp, "60")));
  ASSERT_TRUE(sound && *sound);
  EXPECT_EQ((*sound)->worldFromCamera.position, glm::dvec3(1.0, 3.0, -2.0));
  EXPECT_NEAR((*sound)->fieldOfView, 1.0471975, 1e-6);
  // Up may lie in the direction of sight.
  const auto down = readBcfViewpoint(viewXml(cameraXml(kUp, kUp, "60")));
  ASSERT_TRUE(down && *down);
  EXPECT_TRUE(isValid((*down)->worldFromCamera));
  const auto none = readBcfViewpoint(viewXml(""));
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->has_value());
}

TEST(BcfReader, RefusesNumbersThatAreNone) {
  for (const char* bad : {"", "nan", "inf", "1e300", "x"})
    EXPECT_FALSE(
        readBcfViewpoint(viewXml(cameraXml("<X>0</X><Y>" + std::string(bad) + "</Y><Z>0</Z>", kUp, "60"))))
        << bad;
  EXPECT_FALSE(readBcfViewpoint(viewXml(cameraXml("<X>0</X><Y>0</Y><Z>0</Z>", kUp, "60"))));
  for (const char* field : {"0", "180", "-1", "nan"})
    EXPECT_FALSE(readBcfViewpoint(viewXml(cameraXml(kNorth, kUp, field)))) << field;
}

TEST(BcfReader, ReadsOrRefusesWhateverIsDamaged) {
  const Topic topic = TopicSample().topics()[0];
  const std::string markup = bcfMarkupXml(topic, BcfVersion::v3_0);
  const std::string view = bcfViewpointXml(*topic.view, BcfVersion::v3_0);
  int refused = 0;
  for (unsigned seed = 0; seed < 2000; ++seed) {
    std::mt19937 random(seed);
    std::string damaged = seed % 2 == 0 ? markup : view;
    for (unsigned i = 0; i <= seed % 4; ++i) {
      const std::size_t at = random() % damaged.size();
      if (random() % 3 == 0)
        damaged.erase(at, random() % 40);
      else
        damaged[at] = static_cast<char>(random() % 256);
    }
    if (seed % 2 != 0) {
      const auto read = readBcfViewpoint(damaged);
      refused += read ? 0 : 1;
      EXPECT_TRUE(!read || !*read || isValid((*read)->worldFromCamera)) << seed;
      continue;
    }
    const auto read = readBcfMarkup(damaged, BcfVersion::v3_0);
    refused += read ? 0 : 1;
    if (!read) {
      EXPECT_EQ(read.error().message.find('\n'), std::string::npos) << seed;
    } else {
      for (const std::string& text : {read->topic.title, read->topic.description, read->topic.author})
        EXPECT_TRUE(isPrintable(text) && text.size() <= document::kMaxText) << seed;
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_LT(refused, 1900);
}

}  // namespace
}  // namespace tandem::client
