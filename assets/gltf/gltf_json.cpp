#include "assets/gltf/gltf_json.h"

#include <algorithm>
#include <cmath>

#include "assets/gltf/gltf_document.h"

namespace tandem::assets {

JsonObject::JsonObject(const Json& value, std::string place) : value_(&value), place_(std::move(place)) {
  if (!value.isObject()) throw GltfError(place_, "must be an object");
}

JsonObject JsonObject::empty(std::string place) { return JsonObject(std::move(place)); }

void JsonObject::fail(const char* key, const std::string& reason) const {
  throw GltfError(place_ + "." + key, reason);
}

std::optional<JsonObject> JsonObject::object(const char* key) const {
  const Json& value = raw(key);
  if (value.isAbsent()) return std::nullopt;
  return JsonObject(value, place_ + "." + key);
}

std::vector<JsonObject> JsonObject::objects(const char* key) const {
  std::vector<JsonObject> out;
  const Json& value = raw(key);
  if (value.isAbsent()) return out;
  if (!value.isArray()) fail(key, "must be an array");
  for (std::size_t i = 0; i < value.size(); ++i)
    out.emplace_back(value.at(i), place_ + "." + key + "[" + std::to_string(i) + "]");
  return out;
}

std::optional<double> JsonObject::number(const char* key) const {
  const Json& value = raw(key);
  if (value.isAbsent()) return std::nullopt;
  if (!value.isNumber() || !std::isfinite(value.number())) fail(key, "must be a finite number");
  return value.number();
}

double JsonObject::sizeOr(const char* key, double fallback) const {
  const double value = numberOr(key, fallback);
  if (value < 0.0) fail(key, "must not be negative");
  return value;
}

std::optional<std::vector<double>> JsonObject::numbers(const char* key, std::size_t count) const {
  const Json& value = raw(key);
  if (value.isAbsent()) return std::nullopt;
  const std::string reason = "must be an array of " + std::to_string(count) + " finite numbers";
  if (!value.isArray() || value.size() != count) fail(key, reason);
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i) {
    const Json& entry = value.at(i);
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
  const Json& value = raw(key);
  if (value.isAbsent()) return fallback;
  if (!value.isBoolean()) fail(key, "must be true or false");
  return value.boolean();
}

std::string JsonObject::text(const char* key, const std::string& fallback) const {
  const Json& value = raw(key);
  if (value.isAbsent()) return fallback;
  if (!value.isText()) fail(key, "must be a string");
  return value.text();
}

std::vector<std::string> JsonObject::texts(const char* key) const {
  std::vector<std::string> out;
  const Json& value = raw(key);
  if (value.isAbsent()) return out;
  if (!value.isArray()) fail(key, "must be an array of strings");
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!value.at(i).isText()) fail(key, "must be an array of strings");
    out.push_back(value.at(i).text());
  }
  return out;
}

std::size_t JsonObject::indexOfName(const char* key, const std::string& name,
                                    std::span<const char* const> names) const {
  const auto found = std::ranges::find_if(names, [&](const char* known) { return name == known; });
  if (!name.empty() && found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::string list;
  for (const char* known : names) {
    if (*known == '\0') continue;
    if (!list.empty()) list += known == names.back() ? " or " : ", ";
    list += known;
  }
  fail(key, "must be " + list);
}

std::size_t JsonObject::count(const char* key) const {
  const Json& value = raw(key);
  if (value.isAbsent() || value.isNull()) return 0;
  return value.isArray() || value.isObject() ? value.size() : 1;
}

std::optional<std::size_t> JsonObject::index(const char* key, std::size_t size, const char* what) const {
  const Json& value = raw(key);
  if (value.isAbsent()) return std::nullopt;
  const bool good = value.isNatural() && value.integer() < size;
  if (!good)
    fail(key, value.dump().substr(0, 40) + " is out of range (" + std::to_string(size) + " " + what + ")");
  return static_cast<std::size_t>(value.integer());
}

std::size_t JsonObject::requiredIndex(const char* key, std::size_t size, const char* what) const {
  const auto value = index(key, size, what);
  if (!value) fail(key, "is missing");
  return *value;
}

void refuseFault(const std::optional<RangeFault>& fault, const std::string& place) {
  if (fault) throw GltfError(place + '.' + fault->property, fault->reason);
}

std::optional<JsonObject> extensionOf(const Json& value, const char* name, const std::string& place) {
  const Json& extension = findExtension(value, name);
  if (extension.isAbsent()) return std::nullopt;
  return JsonObject(extension, place + "." + name);
}

}  // namespace tandem::assets
