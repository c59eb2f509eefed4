#include "assets/base/number_option.h"

#include <cstdio>
#include <cstdlib>

namespace tandem::assets {

std::function<std::string(const std::string&)> numberFrom(double least, double most) {
  return [least, most](const std::string& text) -> std::string {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (!text.empty() && *end == '\0' && value >= least && value <= most) return "";
    char message[96];
    std::snprintf(message, sizeof message, "must be a number from %g to %g, not ", least, most);
    return message + text;
  };
}

}  // namespace tandem::assets
