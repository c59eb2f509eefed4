#pragma once

#include <chrono>

#include "sync/wire/time.h"

namespace tandem::client {

/// This machine's monotonic clock.
inline sync::Micros localTime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace tandem::client
