#include "client/session/view_model.h"

#include <glm/gtc/quaternion.hpp>

namespace tandem::client {

Pose worldFromCamera(const Camera& camera) {
  const glm::dquat orientation = glm::angleAxis(camera.yaw, glm::dvec3(0.0, 1.0, 0.0)) *
                                 glm::angleAxis(-camera.pitch, glm::dvec3(1.0, 0.0, 0.0));
  return {camera.target + orientation * glm::dvec3(0.0, 0.0, camera.distance), orientation};
}

}  // namespace tandem::client
