#pragma once

// The order in which an assembly comes apart.

#include <cstddef>
#include <functional>
#include <vector>

#include "client/extraction/part_extraction.h"

namespace tandem::client {

struct ExtractionOrder {
  std::vector<PartId> order;      // of the parts that get out
  std::vector<Extraction> parts;  // of each part that a hand can take: its way, or what is in it at the end
};

/// Takes away all parts that get out, those with the simplest way first, and tries the rest again, until
/// none gets out. On all cores. `progress` is told the share done, 0..1, in the calling thread.
ExtractionOrder extractionOrder(PartExtractor& extractor, std::size_t parts,
                                const std::function<void(double)>& progress);

}  // namespace tandem::client
