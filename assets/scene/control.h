#pragma once

// A control of the haptic user interface: a movable part with one free axis, and what a hand feels along it.
//
// 1. The value of a control is the coordinate of its part along that axis in m, or its angle about that axis
//    in rad for a dial. Sites replicate the value, and the server stores it, as the pose of the part and in
//    no other form.
// 2. controlValue(control, poseAt(control, q)) == q for every q from min to max.

#include <cstdint>
#include <string>
#include <vector>

#include "assets/base/ids.h"
#include "assets/base/pose.h"

namespace tandem::assets {

struct Scene;

enum class ControlKind : std::uint8_t {
  button,  // springs back when released
  dial,    // turns; the only one whose value is an angle
  slider,
  drawer,  // a slider that is held by a handle and pulled
  layer,   // a slider that shows parts while its value is above a threshold
};

inline constexpr std::size_t kMaxDetents = 4096;

/// Detents of a control or a joint: the wells of a potential along its axis.
struct Detents {
  std::vector<double> places;  // m or rad, ascending, within min..max
  double force = 0.0;          // N or N·m: the largest resistance on leaving one
  double width = 0.0;          // m or rad: of one well, at most the distance between two; 0 = that distance
};

/// The snap of a button: an extra resistance that grows towards a place and falls behind it.
struct Click {
  double at = 0.0;     // m or rad
  double drop = 0.0;   // N or N·m: the resistance at `at`; 0 = no click
  double width = 0.0;  // m or rad: half of the range about `at` over which it acts
};

struct Control {
  std::string name;  // shown to people
  PartId part = kNoPart;
  ControlKind kind = ControlKind::button;
  Pose worldFromAxis;            // the axis is its local X, through its origin
  Pose axisFromPart;             // the part at value 0, in the frame of the axis
  double min = 0.0, max = 0.0;   // m; rad for a dial. The ends are stops
  bool endless = false;          // a dial without stops: min = -pi, max = pi, where it begins anew
  double initial = 0.0;          // value of the pose at which the scene has the part
  double inertia = 0.0;          // kg, kg·m^2 about the axis for a dial; > 0
  double springStiffness = 0.0;  // N/m or N·m/rad, back to springRest; 0 = none
  double springRest = 0.0;       // may lie outside of min..max: a spring that is never slack
  double damping = 0.0;          // N·s/m or N·m·s/rad
  double friction = 0.0;         // N or N·m, dry
  Detents detents;
  Click click;
  std::uint32_t roles = 6;    // bit r: sites whose session role has the number r may move it
  std::vector<PartId> shows;  // layer: these can be seen and touched while the value is above `threshold`
  double threshold = 0.0;
};

inline bool turns(const Control& control) { return control.kind == ControlKind::dial; }

/// "button", "dial", "slider", "drawer" or "layer".
const char* toString(ControlKind kind);

/// The pose of the control's part at a value (m or rad), which is not limited to the stops.
Pose poseAt(const Control& control, double value);

/// The value nearest to a pose of the control's part: its coordinate along the axis, or its angle about it
/// within half a turn of the middle of the range. Not clamped.
double controlValue(const Control& control, const Pose& worldFromPart);

/// The nearest value that the control can have: within its stops, or within one turn.
double admissible(const Control& control, double value);

/// The twist of the part when the value changes at `rate` (m/s or rad/s).
Twist twistAt(const Control& control, const Pose& worldFromPart, double rate);

/// Direction of the axis in the world, unit.
glm::dvec3 axisOf(const Control& control);

/// Whether a layer shows its parts at a value.
inline bool isShowing(const Control& control, double value) { return value > control.threshold; }

/// The control of a part, or null. Walks all controls.
const Control* controlOf(const Scene& scene, PartId part);

/// Whether sites of the role with this number may move the part: always, unless it is a control that forbids
/// it.
bool roleMaySet(const Scene& scene, PartId part, unsigned role);

}  // namespace tandem::assets
