#include "client/exchange/bcf_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <pugixml.hpp>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>

#include "assets/base/finite.h"
#include "assets/base/printable.h"
#include "assets/base/utc_time.h"
#include "assets/document/describe.h"
#include "client/exchange/guid.h"

namespace tandem::client {
namespace {

using pugi::xml_node;

constexpr std::size_t kMaxGuid = 64;     // bytes
constexpr std::size_t kMaxRead = 65536;  // components or lines that are looked at

/// A file is not as it must be. Does not leave this source.
struct BcfError {
  std::string reason;
};

/// Finds what no BCF file has: deep nesting, and a document type, by which a small file could name large
/// texts.
class Inspection : public pugi::xml_tree_walker {
 public:
  bool for_each(xml_node& node) override {
    if (depth() > kMaxXmlDepth) problem = "nests too deeply";
    if (node.type() == pugi::node_doctype) problem = "has a document type, which is not read";
    return problem == nullptr;
  }
  const char* problem = nullptr;
};

/// Parses a file into `document` and gives its root, which must have this name.
xml_node parse(pugi::xml_document& document, const std::string& xml, const char* name) {
  const pugi::xml_parse_result result =
      document.load_buffer(xml.data(), xml.size(), pugi::parse_default | pugi::parse_doctype);
  if (!result)
    throw BcfError{std::string("is no XML: ") + result.description() + " at byte " +
                   std::to_string(result.offset)};
  Inspection inspection;
  document.traverse(inspection);
  if (inspection.problem != nullptr) throw BcfError{inspection.problem};
  const xml_node root = document.document_element();
  if (std::strcmp(root.name(), name) != 0) throw BcfError{std::string("has no ") + name};
  return root;
}

/// A text in one line, cut to a limit between two characters, without spaces around it.
std::string oneLine(std::string text, std::size_t limit) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t' || c == '\r'; }, ' ');
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return {};
  text = text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
  return printable(text, limit);
}

std::string childText(xml_node parent, const char* name, std::size_t limit) {
  return oneLine(parent.child(name).text().get(), limit);
}

std::int64_t timeOf(xml_node parent, const char* name) {
  const std::string text = childText(parent, name, kMaxGuid);
  if (text.empty()) return 0;
  const std::optional<std::int64_t> time = utcTime(text);
  if (!time) throw BcfError{std::string("has a ") + name + " that is no time"};
  return *time;
}

std::string guidOf(xml_node node) {
  const std::string guid = node.attribute("Guid").value();
  if (guid.empty() || guid.size() > kMaxGuid || !isPrintable(guid))
    throw BcfError{std::string("has a ") + node.name() + " without a GUID"};
  std::string lower = guid;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return lower;
}

double numberOf(xml_node parent, const char* name) {
  const pugi::xml_text text = parent.child(name).text();
  const double value = text.as_double(NAN);
  if (text.empty() || !std::isfinite(value) || std::abs(value) > document::kFarthest)
    throw BcfError{std::string("has a ") + parent.name() + " without a sound " + name};
  return value;
}

glm::dvec3 vectorOf(xml_node parent, const char* name) {
  const xml_node node = parent.child(name);
  if (!node) throw BcfError{std::string("has a ") + parent.name() + " without " + name};
  return worldFromBcf({numberOf(node, "X"), numberOf(node, "Y"), numberOf(node, "Z")});
}

glm::dvec3 directionOf(xml_node parent, const char* name) {
  const glm::dvec3 direction = vectorOf(parent, name);
  if (!(glm::length(direction) > 1e-12))
    throw BcfError{std::string("has a ") + parent.name() + " whose " + name + " points nowhere"};
  return glm::normalize(direction);
}

TopicKind kindOf(const std::string& type) {
  const auto found =
      std::find_if(kTopicTypes.begin(), kTopicTypes.end(), [&](const char* each) { return type == each; });
  return found == kTopicTypes.end() ? TopicKind::note : static_cast<TopicKind>(found - kTopicTypes.begin());
}

TopicComment commentOf(xml_node node) {
  TopicComment comment;
  comment.guid = guidOf(node);
  comment.author = childText(node, "Author", document::kMaxName);
  comment.text = childText(node, "Comment", document::kMaxText);
  comment.made = timeOf(node, "Date");
  comment.changed = std::max(comment.made, timeOf(node, "ModifiedDate"));
  return comment;
}

/// The eye at the place of a camera element.
Pose poseOf(xml_node camera) {
  const glm::dvec3 back = -directionOf(camera, "CameraDirection");
  const glm::dvec3 up = directionOf(camera, "CameraUpVector");
  glm::dvec3 right = glm::cross(up, back);
  if (glm::length(right) < 1e-6)  // up says nothing: any upright eye will do
    right = glm::cross(std::abs(back.y) < 0.9 ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(0.0, 0.0, 1.0), back);
  right = glm::normalize(right);
  const glm::dmat3 axes(right, glm::cross(back, right), back);
  return {vectorOf(camera, "CameraViewPoint"), glm::normalize(glm::quat_cast(axes))};
}

std::vector<std::string> componentsOf(xml_node list) {
  std::vector<std::string> guids;
  for (const xml_node component : list.children("Component")) {
    std::string guid = component.attribute("IfcGuid").value();
    if (isIfcGuid(guid) && guids.size() < kMaxRead) guids.push_back(std::move(guid));
  }
  return guids;
}

std::optional<TopicView> viewOf(xml_node info) {
  TopicView view;
  view.guid = guidOf(info);
  const xml_node components = info.child("Components");
  view.selected = componentsOf(components.child("Selection"));
  const xml_node visibility = components.child("Visibility");
  view.onlyThese = visibility && !visibility.attribute("DefaultVisibility").as_bool(false);
  view.exceptions = componentsOf(visibility.child("Exceptions"));
  const xml_node perspective = info.child("PerspectiveCamera"), orthogonal = info.child("OrthogonalCamera");
  if (!perspective && !orthogonal) return std::nullopt;
  view.worldFromCamera = poseOf(perspective ? perspective : orthogonal);
  if (perspective) view.fieldOfView = glm::radians(numberOf(perspective, "FieldOfView"));
  if (perspective.child("AspectRatio")) view.aspect = numberOf(perspective, "AspectRatio");
  if (!(view.fieldOfView > 0.0 && view.fieldOfView < glm::radians(180.0)) || !(view.aspect > 0.0))
    throw BcfError{"has a camera without a sound field of view"};
  for (const xml_node plane : info.child("ClippingPlanes").children("ClippingPlane"))
    if (view.sections.size() < document::kMaxSections)
      view.sections.push_back({vectorOf(plane, "Location"), directionOf(plane, "Direction")});
  for (const xml_node line : info.child("Lines").children("Line"))
    if (view.lines.size() < kMaxRead)
      view.lines.emplace_back(vectorOf(line, "StartPoint"), vectorOf(line, "EndPoint"));
  return view;
}

BcfMarkup markupOf(xml_node markup, BcfVersion version) {
  BcfMarkup read;
  const xml_node node = markup.child("Topic");
  if (!node) throw BcfError{"has no Topic"};
  Topic& topic = read.topic;
  topic.guid = guidOf(node);
  topic.kind = kindOf(node.attribute("TopicType").value());
  topic.status = oneLine(node.attribute("TopicStatus").value(), document::kMaxName);
  topic.title = childText(node, "Title", document::kMaxText);
  topic.description = childText(node, "Description", document::kMaxText);
  if (topic.title.empty() && topic.description.empty()) throw BcfError{"has a Topic without a Title"};
  topic.author = childText(node, "CreationAuthor", document::kMaxName);
  topic.assignee = childText(node, "AssignedTo", document::kMaxName);
  topic.made = timeOf(node, "CreationDate");
  topic.changed = std::max(topic.made, timeOf(node, "ModifiedDate"));
  const bool old = version == BcfVersion::v2_1;
  for (const xml_node comment : (old ? markup : node.child("Comments")).children("Comment")) {
    topic.comments.push_back(commentOf(comment));
    if (topic.comments.back().text.empty()) topic.comments.pop_back();  // it only shows a viewpoint
  }
  const xml_node viewpoint = old ? markup.child("Viewpoints") : node.child("Viewpoints").child("ViewPoint");
  read.viewpointFile = viewpoint.child("Viewpoint").text().get();
  return read;
}

template <typename Read>
auto guarded(const Read& read) -> Result<decltype(read())> {
  try {
    return read();
  } catch (const BcfError& error) {
    return Error{error.reason};
  }
}

}  // namespace

Result<BcfVersion> readBcfVersion(const std::string& xml) {
  return guarded([&] {
    pugi::xml_document document;
    const std::string id = parse(document, xml, "Version").attribute("VersionId").value();
    if (id.starts_with("2.")) return BcfVersion::v2_1;
    if (id.starts_with("3.")) return BcfVersion::v3_0;
    throw BcfError{"names a version of BCF that is not read; 2.1 and 3.0 are"};
  });
}

Result<BcfMarkup> readBcfMarkup(const std::string& xml, BcfVersion version) {
  return guarded([&] {
    pugi::xml_document document;
    return markupOf(parse(document, xml, "Markup"), version);
  });
}

Result<std::optional<TopicView>> readBcfViewpoint(const std::string& xml) {
  return guarded([&] {
    pugi::xml_document document;
    return viewOf(parse(document, xml, "VisualizationInfo"));
  });
}

}  // namespace tandem::client
