#pragma once

// What the queries of a thread have cost: counts that do not depend on the machine, for benches and tests.

#include <cstdint>

namespace tandem::haptics {

struct QueryWork {
  std::uint64_t queries = 0, nodes = 0, triangles = 0;  // triangles: tested in double precision

  QueryWork operator-(const QueryWork& before) const {
    return {queries - before.queries, nodes - before.nodes, triangles - before.triangles};
  }
};

/// Of all trees, since the thread began.
inline constinit thread_local QueryWork queryWork;

}  // namespace tandem::haptics
