#include "assets/gltf/gltf_json.h"

#include <cmath>

namespace tandem::assets {

using nlohmann::json;

JsonObject::JsonObject(const json& value, std::string place) : value_(&value), place_(std::move(place)) {
  if (!value.is_object()) throw GltfError(place_, "must be an object");
}

void JsonObject::fail(const char* key, const std::string& reason) const {
  throw GltfError(place_ + "." + key, reason);
}

const json* JsonObject::find(const char* key) const {
  const auto it = value_->find(key);
  return it == value_->end() ? nullptr : &*it;
}

std::optional<JsonObject> JsonObject::object(const char* key) const {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  return JsonObject(*value, place_ + "." + key);
}

std::vector<JsonObject> JsonObject::objects(const char* key) const {
  std::vector<JsonObject> out;
  const json* value = find(key);
  if (value == nullptr) return out;
  if (!value->is_array()) fail(key, "must be an array");
  for (std::size_t i = 0; i < value->size(); ++i)
    out.emplace_back((*value)[i], place_ + "." + key + "[" + std::to_string(i) + "]");
  return out;
}

std::optional<double> JsonObject::number(const char* key) const {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_number() || !std::isfinite(value->get<double>())) fail(key, "must be a finite number");
  return value->get<double>();
}

double JsonObject::sizeOr(const char* key, double fallback) const {
  const double value = numberOr(key, fallback);
  if (value < 0.0) fail(key, "must not be negative");
  return value;
}

std::optional<std::vector<double>> JsonObject::numbers(const char* key, std::size_t count) const {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  const std::string reason = "must be an array of " + std::to_string(count) + " finite numbers";
  if (!value->is_array() || value->size() != count) fail(key, reason);
  std::vector<double> out;
  for (const json& entry : *value) {
    if (!entry.is_number() || !std::isfinite(entry.get<double>())) fail(key, reason);
    out.push_back(entry.get<double>());
  }
  return out;
}

std::optional<glm::dvec3> JsonObject::vector(const char* key) const {
  const auto values = numbers(key, 3);
  if (!values) return std::nullopt;
  return glm::dvec3((*values)[0], (*values)[1], (*values)[2]);
}

bool JsonObject::flag(const char* key, bool fallback) const {
  const json* value = find(key);
  if (value == nullptr) return fallback;
  if (!value->is_boolean()) fail(key, "must be true or false");
  return value->get<bool>();
}

std::string JsonObject::text(const char* key, const std::string& fallback) const {
  const json* value = find(key);
  if (value == nullptr) return fallback;
  if (!value->is_string()) fail(key, "must be a string");
  return value->get<std::string>();
}

std::vector<std::string> JsonObject::texts(const char* key) const {
  std::vector<std::string> out;
  const json* value = find(key);
  if (value == nullptr) return out;
  if (!value->is_array()) fail(key, "must be an array of strings");
  for (const json& entry : *value) {
    if (!entry.is_string()) fail(key, "must be an array of strings");
    out.push_back(entry.get<std::string>());
  }
  return out;
}

std::optional<std::size_t> JsonObject::index(const char* key, std::size_t size, const char* what) const {
  const json* value = find(key);
  if (value == nullptr) return std::nullopt;
  const bool good = value->is_number_unsigned() && value->get<std::uint64_t>() < size;
  if (!good)
    fail(key, value->dump().substr(0, 40) + " is out of range (" + std::to_string(size) + " " + what + ")");
  return value->get<std::size_t>();
}

std::size_t JsonObject::requiredIndex(const char* key, std::size_t size, const char* what) const {
  const auto value = index(key, size, what);
  if (!value) fail(key, "is missing");
  return *value;
}

void refuseFault(const std::optional<RangeFault>& fault, const std::string& place) {
  if (fault) throw GltfError(place + '.' + fault->property, fault->reason);
}

std::optional<JsonObject> extensionOf(const json& value, const char* name, const std::string& place) {
  const json* extension = findExtension(value, name);
  if (extension == nullptr) return std::nullopt;
  return JsonObject(*extension, place + "." + name);
}

}  // namespace tandem::assets
