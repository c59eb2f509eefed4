#include "server/operation/server_log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "assets/base/utc_time.h"

namespace tandem::server {
namespace {

// What a line's formatter adds. One thread logs.
std::string sessionName;
SiteId currentSite = kNoSite;

class JsonFormatter : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& line, spdlog::memory_buf_t& out) override {
    const auto since = line.time.time_since_epoch();
    const std::string text =
        logLineInJson(std::chrono::duration_cast<std::chrono::milliseconds>(since).count(),
                      std::string(spdlog::level::to_string_view(line.level).data()), sessionName, currentSite,
                      std::string(line.payload.data(), line.payload.size())) +
        '\n';
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override { return std::make_unique<JsonFormatter>(); }
};

void writeOne(const LogLine& line) {
  currentSite = line.site;
  spdlog::log(line.error ? spdlog::level::err : spdlog::level::info, "{}", line.text);
  currentSite = kNoSite;
}

}  // namespace

std::string logLineInJson(std::int64_t unixTime_ms, const std::string& level, const std::string& session,
                          SiteId site, const std::string& message) {
  std::string time = utcText(unixTime_ms / 1000);
  std::array<char, 8> fraction{};
  std::snprintf(fraction.data(), fraction.size(), ".%03d", static_cast<int>(unixTime_ms % 1000));
  time.insert(time.size() - 1, fraction.data());
  nlohmann::ordered_json object{{"time", time}, {"level", level}};
  if (!session.empty()) object["session"] = session;
  if (site != kNoSite) object["site"] = site;
  object["message"] = message;
  return object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void startLog(bool quiet, bool json) {
  auto log = spdlog::stderr_color_mt("tandem-server");
  if (json)
    log->set_formatter(std::make_unique<JsonFormatter>());
  else
    log->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
  log->set_level(quiet ? spdlog::level::warn : spdlog::level::info);
  spdlog::set_default_logger(log);
}

void nameSessionInLog(const std::string& session) { sessionName = session; }

void SessionLogWriter::write(const std::vector<LogLine>& lines, sync::Micros now) {
  for (const LogLine& line : limiter_.drainCounts(now)) writeOne(line);
  for (const LogLine& line : lines)
    if (limiter_.admit(line, now)) writeOne(line);
}

}  // namespace tandem::server
