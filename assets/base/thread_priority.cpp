#include "assets/base/thread_priority.h"

#include <sys/resource.h>

namespace tandem {

void lowerThreadPriority() {
  constexpr int kNiceness = 10;
  // On Linux a priority belongs to a thread, and the threads that it starts inherit it; the rest of the
  // process keeps its own. Where the system refuses, the thread competes as any other.
  static_cast<void>(::setpriority(PRIO_PROCESS, 0, kNiceness));
}

}  // namespace tandem
