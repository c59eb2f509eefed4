#pragma once

// Co-location: finds where a device's workspace lies in the view from touched points. The person brings the
// tip to targets at known places of the view, each of which gives a pair. Pure except for the two file
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
  glm::dvec3 view{0.0, 0.0, 0.0};    // the target's place in the view
};

/// The result view = pose * (scale * device), and its residuals.
struct Colocation {
  Pose viewFromDevice;
  double scale = 1.0;  // view metres per device metre, > 0
  double rms = 0.0;    // m, view: root mean square of the residuals
  double worst = 0.0;  // m, the largest
  std::size_t pairs = 0;

  glm::dvec3 toView(const glm::dvec3& device) const { return transformPoint(viewFromDevice, scale * device); }
};

/// The similarity (or, with `withScale` false, the rigid motion) with the least sum of squared residuals in
/// the view. The rotation is the eigenvector of Horn's 4 x 4 matrix (Horn 1987, "Closed-form solution of
/// absolute orientation using unit quaternions"), so it is never a reflection; the scale follows Umeyama
/// 1991, eq. 42, the optimum for residuals in the view. Refused with a reason: fewer than three pairs,
/// non-finite numbers, points on a line or in one place in either frame, pairs that fit two rotations equally
/// well, pairs that only a reflection fits.
Result<Colocation> colocate(std::span<const PointPair> pairs, bool withScale = true);

/// The mapping that places the device accordingly.
DeviceMapping mappingOf(const Colocation& colocation);

/// Pairs from CSV text: a header `dx,dy,dz,vx,vy,vz`, then one pair a row, m. `name` appears in the error.
Result<std::vector<PointPair>> parsePairs(const std::string& text, const std::string& name);

/// JSON text of a calibration, and its reader, which refuses anything invalid.
std::string toJson(const Colocation& colocation);
Result<Colocation> parseColocation(const std::string& json, const std::string& name);

/// The same readers and writers for files.
Result<std::vector<PointPair>> loadPairs(const std::string& path);
Result<Colocation> loadColocation(const std::string& path);

}  // namespace tandem::haptics
