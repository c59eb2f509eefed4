#pragma once

// JSON as a value: read from hostile text, built up by the programs that write results. The parser and the
// writer are nlohmann's, whose headers cost seconds to compile; json.cpp is the one source of the programs
// that includes them.
//
// 1. Members of an object keep the order in which they were added; parse() sorts them by name.
// 2. There are two ways to read. at() and the typed values throw JsonError for what is not there or is of
//    another kind. member() never throws: it returns an absent value, whose own members are absent too, so
//    that a path of optional members can be followed in one expression. References stay valid until the value
//    that holds them is changed.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/base/result.h"

namespace tandem {

/// A member is missing or a value is of another kind than its reader needs. The message names it.
class JsonError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Json {
 public:
  enum class Kind : std::uint8_t { absent, null, boolean, integer, natural, real, text, array, object };
  using Member = std::pair<std::string, Json>;

  Json();  // null
  Json(std::nullptr_t);
  Json(bool value);
  Json(double value);
  Json(const char* value);
  Json(std::string value);
  Json(std::string_view value);
  template <std::signed_integral T>
  Json(T value) : Json(Kind::integer, static_cast<std::uint64_t>(static_cast<std::int64_t>(value))) {}
  template <std::unsigned_integral T>
  requires(!std::same_as<T, bool>) Json(T value) : Json(Kind::natural, static_cast<std::uint64_t>(value)) {}
  template <typename T>
  Json(const std::vector<T>& values) : Json(array()) {
    for (const T& value : values) push(value);
  }
  /// An object if every element is a pair of a text and a value, else an array.
  Json(std::initializer_list<Json> values);
  Json(const Json& other);
  Json(Json&& other) noexcept;
  Json& operator=(const Json& other);
  Json& operator=(Json&& other) noexcept;
  ~Json();

  static Json array();
  static Json object();
  /// The value that member() returns where there is none.
  static const Json& absent();

  Kind kind() const { return kind_; }
  bool isAbsent() const { return kind_ == Kind::absent; }
  bool isNull() const { return kind_ == Kind::null; }  // null counts as a value that is there
  bool isBoolean() const { return kind_ == Kind::boolean; }
  bool isNumber() const { return isInteger() || kind_ == Kind::real; }
  bool isInteger() const { return kind_ == Kind::integer || kind_ == Kind::natural; }
  /// A whole number that is written without a sign, a fraction and an exponent.
  bool isNatural() const { return kind_ == Kind::natural; }
  bool isText() const { return kind_ == Kind::text; }
  bool isArray() const { return kind_ == Kind::array; }
  bool isObject() const { return kind_ == Kind::object; }

  /// The value itself. Each throws JsonError for another kind; integer() also for what is negative or has a
  /// fraction.
  bool boolean() const;
  double number() const;
  std::uint64_t integer() const;
  std::int64_t signedInteger() const;  // of Kind::integer only
  const std::string& text() const;

  /// Elements or members; 0 of anything else.
  std::size_t size() const;
  bool empty() const { return size() == 0; }
  bool contains(std::string_view name) const { return !member(name).isAbsent(); }
  /// The member of that name; absent where there is none or this is no object.
  const Json& member(std::string_view name) const;
  /// The same to be changed; null where there is none.
  Json* find(std::string_view name);
  /// A member or an element that must be there; throws JsonError if it is not.
  const Json& at(std::string_view name) const;
  const Json& at(std::size_t index) const;
  /// The member of that name, added as null if there is none; null becomes an object. Throws JsonError for
  /// anything else.
  Json& operator[](std::string_view name);

  /// Appends an element; null becomes an array. Throws JsonError for anything else.
  void push(Json value);
  Json& back();
  /// Copies the members of another object into this one.
  void update(const Json& other);
  /// Removes a member if it is there.
  void erase(std::string_view name);

  const std::vector<Member>& members() const { return members_; }
  std::vector<Member>& members() { return members_; }
  const Json* begin() const { return elements_.data(); }
  const Json* end() const { return elements_.data() + elements_.size(); }
  Json* begin() { return elements_.data(); }
  Json* end() { return elements_.data() + elements_.size(); }

  /// A copy with every fraction rounded to nine significant digits: 1 nm of a pose, 1 ms of a day.
  Json rounded() const;

  /// The text; with an indent of 0 or more, one member a line. Bytes that are not UTF-8 become U+FFFD.
  std::string dump(int indent = -1) const;

  /// Reads hostile text. The error is the reason and the place on one line, without a file's name. Text that
  /// nests deeper than kMaxNesting is refused, so that what recurses over a value stays within the stack.
  /// `progress` is called with the share of the text that has been read, every megabyte.
  static Result<Json> parse(std::string_view text, const std::function<void(double)>& progress = {});
  static constexpr int kMaxNesting = 96;
  /// How deep the brackets outside of strings nest.
  static int nesting(std::string_view text);
  /// Bytes without what strings have beyond their first kShortText bytes: what memory and time go by, because
  /// a value takes them however short its text is.
  static std::size_t structureBytes(std::string_view text);
  static constexpr std::size_t kShortText = 256;

 private:
  friend class JsonBuilder;
  Json(Kind kind, std::uint64_t bits) : kind_(kind), bits_(bits) {}

  Kind kind_ = Kind::null;
  std::uint64_t bits_ = 0;  // of a boolean, a natural number or an integer
  double real_ = 0.0;
  std::string text_;
  std::vector<Json> elements_;
  std::vector<Member> members_;
};

}  // namespace tandem
