#include "assets/base/json.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "assets/base/assert.h"

namespace tandem {
namespace {

Json fromLibrary(const nlohmann::json& from) {
  switch (from.type()) {
    case nlohmann::json::value_t::boolean:
      return from.get<bool>();
    case nlohmann::json::value_t::number_integer:
      return from.get<std::int64_t>();
    case nlohmann::json::value_t::number_unsigned:
      return from.get<std::uint64_t>();
    case nlohmann::json::value_t::number_float:
      return from.get<double>();
    case nlohmann::json::value_t::string:
      return from.get_ref<const std::string&>();
    case nlohmann::json::value_t::array: {
      Json array = Json::array();
      for (const nlohmann::json& element : from) array.push(fromLibrary(element));
      return array;
    }
    case nlohmann::json::value_t::object: {
      Json object = Json::object();
      for (const auto& [name, member] : from.items()) object[name] = fromLibrary(member);
      return object;
    }
    default:
      return nullptr;
  }
}

nlohmann::ordered_json toLibrary(const Json& from) {
  switch (from.kind()) {
    case Json::Kind::null:
      return nullptr;
    case Json::Kind::boolean:
      return from.boolean();
    case Json::Kind::integer:
      return from.signedInteger();
    case Json::Kind::natural:
      return from.integer();
    case Json::Kind::real:
      return from.number();
    case Json::Kind::text:
      return from.text();
    case Json::Kind::array: {
      nlohmann::ordered_json array = nlohmann::ordered_json::array();
      for (const Json& element : from) array.push_back(toLibrary(element));
      return array;
    }
    case Json::Kind::object: {
      nlohmann::ordered_json object = nlohmann::ordered_json::object();
      for (const auto& [name, member] : from.members()) object[name] = toLibrary(member);
      return object;
    }
  }
  return nullptr;
}

[[noreturn]] void fail(const std::string& what) { throw JsonError(what); }

/// The library's message without its own name and number in front.
std::string reasonOf(const nlohmann::json::exception& error) {
  const std::string text = error.what();
  const std::size_t end = text.find("] ");
  return end == std::string::npos ? text : text.substr(end + 2);
}

}  // namespace

Json::Json() = default;
Json::Json(std::nullptr_t) {}
Json::Json(bool value) : kind_(Kind::boolean), bits_(value ? 1 : 0) {}
Json::Json(double value) : kind_(Kind::real), real_(value) {}
Json::Json(const char* value) : kind_(Kind::text), text_(value) {}
Json::Json(std::string value) : kind_(Kind::text), text_(std::move(value)) {}
Json::Json(std::string_view value) : kind_(Kind::text), text_(value) {}
Json::Json(const Json& other) = default;
Json::Json(Json&& other) noexcept = default;
Json& Json::operator=(const Json& other) = default;
Json& Json::operator=(Json&& other) noexcept = default;
Json::~Json() = default;

Json::Json(std::initializer_list<Json> values) {
  const bool pairs = std::all_of(values.begin(), values.end(), [](const Json& value) {
    return value.isArray() && value.size() == 2 && value.elements_[0].isText();
  });
  kind_ = pairs ? Kind::object : Kind::array;
  for (const Json& value : values) {
    if (pairs)
      members_.emplace_back(value.elements_[0].text_, value.elements_[1]);
    else
      elements_.push_back(value);
  }
}

Json Json::array() { return {Kind::array, 0}; }
Json Json::object() { return {Kind::object, 0}; }

bool Json::boolean() const {
  if (!isBoolean()) fail("must be true or false");
  return bits_ != 0;
}

double Json::number() const {
  if (kind_ == Kind::integer) return static_cast<double>(static_cast<std::int64_t>(bits_));
  if (kind_ == Kind::natural) return static_cast<double>(bits_);
  if (kind_ != Kind::real) fail("must be a number");
  return real_;
}

std::uint64_t Json::integer() const {
  if (!isInteger() || (kind_ == Kind::integer && static_cast<std::int64_t>(bits_) < 0))
    fail("must be a whole number");
  return bits_;
}

std::int64_t Json::signedInteger() const {
  if (kind_ != Kind::integer) fail("must be a whole number");
  return static_cast<std::int64_t>(bits_);
}

const std::string& Json::text() const {
  if (!isText()) fail("must be a text");
  return text_;
}

std::size_t Json::size() const { return elements_.size() + members_.size(); }

bool Json::contains(std::string_view name) const {
  return std::any_of(members_.begin(), members_.end(), [&](const Member& m) { return m.first == name; });
}

const Json& Json::at(std::string_view name) const {
  for (const Member& member : members_)
    if (member.first == name) return member.second;
  fail("lacks \"" + std::string(name) + "\"");
}

const Json& Json::at(std::size_t index) const {
  if (index >= elements_.size()) fail("has no element " + std::to_string(index));
  return elements_[index];
}

Json& Json::operator[](std::string_view name) {
  if (isNull()) kind_ = Kind::object;
  if (!isObject()) fail("is no object, to have \"" + std::string(name) + "\"");
  for (Member& member : members_)
    if (member.first == name) return member.second;
  return members_.emplace_back(std::string(name), Json()).second;
}

void Json::push(Json value) {
  if (isNull()) kind_ = Kind::array;
  if (!isArray()) fail("is no array, to be added to");
  elements_.push_back(std::move(value));
}

Json& Json::back() {
  ASSERT(!elements_.empty());
  return elements_.back();
}

void Json::update(const Json& other) {
  for (const Member& member : other.members_) (*this)[member.first] = member.second;
}

const std::vector<Json::Member>& Json::members() const { return members_; }

Json Json::rounded() const {
  Json result = *this;
  for (Json& element : result.elements_) element = element.rounded();
  for (Member& member : result.members_) member.second = member.second.rounded();
  if (kind_ == Kind::real) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.9g", real_);
    result.real_ = std::strtod(digits, nullptr);
  }
  return result;
}

std::string Json::dump(int indent) const { return toLibrary(*this).dump(indent); }

Result<Json> Json::parse(const std::string& text) {
  try {
    return fromLibrary(nlohmann::json::parse(text));
  } catch (const nlohmann::json::exception& error) {
    return Error{reasonOf(error)};
  }
}

}  // namespace tandem
