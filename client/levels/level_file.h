#pragma once

// Levels kept on disk under the content of their mesh, beside the fields of contact.

#include <optional>
#include <string>
#include <vector>

#include "assets/scene/scene_package.h"
#include "client/levels/mesh_levels.h"

namespace tandem::client {

/// Of all that levels are made of: two meshes of one content have the same levels.
assets::ContentHash levelContent(const assets::Mesh& mesh);

/// The levels kept in `directory` (empty: none are); nothing if there is no intact file.
std::optional<std::vector<Level>> readLevels(const std::string& directory,
                                             const assets::ContentHash& content);
/// What cannot be written costs only the time to make it again.
void keepLevels(const std::string& directory, const assets::ContentHash& content,
                const std::vector<Level>& levels);

}  // namespace tandem::client
