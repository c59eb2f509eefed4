#pragma once

// Spreads independent work over the cores while a scene is prepared. Never used in a tick.

#include <cstddef>
#include <functional>

namespace tandem {

/// Calls work(i) once for every i in [0, count), on up to all cores, the calling thread among them, and
/// returns when all are done. The order is not defined: results must go to places of their own. `progress`,
/// if set, is called from the calling thread only, with the number of items begun so far. An exception out of
/// `work` stops the rest; the one of the smallest i that threw is thrown again here, so that the same file
/// gives the same error whatever the timing.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& work,
                 const std::function<void(std::size_t)>& progress = {});

}  // namespace tandem
