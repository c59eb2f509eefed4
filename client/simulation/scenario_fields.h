#pragma once

// Reads the objects of a scenario. Every reader throws a std::string, the place and the reason, for what is
// missing, of another kind or out of range.

#include <cmath>
#include <set>
#include <string>

#include "assets/base/json.h"
#include "client/simulation/scenario.h"

namespace tandem::client {

/// Reads the fields of one object and refuses fields that nobody reads.
class Fields {
 public:
  Fields(const Json& object, std::string where) : object_(object), where_(std::move(where)) {
    if (!object_.isObject()) throw where_ + ": must be an object";
  }
  bool has(const char* key) {
    known_.insert(key);
    return object_.contains(key);
  }
  double number(const char* key, double fallback, double least, double most) {
    if (!has(key)) return fallback;
    const Json& value = object_.at(key);
    if (!value.isNumber() || !std::isfinite(value.number()) || value.number() < least ||
        value.number() > most)
      throw where_ + ": \"" + key + "\" must be a number from " + short_(least) + " to " + short_(most);
    return value.number();
  }
  double required(const char* key, double least, double most) {
    if (!has(key)) throw where_ + ": lacks \"" + key + "\"";
    return number(key, 0.0, least, most);
  }
  std::string text(const char* key, const std::string& fallback) {
    if (!has(key)) return fallback;
    if (!object_.at(key).isText()) throw where_ + ": \"" + key + "\" must be a string";
    return object_.at(key).text();
  }
  std::string requiredText(const char* key) {
    if (!has(key)) throw where_ + ": lacks \"" + key + "\"";
    return text(key, "");
  }
  const Json& list(const char* key) {
    static const Json empty = Json::array();
    if (!has(key)) return empty;
    if (!object_.at(key).isArray()) throw where_ + ": \"" + key + "\" must be a list";
    return object_.at(key);
  }
  const Json& operator[](const char* key) { return object_.at(key); }
  const std::string& where() const { return where_; }
  /// Throws if the object has a key that was not read: a misspelt key must not be ignored.
  void refuseUnknown() const {
    for (const auto& [key, value] : object_.members())
      if (!known_.count(key)) throw where_ + ": does not know \"" + key + "\"";
  }

 private:
  static std::string short_(double value) {
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
  }
  const Json& object_;
  std::string where_;
  std::set<std::string> known_;
};

/// Reads an entry of the scenario's "faults".
Fault parseFault(const Json& entry, const std::string& where);
/// The entry that parseFault() reads.
Json faultJson(const Fault& fault);

}  // namespace tandem::client
