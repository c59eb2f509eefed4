#include "client/session/holding_words.h"

#include <algorithm>
#include <vector>

#include "client/base/readable.h"

namespace tandem::client {
namespace {

/// Owner and co-holders of a part, as far as the session knows them.
std::vector<const SiteView*> holdersOf(const ViewModel& model, PartId part) {
  std::vector<const SiteView*> holders;
  const auto add = [&](SiteId id) {
    for (const SiteView& site : model.sites)
      if (site.info.site == id) holders.push_back(&site);
  };
  if (part >= model.owner.size() || model.owner[part] == kNoSite) return holders;
  add(model.owner[part]);
  if (part < model.coHolders.size())
    for (const SiteId id : model.coHolders[part])
      if (id != model.owner[part]) add(id);
  return holders;
}

std::vector<std::string> othersWith(const ViewModel& model, PartId part, SiteId site) {
  std::vector<std::string> names;
  for (const SiteView* holder : holdersOf(model, part))
    if (holder->info.site != site) names.push_back(holder->info.name);
  return names;
}

std::string withOthers(const ViewModel& model, PartId part, SiteId site) {
  const std::string others = listed(othersWith(model, part, site));
  return partName(model, part) + (others.empty() ? "" : " with " + others);
}

/// Whether a co-holder has its tool at the part, and does not hold it.
bool pushes(const ViewModel& model, const SiteView& site, PartId part) {
  if (part < model.owner.size() && model.owner[part] == site.info.site) return false;
  return (site.self ? model.hand.touched : site.presence.touched) == part &&
         !(site.self && model.hand.held == part);
}

}  // namespace

std::string partName(const ViewModel& model, PartId part) {
  return model.scene && part < model.scene->parts.size() ? model.scene->parts[part].name : std::string();
}

std::string holdersInWords(const ViewModel& model, PartId part) {
  const std::vector<const SiteView*> holders = holdersOf(model, part);
  if (holders.empty()) return "";
  const SiteView& first = *holders.front();
  const std::string others = listed(othersWith(model, part, first.info.site));
  return first.info.name + (others.empty() ? "" : " with " + others);
}

std::string holdingInWords(const ViewModel& model, const SiteView& site) {
  std::vector<std::string> held, shared;
  std::string pushed;
  for (std::size_t p = 0; p < model.owner.size(); ++p) {
    const auto part = static_cast<PartId>(p);
    const std::vector<const SiteView*> holders = holdersOf(model, part);
    if (std::find(holders.begin(), holders.end(), &site) == holders.end()) continue;
    if (pushes(model, site, part)) {
      pushed = "pushes " + partName(model, part) + ", which " +
               listed(othersWith(model, part, site.info.site)) + (holders.size() > 2 ? " hold" : " holds");
      continue;
    }
    held.push_back(withOthers(model, part, site.info.site));
    if (holders.size() > 1) shared.push_back(held.back());
  }
  if (held.empty()) return pushed;
  if (held.size() == 1) return "holds " + held.front();
  const std::string count = "holds " + std::to_string(held.size()) + " parts";
  return shared.empty() ? count : count + ", " + listed(shared);
}

std::string sharingInWords(const ViewModel& model) {
  const auto self =
      std::find_if(model.sites.begin(), model.sites.end(), [](const SiteView& site) { return site.self; });
  if (self == model.sites.end() || model.hand.held == kNoPart) return "";
  const std::vector<std::string> others = othersWith(model, model.hand.held, self->info.site);
  if (others.empty()) return "";
  const std::string link = linkInWords(model.hand.links);
  return "with " + listed(others) + (link.empty() ? "" : ": " + link);
}

}  // namespace tandem::client
