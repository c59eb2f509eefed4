#include "assets/base/utc_time.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <string_view>

namespace tandem {
namespace {

constexpr std::int64_t kDay = 86400;                                 // s
constexpr std::int64_t kFirst = -62135596800, kLast = 253402300799;  // the years 1 to 9999, Unix time, s

/// Takes digits and signs off the front of a text; what does not fit makes it fail for good.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : rest_(text) {}

  int number(std::size_t digits) {
    int value = 0;
    for (std::size_t i = 0; i < digits; ++i) {
      if (rest_.empty() || rest_.front() < '0' || rest_.front() > '9') {
        failed_ = true;
        return 0;
      }
      value = 10 * value + (rest_.front() - '0');
      rest_.remove_prefix(1);
    }
    return value;
  }
  bool sign(char expected) {
    if (rest_.empty() || rest_.front() != expected) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void need(char expected) { failed_ = !sign(expected) || failed_; }
  void fraction() {
    if (!sign('.')) return;
    number(1);
    while (!rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9') rest_.remove_prefix(1);
  }
  /// Whether all of the text was taken.
  bool done() const { return !failed_ && rest_.empty(); }

 private:
  std::string_view rest_;
  bool failed_ = false;
};

}  // namespace

std::int64_t systemUnixTime() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string utcText(std::int64_t unix) {
  namespace chrono = std::chrono;
  const std::int64_t time = std::clamp(unix, kFirst, kLast);
  const std::int64_t day = (time - kFirst) / kDay + kFirst / kDay, second = time - day * kDay;
  const chrono::year_month_day date{chrono::sys_days(chrono::days(day))};
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02dZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(second / 3600), static_cast<int>(second / 60 % 60),
                static_cast<int>(second % 60));
  return text.data();
}

std::optional<std::int64_t> utcTime(const std::string& text) {
  namespace chrono = std::chrono;
  Scanner scanner(text);
  const int year = scanner.number(4);
  scanner.need('-');
  const int month = scanner.number(2);
  scanner.need('-');
  const int day = scanner.number(2);
  scanner.need('T');
  const int hour = scanner.number(2);
  scanner.need(':');
  const int minute = scanner.number(2);
  scanner.need(':');
  const int second = scanner.number(2);
  scanner.fraction();
  int offset = 0;  // minutes
  if (!scanner.sign('Z')) {
    const bool east = scanner.sign('+'), west = !east && scanner.sign('-');
    if (east || west) {
      offset = 60 * scanner.number(2);
      scanner.need(':');
      offset += scanner.number(2);
      if (west) offset = -offset;
    }
  }
  const chrono::year_month_day date{chrono::year(year), chrono::month(static_cast<unsigned>(month)),
                                    chrono::day(static_cast<unsigned>(day))};
  // A leap second, and the hour 24 that ends a day, count as what follows them.
  const bool fits = (hour < 24 || (hour == 24 && minute == 0 && second == 0)) && minute < 60 && second <= 60;
  if (!scanner.done() || year < 1 || !date.ok() || !fits || std::abs(offset) > 14 * 60) return std::nullopt;
  const std::int64_t days = chrono::sys_days(date).time_since_epoch().count();
  return days * kDay + hour * 3600 + minute * 60 + second - offset * 60;
}

}  // namespace tandem
