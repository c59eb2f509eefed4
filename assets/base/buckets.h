#pragma once

// Lists of numbers by key, in two arrays (a counting sort).

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace tandem {

/// The items of key k, 0 <= k < keys, in the order in which they came.
class Buckets {
 public:
  Buckets() = default;
  /// `forEach(add)` calls add(key, item) for every item, twice over and alike both times.
  template <typename ForEach>
  Buckets(std::size_t keys, ForEach&& forEach) : first_(keys + 1, 0) {
    forEach([this](std::size_t key, std::uint32_t) { ++first_[key + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    items_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    forEach([&](std::size_t key, std::uint32_t item) { items_[next[key]++] = item; });
  }
  std::size_t keys() const { return first_.empty() ? 0 : first_.size() - 1; }
  std::span<const std::uint32_t> operator[](std::size_t key) const {
    return {items_.data() + first_[key], first_[key + 1] - first_[key]};
  }

 private:
  std::vector<std::uint32_t> first_, items_;
};

}  // namespace tandem
