#include "client/exchange/document_topics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "assets/base/printable.h"

namespace tandem::client {
namespace {

using document::Entry;

constexpr std::size_t kMaxTitle = 80;        // bytes
constexpr double kYaw = 0.7, kPitch = 0.5;   // rad, of a camera that is made: from the right, above
constexpr double kMargin = 1.3;              // of its distance, around what it looks at
constexpr double kDefaultFieldOfView = 0.7;  // rad, as the window's

constexpr std::array<const char*, 4> kNoteStatus{"Open", "In progress", "Resolved", "Closed"};
constexpr std::array<const char*, 5> kClashStatus{"New", "Active", "Reviewed", "Approved", "Resolved"};
constexpr const char* kNoStatus = "Info";  // views and measures ask for nothing

/// A length with a unit that suits it, or an angle.
std::string quantity(document::MeasureKind kind, double value) {
  std::array<char, 40> text{};
  if (kind == document::MeasureKind::angle)
    std::snprintf(text.data(), text.size(), "%.6g deg", glm::degrees(value));
  else if (std::abs(value) < 1.0)
    std::snprintf(text.data(), text.size(), "%.6g mm", 1e3 * value);
  else
    std::snprintf(text.data(), text.size(), "%.6g m", value);
  return text.data();
}

bool isEmpty(const assets::Bounds& bounds) {
  return !(bounds.min.x <= bounds.max.x && bounds.min.y <= bounds.max.y && bounds.min.z <= bounds.max.z);
}

/// The box around a box at a pose, world axes.
assets::Bounds moved(const assets::Bounds& bounds, const Pose& pose) {
  assets::Bounds box;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 point = transformPoint(pose, {(corner & 1) != 0 ? bounds.max.x : bounds.min.x,
                                                   (corner & 2) != 0 ? bounds.max.y : bounds.min.y,
                                                   (corner & 4) != 0 ? bounds.max.z : bounds.min.z});
    box.include(point);
  }
  return box;
}

class TopicMaker {
 public:
  explicit TopicMaker(const TopicSource& source) : source_(source) {
    for (const assets::Part& part : source.scene.parts) names_.push_back(part.name);
    for (const auto& [revision, id] : source.document.byRevision())
      if (const auto* name = std::get_if<document::PartName>(&source.document.find(id)->body))
        if (known(name->part) && !name->name.empty()) names_[name->part] = name->name;
    sceneSize_ =
        isEmpty(source.scene.bounds) ? 1.0 : glm::length(source.scene.bounds.max - source.scene.bounds.min);
  }

  std::vector<Topic> make() {
    std::map<document::EntryId, std::vector<TopicComment>> threads;
    for (const auto& [id, entry] : source_.document.entries())
      if (const auto* comment = std::get_if<document::Comment>(&entry.body))
        threads[comment->note].push_back({uuidOf(entry, source_.sceneHash), authorOf(entry), comment->text,
                                          entry.made, entry.changed, entry.id});
    std::vector<Topic> topics;
    for (const auto& [id, entry] : source_.document.entries()) {
      Topic topic = head(entry);
      if (const auto* note = std::get_if<document::Note>(&entry.body)) {
        fill(topic, *note);
        topic.comments = std::move(threads[id]);
      } else if (const auto* clash = std::get_if<document::ClashVerdict>(&entry.body)) {
        fill(topic, *clash);
      } else if (const auto* view = std::get_if<document::NamedView>(&entry.body)) {
        fill(topic, *view);
      } else if (const auto* measure = std::get_if<document::Measure>(&entry.body)) {
        fill(topic, *measure);
      } else {
        continue;
      }
      if (topic.title.empty()) topic.title = kTopicTypes[static_cast<std::size_t>(topic.kind)];
      topics.push_back(std::move(topic));
    }
    return topics;
  }

 private:
  static std::string authorOf(const Entry& entry) {
    return entry.authorName.empty() ? "unknown" : entry.authorName;
  }

  Topic head(const Entry& entry) const {
    Topic topic;
    topic.entry = entry.id;
    topic.guid = uuidOf(entry, source_.sceneHash);
    topic.author = authorOf(entry);
    topic.made = entry.made;
    topic.changed = entry.changed;
    topic.view.emplace().guid = uuidOf("view\n" + topic.guid);
    return topic;
  }

  bool known(PartId part) const { return part < source_.scene.parts.size(); }
  Pose poseOf(PartId part) const { return known(part) ? source_.worldFromPart[part] : Pose{}; }
  assets::Bounds boundsOf(PartId part) const {
    if (!known(part)) return {};
    const std::uint32_t mesh = source_.scene.parts[part].mesh;
    return mesh == assets::kNone ? assets::Bounds{} : moved(source_.scene.meshes[mesh].bounds, poseOf(part));
  }

  void point(Topic& topic, PartId part) const {
    if (!known(part)) return;
    auto& selected = topic.view->selected;
    if (std::find(selected.begin(), selected.end(), source_.guids.guid(part)) != selected.end()) return;
    topic.parts.push_back(names_[part]);
    selected.push_back(source_.guids.guid(part));
  }
  std::string name(PartId part) const { return known(part) ? names_[part] : "part " + std::to_string(part); }

  /// Turns the topic's camera to a ball.
  void look(Topic& topic, const glm::dvec3& centre, double radius) const {
    TopicView& view = *topic.view;
    view.fieldOfView = kDefaultFieldOfView;
    const double distance =
        kMargin * std::max(radius, 1e-3 * sceneSize_) / std::sin(0.5 * kDefaultFieldOfView);
    const glm::dquat orientation =
        glm::angleAxis(kYaw, glm::dvec3(0.0, 1.0, 0.0)) * glm::angleAxis(-kPitch, glm::dvec3(1.0, 0.0, 0.0));
    view.worldFromCamera = {centre + orientation * glm::dvec3(0.0, 0.0, distance), orientation};
  }

  void fill(Topic& topic, const document::Note& note) const {
    topic.kind = TopicKind::note;
    topic.title = titleOf(note.text);
    topic.description = note.text;
    topic.assignee = note.assignee;
    topic.status = kNoteStatus[static_cast<std::size_t>(note.status)];
    point(topic, note.part);
    topic.places = {transformPoint(poseOf(note.part), note.place)};
    const assets::Bounds bounds = boundsOf(note.part);
    const double radius = isEmpty(bounds) ? 0.15 * sceneSize_ : 0.5 * glm::length(bounds.max - bounds.min);
    look(topic, topic.places.front(), std::min(radius, 0.25 * sceneSize_));
  }

  /// The camera looks at where the boxes of both parts meet, and shows these parts alone.
  void fill(Topic& topic, const document::ClashVerdict& clash) const {
    topic.kind = TopicKind::clash;
    topic.title = "Clash of " + name(clash.a) + " and " + name(clash.b);
    if (clash.depth > 0.0)
      topic.title += ", " + quantity(document::MeasureKind::distance, clash.depth) + " deep";
    topic.description = clash.text;
    topic.status = kClashStatus[static_cast<std::size_t>(clash.status)];
    point(topic, clash.a);
    point(topic, clash.b);
    topic.view->onlyThese = !topic.view->selected.empty();
    topic.view->exceptions = topic.view->selected;
    const assets::Bounds a = boundsOf(clash.a), b = boundsOf(clash.b);
    assets::Bounds both{glm::max(a.min, b.min), glm::min(a.max, b.max)};
    if (isEmpty(both)) both = {glm::min(a.min, b.min), glm::max(a.max, b.max)};
    if (isEmpty(both)) both = source_.scene.bounds;
    if (isEmpty(both)) both = {glm::dvec3(-1.0), glm::dvec3(1.0)};
    const double smaller = std::min(glm::length(a.max - a.min), glm::length(b.max - b.min));
    const double least = isEmpty(a) || isEmpty(b) ? 0.0 : 0.3 * smaller;
    look(topic, 0.5 * (both.min + both.max), std::max(0.5 * glm::length(both.max - both.min), least));
  }

  void fill(Topic& topic, const document::NamedView& view) const {
    topic.kind = TopicKind::view;
    topic.title = view.name;
    topic.status = kNoStatus;
    topic.view->worldFromCamera = view.worldFromCamera;
    topic.view->fieldOfView = kDefaultFieldOfView;
    topic.view->sections = view.sections;
    topic.view->onlyThese = view.onlyThese;
    for (const PartId part : view.parts)
      if (known(part)) topic.view->exceptions.push_back(source_.guids.guid(part));
    topic.places = {transformPoint(view.worldFromCamera, {0.0, 0.0, -view.distance})};
  }

  void fill(Topic& topic, const document::Measure& measure) const {
    topic.kind = TopicKind::measure;
    topic.description = std::string(document::kMeasureNames[static_cast<std::size_t>(measure.kind)]) + " " +
                        quantity(measure.kind, measure.value);
    topic.title = measure.name.empty() ? topic.description : measure.name;
    topic.status = kNoStatus;
    assets::Bounds bounds;
    for (const document::Anchor& anchor : measure.anchors) {
      point(topic, anchor.part);
      const glm::dvec3 place = transformPoint(poseOf(anchor.part), anchor.point);
      if (!topic.places.empty()) topic.view->lines.emplace_back(topic.places.back(), place);
      topic.places.push_back(place);
      bounds.include(place);
    }
    if (isEmpty(bounds)) bounds = source_.scene.bounds;
    if (isEmpty(bounds)) bounds = {glm::dvec3(-1.0), glm::dvec3(1.0)};
    look(topic, 0.5 * (bounds.min + bounds.max),
         std::max(glm::length(bounds.max - bounds.min), 0.05 * sceneSize_));
  }

  const TopicSource& source_;
  std::vector<std::string> names_;  // by part
  double sceneSize_ = 1.0;          // m
};

}  // namespace

std::string titleOf(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return {};
  const std::size_t sentence = text.find(". ", begin);
  const std::size_t end = sentence == std::string::npos ? text.find_last_not_of(' ') + 1 : sentence;
  std::string title = text.substr(begin, end - begin);
  if (title.size() <= kMaxTitle) return title;
  title = printable(title, kMaxTitle);
  const std::size_t space = title.rfind(' ');
  if (space != std::string::npos && space > kMaxTitle / 2) title.resize(space);
  return title + "...";
}

std::vector<Topic> topicsOf(const TopicSource& source) {
  ASSERT(source.worldFromPart.size() == source.scene.parts.size());
  return TopicMaker(source).make();
}

}  // namespace tandem::client
