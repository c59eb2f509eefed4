#pragma once

// Where a thread's processor time goes, by sampling: a timer on the thread's own processor clock interrupts
// it a few hundred times a second, and the names of the functions on its stack say which stage it was in.
// The code that is measured has no hooks, and the time that it waits or is not scheduled does not count.
//
// Programs that use it are linked with -rdynamic, so that functions have names at run time.

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <signal.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace tandem::bench {

/// One sampler a process at a time; begin() and end() on the thread that is measured.
class StageSampler {
 public:
  /// The first rule whose text occurs in the name of a function, from the innermost outwards, gives the
  /// stage.
  struct Rule {
    const char* text;
    const char* stage;
  };

  void begin() {
    store().used = 0;
    std::array<void*, 4> warm;
    backtrace(warm.data(), 4);  // its first call allocates
    struct sigaction action {};
    action.sa_handler = &StageSampler::sample;
    action.sa_flags = SA_RESTART;
    sigaction(SIGPROF, &action, nullptr);
    sigevent event{};
    event.sigev_notify = SIGEV_THREAD_ID;
    event.sigev_signo = SIGPROF;
    event._sigev_un._tid = static_cast<pid_t>(syscall(SYS_gettid));
    running_ = timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &timer_) == 0;
    const itimerspec every{{0, kPeriod_ns}, {0, kPeriod_ns}};
    if (running_) timer_settime(timer_, 0, &every, nullptr);
  }
  void end() {
    if (running_) timer_delete(timer_);
    running_ = false;
  }
  /// Each stage's share of the samples; "other" holds what no rule names.
  std::map<std::string, double> shares(const std::vector<Rule>& rules) const {
    std::map<std::string, double> found;
    const std::size_t count = std::min<std::size_t>(store().used, kMaxSamples);
    for (std::size_t i = 0; i < count; ++i)
      found[stageOf(store().stacks[i], rules)] += 1.0 / static_cast<double>(count);
    return found;
  }
  std::size_t samples() const { return std::min<std::size_t>(store().used, kMaxSamples); }
  /// The name of the function at an address; empty if it has none.
  static std::string nameOf(void* address) {
    Dl_info info{};
    if (dladdr(address, &info) == 0 || info.dli_sname == nullptr) return {};
    int status = 0;
    char* plain = abi::__cxa_demangle(info.dli_sname, nullptr, nullptr, &status);
    std::string name = status == 0 ? plain : info.dli_sname;
    std::free(plain);
    return name;
  }

 private:
  static constexpr long kPeriod_ns = 2'000'000;
  static constexpr std::size_t kMaxSamples = 16384, kDepth = 24, kOwnFrames = 2;
  struct Stack {
    std::array<void*, kDepth> frames{};
    int depth = 0;
  };
  struct Store {
    std::vector<Stack> stacks = std::vector<Stack>(kMaxSamples);
    std::atomic<std::size_t> used{0};
  };
  static Store& store() {
    static Store made;
    return made;
  }
  static void sample(int) {
    const std::size_t at = store().used.fetch_add(1, std::memory_order_relaxed);
    if (at >= kMaxSamples) return;
    Stack& stack = store().stacks[at];
    stack.depth = backtrace(stack.frames.data(), static_cast<int>(kDepth));
  }
  static std::string stageOf(const Stack& stack, const std::vector<Rule>& rules) {
    static std::map<void*, std::string> names;
    for (auto i = kOwnFrames; i < static_cast<std::size_t>(stack.depth); ++i) {
      const auto [at, isNew] = names.try_emplace(stack.frames[i]);
      if (isNew) at->second = nameOf(stack.frames[i]);
      for (const Rule& rule : rules)
        if (at->second.find(rule.text) != std::string::npos) return rule.stage;
    }
    return "other";
  }

  timer_t timer_{};
  bool running_ = false;
};

}  // namespace tandem::bench
