#include "client/commands/tool_option.h"

#include <cstdlib>

namespace tandem::client {

Result<std::optional<double>> parseTip(const std::string& text, const char* forms) {
  constexpr double kLargestRadius = 1e4;  // m
  if (text.empty()) return std::optional<double>();
  if (text == "point") return std::optional<double>(0.0);
  if (text.rfind("ball:", 0) != 0) return Error{"--tool " + text + ": must be " + forms};
  char* end = nullptr;
  const double radius = std::strtod(text.c_str() + 5, &end);
  if (*end != '\0' || !(radius >= 1e-9 && radius <= kLargestRadius))
    return Error{"--tool " + text + ": the radius must be a number of metres from 1e-9 to 1e4"};
  return std::optional<double>(radius);
}

}  // namespace tandem::client
