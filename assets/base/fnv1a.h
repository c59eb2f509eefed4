#pragma once

// A hash that tells whether two runs or two pictures were the same. It resists no attacker.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace tandem {

/// The 64-bit FNV-1a hash of a sequence of bytes (Fowler, Noll and Vo,
/// http://www.isthe.com/chongo/tech/comp/fnv).
class Fnv1a {
 public:
  void addBytes(const void* bytes, std::size_t count) {
    const auto* next = static_cast<const unsigned char*>(bytes);
    for (std::size_t i = 0; i < count; ++i) hash_ = (hash_ ^ next[i]) * kPrime;
  }
  /// Adds the bytes of a value as they stand in memory: -0.0 and 0.0 differ.
  template <typename T>
  void add(const T& value) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    addBytes(bytes, sizeof(T));
  }
  /// Adds the components of a vector or quaternion of GLM.
  template <typename T>
  void addComponents(const T& vector) {
    for (typename T::length_type i = 0; i < T::length(); ++i) add(vector[i]);
  }
  std::uint64_t value() const { return hash_; }

 private:
  static constexpr std::uint64_t kOffsetBasis = 14695981039346656037ull, kPrime = 1099511628211ull;
  std::uint64_t hash_ = kOffsetBasis;
};

}  // namespace tandem
