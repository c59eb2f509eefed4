#pragma once

// Distance fields kept on disk by what they were made from: a part that collided yesterday collides at once
// today. One file a field; who bakes the same one in two processes at a time bakes it twice, that is all.

#include <optional>
#include <string>

#include "haptics/scene/distance_field.h"

namespace tandem::haptics {

/// The field of a mesh as `options` ask for it: read from `directory` (empty: none is kept) if it is there and
/// is whole, else baked and written there. What cannot be read, written or believed costs time only. `cached`
/// becomes whether it was read. The number of threads makes no difference to the field, nor to what it is
/// found by.
DistanceField cachedField(const TriangleBvh& tree, const DistanceField::Options& options,
                          const std::string& directory, bool& cached);

/// The same, if it can be read.
std::optional<DistanceField> readField(const TriangleBvh& tree, const DistanceField::Options& options,
                                       const std::string& directory);

}  // namespace tandem::haptics
