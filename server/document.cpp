#include "server/document.h"

#include <variant>

#include "assets/base/assert.h"

namespace tandem::server {

using document::Entry;
using document::Refusal;

void SharedDocument::restore(const std::map<document::EntryId, Entry>& entries) {
  document_.clear();
  created_.clear();
  for (const auto& [id, entry] : entries) {
    if (document_.put(entry)) created_[{entry.author, entry.creation}] = id;
  }
}

const Entry* SharedDocument::doneBefore(const sync::PutEntry& request, SiteId site) const {
  if (request.change.id == 0) {
    const auto made = created_.find({site, request.request});
    return made == created_.end() ? nullptr : document_.find(made->second);
  }
  const Entry* entry = document_.find(request.change.id);
  const bool same = entry != nullptr && entry->editor == site && entry->request == request.request;
  return same ? entry : nullptr;
}

bool SharedDocument::mayChange(const document::Change& change, sync::Role role, SiteId site) const {
  if (role != sync::Role::participant) return role == sync::Role::instructor;
  const Entry* entry = document_.find(change.id);
  const bool removes = std::holds_alternative<document::Removed>(change.body);
  return !removes || entry == nullptr || entry->author == site;
}

SharedDocument::Answer SharedDocument::put(const sync::PutEntry& request, sync::Role role,
                                           const document::By& by) {
  ASSERT(by.site != kNoSite && by.request == request.request);
  if (const Entry* done = doneBefore(request, by.site))
    return {{request.request, Refusal::none, {}, done->id, done->revision}, std::nullopt};
  if (!mayChange(request.change, role, by.site))
    return {{request.request, Refusal::roleForbids, toString(Refusal::roleForbids), 0, 0}, std::nullopt};
  const document::Document::Outcome outcome = document_.apply(request.change, by);
  if (outcome.refusal != Refusal::none)
    return {{request.request, outcome.refusal, outcome.reason, 0, 0}, std::nullopt};
  if (request.change.id == 0) created_[{by.site, by.request}] = outcome.entry.id;
  if (outcome.forgotten != 0)
    std::erase_if(created_, [&](const auto& made) { return made.second == outcome.forgotten; });
  return {{request.request, Refusal::none, {}, outcome.entry.id, outcome.entry.revision},
          DocumentRecord{outcome.entry, outcome.forgotten}};
}

}  // namespace tandem::server
