#pragma once

// Messages to bytes and back.
//
// 1. The bytes of a peer are hostile until decode returns ok.
// 2. A decoded message is already checked: enums in range, numbers finite, quaternions unit, strings within
//    limits. Part ids, roles and epochs are checked by the receiver, which knows the session.

#include <cstddef>
#include <span>
#include <vector>

#include "assets/base/result.h"
#include "sync/wire/control_message.h"
#include "sync/wire/state_message.h"
#include "sync/wire/wire_frame.h"

namespace tandem::sync {

/// Text is cut to its limit, and bytes that a receiver would refuse (not UTF-8, control characters) become
/// '?'.
std::vector<std::byte> encodeControl(const ControlMessage& message);
/// Control messages are exact: doubles on the wire. Of a Hello with another protocol version only that
/// version is decoded, so that the server can answer it.
Result<ControlMessage> decodeControl(std::span<const std::byte> bytes);

/// The second byte of a state datagram. A streamed update is one that StateSender writes (state_stream.h); a
/// pair is a message and another one, or pair, behind it (state_bundle.h).
enum class StateKind : std::uint8_t {
  update = 1,
  ping = 2,
  pong = 3,
  link = 4,
  streamed = 5,
  ack = 6,
  pair = 7,
  updateOfTwoHands = 8
};

/// How many values an encoding left out or clamped. Zero in normal use.
struct EncodeLosses {
  int leftOut = 0;  // parts that did not fit, or whose pose is not a valid one
  int clamped = 0;  // numbers outside their range on the wire (a position outside the frame, a speed)
};

/// Replaces `bytes`. Parts from the back of StateUpdate::parts are left out to stay within kMaxStateBytes.
/// Does not allocate once `bytes` has the capacity kMaxStateBytes.
void encodeState(const StateMessage& message, const WireFrame& frame, std::vector<std::byte>& bytes,
                 EncodeLosses* losses = nullptr);
/// Whether a datagram's kind is that of a StateUpdate, whole or streamed.
bool isStateUpdate(std::span<const std::byte> bytes);
bool isLinkUpdate(std::span<const std::byte> bytes);
/// Decodes every kind but the streamed one, which StateReceiver reads. Reuses the storage of `message` (a
/// StateUpdate keeps its vector's capacity). After an error its content is unspecified.
Status decodeState(std::span<const std::byte> bytes, const WireFrame& frame, StateMessage& message);

// Largest errors of quantisation (sync/WIRE.md derives them).
inline constexpr double kMaxAngleError = 1.9e-5;                                  // rad
inline constexpr double kMaxLinearSpeed = 8.0;                                    // m/s an axis, clamped
inline constexpr double kMaxAngularSpeed = 64.0;                                  // rad/s an axis, clamped
inline constexpr double kMaxPresenceForce = 64.0;                                 // N an axis, clamped
inline constexpr double kLinearSpeedError = 0.5 * kMaxLinearSpeed / 32767.0;      // m/s an axis
inline constexpr double kAngularSpeedError = 0.5 * kMaxAngularSpeed / 32767.0;    // rad/s an axis
inline constexpr double kPresenceForceError = 0.5 * kMaxPresenceForce / 32767.0;  // N an axis
/// m an axis, for positions inside the frame.
inline double positionError(const WireFrame& frame) { return 0.5000001 * frame.halfExtent / 8388608.0; }

/// The pose and twist as they will be at the receiver after quantisation.
PartState quantised(const PartState& state, const WireFrame& frame);

}  // namespace tandem::sync
