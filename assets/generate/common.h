#pragma once

// Appearances and feels that the sample scenes share.

#include "assets/generate/sample_scene.h"

namespace tandem::generate {

inline constexpr double mm = 1e-3;

/// Indices of commonAppearances().
enum AppearanceId : std::size_t {
  kPaint,
  kMachined,
  kSteel,
  kBrass,
  kBench,
  kPlastic,
  kRubber,
  kPaper,
  kUsedPaper,
  kLime
};

inline std::vector<Appearance> commonAppearances() {
  return {{"painted casting", {0.05, 0.16, 0.30}, 0.1, 0.45},
          {"machined aluminium", {0.78, 0.79, 0.81}, 0.9, 0.35},
          {"steel", {0.50, 0.52, 0.55}, 0.95, 0.30},
          {"brass", {0.72, 0.50, 0.18}, 0.95, 0.30},
          {"bench", {0.33, 0.31, 0.28}, 0.0, 0.85},
          {"plastic", {0.75, 0.10, 0.06}, 0.0, 0.45},
          {"rubber", {0.03, 0.03, 0.035}, 0.0, 0.80},
          {"filter paper", {0.85, 0.80, 0.62}, 0.0, 0.90},
          {"used filter paper", {0.24, 0.17, 0.09}, 0.0, 0.95},
          {"lime plastic", {0.35, 0.62, 0.08}, 0.0, 0.50}};
}

/// Indices of commonFeels().
enum FeelId : std::size_t { kFeelSteel, kFeelAluminium, kFeelBrass, kFeelPlastic, kFeelRubber, kFeelWood };

inline std::vector<Feel> commonFeels() {
  return {
      {"steel", 7850.0, 0.20, 0.15, 0.3, 2000.0, 2.0}, {"aluminium", 2700.0, 0.25, 0.20, 0.2, 1800.0, 2.0},
      {"brass", 8500.0, 0.20, 0.15, 0.2, 2000.0, 2.0}, {"plastic", 1150.0, 0.30, 0.25, 0.2, 1200.0, 2.0},
      {"rubber", 1200.0, 0.90, 0.80, 0.5, 500.0, 3.0}, {"wood", 700.0, 0.45, 0.35, 0.1, 1000.0, 3.0}};
}

/// A slab with rounded corners and bevelled edges whose top is the plane y = 0, for the other parts to stand
/// on.
SampleShape benchTop(const glm::dvec2& size);

/// A block with rounded corners and bevelled edges (3 mm and 1 mm) on the plane y = 0.
SampleShape block(const std::string& name, const glm::dvec2& size, double height, AppearanceId appearance,
                  std::size_t feel);

/// Gap in m between the bench and what stands on it, so that nothing touches at rest.
inline constexpr double kRestGap = 0.2 * mm;

}  // namespace tandem::generate
