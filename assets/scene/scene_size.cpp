#include "assets/scene/scene_size.h"

#include <algorithm>
#include <cstdio>

namespace tandem::assets {
namespace {

constexpr double kLong = 50.0;       // m
constexpr double kHeavy = 10'000.0;  // kg

std::string threeDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value < 1000.0 ? "%.3g" : "%.0f", value);
  return text;
}

}  // namespace

std::string sizeInWords(const Scene& scene) {
  const glm::dvec3 size = scene.bounds.max - scene.bounds.min;
  return threeDigits(size.x) + " x " + threeDigits(size.y) + " x " + threeDigits(size.z) + " m";
}

std::string unitDoubt(const Scene& scene, const std::string& units) {
  const std::string question =
      units == "m" ? ": is the file in mm? --units mm" : ": is the file's unit really " + units + "?";
  if (scene.parts.empty()) return {};
  const glm::dvec3 size = scene.bounds.max - scene.bounds.min;
  const double length = std::max({size.x, size.y, size.z});
  if (length > kLong) return threeDigits(length) + " m long" + question;
  const auto lighter = [](const Part& a, const Part& b) {
    return a.massProperties.mass < b.massProperties.mass;
  };
  const Part& heaviest = *std::max_element(scene.parts.begin(), scene.parts.end(), lighter);
  if (heaviest.massProperties.mass <= kHeavy) return {};
  return heaviest.name + " would weigh " + threeDigits(1e-3 * heaviest.massProperties.mass) + " t" + question;
}

}  // namespace tandem::assets
