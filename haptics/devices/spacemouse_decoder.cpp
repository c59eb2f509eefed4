#include "haptics/devices/spacemouse_decoder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr double kFullDeflection = 350.0;
constexpr std::uint16_t kLogitech = 0x046d, k3Dconnexion = 0x256f;

constexpr SpaceMouseModel kModels[] = {
    {kLogitech, 0xc603, "SpaceMouse Plus XT"},
    {kLogitech, 0xc605, "CadMan"},
    {kLogitech, 0xc606, "SpaceMouse Classic"},
    {kLogitech, 0xc621, "Spaceball 5000"},
    {kLogitech, 0xc623, "SpaceTraveler"},
    {kLogitech, 0xc625, "SpacePilot"},
    {kLogitech, 0xc626, "SpaceNavigator"},
    {kLogitech, 0xc627, "SpaceExplorer"},
    {kLogitech, 0xc628, "SpaceNavigator for Notebooks"},
    {kLogitech, 0xc629, "SpacePilot Pro"},
    {kLogitech, 0xc62b, "SpaceMouse Pro"},
    {k3Dconnexion, 0xc62e, "SpaceMouse Wireless (cable)"},
    {k3Dconnexion, 0xc62f, "SpaceMouse Wireless"},
    {k3Dconnexion, 0xc631, "SpaceMouse Pro Wireless (cable)"},
    {k3Dconnexion, 0xc632, "SpaceMouse Pro Wireless"},
    {k3Dconnexion, 0xc633, "SpaceMouse Enterprise"},
    {k3Dconnexion, 0xc635, "SpaceMouse Compact"},
    {k3Dconnexion, 0xc636, "SpaceMouse Module"},
    {k3Dconnexion, 0xc638, "SpaceMouse Pro Wireless Bluetooth (cable)"},
    {k3Dconnexion, 0xc63a, "SpaceMouse Wireless Bluetooth"},
    {k3Dconnexion, 0xc652, "3Dconnexion Universal Receiver"},
};

double axis(std::span<const std::uint8_t> report, std::size_t offset) {
  const auto raw = static_cast<std::int16_t>(report[offset] | report[offset + 1] << 8);
  return std::clamp(raw / kFullDeflection, -1.0, 1.0);
}

/// Reads `count` axes that follow the report id into state.axes from `first` on.
void readAxes(std::span<const std::uint8_t> report, std::size_t first, std::size_t count,
              SpaceMouseState& state) {
  ASSERT(first + count <= state.axes.size() && report.size() > 2 * count);
  for (std::size_t i = 0; i < count; ++i) state.axes[first + i] = axis(report, 1 + 2 * i);
}

double response(double deflection, const VelocityCurve& curve) {
  const double beyond = (std::abs(deflection) - curve.deadZone) / (1.0 - curve.deadZone);
  if (!(beyond > 0.0)) return 0.0;  // also for a deflection that is not a number
  const double x = std::min(beyond, 1.0);
  return std::copysign(curve.linearShare * x + (1.0 - curve.linearShare) * x * x * x, deflection);
}

}  // namespace

std::span<const SpaceMouseModel> spaceMouseModels() { return kModels; }

const char* spaceMouseName(std::uint16_t vendor, std::uint16_t product) {
  for (const SpaceMouseModel& model : kModels)
    if (model.vendor == vendor && model.product == product) return model.name;
  return nullptr;
}

bool decodeSpaceMouseReport(std::span<const std::uint8_t> report, SpaceMouseState& state) {
  if (report.empty()) return false;
  switch (report[0]) {
    case 0x01:
      if (report.size() < 7) return false;
      readAxes(report, 0, report.size() >= 13 ? 6 : 3, state);
      return true;
    case 0x02:
      if (report.size() < 7) return false;
      readAxes(report, 3, 3, state);
      return true;
    case 0x03: {
      if (report.size() < 2) return false;
      std::uint32_t bits = 0;
      for (std::size_t i = 0; i < std::min<std::size_t>(4, report.size() - 1); ++i)
        bits |= static_cast<std::uint32_t>(report[1 + i]) << (8 * i);
      state.buttons = bits;
      return true;
    }
    case 0x17:
      if (report.size() < 2 || report[1] > 100) return false;
      state.battery = report[1];
      return true;
    default:
      return false;
  }
}

Twist twistFromDeflection(const std::array<double, 6>& axes, const VelocityCurve& curve,
                          const glm::dquat& worldFromView) {
  const auto r = [&](std::size_t i) { return response(axes[i], curve); };
  // The raw axes (right, towards the user, down) are right-handed; the view's are (right, up, towards the
  // user). One proper rotation therefore serves translation and rotation alike.
  const glm::dvec3 linear(r(0), -r(2), r(1)), angular(r(3), -r(5), r(4));
  return {worldFromView * (curve.maxSpeed * linear), worldFromView * (curve.maxTurnRate * angular)};
}

}  // namespace tandem::haptics
