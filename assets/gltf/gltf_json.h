#pragma once

// Typed, checked reading of JSON properties. A GltfError names the place of the property.

#include <optional>
#include <span>
#include <string>

#include <glm/vec3.hpp>

#include "assets/base/json.h"
#include "assets/gltf/gltf_error.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {

/// One JSON object of a document and where it stands in the file. Valid as long as the document.
class JsonObject {
 public:
  /// Throws GltfError where the value is no object.
  JsonObject(const Json& value, std::string place);
  /// An object without properties.
  static JsonObject empty(std::string place);

  const std::string& place() const { return place_; }
  bool has(const char* key) const { return value_->contains(key); }

  /// A property that is an object; nothing if it is absent.
  std::optional<JsonObject> object(const char* key) const;
  /// Elements of a property that is an array of objects; empty if it is absent.
  std::vector<JsonObject> objects(const char* key) const;
  /// A finite number.
  std::optional<double> number(const char* key) const;
  double numberOr(const char* key, double fallback) const { return number(key).value_or(fallback); }
  /// A finite number >= 0.
  double sizeOr(const char* key, double fallback) const;
  /// `count` finite numbers.
  std::optional<std::vector<double>> numbers(const char* key, std::size_t count) const;
  std::optional<glm::dvec3> vector(const char* key) const;
  bool flag(const char* key, bool fallback) const;
  std::string text(const char* key, const std::string& fallback) const;
  std::vector<std::string> texts(const char* key) const;
  /// A property that is one of the names of an enumeration's values (describe.h), in their order; `fallback`
  /// stands where it is absent. An empty name is that of no value.
  template <typename Enum>
  Enum choice(const char* key, const std::string& fallback, std::span<const char* const> names) const {
    return static_cast<Enum>(indexOfName(key, text(key, fallback), names));
  }
  /// Elements of a property that is an array; 0 if it is absent or null, 1 if it is a plain value.
  std::size_t count(const char* key) const;
  /// An index below `size`; a message names the list as `what`.
  std::optional<std::size_t> index(const char* key, std::size_t size, const char* what) const;
  std::size_t requiredIndex(const char* key, std::size_t size, const char* what) const;

  [[noreturn]] void fail(const char* key, const std::string& reason) const;
  /// A property as it stands, of any type; absent if there is none.
  const Json& raw(const char* key) const { return value_->member(key); }
  const Json& raw() const { return *value_; }

 private:
  explicit JsonObject(std::string place) : place_(std::move(place)) {}
  std::size_t indexOfName(const char* key, const std::string& name, std::span<const char* const> names) const;

  const Json* value_ = &Json::absent();
  std::string place_;
};

/// Throws what a check of value ranges has found, if anything, as a fault of `place`.
void refuseFault(const std::optional<RangeFault>& fault, const std::string& place);

/// value.extensions[name] as a checked object.
std::optional<JsonObject> extensionOf(const Json& value, const char* name, const std::string& place);

}  // namespace tandem::assets
