#pragma once

// Events in order from one thread to another: wait-free on both sides, fixed capacity.
//
// 1. One producer thread, one consumer thread.
// 2. Nothing is lost silently: push() returns false when the ring is full, and dropped() counts.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace tandem::haptics {

/// Holds up to N elements; N is a power of two.
template <typename T, std::size_t N>
class SpscRing {
  static_assert(N >= 2 && (N & (N - 1)) == 0, "the capacity is a power of two");
  // GLM's types copy member by member but are not "trivially copyable" to the compiler; what owns memory
  // has a destructor of its own, and that is what must not be here.
  static_assert(std::is_trivially_destructible_v<T>, "a copy must neither allocate nor throw");

 public:
  SpscRing() = default;
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  /// Producer: appends; false (and counted) when full.
  [[nodiscard]] bool push(const T& value) {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == N) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[tail & (N - 1)] = value;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer: takes the oldest; false when empty.
  [[nodiscard]] bool pop(T& out) {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    out = slots_[head & (N - 1)];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Elements inside; from another thread a snapshot.
  std::size_t size() const {
    const std::size_t head = head_.load(std::memory_order_acquire);
    return tail_.load(std::memory_order_acquire) - head;
  }

  /// Pushes that found the ring full; any thread.
  std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  static constexpr std::size_t capacity() { return N; }

 private:
  std::array<T, N> slots_{};
  alignas(64) std::atomic<std::size_t> head_{0};  // written by the consumer
  alignas(64) std::atomic<std::size_t> tail_{0};  // written by the producer
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace tandem::haptics
