#include "assets/scene/near_names.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <utility>

namespace tandem::assets {
namespace {

constexpr std::size_t kCompared = 64;  // bytes of a name
constexpr std::size_t kNamed = 5;
constexpr std::size_t kSlip = 2;  // letters

std::string comparable(const std::string& name) {
  std::string text = name.substr(0, kCompared);
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Levenshtein's distance.
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string nearNames(const std::string& wanted, const std::vector<std::string>& names) {
  const std::string target = comparable(wanted);
  std::vector<std::pair<std::size_t, std::size_t>> ranked;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name = comparable(names[i]);
    // A name that contains the wanted one is nearer than any other.
    const bool contains = !target.empty() && name.find(target) != std::string::npos;
    ranked.emplace_back(contains ? 0 : editDistance(target, name), i);
  }
  std::sort(ranked.begin(), ranked.end());
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, ranked.size()); ++i)
    text += (i == 0 ? "; near it are '" : "', '") + names[ranked[i].second];
  return text.empty() ? text : text + "'";
}

std::string nearParts(const std::string& wanted, const Scene& scene) {
  std::vector<std::string> names;
  for (const Part& part : scene.parts) names.push_back(part.name);
  return nearNames(wanted, names);
}

std::string meantName(const std::string& wanted, const std::vector<std::string>& names) {
  std::string best;
  std::size_t least = kSlip + 1;
  for (const std::string& name : names) {
    const std::size_t distance = editDistance(comparable(wanted), comparable(name));
    if (distance >= least || distance >= name.size()) continue;
    least = distance;
    best = name;
  }
  return best;
}

}  // namespace tandem::assets
