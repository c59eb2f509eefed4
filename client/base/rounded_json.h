#pragma once

// Numbers in result files without the tails that binary fractions have.

#include <nlohmann/json_fwd.hpp>

namespace tandem::client {

/// The same with every fraction rounded to nine significant digits: a poses' nm, a day's ms.
nlohmann::ordered_json rounded(nlohmann::ordered_json json);

}  // namespace tandem::client
