#include "sync/wire/voice_url.h"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace tandem::sync {
namespace {

constexpr const char* kWithHost[] = {"http://", "https://", "mumble://", "ts3server://", "teamspeak://"};
constexpr const char* kWithoutHost[] = {"sip:", "sips:", "xmpp:"};

bool beginsAs(const std::string& text, std::string_view scheme) {
  return text.size() > scheme.size() &&
         std::equal(scheme.begin(), scheme.end(), text.begin(),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

/// RFC 3986's characters, without those that end a link in a text.
bool mayBeInUrl(unsigned char c) {
  return std::isalnum(c) != 0 ||
         std::string_view("-._~:/?#@!$&*+,;=%").find(char(c)) != std::string_view::npos;
}

}  // namespace

bool isVoiceUrl(const std::string& text) {
  if (text.size() > kMaxVoiceUrl || !std::all_of(text.begin(), text.end(), mayBeInUrl)) return false;
  for (const char* scheme : kWithHost)
    if (beginsAs(text, scheme))
      return std::isalnum(static_cast<unsigned char>(text[std::string_view(scheme).size()])) != 0;
  for (const char* scheme : kWithoutHost)
    if (beginsAs(text, scheme)) return text[std::string_view(scheme).size()] != '/';
  return false;
}

}  // namespace tandem::sync
