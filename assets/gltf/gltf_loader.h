#pragma once

// The steps of loading, for loadGltf() and for the cache, which hashes the opened file before it builds the
// scene. For the loader's sources only.

#include <string>

#include "assets/gltf/gltf_document.h"
#include "assets/gltf/load_gltf.h"

namespace tandem::assets {

/// Opens the file and its external buffers; throws GltfError.
void openFromDisk(const std::string& path, const LoadOptions& options, GltfDocument& document);

/// The scene of an opened file; throws GltfError.
Scene buildScene(const std::string& name, GltfDocument& document, const LoadOptions& options);

/// The exception in flight as one line "name: place: reason". Call it from a catch block only.
Error describeError(const std::string& name);

}  // namespace tandem::assets
