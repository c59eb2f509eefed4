#pragma once

// Reading a distance field at several points at once. Part of distance_field.h, which alone includes it.

#include "haptics/scene/distance_field.h"

namespace tandem::haptics {

/// Where up to kMaxAtOnce points are in a field, as far as that is known.
class DistanceField::Places {
  friend class DistanceField;
  std::array<const std::uint32_t*, kMaxAtOnce> entries_;
  std::array<const Cell*, kMaxAtOnce> cells_;
};

inline void DistanceField::read(const glm::vec3* points, std::uint32_t count, Reading* readings) const {
  Places places;
  seek(points, count, places);
  fetch(count, places);
  read(points, count, places, readings);
}

inline void DistanceField::seek(const glm::vec3* points, std::uint32_t count, Places& places) const {
  if (!shapes_.empty()) return;
  for (std::uint32_t k = 0; k < count; ++k) {
    places.entries_[k] = entryOf(points[k]);
    __builtin_prefetch(places.entries_[k]);
  }
}

inline void DistanceField::fetch(std::uint32_t count, Places& places) const {
  if (!shapes_.empty()) return;
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t* const entry = places.entries_[k];
    places.cells_[k] = entry != nullptr ? &cells_[*entry & ~kLeaf] : nullptr;
    __builtin_prefetch(places.cells_[k]);
  }
}

inline void DistanceField::read(const glm::vec3* points, std::uint32_t count, const Places& places,
                                Reading* readings) const {
  if (!shapes_.empty()) return ofShapes(points, count, readings);
  for (std::uint32_t k = 0; k < count; ++k) {
    const Cell* const cell = places.cells_[k];
    readings[k] = cell != nullptr ? readingAt(*cell, points[k]) : beyond(points[k]);
  }
}

}  // namespace tandem::haptics
