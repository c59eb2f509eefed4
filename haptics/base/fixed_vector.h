#pragma once

// A list of at most N elements in place: an array and its count as one value, for code that must not
// allocate.

#include <cstddef>
#include <utility>

#include <boost/container/static_vector.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {

/// boost::container::static_vector with checked growth and access; a full list is the caller's error.
template <typename T, std::size_t N>
class FixedVector {
  using Elements = boost::container::static_vector<T, N>;

 public:
  static constexpr std::size_t capacity() { return N; }
  std::size_t size() const { return elements_.size(); }
  bool empty() const { return elements_.empty(); }
  bool full() const { return elements_.size() == N; }

  T& operator[](std::size_t i) {
    ASSERT(i < elements_.size());
    return elements_[i];
  }
  const T& operator[](std::size_t i) const {
    ASSERT(i < elements_.size());
    return elements_[i];
  }
  T& back() { return (*this)[elements_.size() - 1]; }
  const T& back() const { return (*this)[elements_.size() - 1]; }

  T& push_back(T element) {
    ASSERT(!full());
    elements_.push_back(std::move(element));
    return elements_.back();
  }
  void pop_back() {
    ASSERT(!empty());
    elements_.pop_back();
  }
  /// Inserts before `at`; the elements from there on move up.
  void insert(typename Elements::const_iterator at, T element) {
    ASSERT(!full());
    elements_.insert(at, std::move(element));
  }
  /// Keeps the first `count` elements.
  void shrink(std::size_t count) {
    ASSERT(count <= elements_.size());
    elements_.erase(elements_.begin() + static_cast<std::ptrdiff_t>(count), elements_.end());
  }
  /// Removes an element; those after it move down.
  void erase(typename Elements::const_iterator at) {
    ASSERT(at != end());
    elements_.erase(at);
  }
  void clear() { elements_.clear(); }

  auto begin() { return elements_.begin(); }
  auto begin() const { return elements_.begin(); }
  auto end() { return elements_.end(); }
  auto end() const { return elements_.end(); }
  T* data() { return elements_.data(); }
  const T* data() const { return elements_.data(); }

 private:
  Elements elements_;
};

}  // namespace tandem::haptics
