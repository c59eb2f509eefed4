#pragma once

namespace tandem::test {

/// The most energy that a session may create (J).
inline constexpr double kEnergyBound = 1e-3;

}  // namespace tandem::test
