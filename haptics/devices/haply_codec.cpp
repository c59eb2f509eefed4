#include "haptics/devices/haply_codec.h"

#include <cmath>
#include <glm/geometric.hpp>

#include <nlohmann/json.hpp>

namespace tandem::haptics {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kLongestId = 64;
constexpr double kFarthest = 10.0, kFastest = 100.0;  // m, m/s: beyond any desktop arm

bool number(const Json& object, const char* key, double limit, double& out) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return false;
  out = found->get<double>();
  return std::abs(out) <= limit;  // also false for NaN
}

bool vector(const Json& object, const char* key, double limit, glm::dvec3& out) {
  const auto found = object.find(key);
  return found != object.end() && found->is_object() && number(*found, "x", limit, out.x) &&
         number(*found, "y", limit, out.y) && number(*found, "z", limit, out.z);
}

/// The first element's `state` of a list of devices, or null; `element` becomes that element.
const Json* firstState(const Json& message, const char* key, const Json*& element) {
  const auto list = message.find(key);
  if (list == message.end() || !list->is_array() || list->empty() || !list->front().is_object())
    return nullptr;
  element = &list->front();
  const auto state = element->find("state");
  return state != element->end() && state->is_object() ? &*state : nullptr;
}

/// False if there is a grip with an invalid state.
bool takeGrip(const Json& message, HaplyState& state) {
  const Json* element = nullptr;
  const Json* grip = nullptr;
  for (const char* key : {"wireless_verse_grip", "verse_grip"})
    if (grip == nullptr) grip = firstState(message, key, element);
  if (grip == nullptr) return true;
  if (const auto turn = grip->find("orientation"); turn != grip->end()) {
    glm::dquat q(1.0, 0.0, 0.0, 0.0);
    if (!turn->is_object() || !number(*turn, "x", 2.0, q.x) || !number(*turn, "y", 2.0, q.y) ||
        !number(*turn, "z", 2.0, q.z) || !number(*turn, "w", 2.0, q.w))
      return false;
    const double length = glm::length(q);
    if (!(std::abs(length - 1.0) < 0.1)) return false;
    state.orientation = q * (1.0 / length);
  }
  const auto buttons = grip->find("buttons");
  if (buttons == grip->end() || !buttons->is_object()) return true;
  std::uint32_t bit = 1;
  for (const char* key : {"a", "b", "c"}) {
    const auto button = buttons->find(key);
    if (button != buttons->end() && button->is_boolean() && button->get<bool>()) state.buttons |= bit;
    bit <<= 1;
  }
  return true;
}

}  // namespace

HaplyMessage decodeHaply(std::string_view text, HaplyState& state) {
  if (text.size() > kLongestHaplyMessage) return HaplyMessage::kMalformed;
  const Json message = Json::parse(text.begin(), text.end(), nullptr, false);
  if (!message.is_object()) return HaplyMessage::kMalformed;
  const auto devices = message.find("inverse3");
  if (devices == message.end() || (devices->is_array() && devices->empty())) return HaplyMessage::kNoDevice;
  const Json* device = nullptr;
  const Json* said = firstState(message, "inverse3", device);
  if (said == nullptr) return HaplyMessage::kMalformed;
  HaplyState next;
  const auto id = device->find("device_id");
  if (id == device->end() || !id->is_string()) return HaplyMessage::kMalformed;
  next.id = id->get<std::string>();
  if (next.id.empty() || next.id.size() > kLongestId) return HaplyMessage::kMalformed;
  if (!vector(*said, "cursor_position", kFarthest, next.position) ||
      !vector(*said, "cursor_velocity", kFastest, next.velocity) || !takeGrip(message, next))
    return HaplyMessage::kMalformed;
  state = std::move(next);
  return HaplyMessage::kState;
}

std::string encodeHaply(const std::string& id, const glm::dvec3& force) {
  if (id.empty()) return R"({"inverse3":[]})";
  const bool finite = std::isfinite(force.x) && std::isfinite(force.y) && std::isfinite(force.z);
  const glm::dvec3 f = finite ? force : glm::dvec3(0.0);
  Json command;
  command["device_id"] = id;
  command["commands"]["set_cursor_force"]["values"] = {{"x", f.x}, {"y", f.y}, {"z", f.z}};
  return Json{{"inverse3", Json::array({command})}}.dump(-1, ' ', false, Json::error_handler_t::replace);
}

glm::dvec3 fromHaplyAxes(const glm::dvec3& v) { return {v.x, v.z, -v.y}; }
glm::dvec3 toHaplyAxes(const glm::dvec3& v) { return {v.x, -v.z, v.y}; }
glm::dquat fromHaplyAxes(const glm::dquat& q) { return {q.w, q.x, q.z, -q.y}; }

}  // namespace tandem::haptics
