#pragma once

// Times as files write them: xs:dateTime of XML Schema, ISO 8601.

#include <cstdint>
#include <optional>
#include <string>

namespace tandem {

/// The time now: Unix time, s.
std::int64_t systemUnixTime();

/// "2026-03-09T14:05:00Z". `unix`: Unix time, s; what lies outside of the years 1 to 9999 is moved to their
/// ends.
std::string utcText(std::int64_t unix);

/// Unix time in s of a text such as "2026-03-09T14:05:00.250+01:00"; a fraction is dropped, and a time
/// without a zone counts as UTC. Nothing if the text is no time of the years 1 to 9999.
std::optional<std::int64_t> utcTime(const std::string& text);

}  // namespace tandem
