#pragma once

// The processor time of the calling thread: the cost of a tick, whatever else the machine does meanwhile.

namespace tandem::client {

/// us, from an arbitrary beginning.
double threadMicroseconds();

}  // namespace tandem::client
