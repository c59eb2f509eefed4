#pragma once

// A glTF file, opened: its container, its JSON and its buffers, with every reference checked. Only the
// loader's own sources (gltf_*.cpp, load_gltf.cpp) include this header.
//
// 1. After openGltf() every index between the sections of the file is in range, and every property that the
//    loader uses has the type that the specification gives it.
// 2. Byte ranges are checked where the bytes are read (gltf_decode.h), not by openGltf().
// 3. The JSON is checked before tinygltf reads the model from it (gltf_model.h).
// 4. A broken file is thrown as GltfError inside the loader, because it may be found ten calls deep and on
//    any thread; the functions of load_gltf.h turn the exception into an Error.

#include <string>
#include <vector>

#include "assets/base/json.h"
#include "assets/gltf/gltf_error.h"
#include "assets/gltf/gltf_model.h"
#include "assets/gltf/gltf_source.h"
#include "assets/gltf/load_gltf.h"

namespace tandem::assets {

/// Text of a file, fit to be shown on one line: cut to 200 bytes between characters, control characters
/// replaced.
std::string cleanText(std::string text);

/// An opened file. Not movable: ranges point into it.
struct GltfDocument {
  GltfDocument() = default;
  GltfDocument(const GltfDocument&) = delete;
  GltfDocument& operator=(const GltfDocument&) = delete;

  /// GltfSource::requireUnchanged() of all files.
  void requireUnchanged() const;

  GltfSource file;                       // the file itself
  std::vector<GltfSource> ownedBuffers;  // per buffer: from a data URI or a file of its own, else empty
  std::vector<GltfRange> buffers;  // per buffer: its byteLength bytes; empty for a meshopt fallback buffer
  std::vector<const GltfSource*> externals;  // buffers that came from files of their own
  Json json;                                 // the whole document; extensions and extras are read from here
  GltfModel model;                           // the core sections; filled by readModel(), not by openGltf()
  std::vector<GltfSource> ownedViews;        // per buffer view: decompressed by meshopt, else empty
};

/// Opens a file: .glb by its magic number, else .gltf. Fills all but the model. `directory` is where external
/// buffers lie; a null pointer forbids them.
void openGltf(GltfSource file, const std::string* directory, const LoadOptions& options,
              GltfDocument& document);

/// Names of extensions, of the keys "extensionsUsed" or "extensionsRequired".
std::vector<std::string> extensionNames(const GltfDocument& document, const char* key);

/// object.extensions[name] if it is there and an object, else absent.
const Json& findExtension(const Json& object, const char* name);

}  // namespace tandem::assets
