#pragma once

// The path of the proxy within a tick, for tests and reports: whether a ball could have gone the same way
// cannot be seen from where the proxy is at the ends of ticks.

#include <vector>

#include <glm/vec3.hpp>

namespace tandem::haptics {

/// A straight move, m, world.
struct ProxyMove {
  glm::dvec3 from{0.0, 0.0, 0.0}, to{0.0, 0.0, 0.0};
};

/// Receives every move of this thread's proxies, those included that are taken back in the same tick. A test
/// or a report sets it; at a hand it stays null, so that moves are not recorded and nothing is allocated.
inline constinit thread_local std::vector<ProxyMove>* proxyTrace = nullptr;

}  // namespace tandem::haptics
