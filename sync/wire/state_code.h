#pragma once

// Poses, velocities and parts as the integers that the wire carries, and their bits (sync/WIRE.md). Only the
// encoders of state datagrams include this.
//
// 1. A decoded code is the encoded one, so nothing drifts however often a state is passed on.
// 2. Codes come from a peer: get...() checks what it reads, and fails the reader on codes that no encoder
//    writes.

#include <array>
#include <cstdint>

#include "sync/wire/bits.h"
#include "sync/wire/wire.h"

namespace tandem::sync {

inline constexpr int kPositionBits = 24, kQuaternionBits = 18, kSpeedBits = 16, kPartBits = 14,
                     kTimeBits = 56;
inline constexpr int kPoseBits = 3 * kPositionBits + 2 + 3 * kQuaternionBits;
inline constexpr int kTwistBits = 6 * kSpeedBits;
inline constexpr int kHandBits = kPoseBits + 3 * kSpeedBits + 1 + kPartBits;
inline constexpr int kPresenceBits = kHandBits + kPoseBits;  // hand and camera
inline constexpr int kSmallestPartBits = kPartBits + 8 + 8 + kPoseBits + 1;
inline constexpr std::int64_t kPositionMax = (std::int64_t{1} << (kPositionBits - 1)) - 1;
inline constexpr std::int64_t kQuaternionMax = (1 << (kQuaternionBits - 1)) - 1;
inline constexpr std::int64_t kSpeedMax = (1 << (kSpeedBits - 1)) - 1;
inline constexpr double kSmallestThreeRange = 0.70710678118654752;
static_assert(kMaxParts == 1u << kPartBits);

using Code3 = std::array<std::int64_t, 3>;

struct PoseCode {
  Code3 position{};
  int largest = 0;  // which of w x y z is left out
  Code3 three{};    // the others, in order
  friend bool operator==(const PoseCode&, const PoseCode&) = default;
};
struct TwistCode {
  Code3 linear{}, angular{};
  bool still() const { return *this == TwistCode{}; }
  friend bool operator==(const TwistCode&, const TwistCode&) = default;
};
struct PartCode {
  PartId part = kNoPart;
  Epoch epoch = 0;
  std::uint32_t sequence = 0;
  PoseCode pose;
  TwistCode twist;
  friend bool operator==(const PartCode&, const PartCode&) = default;
};

/// Which of w x y z has the largest magnitude; a code leaves that one out.
int largestOf(const glm::dquat& q);
/// Counts in `clamped` the numbers that lay outside their range.
PoseCode toCode(const Pose& pose, const WireFrame& frame, int& clamped);
TwistCode toCode(const Twist& twist, int& clamped);
PartCode toCode(const PartState& state, const WireFrame& frame, int& clamped);
/// False if the three are not those of a unit quaternion whose largest component was left out.
bool fromCode(const PoseCode& code, const WireFrame& frame, Pose& pose);
Twist fromCode(const TwistCode& code);
bool fromCode(const PartCode& code, const WireFrame& frame, PartState& state);

/// Whether a state can be encoded: it has a part and a valid pose.
bool sendable(const PartState& state);

void put(BitWriter& writer, const PoseCode& code);
void put(BitWriter& writer, const TwistCode& code);
void putTime(BitWriter& writer, Micros time);
/// `camera`: whether the pose of the camera is included. The second tool's is put by itself.
void putPresence(BitWriter& writer, const Presence& presence, bool camera, const WireFrame& frame,
                 int& clamped);
/// The pose of the second tool, which there must be.
void putSecondTool(BitWriter& writer, const Presence& presence, const WireFrame& frame, int& clamped);
/// A part by itself, without a baseline.
void putWhole(BitWriter& writer, const PartCode& code);
int wholeBits(const PartCode& code);

void getPose(BitReader& reader, const WireFrame& frame, Pose& pose);
Twist getTwist(BitReader& reader);
Micros getTime(BitReader& reader);
void getPresence(BitReader& reader, const WireFrame& frame, bool camera, Presence& presence);
void getSecondTool(BitReader& reader, const WireFrame& frame, Presence& presence);
PartCode getWhole(BitReader& reader);

}  // namespace tandem::sync
