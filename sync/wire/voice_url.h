#pragma once

// Where people of a session talk to each other: a URL that the server names to all who join. It is shown in
// windows and terminals and may be opened, so that it is held to a few schemes and to printable ASCII.

#include <cstddef>
#include <string>

namespace tandem::sync {

inline constexpr std::size_t kMaxVoiceUrl = 256;  // bytes
inline constexpr const char* kVoiceSchemes = "http, https, mumble, sip, sips, teamspeak, ts3server or xmpp";

/// Whether it begins with one of these schemes, names something, and has no blank, quote, bracket or control
/// character.
bool isVoiceUrl(const std::string& text);

}  // namespace tandem::sync
