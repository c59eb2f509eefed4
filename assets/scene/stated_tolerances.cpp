#include "assets/scene/stated_tolerances.h"

#include <set>

#include "assets/base/assert.h"

namespace tandem::assets {

std::vector<std::string> statedTolerances(const Scene& scene, PartId part) {
  ASSERT(part < scene.parts.size());
  std::vector<std::string> stated;
  const auto add = [&](const std::string& where, const std::string& prefix) {
    for (const Finding& finding : scene.findings)
      if (finding.code == kStatedTolerance && finding.where == where)
        stated.push_back(prefix + finding.message);
  };
  const Part& of = scene.parts[part];
  std::set<std::string> names{of.name};  // groups within each other often have the same
  add(of.name, "");
  for (std::uint32_t node = of.treeNode; node < scene.tree.size(); node = scene.tree[node].parent) {
    const std::string& name = scene.tree[node].name;
    if (!name.empty() && names.insert(name).second) add(name, name + ": ");
  }
  return stated;
}

}  // namespace tandem::assets
