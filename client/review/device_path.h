#pragma once

// A scripted device path: one pose a millisecond, from CSV with the header t,x,y,z or t,x,y,z,qw,qx,qy,qz. A
// cell may be `nan`: that reading is not valid. Time may stand still (a device that has stopped sending), but
// not go backwards.

#include <string>
#include <vector>

#include "assets/base/pose.h"
#include "assets/base/result.h"

namespace tandem::client {

struct PathRow {
  double time = 0.0;  // s
  Pose pose;          // world frame
  bool valid = true;  // every cell was a finite number
};

/// The error names the line and the reason.
Result<std::vector<PathRow>> loadDevicePath(const std::string& path);

}  // namespace tandem::client
