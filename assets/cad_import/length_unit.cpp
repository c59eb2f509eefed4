#include "assets/cad_import/length_unit.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <utility>

#include <glm/common.hpp>

namespace tandem::cad_import {
namespace {

constexpr double kLong = 50.0, kShort = 1e-3;  // m

std::string inWords(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", metres);
  return text;
}

/// The longest side of the box around all placed meshes, m.
double longestSide(const CadScene& scene) {
  std::vector<std::pair<glm::dvec3, glm::dvec3>> boxes;
  for (const CadMesh& mesh : scene.meshes) {
    glm::dvec3 low(1e300), high(-1e300);
    for (const glm::dvec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    boxes.emplace_back(low, high);
  }
  std::vector<glm::dmat4> worldFromNode;
  glm::dvec3 low(1e300), high(-1e300);
  for (const CadNode& node : scene.nodes) {
    worldFromNode.push_back(node.parent == kNone ? node.parentFromNode
                                                 : worldFromNode[node.parent] * node.parentFromNode);
    if (node.mesh == kNone) continue;
    const auto& [least, most] = boxes[node.mesh];
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 at((corner & 1) != 0 ? most.x : least.x, (corner & 2) != 0 ? most.y : least.y,
                          (corner & 4) != 0 ? most.z : least.z);
      const glm::dvec3 placed(worldFromNode.back() * glm::dvec4(at, 1.0));
      low = glm::min(low, placed);
      high = glm::max(high, placed);
    }
  }
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

}  // namespace

std::optional<double> metresPerUnit(const std::string& name) {
  static const std::pair<const char*, double> kUnits[] = {
      {"m", 1.0},           {"metre", 1.0},       {"meter", 1.0},       {"mm", 1e-3},
      {"millimetre", 1e-3}, {"millimeter", 1e-3}, {"cm", 1e-2},         {"centimetre", 1e-2},
      {"centimeter", 1e-2}, {"micron", 1e-6},     {"micrometre", 1e-6}, {"micrometer", 1e-6},
      {"in", 0.0254},       {"inch", 0.0254},     {"foot", 0.3048},     {"ft", 0.3048},
      {"feet", 0.3048}};
  std::string lower;
  for (const char c : name) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [unit, metres] : kUnits)
    if (lower == unit) return metres;
  return std::nullopt;
}

std::string unitDoubt(const CadScene& scene) {
  const double length = longestSide(scene);
  if (!(length > kLong || (length < kShort && length > 0.0))) return {};
  const bool isLong = length > kLong;
  const char* other = isLong ? "mm" : "m";
  const double would = length / scene.metresPerUnit * *metresPerUnit(other);
  std::string text = inWords(length) + " m long";
  text += scene.unit.empty() ? " if its unit is as taken" : " by its unit, " + scene.unit;
  if (scene.unit != other)
    text += ": is it " + std::string(other) + ", and " + inWords(would) + " m? --units " + other;
  return text;
}

}  // namespace tandem::cad_import
