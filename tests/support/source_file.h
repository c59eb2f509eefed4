#pragma once

#include <string>
#include <string_view>

namespace tandem {

/// The path of a file of this checkout; `path`: from its top folder, as in "assets/scenes/pump.glb". One
/// object alone holds where the checkout is, so all others are the same in every checkout.
std::string sourceFile(std::string_view path);

}  // namespace tandem
