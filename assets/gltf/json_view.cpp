#include "assets/gltf/json_view.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "assets/base/assert.h"
#include "assets/gltf/gltf_error.h"

namespace tandem::assets {
namespace {

using nlohmann::json;

// Far beyond any real file; keeps what recurses over JSON, nlohmann's destructor among it, off the stack's
// end.
constexpr int kMaxJsonDepth = 96;

void checkDepth(std::string_view text) {
  int depth = 0;
  bool inString = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (inString) {
      if (c == '\\') ++i;
      if (c == '"') inString = false;
    } else if (c == '"') {
      inString = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth)
        throw GltfError("json", "is nested deeper than " + std::to_string(kMaxJsonDepth) + " levels");
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
}

}  // namespace

bool JsonView::isObject() const { return value_ != nullptr && value_->is_object(); }
bool JsonView::isArray() const { return value_ != nullptr && value_->is_array(); }
bool JsonView::isText() const { return value_ != nullptr && value_->is_string(); }
bool JsonView::isFlag() const { return value_ != nullptr && value_->is_boolean(); }
bool JsonView::isNumber() const { return value_ != nullptr && value_->is_number(); }
bool JsonView::isWhole() const { return value_ != nullptr && value_->is_number_unsigned(); }

std::size_t JsonView::size() const { return value_ == nullptr ? 0 : value_->size(); }

JsonView JsonView::member(const char* key) const {
  if (!isObject()) return {};
  const auto it = value_->find(key);
  return it == value_->end() ? JsonView() : JsonView(&*it);
}

JsonView JsonView::element(std::size_t index) const {
  ASSERT(isArray() && index < value_->size());
  return JsonView(&(*value_)[index]);
}

std::vector<std::string> JsonView::keys() const {
  std::vector<std::string> names;
  if (isObject())
    for (const auto& [key, value] : value_->items()) names.push_back(key);
  return names;
}

double JsonView::number() const {
  ASSERT(isNumber());
  return value_->get<double>();
}

std::uint64_t JsonView::whole() const {
  ASSERT(value_ != nullptr && value_->is_number_integer());
  return value_->get<std::uint64_t>();
}

bool JsonView::flag() const {
  ASSERT(isFlag());
  return value_->get<bool>();
}

std::string JsonView::text() const {
  ASSERT(isText());
  return value_->get<std::string>();
}

std::string JsonView::dump() const {
  ASSERT(value_ != nullptr);
  return value_->dump();
}

JsonTree::JsonTree() : root_(std::make_unique<json>()) {}
JsonTree::~JsonTree() = default;

void JsonTree::parse(std::string_view text) {
  checkDepth(text);
  try {
    *root_ = json::parse(text.begin(), text.end());
  } catch (const json::exception& e) {
    std::string reason = e.what();
    // "[json.exception.parse_error.101] parse error at line 1 ..." starts with the name of nlohmann's class.
    if (const auto bracket = reason.find("] "); bracket != std::string::npos) reason.erase(0, bracket + 2);
    std::replace_if(
        reason.begin(), reason.end(), [](unsigned char c) { return c < 32; }, ' ');
    throw GltfError("json", reason);
  }
}

}  // namespace tandem::assets
