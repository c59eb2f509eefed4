#pragma once

// Numbers as tables for people show them: few digits, no exponents, each with its unit.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "haptics/tick.h"

namespace tandem::client {

/// Three significant digits, more where the whole part has more; "<0.001" for less than that.
std::string threeDigits(double value);

/// A length in m, as "1.31 mm" or "0.4 um".
std::string readableLength(double length);

/// A mass in kg, as "28 g", "1.61 kg" or "33.7 t".
std::string readableMass(double mass);

/// "512 B", "1.21 kB", "3.4 MB".
std::string readableBytes(std::size_t bytes);

/// "Ada", "Ada and Ben", "Ada, Ben and Cid".
std::string listed(const std::vector<std::string>& names);

/// A Unix time in s by this machine's clock: "14:05", of another day than `now` "27 Nov 14:05", of another
/// year "27 Nov 2025".
std::string clockTime(std::int64_t unix, std::int64_t now);

/// How stiffly the hands of co-holders are felt, and at which delay: "stiff (27 ms)"; empty if nobody shares
/// the part.
std::string linkInWords(const haptics::LinkReport& links);

}  // namespace tandem::client
