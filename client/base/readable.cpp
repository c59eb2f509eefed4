#include "client/base/readable.h"

#include <cmath>
#include <cstdio>
#include <ctime>

namespace tandem::client {

std::string threeDigits(double value) {
  const double size = std::abs(value);
  if (size > 0.0 && size < 1e-3) return "<0.001";
  char text[64];
  std::snprintf(text, sizeof text, size < 999.5 ? "%.3g" : "%.0f", value);
  return text;
}

std::string readableLength(double length) {
  const double size = std::abs(length);
  if (size >= 0.9995) return threeDigits(length) + " m";
  if (size >= 0.9995e-3) return threeDigits(1e3 * length) + " mm";
  return threeDigits(1e6 * length) + " um";
}

std::string readableMass(double mass) {
  if (mass >= 999.5) return threeDigits(1e-3 * mass) + " t";
  if (mass >= 0.9995) return threeDigits(mass) + " kg";
  return threeDigits(1e3 * mass) + " g";
}

std::string readableBytes(std::size_t bytes) {
  const auto size = static_cast<double>(bytes);
  if (size >= 999.5e6) return threeDigits(1e-9 * size) + " GB";
  if (size >= 999.5e3) return threeDigits(1e-6 * size) + " MB";
  if (size >= 999.5) return threeDigits(1e-3 * size) + " kB";
  return threeDigits(size) + " B";
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

std::string clockTime(std::int64_t unix, std::int64_t now) {
  constexpr const char* kMonths[] = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                     "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const auto local = [](std::int64_t time) {
    const auto seconds = static_cast<std::time_t>(time);
    std::tm parts{};
    ::localtime_r(&seconds, &parts);
    return parts;
  };
  const std::tm then = local(unix), today = local(now);
  char text[48];
  if (then.tm_year != today.tm_year)
    std::snprintf(text, sizeof text, "%d %s %d", then.tm_mday, kMonths[then.tm_mon % 12],
                  1900 + then.tm_year);
  else if (then.tm_yday != today.tm_yday)
    std::snprintf(text, sizeof text, "%d %s %02d:%02d", then.tm_mday, kMonths[then.tm_mon % 12], then.tm_hour,
                  then.tm_min);
  else
    std::snprintf(text, sizeof text, "%02d:%02d", then.tm_hour, then.tm_min);
  return text;
}

std::string linkInWords(const haptics::LinkReport& links) {
  if (links.live == 0) return "";
  const bool one = links.live == 1;
  char delay[32];
  std::snprintf(delay, sizeof delay, " (%.0f ms)", 1e3 * links.delay);
  if (!links.heard) return one ? "nothing is heard of the other hand" : "nothing is heard of one of them";
  if (links.regime == haptics::LinkRegime::apart)
    return std::string("one at a time: too far away to be felt") + delay;
  if (links.fade < 0.99 || !links.fresh) return "coming up";
  return (links.regime == haptics::LinkRegime::stiff ? "stiff" : "soft: far away") + std::string(delay);
}

}  // namespace tandem::client
