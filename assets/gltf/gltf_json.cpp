#include "assets/gltf/gltf_json.h"

#include <cmath>

#include "assets/gltf/gltf_document.h"

namespace tandem::assets {

JsonObject::JsonObject(JsonView value, std::string place) : value_(value), place_(std::move(place)) {
  if (!value.isObject()) throw GltfError(place_, "must be an object");
}

JsonObject JsonObject::empty(std::string place) { return JsonObject(std::move(place)); }

void JsonObject::fail(const char* key, const std::string& reason) const {
  throw GltfError(place_ + "." + key, reason);
}

std::optional<JsonObject> JsonObject::object(const char* key) const {
  const JsonView value = raw(key);
  if (!value) return std::nullopt;
  return JsonObject(value, place_ + "." + key);
}

std::vector<JsonObject> JsonObject::objects(const char* key) const {
  std::vector<JsonObject> out;
  const JsonView value = raw(key);
  if (!value) return out;
  if (!value.isArray()) fail(key, "must be an array");
  for (std::size_t i = 0; i < value.size(); ++i)
    out.emplace_back(value.element(i), place_ + "." + key + "[" + std::to_string(i) + "]");
  return out;
}

std::optional<double> JsonObject::number(const char* key) const {
  const JsonView value = raw(key);
  if (!value) return std::nullopt;
  if (!value.isNumber() || !std::isfinite(value.number())) fail(key, "must be a finite number");
  return value.number();
}

double JsonObject::sizeOr(const char* key, double fallback) const {
  const double value = numberOr(key, fallback);
  if (value < 0.0) fail(key, "must not be negative");
  return value;
}

std::optional<std::vector<double>> JsonObject::numbers(const char* key, std::size_t count) const {
  const JsonView value = raw(key);
  if (!value) return std::nullopt;
  const std::string reason = "must be an array of " + std::to_string(count) + " finite numbers";
  if (!value.isArray() || value.size() != count) fail(key, reason);
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i) {
    const JsonView entry = value.element(i);
    if (!entry.isNumber() || !std::isfinite(entry.number())) fail(key, reason);
    out.push_back(entry.number());
  }
  return out;
}

std::optional<glm::dvec3> JsonObject::vector(const char* key) const {
  const auto values = numbers(key, 3);
  if (!values) return std::nullopt;
  return glm::dvec3((*values)[0], (*values)[1], (*values)[2]);
}

bool JsonObject::flag(const char* key, bool fallback) const {
  const JsonView value = raw(key);
  if (!value) return fallback;
  if (!value.isFlag()) fail(key, "must be true or false");
  return value.flag();
}

std::string JsonObject::text(const char* key, const std::string& fallback) const {
  const JsonView value = raw(key);
  if (!value) return fallback;
  if (!value.isText()) fail(key, "must be a string");
  return value.text();
}

std::vector<std::string> JsonObject::texts(const char* key) const {
  std::vector<std::string> out;
  const JsonView value = raw(key);
  if (!value) return out;
  if (!value.isArray()) fail(key, "must be an array of strings");
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!value.element(i).isText()) fail(key, "must be an array of strings");
    out.push_back(value.element(i).text());
  }
  return out;
}

std::optional<std::size_t> JsonObject::index(const char* key, std::size_t size, const char* what) const {
  const JsonView value = raw(key);
  if (!value) return std::nullopt;
  const bool good = value.isWhole() && value.whole() < size;
  if (!good)
    fail(key, value.dump().substr(0, 40) + " is out of range (" + std::to_string(size) + " " + what + ")");
  return static_cast<std::size_t>(value.whole());
}

std::size_t JsonObject::requiredIndex(const char* key, std::size_t size, const char* what) const {
  const auto value = index(key, size, what);
  if (!value) fail(key, "is missing");
  return *value;
}

void refuseFault(const std::optional<RangeFault>& fault, const std::string& place) {
  if (fault) throw GltfError(place + '.' + fault->property, fault->reason);
}

std::optional<JsonObject> extensionOf(JsonView value, const char* name, const std::string& place) {
  const JsonView extension = findExtension(value, name);
  if (!extension) return std::nullopt;
  return JsonObject(extension, place + "." + name);
}

}  // namespace tandem::assets
