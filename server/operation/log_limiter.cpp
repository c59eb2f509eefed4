#include "server/operation/log_limiter.h"

#include <cctype>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr std::size_t kKeyLength = 160;

/// The line with each number as one #.
std::string kindOf(const std::string& text) {
  std::string kind;
  for (const char c : text.substr(0, kKeyLength)) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (!digit)
      kind += c;
    else if (kind.empty() || kind.back() != '#')
      kind += '#';
  }
  return kind;
}

}  // namespace

bool LogLimiter::admit(const LogLine& line, sync::Micros now) {
  if (line.error) return true;
  std::string name = kindOf(line.text);
  if (kinds_.size() >= kKinds && !kinds_.contains(name)) name = "others";
  const auto [at, isNew] = kinds_.try_emplace(std::move(name));
  Kind& kind = at->second;
  if (isNew) kind.begun = now;
  ASSERT(kind.written <= kLines && kinds_.size() <= kKinds + 1);
  if (kind.written < kLines) {
    ++kind.written;
    return true;
  }
  ++kind.leftOut;
  kind.latest = line;
  return false;
}

std::vector<LogLine> LogLimiter::drainCounts(sync::Micros now) {
  std::vector<LogLine> lines;
  for (auto at = kinds_.begin(); at != kinds_.end();) {
    const Kind& kind = at->second;
    if (now - kind.begun < kWindow) {
      ++at;
      continue;
    }
    if (kind.leftOut > 0) {
      lines.push_back(kind.latest);
      lines.back().text = "... " + std::to_string(kind.leftOut) + " more in " +
                          std::to_string((now - kind.begun) / sync::kSecond) + " s: " + kind.latest.text;
    }
    at = kinds_.erase(at);
  }
  return lines;
}

}  // namespace tandem::server
