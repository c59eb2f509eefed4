#pragma once

// The latest value from one thread to another: wait-free on both sides, so a 1 kHz thread may stand on
// either.
//
// 1. One producer thread, one consumer thread.
// 2. The consumer sees whole values only, and never an older one after a newer one. Values in between may be
// skipped.

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace tandem::haptics {

template <typename T>
class TripleBuffer {
  // GLM's types copy member by member but are not "trivially copyable" to the compiler; what owns memory
  // has a destructor of its own, and that is what must not be here.
  static_assert(std::is_trivially_destructible_v<T>, "a copy must neither allocate nor throw");

 public:
  explicit TripleBuffer(const T& initial = T{}) : slots_{initial, initial, initial} {}
  TripleBuffer(const TripleBuffer&) = delete;
  TripleBuffer& operator=(const TripleBuffer&) = delete;

  /// Producer: publishes a value.
  void write(const T& value) {
    slots_[back_] = value;
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kNew), std::memory_order_acq_rel) & kIndex;
  }

  /// Consumer: the latest published value, or the initial one. The reference holds until the next call of
  /// latest() or read() and must not be used by another thread.
  const T& latest() {
    takeNew();
    return slots_[front_];
  }

  /// Consumer: copies the latest value to `out`; false when nothing was published since the last call (out is
  /// set all the same).
  bool read(T& out) {
    const bool isNew = takeNew();
    out = slots_[front_];
    return isNew;
  }

 private:
  static constexpr std::uint8_t kIndex = 3, kNew = 4;

  bool takeNew() {
    if ((middle_.load(std::memory_order_relaxed) & kNew) == 0) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  std::array<T, 3> slots_;
  alignas(64) std::uint8_t back_ = 0;  // the producer's
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t front_ = 2;  // the consumer's
};

}  // namespace tandem::haptics
