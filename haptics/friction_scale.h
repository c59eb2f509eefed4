#pragma once

// Where on a surface the friction is more or less than its material's.

#include "haptics/contact_world.h"

namespace tandem::haptics {

/// Factor on both friction coefficients at one point of a surface, >= 0. Everywhere 1: no material has a
/// friction map.
inline double frictionScale(const ContactWorld& /*world*/, const SurfacePoint& /*at*/) { return 1.0; }

}  // namespace tandem::haptics
