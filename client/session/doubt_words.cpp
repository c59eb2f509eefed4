#include "client/session/doubt_words.h"

#include <algorithm>
#include <vector>

#include "client/base/readable.h"

namespace tandem::client {

std::string doubtsInWords(const ViewModel& model, const SiteView& site) {
  std::vector<std::string> names;
  bool self = false;
  std::size_t others = 0;  // who could say so
  for (const SiteView& other : model.sites) {
    if (other.info.site == site.info.site) continue;
    const bool doubts =
        std::find(site.doubtedBy.begin(), site.doubtedBy.end(), other.info.site) != site.doubtedBy.end();
    if (doubts || (other.info.connected && other.info.role != sync::Role::observer)) ++others;
    if (!doubts) continue;
    self = self || other.self;
    if (!other.self) names.push_back(other.info.name);
  }
  if (self) names.emplace_back("you");
  if (names.empty()) return "";
  constexpr std::size_t kMostNames = 3;
  const bool plural = names.size() > 1 || self;
  return "does not move or push as a hand does, " + std::string(plural ? "say " : "says ") +
         (names.size() > kMostNames ? std::to_string(names.size()) + " sites" : listed(names)) + " (" +
         std::to_string(names.size()) + " of " + std::to_string(others) +
         (others == 1 ? " other site)" : " other sites)");
}

}  // namespace tandem::client
