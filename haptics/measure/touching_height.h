#pragma once

#include "haptics/measure/depth_model.h"

namespace tandem::haptics {

/// The height along z at which `above` just touches `under` when it comes down from `from` m, to 1 % of
/// `step`. It is moved by `step` m at a time, so that a thinner part may be missed; 0 where nothing is met
/// above z = 0.
double touchingHeight(const DepthModel& under, const Pose& worldFromUnder, const DepthModel& above,
                      Pose worldFromAbove, double from, double step);

}  // namespace tandem::haptics
