#include "haptics/devices/haply_codec.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "assets/base/json.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kMaxIdBytes = 64;
constexpr double kMaxDistance = 10.0, kMaxSpeed = 100.0;  // m, m/s: beyond any desktop arm

bool readNumber(const Json& object, const char* key, double limit, double& out) {
  const Json& value = object.member(key);
  if (!value.isNumber()) return false;
  out = value.number();
  return std::abs(out) <= limit;  // also false for NaN
}

bool readVector(const Json& object, const char* key, double limit, glm::dvec3& out) {
  const Json& value = object.member(key);
  return readNumber(value, "x", limit, out.x) && readNumber(value, "y", limit, out.y) &&
         readNumber(value, "z", limit, out.z);
}

/// The first of a list of devices; absent where there is none.
const Json& firstDevice(const Json& message, const char* key) {
  const Json& list = message.member(key);
  return list.isArray() && !list.empty() ? list.at(0) : Json::absent();
}

/// False if there is a grip with an invalid state.
bool readGrip(const Json& message, HaplyState& state) {
  const Json* grip = &Json::absent();
  for (const char* key : {"wireless_verse_grip", "verse_grip"})
    if (!grip->isObject()) grip = &firstDevice(message, key).member("state");
  if (!grip->isObject()) return true;
  if (const Json& orientation = grip->member("orientation"); !orientation.isAbsent()) {
    glm::dquat q(1.0, 0.0, 0.0, 0.0);
    if (!readNumber(orientation, "x", 2.0, q.x) || !readNumber(orientation, "y", 2.0, q.y) ||
        !readNumber(orientation, "z", 2.0, q.z) || !readNumber(orientation, "w", 2.0, q.w))
      return false;
    const double length = glm::length(q);
    if (!(std::abs(length - 1.0) < 0.1)) return false;
    state.orientation = q * (1.0 / length);
  }
  const Json& buttons = grip->member("buttons");
  std::uint32_t bit = 1;
  for (const char* key : {"a", "b", "c"}) {
    const Json& button = buttons.member(key);
    if (button.isBoolean() && button.boolean()) state.buttons |= bit;
    bit <<= 1;
  }
  return true;
}

}  // namespace

HaplyMessage decodeHaply(std::string_view text, HaplyState& state) {
  if (text.size() > kMaxHaplyMessage) return HaplyMessage::kMalformed;
  const Result<Json> parsed = Json::parse(text);
  if (!parsed || !parsed->isObject()) return HaplyMessage::kMalformed;
  const Json& message = *parsed;
  const Json& devices = message.member("inverse3");
  if (devices.isAbsent() || (devices.isArray() && devices.empty())) return HaplyMessage::kNoDevice;
  const Json& device = firstDevice(message, "inverse3");
  const Json& reported = device.member("state");
  const Json& id = device.member("device_id");
  if (!reported.isObject() || !id.isText()) return HaplyMessage::kMalformed;
  HaplyState next;
  next.id = id.text();
  if (next.id.empty() || next.id.size() > kMaxIdBytes) return HaplyMessage::kMalformed;
  if (!readVector(reported, "cursor_position", kMaxDistance, next.position) ||
      !readVector(reported, "cursor_velocity", kMaxSpeed, next.velocity) || !readGrip(message, next))
    return HaplyMessage::kMalformed;
  state = std::move(next);
  return HaplyMessage::kState;
}

std::string encodeHaply(const std::string& id, const glm::dvec3& force) {
  if (id.empty()) return R"({"inverse3":[]})";
  const bool finite = std::isfinite(force.x) && std::isfinite(force.y) && std::isfinite(force.z);
  const glm::dvec3 f = finite ? force : glm::dvec3(0.0);
  Json command;
  Json& values = command["commands"]["set_cursor_force"]["values"];
  values["x"] = f.x;
  values["y"] = f.y;
  values["z"] = f.z;
  command["device_id"] = id;
  Json message;
  message["inverse3"].push(std::move(command));
  return message.dump();
}

glm::dvec3 fromHaplyAxes(const glm::dvec3& v) { return {v.x, v.z, -v.y}; }
glm::dvec3 toHaplyAxes(const glm::dvec3& v) { return {v.x, -v.z, v.y}; }
glm::dquat fromHaplyAxes(const glm::dquat& q) { return {q.w, q.x, q.z, -q.y}; }

}  // namespace tandem::haptics
