#include "assets/document/document.h"

#include <algorithm>

#include "assets/base/assert.h"
#include "assets/document/entry_check.h"

namespace tandem::document {

const char* toString(Refusal refusal) {
  switch (refusal) {
    case Refusal::none:
      return "done";
    case Refusal::roleForbids:
      return "this role may not change it";
    case Refusal::noSuchEntry:
      return "there is no such entry";
    case Refusal::changedSince:
      return "another has changed it since";
    case Refusal::referredTo:
      return "another entry refers to it";
    case Refusal::full:
      return "the document is full";
    case Refusal::unsound:
      return "it is not within the limits";
    case Refusal::notNow:
      return "the server cannot write its journal";
  }
  return "unknown refusal";
}

const Entry* Document::find(EntryId id) const {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : &found->second;
}

/// Whether a change may be made; its outcome if not.
Document::Outcome Document::judge(const Change& change) const {
  const Entry* old = find(change.id);
  const bool removes = std::holds_alternative<Removed>(change.body);
  if (const Status sound = check(change.body); !sound) return refuse(Refusal::unsound, sound.error().message);
  if (change.id == 0 && (removes || change.base != 0))
    return refuse(Refusal::unsound, "a new entry has a body and no base");
  if (change.id != 0 && old == nullptr) return refuse(Refusal::noSuchEntry, toString(Refusal::noSuchEntry));
  if (old != nullptr && old->revision != change.base)
    return refuse(Refusal::changedSince, toString(Refusal::changedSince));
  const bool lives = old != nullptr && !old->removed();
  if (!lives && removes) return refuse(Refusal::noSuchEntry, toString(Refusal::noSuchEntry));
  if (lives && removes) {
    const auto references = refers_.find(change.id);
    if (references != refers_.end()) return refuse(Refusal::referredTo, toString(Refusal::referredTo));
    return {};
  }
  if (lives && change.body.index() != old->body.index())
    return refuse(Refusal::unsound, "an entry keeps its kind");
  if (const EntryId note = reference(change.body); note != 0) {
    const Entry* referred = find(note);
    if (referred == nullptr || !std::holds_alternative<Note>(referred->body))
      return refuse(Refusal::noSuchEntry, "there is no such note");
  }
  const std::size_t bytes = bytes_ + sizeOf(change.body) - (lives ? sizeOf(old->body) : 0);
  if ((!lives && size() >= kMaxEntries) || bytes > kMaxBytes)
    return refuse(Refusal::full, toString(Refusal::full));
  return {};
}

Document::Outcome Document::apply(const Change& change, const By& by) {
  Outcome outcome = judge(change);
  if (outcome.refusal != Refusal::none) return outcome;
  Entry& entry = outcome.entry;
  if (change.id != 0) {
    entry = *find(change.id);
  } else {
    entry.id = lastId_ + 1;
    entry.author = by.site;
    entry.creation = by.request;
    entry.authorName = by.name;
    entry.made = by.time;
    if (removed_.size() > kMaxRemoved) outcome.forgotten = byRevision_.at(*removed_.begin());
  }
  entry.revision = revision_ + 1;
  entry.editor = by.site;
  entry.request = by.request;
  entry.changed = by.time;
  entry.body = change.body;
  if (outcome.forgotten != 0) forget(outcome.forgotten);
  store(entry);
  return outcome;
}

bool Document::put(const Entry& entry) {
  ASSERT(entry.id != 0 && entry.revision != 0);
  const Entry* old = find(entry.id);
  if ((old != nullptr && old->revision >= entry.revision) || byRevision_.contains(entry.revision))
    return false;
  store(entry);
  if (removed_.size() > kMaxRemoved + 1) forget(byRevision_.at(*removed_.begin()));
  return true;
}

void Document::store(const Entry& entry) {
  forget(entry.id);
  bytes_ += sizeOf(entry.body);
  if (const EntryId note = reference(entry.body); note != 0) ++refers_[note];
  if (entry.removed()) removed_.insert(entry.revision);
  byRevision_[entry.revision] = entry.id;
  lastId_ = std::max(lastId_, entry.id);
  revision_ = std::max(revision_, entry.revision);
  entries_[entry.id] = entry;
  ASSERT(byRevision_.size() == entries_.size());
}

void Document::forget(EntryId id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  const Entry& entry = found->second;
  bytes_ -= sizeOf(entry.body);
  removed_.erase(entry.revision);
  byRevision_.erase(entry.revision);
  if (const EntryId note = reference(entry.body); note != 0 && --refers_[note] == 0) refers_.erase(note);
  entries_.erase(found);
}

}  // namespace tandem::document
