#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>

#include "client/session/view_model.h"

namespace tandem::client {

inline glm::vec3 srgb(const std::array<std::uint8_t, 3>& c) {
  return glm::vec3(static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])) / 255.0f;
}
inline glm::vec3 linear(const glm::vec3& srgbColour) {
  return {std::pow(srgbColour.x, 2.2f), std::pow(srgbColour.y, 2.2f), std::pow(srgbColour.z, 2.2f)};
}

/// The site with this id, or null.
inline const SiteView* findSite(const ViewModel& model, SiteId site) {
  for (const SiteView& view : model.sites)
    if (view.info.site == site) return &view;
  return nullptr;
}
/// sRGB colour of the person at this site; a calm blue without a session.
inline glm::vec3 selfColour(const ViewModel& model) {
  const SiteView* self = selfSite(model);
  return self ? srgb(self->info.colour) : glm::vec3(0.18f, 0.44f, 0.87f);
}

}  // namespace tandem::client
