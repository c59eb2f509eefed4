#pragma once

#include <string>
#include <string_view>

namespace tandem {

/// The whole path of a file of the project; `path` begins at its top folder, as in "assets/scenes/pump.glb".
/// source_file.cpp alone is compiled with the place of the checkout; all else is the same in every checkout.
std::string sourceFile(std::string_view path);

}  // namespace tandem
