#pragma once

// A topic: one thing that was agreed on, or is still open, as review tools exchange it. Plain data between
// the document (document_topics.h, topic_changes.h) and the files (bcf_file.h, topic_csv.h, topic_page.h).

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assets/document/entry.h"

namespace tandem::client {

/// What kind of entry a topic is of, or may become.
enum class TopicKind : std::uint8_t { note, clash, view, measure };
/// Their TopicType in a file; any other type is read as a note.
inline constexpr std::array<const char*, 4> kTopicTypes{"Note", "Clash", "View", "Measure"};

struct TopicComment {
  std::string guid, author, text;
  std::int64_t made = 0, changed = 0;  // Unix time, s
  document::EntryId entry = 0;         // of comments that were made from the document
};

/// How the scene is seen, in world axes (+y up), m. Parts go by their IFC GUIDs.
struct TopicView {
  std::string guid;
  Pose worldFromCamera;      // looks along -z, +y up
  double fieldOfView = 0.7;  // rad, vertical
  double aspect = 1.6;       // width to height
  std::vector<document::SectionPlane> sections;
  std::vector<std::string> selected;
  bool onlyThese = false;  // `exceptions` are all that is shown; else they are hidden
  std::vector<std::string> exceptions;
  std::vector<std::pair<glm::dvec3, glm::dvec3>> lines;
};

struct Topic {
  std::string guid;  // UUID, lower case
  TopicKind kind = TopicKind::note;
  std::string status, title, description, author, assignee;
  std::int64_t made = 0, changed = 0;  // Unix time, s
  std::vector<TopicComment> comments;
  std::optional<TopicView> view;
  std::vector<std::uint8_t> picture;  // PNG; empty: none

  // Of topics that were made from the document; not in every kind of file.
  document::EntryId entry = 0;
  std::vector<std::string> parts;  // names
  std::vector<glm::dvec3> places;  // world, m: what the topic points at
};

}  // namespace tandem::client
