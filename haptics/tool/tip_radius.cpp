#include "haptics/tool/tip_radius.h"

#include <algorithm>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/scene/contact_scene_data.h"

namespace tandem::haptics {

double tipRadius(const ContactScene& scene) {
  std::vector<double> sizes;
  for (const Collider& collider : scene.data().colliders) {
    if (collider.radius > 0.0) sizes.push_back(2.0 * collider.radius);
  }
  if (sizes.empty()) return 0.0;
  const auto median = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), median, sizes.end());
  const assets::Bounds& bounds = scene.scene().bounds;
  const double all = bounds.min.x <= bounds.max.x ? glm::length(bounds.max - bounds.min) : 0.0;
  return std::min(0x1p-4 * *median, all > 0.0 ? 0x1p-8 * all : 0x1p-8 * *median);
}

}  // namespace tandem::haptics
