#pragma once

// Single pictures of a scene without people, panels or a display, through EGL. Main thread only.

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "assets/base/result.h"
#include "assets/document/entry.h"
#include "assets/scene/scene.h"

namespace tandem::client {

/// What one picture shows. World axes, m.
struct Still {
  Pose worldFromEye;                             // looks along -z, +y up
  double fieldOfView = 0.7;                      // rad, vertical
  std::vector<document::SectionPlane> sections;  // at most kMaxSections
  bool onlyThese = false;                        // `parts` are all that is shown; else they are hidden
  std::vector<PartId> parts;
  std::vector<PartId> marked;      // in a colour of their own
  std::vector<glm::dvec3> places;  // with a dot
  std::vector<std::pair<glm::dvec3, glm::dvec3>> lines;
};

class StillPictures {
 public:
  /// `scene` outlives this. The error says what is missing of OpenGL.
  static Result<std::unique_ptr<StillPictures>> open(const assets::Scene& scene, int width, int height);
  virtual ~StillPictures() = default;
  /// The picture as a PNG, of parts at these poses.
  virtual std::vector<std::uint8_t> draw(const Still& still, std::span<const Pose> worldFromPart) = 0;
};

}  // namespace tandem::client
