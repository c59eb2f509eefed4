#include "sync/wire/state_code.h"

#include <algorithm>
#include <cmath>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

/// A number as a signed code in steps of `quantum`; zero is exact. Not a number becomes zero.
std::int64_t wholeCode(double value, double quantum, std::int64_t min, std::int64_t max, int& clamped) {
  ASSERT(quantum > 0.0 && min < max);
  const double code = value / quantum;
  if (!(code >= static_cast<double>(min) - 0.5)) {
    ++clamped;
    return std::isnan(code) ? 0 : min;
  }
  if (code > static_cast<double>(max) + 0.5) {
    ++clamped;
    return max;
  }
  return std::min(max, std::max(min, std::int64_t{std::llround(code)}));
}

Code3 speedCode(const glm::dvec3& value, double range, int& clamped) {
  Code3 code;
  for (int i = 0; i < 3; ++i)
    code[static_cast<std::size_t>(i)] =
        wholeCode(value[i], range / kSpeedMax, -kSpeedMax, kSpeedMax, clamped);
  return code;
}
glm::dvec3 fromSpeedCode(const Code3& code, double range) {
  return glm::dvec3(static_cast<double>(code[0]), static_cast<double>(code[1]),
                    static_cast<double>(code[2])) *
         (range / kSpeedMax);
}

void putSpeed(BitWriter& writer, const Code3& code) {
  for (const std::int64_t x : code) writer.putSigned(x, kSpeedBits);
}
Code3 getSpeed(BitReader& reader) {
  Code3 code;
  for (std::int64_t& x : code) {
    x = reader.getSigned(kSpeedBits);
    if (x < -kSpeedMax) reader.fail();  // no encoder writes this code
  }
  return code;
}

PoseCode getPoseCode(BitReader& reader) {
  PoseCode code;
  for (std::int64_t& x : code.position) x = reader.getSigned(kPositionBits);
  code.largest = static_cast<int>(reader.get(2));
  for (std::int64_t& x : code.three) x = reader.getSigned(kQuaternionBits);
  return code;
}

}  // namespace

int largestOf(const glm::dquat& q) {
  const double w[4] = {q.w, q.x, q.y, q.z};
  int largest = 0;
  for (int i = 1; i < 4; ++i)
    if (std::abs(w[i]) > std::abs(w[largest])) largest = i;
  return largest;
}

PoseCode toCode(const Pose& pose, const WireFrame& frame, int& clamped) {
  PoseCode code;
  for (int i = 0; i < 3; ++i) {
    code.position[static_cast<std::size_t>(i)] =
        wholeCode(pose.position[i] - frame.centre[i], frame.halfExtent / (kPositionMax + 1),
                  -kPositionMax - 1, kPositionMax, clamped);
  }
  const glm::dquat& q = pose.orientation;
  const double w[4] = {q.w, q.x, q.y, q.z};
  code.largest = largestOf(q);
  const double sign = w[code.largest] < 0.0 ? -1.0 : 1.0;
  int ignored = 0;  // a unit quaternion is never out of range by more than rounding
  std::size_t k = 0;
  for (int i = 0; i < 4; ++i) {
    if (i == code.largest) continue;
    code.three[k++] = wholeCode(sign * w[i], kSmallestThreeRange / kQuaternionMax, -kQuaternionMax,
                                kQuaternionMax, ignored);
  }
  return code;
}

bool fromCode(const PoseCode& code, const WireFrame& frame, Pose& pose) {
  for (int i = 0; i < 3; ++i) {
    pose.position[i] = frame.centre[i] + static_cast<double>(code.position[static_cast<std::size_t>(i)]) *
                                             (frame.halfExtent / (kPositionMax + 1));
  }
  double w[4] = {}, sum = 0.0;
  std::size_t k = 0;
  for (int i = 0; i < 4; ++i) {
    if (i == code.largest) continue;
    w[i] = static_cast<double>(code.three[k++]) * (kSmallestThreeRange / kQuaternionMax);
    sum += w[i] * w[i];
  }
  if (sum > 0.75 + 1e-4) return false;
  w[code.largest] = std::sqrt(1.0 - sum);
  pose.orientation = glm::dquat(w[0], w[1], w[2], w[3]);
  return true;
}

TwistCode toCode(const Twist& twist, int& clamped) {
  return {speedCode(twist.linear, kMaxLinearSpeed, clamped),
          speedCode(twist.angular, kMaxAngularSpeed, clamped)};
}
Twist fromCode(const TwistCode& code) {
  return {fromSpeedCode(code.linear, kMaxLinearSpeed), fromSpeedCode(code.angular, kMaxAngularSpeed)};
}

PartCode toCode(const PartState& state, const WireFrame& frame, int& clamped) {
  return {state.part, state.epoch, state.sequence, toCode(state.worldFromPart, frame, clamped),
          toCode(state.twist, clamped)};
}
bool fromCode(const PartCode& code, const WireFrame& frame, PartState& state) {
  state.part = code.part;
  state.epoch = code.epoch;
  state.sequence = code.sequence;
  state.twist = fromCode(code.twist);
  return fromCode(code.pose, frame, state.worldFromPart);
}

bool sendable(const PartState& state) { return state.part < kMaxParts && isValid(state.worldFromPart); }

void put(BitWriter& writer, const PoseCode& code) {
  for (const std::int64_t x : code.position) writer.putSigned(x, kPositionBits);
  writer.put(static_cast<std::uint64_t>(code.largest), 2);
  for (const std::int64_t x : code.three) writer.putSigned(x, kQuaternionBits);
}
void put(BitWriter& writer, const TwistCode& code) {
  putSpeed(writer, code.linear);
  putSpeed(writer, code.angular);
}
void putTime(BitWriter& writer, Micros time) {
  writer.putSigned(std::min(kMaxMicros, std::max(-kMaxMicros, time)), kTimeBits);
}

namespace {

/// An invalid pose (of a device that failed) is replaced by one at the centre.
void putShownPose(BitWriter& writer, const Pose& pose, const WireFrame& frame, int& clamped) {
  const Pose fallback{frame.centre, glm::dquat(1.0, 0.0, 0.0, 0.0)};
  put(writer, toCode(isValid(pose) ? pose : fallback, frame, clamped));
}

}  // namespace

void putPresence(BitWriter& writer, const Presence& presence, bool camera, const WireFrame& frame,
                 int& clamped) {
  putShownPose(writer, presence.worldFromTool, frame, clamped);
  if (camera) putShownPose(writer, presence.worldFromCamera, frame, clamped);
  putSpeed(writer, speedCode(presence.force, kMaxPresenceForce, clamped));
  const bool touches = presence.touched < kMaxParts;
  writer.put(touches ? 1 : 0, 1);
  writer.put(touches ? presence.touched : 0, kPartBits);
}

void putSecondTool(BitWriter& writer, const Presence& presence, const WireFrame& frame, int& clamped) {
  putShownPose(writer, *presence.worldFromSecondTool, frame, clamped);
}

void putWhole(BitWriter& writer, const PartCode& code) {
  writer.put(code.part, kPartBits);
  writer.putVarint(code.epoch);
  writer.putVarint(code.sequence);
  put(writer, code.pose);
  writer.put(code.twist.still() ? 1 : 0, 1);
  if (!code.twist.still()) put(writer, code.twist);
}
int wholeBits(const PartCode& code) {
  return kPartBits + varintBits(code.epoch) + varintBits(code.sequence) + kPoseBits + 1 +
         (code.twist.still() ? 0 : kTwistBits);
}

void getPose(BitReader& reader, const WireFrame& frame, Pose& pose) {
  if (!fromCode(getPoseCode(reader), frame, pose)) reader.fail();
}
Twist getTwist(BitReader& reader) {
  const Code3 linear = getSpeed(reader);
  return fromCode(TwistCode{linear, getSpeed(reader)});
}
Micros getTime(BitReader& reader) {
  const Micros time = reader.getSigned(kTimeBits);
  if (time < -kMaxMicros) reader.fail();
  return time;
}

void getPresence(BitReader& reader, const WireFrame& frame, bool camera, Presence& presence) {
  getPose(reader, frame, presence.worldFromTool);
  if (camera) getPose(reader, frame, presence.worldFromCamera);
  presence.force = fromSpeedCode(getSpeed(reader), kMaxPresenceForce);
  const bool touches = reader.get(1) == 1;
  const auto part = static_cast<PartId>(reader.get(kPartBits));
  if (!touches && part != 0) reader.fail();
  presence.touched = touches ? part : kNoPart;
}

void getSecondTool(BitReader& reader, const WireFrame& frame, Presence& presence) {
  getPose(reader, frame, presence.worldFromSecondTool.emplace());
}

PartCode getWhole(BitReader& reader) {
  PartCode code;
  code.part = static_cast<PartId>(reader.get(kPartBits));
  code.epoch = reader.getVarint();
  code.sequence = reader.getVarint();
  code.pose = getPoseCode(reader);
  if (reader.get(1) == 1) return code;
  code.twist.linear = getSpeed(reader);
  code.twist.angular = getSpeed(reader);
  return code;
}

}  // namespace tandem::sync
