#include "haptics/measure/touching_height.h"

#include "haptics/measure/penetration.h"

namespace tandem::haptics {

double touchingHeight(const DepthModel& under, const Pose& worldFromUnder, const DepthModel& above,
                      Pose worldFromAbove, double from, double step) {
  constexpr int kHalvings = 7;
  const auto inside = [&](double z) {
    worldFromAbove.position.z = z;
    return deepestPenetration(under, worldFromUnder, above, worldFromAbove).depth > 0.0;
  };
  double low = from;
  while (low > 0.0 && !inside(low)) low -= step;
  double high = low + step;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (inside(middle) ? low : high) = middle;
  }
  return high;
}

}  // namespace tandem::haptics
