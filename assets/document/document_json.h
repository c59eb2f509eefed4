#pragma once

// The document as one JSON file: {"tandem_document": 1, "scene": "..", "entries": [{"id", "kind", "author",
// "made", "changed", and the fields of the kind by their names in describe.h}]}. Parts are numbers, so that
// the file belongs to one scene.

#include <string>
#include <vector>

#include "assets/base/result.h"
#include "assets/document/document.h"

namespace tandem::document {

inline constexpr std::size_t kMaxFileBytes = std::size_t{64} << 20;

/// The entries that are not removed, one a line, by id. `scene` is the hash of the scene package in
/// hexadecimal digits.
std::string toJson(const Document& document, const std::string& scene);

struct DocumentFile {
  std::string scene;
  std::vector<Entry> entries;  // an entry that is referred to comes before those that refer to it
};
/// Reads the text of such a file, whole or not at all. Members that are not known are refused. The error
/// names `source`, the entry and the reason.
Result<DocumentFile> fromJson(const std::string& text, const std::string& source);

}  // namespace tandem::document
