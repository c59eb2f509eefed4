#include "assets/base/json.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "assets/base/assert.h"

namespace tandem {
namespace {

nlohmann::ordered_json toLibrary(const Json& from) {
  switch (from.kind()) {
    case Json::Kind::absent:
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
      // push_back() of the underlying vector: the library's own insertion searches the object for every
      // member.
      nlohmann::ordered_json::object_t object;
      for (const auto& [name, member] : from.members()) object.push_back({name, toLibrary(member)});
      return object;
    }
  }
  return nullptr;
}

[[noreturn]] void fail(const std::string& what) { throw JsonError(what); }

/// The library's message on one line, without "[json.exception.parse_error.101] " in front.
std::string reasonOf(const nlohmann::json::exception& error) {
  std::string text = error.what();
  if (const std::size_t end = text.find("] "); end != std::string::npos) text.erase(0, end + 2);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32; }, ' ');
  return text;
}

bool namedBefore(const Json::Member& a, const Json::Member& b) { return a.first < b.first; }

/// Sorts members by name. Of members with one name the last remains, as RFC 8259, 4 leaves to the reader.
void sortMembers(std::vector<Json::Member>& members) {
  std::stable_sort(members.begin(), members.end(), namedBefore);
  std::size_t count = 0;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (i + 1 < members.size() && members[i + 1].first == members[i].first) continue;
    if (count != i) members[count] = std::move(members[i]);
    ++count;
  }
  members.erase(members.begin() + static_cast<std::ptrdiff_t>(count), members.end());
}

}  // namespace

/// A place in a text that says how far it has got.
class WatchedText {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  explicit WatchedText(std::string_view text) : at_(text.data() + text.size()) {}
  WatchedText(std::string_view text, const std::function<void(double)>& progress)
      : progress_(&progress), at_(text.data()), begin_(at_), size_(text.size()) {}
  reference operator*() const { return *at_; }
  WatchedText& operator++() {
    ++at_;
    const auto done = static_cast<std::size_t>(at_ - begin_);
    if (done % kStep == 0) (*progress_)(static_cast<double>(done) / static_cast<double>(size_));
    return *this;
  }
  WatchedText operator++(int) {
    const WatchedText before = *this;
    ++*this;
    return before;
  }
  bool operator==(const WatchedText& other) const { return at_ == other.at_; }
  bool operator!=(const WatchedText& other) const { return at_ != other.at_; }

 private:
  static constexpr std::size_t kStep = 1 << 20;
  const std::function<void(double)>* progress_ = nullptr;
  const char* at_;
  const char* begin_ = nullptr;
  std::size_t size_ = 0;
};

/// Builds a value from the events of the library's parser, which is not recursive.
class JsonBuilder final : public nlohmann::json_sax<nlohmann::json> {
 public:
  Json root;
  std::string error;

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { return false; }  // JSON text has none
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool key(string_t& name) override {
    open_.back()->members_.emplace_back(std::move(name), Json());
    return true;
  }
  bool end_object() override {
    sortMembers(open_.back()->members_);
    return end_array();
  }
  bool end_array() override {
    open_.pop_back();
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& reason) override {
    error = reasonOf(reason);
    return false;
  }

 private:
  Json& place(Json value) {
    if (open_.empty()) return root = std::move(value);
    Json& parent = *open_.back();
    if (parent.isArray()) return parent.elements_.emplace_back(std::move(value));
    return parent.members_.back().second = std::move(value);
  }
  bool add(Json value) {
    place(std::move(value));
    return true;
  }
  bool open(Json value) {
    open_.push_back(&place(std::move(value)));
    return true;
  }

  /// The arrays and objects that have begun and not ended. Only the last of them grows, so the pointers stay
  /// valid.
  std::vector<Json*> open_;
};

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

const Json& Json::absent() {
  static const Json none(Kind::absent, 0);
  return none;
}

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

const Json& Json::member(std::string_view name) const {
  for (const Member& member : members_)
    if (member.first == name) return member.second;
  return absent();
}

Json* Json::find(std::string_view name) {
  for (Member& member : members_)
    if (member.first == name) return &member.second;
  return nullptr;
}

const Json& Json::at(std::string_view name) const {
  const Json& found = member(name);
  if (found.isAbsent()) fail("lacks \"" + std::string(name) + "\"");
  return found;
}

const Json& Json::at(std::size_t index) const {
  if (index >= elements_.size()) fail("has no element " + std::to_string(index));
  return elements_[index];
}

Json& Json::operator[](std::string_view name) {
  if (isNull()) kind_ = Kind::object;
  if (!isObject()) fail("is no object, to have \"" + std::string(name) + "\"");
  if (Json* found = find(name)) return *found;
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

void Json::erase(std::string_view name) {
  std::erase_if(members_, [&](const Member& member) { return member.first == name; });
}

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

std::string Json::dump(int indent) const {
  return toLibrary(*this).dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

int Json::nesting(std::string_view text) {
  int depth = 0, deepest = 0;
  bool inString = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (inString) {
      if (c == '\\') ++i;
      if (c == '"') inString = false;
    } else if (c == '"') {
      inString = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

std::size_t Json::structureBytes(std::string_view text) {
  std::size_t bytes = text.size();
  for (std::size_t at = text.find('"'); at != std::string_view::npos; at = text.find('"', at + 1)) {
    const std::size_t begin = at + 1;
    for (++at; at < text.size() && text[at] != '"'; ++at)
      if (text[at] == '\\') ++at;
    const std::size_t length = std::min(at, text.size()) - begin;
    bytes -= length - std::min(length, kShortText);
  }
  return bytes;
}

Result<Json> Json::parse(std::string_view text, const std::function<void(double)>& progress) {
  if (nesting(text) > kMaxNesting)
    return Error{"is nested deeper than " + std::to_string(kMaxNesting) + " levels"};
  JsonBuilder builder;
  const bool read = progress
                        ? nlohmann::json::sax_parse(WatchedText(text, progress), WatchedText(text), &builder)
                        : nlohmann::json::sax_parse(text.begin(), text.end(), &builder);
  if (!read) return Error{builder.error};
  return std::move(builder.root);
}

}  // namespace tandem
