#pragma once

// How much each network has used of late: every use counts 1 at first and fades exponentially. Internal to
// the transport.
//
// 1. All counts fade alike, so their order changes only with a use; it is kept by the logarithm of what a
//    count would have been worth at time 0.
// 2. The table is bounded: who was not seen for longest is forgotten.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <list>
#include <unordered_map>

#include "sync/wire/time.h"

namespace tandem::sync {

class RecentUse {
 public:
  /// `memory`: after which time a use counts 1/e.
  explicit RecentUse(Micros memory) : memory_(memory) {}

  static constexpr std::size_t kMaxKeys = 8192;
  static constexpr double kNone = -std::numeric_limits<double>::infinity();

  /// Orders keys by what they have used, the same at any time.
  double order(std::uint64_t key) const;
  /// What the key has used, as of now.
  double count(std::uint64_t key, Micros now) const;
  void add(std::uint64_t key, Micros now);
  /// Takes a use back that was added at that time.
  void takeBack(std::uint64_t key, Micros at);

 private:
  struct Entry {
    double order = kNone;
    std::list<std::uint64_t>::iterator place;
  };
  Micros memory_;
  std::unordered_map<std::uint64_t, Entry> entries_;
  std::list<std::uint64_t> oldestFirst_;
};

}  // namespace tandem::sync
