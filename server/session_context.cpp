#include "server/session_context.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr std::size_t kMaxLogLines = 1000;  // between two calls of drain()

}  // namespace

void SessionLog::note(std::string line, SiteId site) {
  if (lines_.size() < kMaxLogLines) lines_.push_back({std::move(line), false, site});
}

void SessionLog::error(std::string line) { lines_.push_back({std::move(line), true, kNoSite}); }

std::vector<LogLine> SessionLog::drain() { return std::exchange(lines_, {}); }

void SessionContext::advance(sync::Micros now, std::int64_t unixNow) {
  now_ = std::max(now_, now);
  unixNow_ = unixNow;
  ASSERT(now_ >= now);
}

}  // namespace tandem::server
