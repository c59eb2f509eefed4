#pragma once

// Disk cache of distance fields, keyed by their inputs, one file per field. Two processes that bake the same
// field at the same time both bake it, without harm.

#include <optional>
#include <string>

#include "haptics/scene/distance_field.h"

namespace tandem::haptics {

/// The field of a mesh with `options`: read from `directory` (empty: no cache) if an intact file exists, else
/// baked and stored there, unless it was stopped. Files that cannot be read, written or validated cost only
/// time. `cached` reports whether the field was read. The number of threads affects neither the field nor its
/// key.
DistanceField cachedField(const TriangleBvh& tree, const DistanceField::Options& options,
                          const std::string& directory, bool& cached);

/// The cached field, if it can be read.
std::optional<DistanceField> readField(const TriangleBvh& tree, const DistanceField::Options& options,
                                       const std::string& directory);

}  // namespace tandem::haptics
