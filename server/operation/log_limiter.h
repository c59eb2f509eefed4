#pragma once

// Keeps a log readable in a flood: of lines that differ in numbers only, the first few in ten seconds are
// written, and the rest are counted ("... 312 more in 10 s: ...").

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "server/session_context.h"
#include "sync/wire/time.h"

namespace tandem::server {

class LogLimiter {
 public:
  static constexpr sync::Micros kWindow = 10 * sync::kSecond;
  static constexpr int kLines = 20;           // of one kind in a window
  static constexpr std::size_t kKinds = 200;  // that are told apart; lines beyond are of one kind

  /// Whether the line is to be written. Errors always are.
  bool admit(const LogLine& line, sync::Micros now);
  /// A line for each kind whose window is over and of which lines were left out.
  std::vector<LogLine> drainCounts(sync::Micros now);

 private:
  struct Kind {
    sync::Micros begun = 0;
    int written = 0;
    std::uint64_t leftOut = 0;
    LogLine latest;
  };
  std::map<std::string, Kind> kinds_;
};

}  // namespace tandem::server
