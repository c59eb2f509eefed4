#include "haptics/grasp/felt_damper.h"

#include <glm/geometric.hpp>

#include "haptics/base/six_axes.h"

namespace tandem::haptics {
const glm::dvec3& FeltDamper::force(double damping, const glm::dvec3& grip, const glm::dvec3& hand,
                                    bool touches, double change) {
  const glm::dvec3 apart = grip - hand, whole = damping * apart;
  glm::dvec3 felt = whole;
  if (change > 0.0 && (touches || !whole_))
    felt = felt_ + shortened((touches ? shortened(whole, change) : whole) - felt_, change);
  const double gained = glm::dot(felt, hand) - glm::dot(whole, grip);
  if (gained > 0.0) felt += gained / (gained + damping * glm::dot(apart, apart)) * (whole - felt);
  whole_ = felt == whole;
  felt_ = felt;
  return felt_;
}

}  // namespace tandem::haptics
