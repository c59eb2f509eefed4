#pragma once

// Parsed JSON behind an interface that does not show which library parses it: nlohmann/json costs seconds in every
// source that includes it, so only json_view.cpp, gltf_rules.cpp and gltf_model.cpp do. For the loader's sources only.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace tandem::assets {

/// A value of a JSON tree, or an absent one. Valid as long as the tree.
class JsonView {
 public:
  JsonView() = default;
  explicit JsonView(const nlohmann::json* value) : value_(value) {}

  /// Whether the value is there; null counts as there.
  explicit operator bool() const { return value_ != nullptr; }

  bool isObject() const;
  bool isArray() const;
  bool isText() const;
  bool isFlag() const;
  bool isNumber() const;
  /// A number that is written without sign, fraction and exponent.
  bool isWhole() const;

  /// Elements of an array or members of an object; 0 for null and an absent value, 1 for any other.
  std::size_t size() const;
  /// A member of an object; absent where there is none or the value is no object.
  JsonView member(const char* key) const;
  /// An element of an array; index < size().
  JsonView element(std::size_t index) const;
  /// The names of an object's members, sorted.
  std::vector<std::string> keys() const;

  /// The value, which must be of the type asked for.
  double number() const;
  std::uint64_t whole() const;
  bool flag() const;
  std::string text() const;
  /// The value as JSON.
  std::string dump() const;

 private:
  const nlohmann::json* value_ = nullptr;
};

/// A JSON text that has been parsed.
class JsonTree {
 public:
  JsonTree();
  ~JsonTree();

  /// Throws GltfError where the text is no JSON or is nested deeper than 96 levels.
  void parse(std::string_view text);

  JsonView root() const { return JsonView(root_.get()); }
  nlohmann::json& mutableRoot() { return *root_; }
  const nlohmann::json& library() const { return *root_; }

 private:
  std::unique_ptr<nlohmann::json> root_;
};

}  // namespace tandem::assets
