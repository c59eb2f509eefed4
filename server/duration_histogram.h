#pragma once

// How long something took, counted by bounds, as a cumulative histogram shows it.

#include <array>
#include <cstddef>
#include <cstdint>

#include "sync/wire/time.h"

namespace tandem::server {

struct DurationHistogram {
  static constexpr std::array<sync::Micros, 12> kBounds = {50,   100,   250,   500,    1000,   2500,
                                                           5000, 10000, 25000, 100000, 500000, 2500000};
  std::array<std::uint64_t, kBounds.size() + 1> counts{};  // each within its bound and beyond the one below
  sync::Micros sum = 0;

  void add(sync::Micros duration) {
    std::size_t at = 0;
    while (at < kBounds.size() && duration > kBounds[at]) ++at;
    ++counts[at];
    sum += duration;
  }
};

}  // namespace tandem::server
