#pragma once

#include <string>

#include "assets/scene/scene.h"

namespace tandem::assets {

/// The first finding of a scene that has this code, or nullptr.
inline const Finding* findingOf(const Scene& scene, const std::string& code) {
  for (const Finding& finding : scene.findings)
    if (finding.code == code) return &finding;
  return nullptr;
}

}  // namespace tandem::assets
