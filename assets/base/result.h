#pragma once

// The error type that every folder returns for operating errors: bad files, bad packets, lost devices.
//
// 1. A programmer's error is an ASSERT (assets/base/assert.h), never a Result.
// 2. The message is one line that names the file (or peer), the place and the reason.

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "assets/base/assert.h"

namespace tandem {

/// Why something could not be done, in one line fit for a person.
struct Error {
  std::string message;
};

/// Either a value or the reason why there is none (std::expected is not in g++ 12).
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Error error) : state_(std::move(error)) {}

  explicit operator bool() const { return ok(); }
  bool ok() const { return std::holds_alternative<T>(state_); }

  T& value() & {
    ASSERT(ok());
    return *std::get_if<T>(&state_);
  }
  const T& value() const& {
    ASSERT(ok());
    return *std::get_if<T>(&state_);
  }
  T&& value() && {
    ASSERT(ok());
    return std::move(*std::get_if<T>(&state_));
  }
  const Error& error() const {
    ASSERT(!ok());
    return *std::get_if<Error>(&state_);
  }

  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }

 private:
  std::variant<T, Error> state_;
};

/// Success without a value, or the reason of the failure.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}

  explicit operator bool() const { return ok(); }
  bool ok() const { return !error_.has_value(); }
  const Error& error() const {
    ASSERT(!ok());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace tandem
