#pragma once

// Co-location: where a device's workspace lies in the view, from points that were touched. The person brings
// the tip to targets whose place in the view is known; each gives a pair. Pure but for the two file
// functions; not for the servo thread.

#include <span>
#include <string>
#include <vector>

#include "assets/base/pose.h"
#include "assets/base/result.h"
#include "haptics/devices/device_mapping.h"

namespace tandem::haptics {

/// One point in both frames, m.
struct PointPair {
  glm::dvec3 device{0.0, 0.0, 0.0};  // the device's base axes
  glm::dvec3 view{0.0, 0.0, 0.0};    // where the target was seen
};

/// view = pose * (scale * device), and how well that fits the pairs.
struct Colocation {
  Pose viewFromDevice;
  double scale = 1.0;  // view metres per device metre, > 0
  double rms = 0.0;    // m, view: root mean square of the residuals
  double worst = 0.0;  // m, the largest
  std::size_t pairs = 0;

  glm::dvec3 toView(const glm::dvec3& device) const { return transformPoint(viewFromDevice, scale * device); }
};

/// The similarity (or, with `withScale` false, the rigid motion) with the least sum of squared residuals in
/// the view: rotation from the eigenvector of Horn's 4 x 4 matrix (Horn 1987, "Closed-form solution of
/// absolute orientation using unit quaternions"), so never a mirror image; scale by Umeyama 1991, eq. 42, the
/// optimum for residuals in the view. Refused, with the reason: fewer than three pairs, a number that is not
/// finite, points that lie on a line or in one place in either frame, pairs that fit two turns equally well,
/// a set that only a mirror image would fit.
Result<Colocation> colocate(std::span<const PointPair> pairs, bool withScale = true);

/// The mapping that places the device so.
DeviceMapping mappingOf(const Colocation& colocation);

/// Pairs from CSV text: a header `dx,dy,dz,vx,vy,vz`, then one pair a row, m. `name` is for the error.
Result<std::vector<PointPair>> parsePairs(const std::string& text, const std::string& name);

/// The JSON that a calibration is kept in, and its reading; anything but a valid one is refused.
std::string toJson(const Colocation& colocation);
Result<Colocation> parseColocation(const std::string& json, const std::string& name);

/// The same from files.
Result<std::vector<PointPair>> loadPairs(const std::string& path);
Result<Colocation> loadColocation(const std::string& path);

}  // namespace tandem::haptics
