#include "client/exchange/topic_changes.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/printable.h"
#include "assets/document/entry_check.h"

namespace tandem::client {
namespace {

using namespace document;

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
}

/// Lower case letters alone, so that "IN_PROGRESS" and "In progress" are the same.
std::string letters(const std::string& text) {
  std::string kept;
  for (const char c : text) {
    if (c >= 'a' && c <= 'z') kept += c;
    if (c >= 'A' && c <= 'Z') kept += static_cast<char>(c - 'A' + 'a');
  }
  return kept;
}

template <typename Status>
std::optional<Status> find(const std::map<std::string, Status>& words, const std::string& status) {
  const auto found = words.find(letters(status));
  return found == words.end() ? std::nullopt : std::optional(found->second);
}

/// The status that a word of another program means, if it is known.
std::optional<NoteStatus> noteStatus(const std::string& status) {
  using enum NoteStatus;
  static const std::map<std::string, NoteStatus> kWords{{"open", open},           {"new", open},
                                                        {"active", open},         {"reopened", open},
                                                        {"todo", open},           {"inprogress", inProgress},
                                                        {"ongoing", inProgress},  {"assigned", inProgress},
                                                        {"reviewed", inProgress}, {"resolved", resolved},
                                                        {"done", resolved},       {"fixed", resolved},
                                                        {"closed", closed},       {"approved", closed}};
  return find(kWords, status);
}
std::optional<ClashStatus> clashStatus(const std::string& status) {
  using enum ClashStatus;
  static const std::map<std::string, ClashStatus> kWords{
      {"new", fresh},       {"active", active},     {"open", active},       {"inprogress", active},
      {"reopened", active}, {"reviewed", reviewed}, {"approved", approved}, {"resolved", resolved},
      {"done", resolved},   {"fixed", resolved},    {"closed", resolved}};
  return find(kWords, status);
}

/// A title and a description as the one text of a note.
std::string textOf(const Topic& topic) {
  const std::string &title = topic.title, &description = topic.description;
  if (description.empty() || description == title) return title;
  if (title.empty() || titleOf(description) == title) return description;
  return printable(title + ": " + description, kMaxText);
}

std::pair<PartId, PartId> pairOf(PartId a, PartId b) { return {std::min(a, b), std::max(a, b)}; }

/// Whether a member had another value.
template <typename T>
bool assign(T& member, const T& value) {
  if (member == value) return false;
  member = value;
  return true;
}
/// The same of a text; spaces around it do not count, because files lose them.
bool assignText(std::string& member, const std::string& value) {
  return trimmed(member) != trimmed(value) && assign(member, value);
}

class ChangeMaker {
 public:
  ChangeMaker(const TopicSource& there, const std::string& name)
      : there_(there), name_(name), nextId_(there.document.lastId() + 1), current_(topicsOf(there)) {
    for (const Topic& topic : current_) {
      known_[topic.guid] = &topic;
      for (const TopicComment& comment : topic.comments) comments_[comment.guid] = comment.entry;
    }
    for (const auto& [id, entry] : there.document.entries()) index(id, entry.body);
  }

  /// Changes an entry that is known by its GUID. What is alike is then looked for among the texts as they
  /// become, as it will be when the file comes again.
  void takeKnown(const Topic& topic) {
    if (const auto known = known_.find(topic.guid); known != known_.end())
      change(
          known->second->entry, [&](Body& body) { return revise(body, *known->second, topic); },
          topic.changed);
  }
  /// The same of comments, after takeKnown() of all topics.
  void takeKnownComments(const Topic& topic) {
    for (const TopicComment& comment : topic.comments) {
      const auto known = comments_.find(comment.guid);
      if (known == comments_.end()) continue;
      need(reference(there_.document.find(known->second)->body));
      const auto revise = [&](Body& body) { return assignText(std::get<Comment>(body).text, comment.text); };
      change(known->second, revise, comment.changed);
    }
  }

  /// After all that is known.
  void take(const Topic& topic) {
    EntryId entry = 0;
    if (const auto known = known_.find(topic.guid); known != known_.end()) {
      entry = known->second->entry;
    } else if (entry = alike(topic); entry != 0) {
      change(
          entry, [&](Body& body) { return setStatus(body, topic); }, topic.changed);
    } else {
      entry = add(bodyOf(topic));
    }
    takeComments(topic, entry);
  }

  TopicChanges changes() && { return std::move(changes_); }

 private:
  /// Makes an entry known by what it says.
  void index(EntryId id, const Body& body) {
    if (const auto* note = std::get_if<Note>(&body)) notes_[trimmed(note->text)].insert(id);
    if (const auto* view = std::get_if<NamedView>(&body)) views_[view->name].insert(id);
    if (const auto* clash = std::get_if<ClashVerdict>(&body)) clashes_[pairOf(clash->a, clash->b)].insert(id);
    if (const auto* comment = std::get_if<Comment>(&body)) ++texts_[comment->note][trimmed(comment->text)];
  }
  /// The same, by what it says now instead of what it said.
  void indexAgain(EntryId id, const Body& before, const Body& now) {
    if (const auto* note = std::get_if<Note>(&before)) notes_[trimmed(note->text)].erase(id);
    if (const auto* view = std::get_if<NamedView>(&before)) views_[view->name].erase(id);
    if (const auto* comment = std::get_if<Comment>(&before)) --texts_[comment->note][trimmed(comment->text)];
    index(id, now);
  }

  std::string credited(const std::string& author, const std::string& text) const {
    if (author.empty() || author == name_) return text;
    return printable('[' + author + "] " + text, kMaxText);
  }
  /// A verdict's text, which may say already who gave it.
  std::string verdictText(const Topic& topic) const {
    if (topic.description.starts_with('[')) return printable(topic.description, kMaxText);
    return credited(topic.author, topic.description);
  }
  PartId selected(const Topic& topic, std::size_t index) const {
    if (!topic.view || index >= topic.view->selected.size()) return kNoPart;
    return there_.guids.part(topic.view->selected[index]);
  }

  /// An entry of another topic that means the same; 0 if there is none.
  EntryId alike(const Topic& topic) const {
    const auto in = [](const auto& map, const auto& key) {
      const auto found = map.find(key);
      return found == map.end() || found->second.empty() ? EntryId{0} : *found->second.begin();
    };
    if (isClash(topic)) return in(clashes_, pairOf(selected(topic, 0), selected(topic, 1)));
    if (topic.kind == TopicKind::view && topic.view) return in(views_, viewName(topic));
    const std::string text = textOf(topic);
    const EntryId broughtIn = in(notes_, trimmed(credited(topic.author, text)));
    return broughtIn != 0 ? broughtIn : in(notes_, trimmed(text));
  }
  bool isClash(const Topic& topic) const {
    const PartId a = selected(topic, 0), b = selected(topic, 1);
    return topic.kind == TopicKind::clash && a != kNoPart && b != kNoPart && a != b;
  }
  static std::string viewName(const Topic& topic) { return printable(topic.title, kMaxName); }

  EntryId add(Body body) {
    Entry entry;
    entry.id = nextId_++;
    index(entry.id, body);
    entry.body = std::move(body);
    return put(std::move(entry));
  }

  EntryId put(Entry entry) {
    const EntryId id = entry.id;
    places_[id] = changes_.entries.size();
    changes_.entries.push_back(std::move(entry));
    return id;
  }

  /// Puts an entry of the session among the changes, as `revise` makes it unless the session is newer.
  template <typename Revise>
  void change(EntryId id, const Revise& revise, std::int64_t changed) {
    const Entry* old = there_.document.find(id);
    if (old == nullptr || places_.contains(id)) return;  // it is among the changes
    Entry entry = *old;
    if (revise(entry.body) && changed < old->changed) {
      ++changes_.kept;
      entry = *old;
    }
    indexAgain(id, old->body, entry.body);
    put(std::move(entry));
  }
  /// Puts the session's note there, for comments to refer to.
  void need(EntryId note) {
    change(
        note, [](Body&) { return false; }, 0);
  }

  /// Takes over what the file has otherwise than the session exports it now.
  bool revise(Body& body, const Topic& now, const Topic& topic) const {
    const bool title = trimmed(now.title) != topic.title;
    const bool description = trimmed(now.description) != topic.description;
    bool changes = setStatus(body, topic);
    if (auto* note = std::get_if<Note>(&body)) {
      changes = assignText(note->assignee, topic.assignee) || changes;
      Topic text = topic;
      if (!title && !topic.description.empty()) text.title.clear();
      if (title || description) changes = assignText(note->text, textOf(text)) || changes;
    } else if (auto* clash = std::get_if<ClashVerdict>(&body)) {
      changes = assignText(clash->text, topic.description) || changes;
    } else if (auto* view = std::get_if<NamedView>(&body)) {
      if (title) changes = assignText(view->name, viewName(topic)) || changes;
    } else if (auto* measure = std::get_if<Measure>(&body)) {
      if (title) changes = assignText(measure->name, viewName(topic)) || changes;
    }
    return changes;
  }

  static bool setStatus(Body& body, const Topic& topic) {
    if (auto* note = std::get_if<Note>(&body))
      return assign(note->status, noteStatus(topic.status).value_or(note->status));
    if (auto* clash = std::get_if<ClashVerdict>(&body))
      return assign(clash->status, clashStatus(topic.status).value_or(clash->status));
    return false;
  }

  /// The entry that an unknown topic becomes.
  Body bodyOf(const Topic& topic) {
    if (isClash(topic))
      return ClashVerdict{selected(topic, 0), selected(topic, 1),
                          clashStatus(topic.status).value_or(ClashStatus::active), 0.0, verdictText(topic)};
    if (topic.kind == TopicKind::view && topic.view) return viewOf(topic);
    if (topic.view && views_[viewName(topic)].empty()) add(viewOf(topic));  // a note keeps no camera
    Note note = noteAt(topic);
    note.text = credited(topic.author, textOf(topic));
    note.assignee = topic.assignee;
    note.status = noteStatus(topic.status).value_or(NoteStatus::open);
    return note;
  }

  /// A note on the part that is selected, or where the camera looks.
  Note noteAt(const Topic& topic) const {
    Note note;
    note.part = selected(topic, 0);
    if (note.part != kNoPart) {
      const std::uint32_t mesh = there_.scene.parts[note.part].mesh;
      if (mesh != assets::kNone) {
        const assets::Bounds& bounds = there_.scene.meshes[mesh].bounds;
        note.place = 0.5 * (bounds.min + bounds.max);
      }
    } else if (topic.view) {
      const Pose& camera = topic.view->worldFromCamera;
      note.place = transformPoint(camera, {0.0, 0.0, -sightOf(camera)});
    }
    return note;
  }
  /// How far before a camera the scene is, m.
  double sightOf(const Pose& camera) const {
    const assets::Bounds& bounds = there_.scene.bounds;
    if (!(bounds.min.x <= bounds.max.x)) return 1.0;
    const glm::dvec3 direction = transformVector(camera, {0.0, 0.0, -1.0});
    const double size = std::max(glm::length(bounds.max - bounds.min), 1e-6);
    return std::max(glm::dot(0.5 * (bounds.min + bounds.max) - camera.position, direction), 0.05 * size);
  }
  NamedView viewOf(const Topic& topic) const {
    NamedView view;
    view.name = viewName(topic);
    view.worldFromCamera = topic.view->worldFromCamera;
    view.distance = std::min(sightOf(view.worldFromCamera), 1e9);
    view.sections = topic.view->sections;
    view.onlyThese = topic.view->onlyThese;
    for (const std::string& guid : topic.view->exceptions)
      if (const PartId part = there_.guids.part(guid); part != kNoPart && view.parts.size() < kMaxListed)
        view.parts.push_back(part);
    // Of parts that this scene does not have, nothing would be left to see.
    if (view.parts.empty()) view.onlyThese = false;
    return view;
  }

  void takeComments(const Topic& topic, EntryId entry) {
    for (const TopicComment& comment : topic.comments) {
      if (comments_.contains(comment.guid)) continue;
      const EntryId note = threadOf(topic, entry);
      const std::string text = credited(comment.author, comment.text);
      auto& texts = texts_[note];
      if (texts[trimmed(comment.text)] > 0 || texts[trimmed(text)] > 0) continue;
      add(Comment{note, text});
    }
  }

  /// The note whose thread takes the comments of a topic: what is no note has one beside it.
  EntryId threadOf(const Topic& topic, EntryId entry) {
    const Body& body = changes_.entries[places_.at(entry)].body;
    if (std::holds_alternative<Note>(body)) return entry;
    Note note = noteAt(topic);
    note.text = printable("Remarks on " + topic.title, kMaxText);
    if (const std::set<EntryId>& there = notes_[trimmed(note.text)]; !there.empty()) {
      const EntryId thread = *there.begin();
      need(thread);
      return thread;
    }
    return add(std::move(note));
  }

  const TopicSource& there_;
  const std::string& name_;
  EntryId nextId_;
  std::vector<Topic> current_;                              // as the session exports them now
  std::map<std::string, const Topic*> known_;               // by GUID
  std::map<std::string, EntryId> comments_;                 // by GUID
  std::map<std::string, std::set<EntryId>> notes_, views_;  // by text; by name
  std::map<std::pair<PartId, PartId>, std::set<EntryId>> clashes_;
  std::map<EntryId, std::map<std::string, int>> texts_;  // of the comments of a note, and how many say it
  std::map<EntryId, std::size_t> places_;                // of what is among the changes
  TopicChanges changes_;
};

}  // namespace

TopicChanges changesOf(const std::vector<Topic>& topics, const TopicSource& there, const std::string& name) {
  ChangeMaker maker(there, name);
  for (const Topic& topic : topics) maker.takeKnown(topic);
  for (const Topic& topic : topics) maker.takeKnownComments(topic);
  for (const Topic& topic : topics) maker.take(topic);
  return std::move(maker).changes();
}

}  // namespace tandem::client
