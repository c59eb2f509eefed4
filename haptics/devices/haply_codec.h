#pragma once

// Messages of Haply's device service for the Inverse3 (with or without VerseGrip), JSON text. Pure; safe for
// any text.
//
//   from it  {"inverse3":[{"device_id":"..","state":{"cursor_position":{x,y,z},"cursor_velocity":{x,y,z}}}],
//             "wireless_verse_grip":[{"state":{"orientation":{x,y,z,w},"buttons":{a,b,c}}}]}           m, m/s
//   to it    {"inverse3":[{"device_id":"..","commands":{"set_cursor_force":{"values":{x,y,z}}}}]}      N
//
// Source: Haply's public client examples. Its axes: x right, y away from the user, z up.

#include <cstdint>
#include <string>
#include <string_view>

#include "assets/base/pose.h"

namespace tandem::haptics {

/// The largest accepted message, bytes.
inline constexpr std::size_t kMaxHaplyMessage = 64 * 1024;

/// Content of one message, in the device's axes.
struct HaplyState {
  std::string id;                                               // of the device, at most 64 bytes
  glm::dvec3 position{0.0, 0.0, 0.0}, velocity{0.0, 0.0, 0.0};  // m, m/s
  glm::dquat orientation{1.0, 0.0, 0.0, 0.0};                   // of the grip; identity without one
  std::uint32_t buttons = 0;                                    // bit 0: a, 1: b, 2: c
};

enum class HaplyMessage {
  kState,      // `state` was filled
  kNoDevice,   // well-formed, but no Inverse3 is connected
  kMalformed,  // not JSON, wrong types, not finite, or out of range: `state` is unchanged
};

HaplyMessage decodeHaply(std::string_view text, HaplyState& state);

/// Message with a force in N, device axes; a non-finite force becomes zero. An empty id gives a reply without
/// a command.
std::string encodeHaply(const std::string& id, const glm::dvec3& force);

/// Converts device axes to axes with y up and z towards the user.
glm::dvec3 fromHaplyAxes(const glm::dvec3& v);
glm::dvec3 toHaplyAxes(const glm::dvec3& v);
glm::dquat fromHaplyAxes(const glm::dquat& q);

}  // namespace tandem::haptics
