#pragma once

#include <numbers>

namespace tandem {

inline constexpr double kPi = std::numbers::pi;

}  // namespace tandem
