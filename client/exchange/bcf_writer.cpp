#include "client/exchange/bcf_writer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "assets/base/utc_time.h"

namespace tandem::client {
namespace {

using pugi::xml_node;

/// Text without the two characters that UTF-8 can hold and XML cannot.
std::string xmlText(const std::string& text) {
  std::string fit;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool bad = text.compare(i, 2, "\xef\xbf") == 0 && i + 2 < text.size() &&
                     (text[i + 2] == '\xbe' || text[i + 2] == '\xbf');
    fit += bad ? '?' : text[i];
    if (bad) i += 2;
  }
  return fit;
}

void add(xml_node parent, const char* name, const std::string& text) {
  parent.append_child(name).text().set(xmlText(text).c_str());
}

bool isBlank(const std::string& text) { return text.find_first_not_of(" \t\r\n") == std::string::npos; }

/// Version 3.0 allows no blank text.
void addFilled(xml_node parent, const char* name, const std::string& text) {
  add(parent, name, isBlank(text) ? "unknown" : text);
}

void addNumber(xml_node parent, const char* name, double value) {
  std::array<char, 32> digits{};
  std::to_chars(digits.data(), digits.data() + digits.size() - 1, value + 0.0);  // no -0
  add(parent, name, digits.data());
}

/// A point, m, or a direction, of world axes.
void addVector(xml_node parent, const char* name, const glm::dvec3& world) {
  const glm::dvec3 v = bcfFromWorld(world);
  xml_node node = parent.append_child(name);
  addNumber(node, "X", v.x);
  addNumber(node, "Y", v.y);
  addNumber(node, "Z", v.z);
}

void addComponents(xml_node parent, const char* name, const std::vector<std::string>& guids) {
  if (guids.empty()) return;
  xml_node list = parent.append_child(name);
  for (const std::string& guid : guids)
    list.append_child("Component").append_attribute("IfcGuid").set_value(guid.c_str());
}

void addComment(xml_node parent, const TopicComment& comment, const Topic& topic, BcfVersion version) {
  xml_node node = parent.append_child("Comment");
  node.append_attribute("Guid").set_value(comment.guid.c_str());
  add(node, "Date", utcText(comment.made));
  addFilled(node, "Author", comment.author);
  // Version 2.1 requires a text, and takes a blank one; 3.0 takes none.
  if (version == BcfVersion::v2_1 || !isBlank(comment.text)) add(node, "Comment", comment.text);
  if (topic.view) node.append_child("Viewpoint").append_attribute("Guid").set_value(topic.view->guid.c_str());
  if (comment.changed == comment.made) return;
  add(node, "ModifiedDate", utcText(comment.changed));
  addFilled(node, "ModifiedAuthor", comment.author);
}

void addViewpoint(xml_node parent, const char* name, const Topic& topic) {
  if (!topic.view) return;
  xml_node node = parent.append_child(name);
  node.append_attribute("Guid").set_value(topic.view->guid.c_str());
  add(node, "Viewpoint", kViewpointFile);
  if (!topic.picture.empty()) add(node, "Snapshot", kSnapshotFile);
}

std::string xmlText(const pugi::xml_document& document) {
  std::ostringstream text;
  document.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  return text.str();
}

xml_node root(pugi::xml_document& document, const char* name) {
  xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version").set_value("1.0");
  declaration.append_attribute("encoding").set_value("UTF-8");
  return document.append_child(name);
}

void addCamera(xml_node parent, const TopicView& view, BcfVersion version) {
  xml_node camera = parent.append_child("PerspectiveCamera");
  const glm::dquat& turn = view.worldFromCamera.orientation;
  addVector(camera, "CameraViewPoint", view.worldFromCamera.position);
  addVector(camera, "CameraDirection", turn * glm::dvec3(0.0, 0.0, -1.0));
  addVector(camera, "CameraUpVector", turn * glm::dvec3(0.0, 1.0, 0.0));
  const double degrees = glm::degrees(view.fieldOfView);
  if (version == BcfVersion::v2_1) return addNumber(camera, "FieldOfView", std::clamp(degrees, 45.0, 60.0));
  addNumber(camera, "FieldOfView", degrees);
  addNumber(camera, "AspectRatio", view.aspect);
}

template <typename Values>
void addList(xml_node parent, const char* list, const char* element, const Values& values) {
  xml_node node = parent.append_child(list);
  for (const std::string& value : values) addFilled(node, element, value);
}

}  // namespace

std::string bcfVersionXml(BcfVersion version) {
  pugi::xml_document document;
  root(document, "Version")
      .append_attribute("VersionId")
      .set_value(version == BcfVersion::v2_1 ? "2.1" : "3.0");
  return xmlText(document);
}

std::string bcfMarkupXml(const Topic& topic, BcfVersion version) {
  pugi::xml_document document;
  xml_node markup = root(document, "Markup");
  xml_node node = markup.append_child("Topic");
  node.append_attribute("Guid").set_value(topic.guid.c_str());
  node.append_attribute("TopicType").set_value(kTopicTypes[static_cast<std::size_t>(topic.kind)]);
  node.append_attribute("TopicStatus").set_value(topic.status.c_str());
  addFilled(node, "Title", topic.title);
  add(node, "CreationDate", utcText(topic.made));
  addFilled(node, "CreationAuthor", topic.author);
  if (topic.changed != topic.made) add(node, "ModifiedDate", utcText(topic.changed));
  if (!isBlank(topic.assignee)) add(node, "AssignedTo", topic.assignee);
  if (!isBlank(topic.description)) add(node, "Description", topic.description);
  if (version == BcfVersion::v2_1) {
    for (const TopicComment& comment : topic.comments) addComment(markup, comment, topic, version);
    addViewpoint(markup, "Viewpoints", topic);
    return xmlText(document);
  }
  if (!topic.comments.empty()) {
    xml_node comments = node.append_child("Comments");
    for (const TopicComment& comment : topic.comments) addComment(comments, comment, topic, version);
  }
  if (topic.view) addViewpoint(node.append_child("Viewpoints"), "ViewPoint", topic);
  return xmlText(document);
}

std::string bcfViewpointXml(const TopicView& view, BcfVersion version) {
  pugi::xml_document document;
  xml_node info = root(document, "VisualizationInfo");
  info.append_attribute("Guid").set_value(view.guid.c_str());
  xml_node components = info.append_child("Components");
  addComponents(components, "Selection", view.selected);
  xml_node visibility = components.append_child("Visibility");
  visibility.append_attribute("DefaultVisibility").set_value(!view.onlyThese);
  addComponents(visibility, "Exceptions", view.exceptions);
  addCamera(info, view, version);
  if (!view.lines.empty()) {
    xml_node lines = info.append_child("Lines");
    for (const auto& [start, end] : view.lines) {
      xml_node line = lines.append_child("Line");
      addVector(line, "StartPoint", start);
      addVector(line, "EndPoint", end);
    }
  }
  if (!view.sections.empty()) {
    xml_node planes = info.append_child("ClippingPlanes");
    for (const document::SectionPlane& section : view.sections) {
      // Its direction points to what is cut away, as the normal of a section does.
      xml_node plane = planes.append_child("ClippingPlane");
      addVector(plane, "Location", section.point);
      addVector(plane, "Direction", section.normal);
    }
  }
  return xmlText(document);
}

std::string bcfExtensionsXml(const std::vector<Topic>& topics) {
  std::set<std::string> statuses{"Open", "In progress", "Resolved", "Closed"}, people;
  for (const Topic& topic : topics) {
    statuses.insert(topic.status);
    people.insert(topic.author);
    if (!isBlank(topic.assignee)) people.insert(topic.assignee);
    for (const TopicComment& comment : topic.comments) people.insert(comment.author);
  }
  pugi::xml_document document;
  xml_node node = root(document, "Extensions");
  const std::vector<std::string> types(kTopicTypes.begin(), kTopicTypes.end()), none;
  addList(node, "TopicTypes", "TopicType", types);
  addList(node, "TopicStatuses", "TopicStatus", statuses);
  addList(node, "Priorities", "Priority", none);
  addList(node, "TopicLabels", "TopicLabel", none);
  addList(node, "Users", "User", people);
  addList(node, "SnippetTypes", "SnippetType", none);
  addList(node, "Stages", "Stage", none);
  return xmlText(document);
}

std::string bcfProjectXml(const std::string& id, const std::string& name) {
  pugi::xml_document document;
  xml_node project = root(document, "ProjectInfo").append_child("Project");
  project.append_attribute("ProjectId").set_value(id.c_str());
  addFilled(project, "Name", name);
  return xmlText(document);
}

}  // namespace tandem::client
