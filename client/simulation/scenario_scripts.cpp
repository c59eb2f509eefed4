#include "client/simulation/scenario_scripts.h"

#include <utility>

namespace tandem::client {

Result<std::vector<HandScript>> parseScripts(const Scenario& scenario, const assets::Scene& scene) {
  std::vector<HandScript> scripts;
  for (const ScenarioSite& site : scenario.sites) {
    const std::string source = scenario.path + ": sites[" + std::to_string(scripts.size()) + "].script";
    Result<HandScript> script = parseHandScript(site.script, source, scene);
    if (!script) return script.error();
    scripts.push_back(std::move(*script));
  }
  return scripts;
}

}  // namespace tandem::client
