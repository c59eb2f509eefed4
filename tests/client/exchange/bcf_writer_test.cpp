// The XML of BCF: elements in the order of buildingSMART's schemas, with all that these require.

#include "client/exchange/bcf_writer.h"

#include <gtest/gtest.h>

#include <pugixml.hpp>

#include "tests/client/exchange/topic_samples.h"

namespace tandem::client {
namespace {

using Names = std::vector<std::string>;

Names childrenOf(const pugi::xml_node& node) {
  Names names;
  for (const pugi::xml_node child : node.children()) names.emplace_back(child.name());
  return names;
}

struct Xml {
  pugi::xml_document document;
  explicit Xml(const std::string& text) { EXPECT_TRUE(document.load_string(text.c_str())) << text; }
  pugi::xml_node at(const char* path) const { return document.select_node(path).node(); }
  Names children(const char* path) const { return childrenOf(at(path)); }
};

Topic note() {
  TopicSample sample;
  std::vector<Topic> topics = sample.topics();
  topics[0].changed = topics[0].comments[0].changed = 9000;
  topics[0].picture = {1};
  return topics[0];
}

TEST(BcfWriter, MarkupOfVersion21HasItsOrder) {
  const Xml xml(bcfMarkupXml(note(), BcfVersion::v2_1));
  EXPECT_EQ(xml.children("/Markup"), (Names{"Topic", "Comment", "Comment", "Viewpoints"}));
  EXPECT_EQ(xml.children("/Markup/Topic"),
            (Names{"Title", "CreationDate", "CreationAuthor", "ModifiedDate", "AssignedTo", "Description"}));
  EXPECT_EQ(xml.children("/Markup/Comment[1]"),
            (Names{"Date", "Author", "Comment", "Viewpoint", "ModifiedDate", "ModifiedAuthor"}));
  EXPECT_EQ(xml.children("/Markup/Comment[2]"), (Names{"Date", "Author", "Comment", "Viewpoint"}));
  EXPECT_EQ(xml.children("/Markup/Viewpoints"), (Names{"Viewpoint", "Snapshot"}));
}

TEST(BcfWriter, MarkupOfVersion30HasItsOrder) {
  const Xml xml(bcfMarkupXml(note(), BcfVersion::v3_0));
  EXPECT_EQ(xml.children("/Markup"), Names{"Topic"});
  EXPECT_EQ(xml.children("/Markup/Topic"), (Names{"Title", "CreationDate", "CreationAuthor", "ModifiedDate",
                                                  "AssignedTo", "Description", "Comments", "Viewpoints"}));
  EXPECT_EQ(xml.children("/Markup/Topic/Comments"), (Names{"Comment", "Comment"}));
  EXPECT_EQ(xml.children("/Markup/Topic/Viewpoints"), Names{"ViewPoint"});
  EXPECT_EQ(xml.children("/Markup/Topic/Viewpoints/ViewPoint"), (Names{"Viewpoint", "Snapshot"}));
}

TEST(BcfWriter, WhatTheSchemasRequireIsThereEvenOfAnEmptyTopic) {
  Topic empty;
  empty.guid = uuidOf(std::string("x"));
  empty.status = "Open";
  for (const BcfVersion version : {BcfVersion::v2_1, BcfVersion::v3_0}) {
    const Xml xml(bcfMarkupXml(empty, version));
    EXPECT_EQ(xml.children("/Markup/Topic"), (Names{"Title", "CreationDate", "CreationAuthor"}));
    for (const char* attribute : {"Guid", "TopicType", "TopicStatus"})
      EXPECT_STRNE(xml.at("/Markup/Topic").attribute(attribute).value(), "") << attribute;
    for (const pugi::xml_node child : xml.at("/Markup/Topic").children())
      EXPECT_STRNE(child.text().get(), "");
  }
}

TEST(BcfWriter, ABlankCommentStandsWhereTheSchemaTakesOne) {
  Topic topic = note();
  topic.comments[1].text = " ";
  EXPECT_EQ(Xml(bcfMarkupXml(topic, BcfVersion::v2_1)).children("/Markup/Comment[2]"),
            (Names{"Date", "Author", "Comment", "Viewpoint"}));
  EXPECT_EQ(Xml(bcfMarkupXml(topic, BcfVersion::v3_0)).children("/Markup/Topic/Comments/Comment[2]"),
            (Names{"Date", "Author", "Viewpoint"}));
}

TEST(BcfWriter, AViewpointHasItsOrderAndZUp) {
  TopicView view = *TopicSample().topics()[2].view;
  view.worldFromCamera = {{1.0, 2.0, 3.0}, {1.0, 0.0, 0.0, 0.0}};
  view.selected = {ifcGuidOf("a")};
  view.lines = {{{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}};
  for (const BcfVersion version : {BcfVersion::v2_1, BcfVersion::v3_0}) {
    const Xml xml(bcfViewpointXml(view, version));
    EXPECT_EQ(xml.children("/VisualizationInfo"),
              (Names{"Components", "PerspectiveCamera", "Lines", "ClippingPlanes"}));
    EXPECT_EQ(xml.children("/VisualizationInfo/Components"), (Names{"Selection", "Visibility"}));
    Names camera{"CameraViewPoint", "CameraDirection", "CameraUpVector", "FieldOfView"};
    if (version == BcfVersion::v3_0) camera.emplace_back("AspectRatio");
    EXPECT_EQ(xml.children("//PerspectiveCamera"), camera);
    const auto number = [&](const char* path) { return xml.at(path).text().as_double(); };
    EXPECT_EQ(number("//CameraViewPoint/X"), 1.0);
    EXPECT_EQ(number("//CameraViewPoint/Y"), -3.0);
    EXPECT_EQ(number("//CameraViewPoint/Z"), 2.0);
    EXPECT_EQ(number("//CameraDirection/Y"), 1.0);  // along -z of the world
    EXPECT_EQ(number("//CameraUpVector/Z"), 1.0);
    EXPECT_EQ(number("//EndPoint/Z"), 1.0);
    EXPECT_EQ(number("//ClippingPlane/Direction/Z"), 1.0);
    EXPECT_EQ(number("//FieldOfView") < 45.0, version == BcfVersion::v3_0);
  }
}

TEST(BcfWriter, AxesTurnBothWays) {
  const glm::dvec3 v(1.0, 2.0, 3.0);
  EXPECT_EQ(worldFromBcf(bcfFromWorld(v)), v);
  EXPECT_EQ(bcfFromWorld({0.0, 1.0, 0.0}), glm::dvec3(0.0, 0.0, 1.0));
}

TEST(BcfWriter, ExtensionsNameEveryValueThatTopicsHave) {
  const std::vector<Topic> topics = TopicSample().topics();
  const Xml xml(bcfExtensionsXml(topics));
  EXPECT_EQ(xml.children("/Extensions"), (Names{"TopicTypes", "TopicStatuses", "Priorities", "TopicLabels",
                                                "Users", "SnippetTypes", "Stages"}));
  const auto has = [&](const char* element, const std::string& value) {
    for (const pugi::xpath_node node : xml.document.select_nodes(element))
      if (node.node().text().get() == value) return true;
    return false;
  };
  for (const Topic& topic : topics) {
    EXPECT_TRUE(has("//TopicStatus", topic.status)) << topic.status;
    EXPECT_TRUE(has("//TopicType", kTopicTypes[static_cast<std::size_t>(topic.kind)]));
    EXPECT_TRUE(has("//User", topic.author));
  }
  EXPECT_TRUE(has("//User", "Ben"));
  EXPECT_FALSE(has("//User", "nobody"));
}

TEST(BcfWriter, VersionAndProjectHaveTheirAttributes) {
  EXPECT_STREQ(Xml(bcfVersionXml(BcfVersion::v2_1)).at("/Version").attribute("VersionId").value(), "2.1");
  EXPECT_STREQ(Xml(bcfVersionXml(BcfVersion::v3_0)).at("/Version").attribute("VersionId").value(), "3.0");
  const Xml project(bcfProjectXml("id", ""));
  EXPECT_STREQ(project.at("/ProjectInfo/Project").attribute("ProjectId").value(), "id");
  EXPECT_STRNE(project.at("/ProjectInfo/Project/Name").text().get(), "");
}

TEST(BcfWriter, TextsAreEscapedAndHoldNothingThatXmlCannot) {
  Topic topic = note();
  topic.description = "<a> & \"b\" \xef\xbf\xbf ]]>";
  const Xml xml(bcfMarkupXml(topic, BcfVersion::v3_0));
  EXPECT_STREQ(xml.at("//Description").text().get(), "<a> & \"b\" ? ]]>");
}

}  // namespace
}  // namespace tandem::client
