#pragma once

// The program's log on standard error: lines for a person, or one JSON object a line for journald and what
// reads it.

#include <cstdint>
#include <string>

#include "server/operation/log_limiter.h"
#include "server/session_context.h"

namespace tandem::server {

/// A log line as JSON: {"time":"..Z","level":"..","session":"..","site":..,"message":".."}; `session` and
/// `site` are left out where they are empty. Any bytes give valid JSON.
std::string logLineInJson(std::int64_t unixTime_ms, const std::string& level, const std::string& session,
                          SiteId site, const std::string& message);

/// Makes the program's default log (spdlog). Call it once, before any line.
void startLog(bool quiet, bool json);
/// The session that JSON lines name from now on.
void nameSessionInLog(const std::string& session);

/// Writes a session's lines, each kind within its limit.
class SessionLogWriter {
 public:
  void write(const std::vector<LogLine>& lines, sync::Micros now);

 private:
  LogLimiter limiter_;
};

}  // namespace tandem::server
