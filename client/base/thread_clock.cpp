#include "client/base/thread_clock.h"

#include <ctime>

#include "assets/base/assert.h"

namespace tandem::client {

double threadMicroseconds() {
  timespec now{};
  const int failed = clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  ASSERT(failed == 0);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace tandem::client
