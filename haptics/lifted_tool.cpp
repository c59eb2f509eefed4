#include "haptics/lifted_tool.h"

#include <algorithm>
#include <utility>

namespace tandem::haptics {

void liftTool(double spring, TickState::Data& data) {
  Hand& hand = data.hands[0];
  if (!std::exchange(data.lifted, true))
    hand.bridge(data.tool.contactWrench().force, glm::dvec3(0.0), spring);
  data.tool.carry(hand.device().worldFromDevice.position);
}

void setToolDown(TickState::Data& data) {
  if (std::exchange(data.lifted, false)) data.tool.reset();
}

PartId partTouched(const TickOutput& out, TickState::Data& data) {
  if (data.lifted) return kNoPart;
  if (out.contactCount > 0 && data.tool.started()) return out.contacts[0].part;
  return data.tool.partUnder(data.held.held());
}

double setDownShare(bool lifted, const TickParameters& parameters, TickState::Data& data) {
  const double step = parameters.fadeTime > 0.0 ? parameters.dt / parameters.fadeTime : 1.0;
  data.liftedShare = std::clamp(data.liftedShare + (lifted ? step : -step), 0.0, 1.0);
  return 1.0 - data.liftedShare;
}

}  // namespace tandem::haptics
