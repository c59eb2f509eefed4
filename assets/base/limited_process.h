#pragma once

// Runs another program on a hostile file: within limits of memory and time, in a process group of its own
// that ends with this process. For programs before they start threads of their own that fork.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "assets/base/result.h"

namespace tandem {

struct ProcessLimits {
  std::uint64_t memory = std::uint64_t{4} << 30;    // bytes of address space
  std::uint64_t fileSize = std::uint64_t{4} << 30;  // bytes of a file that it writes
  double processorTime = 600.0;                     // s
  double wallTime = 1200.0;                         // s
};

/// How a process ended.
struct ProcessEnd {
  enum class How : std::uint8_t { exited, crashed, tookTooLong, cancelled };
  How how = How::exited;
  int code = 0;           // of an exit; of a crash the signal
  std::string lastError;  // the last line that it wrote to standard error, at most 4 KiB
};

/// Runs `command` (the program's path, then its arguments) and waits for it. `onLine` is called with each
/// line of its standard output, cut at 1 MiB; its standard input is empty. Where `cancelled` returns true,
/// asked ten times a second, or a limit is reached, the whole process group is killed. An error only where
/// the program cannot be started.
Result<ProcessEnd> runLimited(const std::vector<std::string>& command, const ProcessLimits& limits,
                              const std::function<void(const std::string&)>& onLine,
                              const std::function<bool()>& cancelled = {});

/// The path of a program that is installed beside the running one; of its bare name if there is none.
std::string besideThisProgram(const std::string& name);

}  // namespace tandem
