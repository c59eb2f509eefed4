#pragma once

// Spreads independent work over the cores while a scene is prepared. Not for ticks.

#include <cstddef>
#include <functional>

namespace tandem {

/// Calls work(i) once for every i in [0, count), on up to all cores including the calling thread, and returns
/// when all calls are done. The order is undefined, so each call must write to a place of its own.
/// `progress`, if set, is called from the calling thread only, with the number of items begun so far. An
/// exception from `work` stops the rest, and the exception of the smallest i that threw is thrown again here.
/// The same file thus gives the same error whatever the timing.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& work,
                 const std::function<void(std::size_t)>& progress = {});

}  // namespace tandem
