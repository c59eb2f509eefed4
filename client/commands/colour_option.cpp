#include "client/commands/colour_option.h"

#include <cstdint>
#include <cstdio>

namespace tandem::client {

Result<sync::SiteColour> parseColour(const std::string& text) {
  unsigned value = 0;
  char rest = 0;
  if (text.size() != 7 || std::sscanf(text.c_str(), "#%6x%c", &value, &rest) != 1)
    return Error{"--colour " + text + ": must be #RRGGBB"};
  if (value == 0) value = 0x010101;
  return sync::SiteColour{static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
                          static_cast<std::uint8_t>(value)};
}

}  // namespace tandem::client
