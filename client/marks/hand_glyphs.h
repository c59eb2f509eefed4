#pragma once

// The glyphs of people in a scene: this site's hands with force and contacts, and the hands and cameras
// of others.

#include <string>
#include <vector>

#include "client/picture/glyphs.h"

namespace tandem::client {

/// A few words at a place in the scene.
struct Label {
  glm::dvec3 world{0.0, 0.0, 0.0};
  glm::dvec2 offset{0.0, 0.0};  // pixels
  glm::vec3 colour{0.0f};       // sRGB
  std::string text;
};

/// Adds everything that stands for people to the batch, and its labels to `labels`.
void addPeople(const ViewModel& model, GlyphBatch& batch, std::vector<Label>& labels);

/// Extends the bounds of all parts by the tips of styli, except those far away from all parts.
void includePeople(const ViewModel& model, assets::Bounds& bounds);

/// The name of a part at a place on it.
Label nameAt(const ViewModel& model, PartId part, const glm::dvec3& place);

}  // namespace tandem::client
