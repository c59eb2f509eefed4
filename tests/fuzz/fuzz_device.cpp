// Bytes from a device or its service: whatever they are, decoding ends, and what it accepts makes sense. The
// first byte chooses the decoder, so that one corpus serves all.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "haptics/devices/colocation.h"
#include "haptics/devices/dualsense_codec.h"
#include "haptics/devices/haply_codec.h"
#include "haptics/devices/pid_codec.h"
#include "haptics/devices/spacemouse_decoder.h"

namespace {

using namespace tandem::haptics;
using Bytes = std::span<const std::uint8_t>;

void require(bool condition) {
  if (!condition) std::abort();
}

bool isUnit(double value) { return value >= -1.0 && value <= 1.0; }

void spaceMouse(Bytes report) {
  SpaceMouseState state;
  if (!decodeSpaceMouseReport(report, state)) return;
  require(std::ranges::all_of(state.axes, isUnit));
}

void dualSense(Bytes report) {
  DualSenseState state;
  if (decodeDualSenseReport(report, state)) {
    require(isUnit(state.leftX) && isUnit(state.leftY) && isUnit(state.rightX) && isUnit(state.rightY));
    require(state.leftTrigger >= 0.0 && state.leftTrigger <= 1.0);
  }
  const glm::dvec3 rate = decodeGyroCalibration(report).rate({32767, -32768, 1});
  require(std::isfinite(rate.x) && std::isfinite(rate.y) && std::isfinite(rate.z));
}

/// Two bytes of length, the descriptor, then an input report and an answer to a request.
void pid(Bytes data) {
  if (data.size() < 2) return;
  const std::size_t length = std::min<std::size_t>(data[0] | data[1] << 8, data.size() - 2);
  const auto layout = findPid(data.subspan(2, length));
  if (!layout.ok()) return;
  const Bytes report = data.subspan(2 + length);
  PidState state;
  decodePidInput(*layout, report, state);
  require(isUnit(state.axes[0]) && isUnit(state.axes[1]));
  decodeBlockLoad(*layout, report);
  require(encodeConstant(*layout, 7, -0.3).size() == layout->constant.bytes);
  require(encodeSetEffect(*layout, 7, PidEffect::kConstant, 1).size() == layout->set.bytes);
  encodeCondition(*layout, 7, 1, {.centre = 0.1, .coefficient = -0.4});
  encodeCreate(*layout, PidEffect::kDamper);
  encodeControl(*layout, PidControl::kReset);
  encodeGain(*layout, 1.0);
  encodeOperation(*layout, 7, PidOperation::kStop);
  encodeFree(*layout, 7);
}

void haply(const std::string& text) {
  HaplyState state;
  if (decodeHaply(text, state) != HaplyMessage::kState) return;
  require(!state.id.empty() && state.id.size() <= 64);
  require(std::abs(state.position.x) <= 10.0 && std::abs(state.position.y) <= 10.0);
  require(tandem::isValid(tandem::Pose{state.position, state.orientation}));
  encodeHaply(state.id, state.velocity);
}

void calibration(const std::string& text) {
  if (const auto read = parseColocation(text, "seed"); read.ok())
    require(tandem::isValid(read->viewFromDevice) && read->scale > 0.0);
  const auto pairs = parsePairs(text, "seed");
  if (!pairs.ok()) return;
  const auto found = colocate(*pairs);
  require(!found.ok() || (tandem::isValid(found->viewFromDevice) && found->scale > 0.0));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Bytes bytes = Bytes(data, size).subspan(1);
  const std::string text(bytes.begin(), bytes.end());
  switch (data[0]) {
    case 's':
      spaceMouse(bytes);
      break;
    case 'd':
      dualSense(bytes);
      break;
    case 'p':
      pid(bytes);
      break;
    case 'h':
      haply(text);
      break;
    case 'c':
      calibration(text);
      break;
    default:
      break;
  }
  return 0;
}
