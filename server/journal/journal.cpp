#include "server/journal/journal.h"

#include <algorithm>

namespace tandem::server {
namespace {

/// Replaces the element that `same` finds, or appends.
template <typename T, typename Same>
void replace(std::vector<T>& all, const T& value, Same same) {
  const auto at = std::find_if(all.begin(), all.end(), same);
  if (at == all.end())
    all.push_back(value);
  else
    *at = value;
}

}  // namespace

void apply(JournalContents& contents, const JournalRecord& record) {
  if (const auto* part = std::get_if<sync::PartRecord>(&record))
    replace(contents.parts, *part, [&](const auto& other) { return other.part == part->part; });
  else if (const auto* site = std::get_if<SiteRecord>(&record))
    replace(contents.sites, *site, [&](const auto& other) { return other.info.site == site->info.site; });
  else if (const auto* nonce = std::get_if<UsedNonce>(&record))
    replace(contents.nonces, *nonce, [&](const auto& other) { return other.nonce == nonce->nonce; });
  else if (const auto* said = std::get_if<SaidRecord>(&record))
    contents.said.insert_or_assign(said->slot(), said->line);
  if (const auto* change = std::get_if<DocumentRecord>(&record)) {
    contents.document.insert_or_assign(change->entry.id, change->entry);
    contents.document.erase(change->forgotten);
  }
}

}  // namespace tandem::server
