#include "haptics/servo/servo_loop.h"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>
#if defined(__x86_64__) || defined(__i386__)
#include <xmmintrin.h>
#endif

#include "assets/base/assert.h"
#include "assets/base/assertion_scope.h"
#include "assets/base/finite.h"
#include "haptics/base/fault.h"
#include "haptics/operator/simulated_hand.h"
#include "haptics/servo/servo_schedule.h"

namespace tandem::haptics {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr int kPriority = 80;  // above the kernel's threaded interrupts (50), below its watchdogs (99)

// steady_clock is CLOCK_MONOTONIC on Linux, so times of the loop and of the rest of the program compare.
std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void sleepUntil(std::int64_t deadline_ns) {
  timespec when{};
  when.tv_sec = deadline_ns / kNanosecondsPerSecond;
  when.tv_nsec = deadline_ns % kNanosecondsPerSecond;
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr) == EINTR) {
  }
}

/// Denormals cost a hundred cycles each and carry nothing that a hand can feel.
void flushDenormals() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_setcsr(_mm_getcsr() | 0x8040u);  // FTZ and DAZ
#elif defined(__aarch64__)
  std::uint64_t control = 0;
  asm volatile("mrs %0, fpcr" : "=r"(control));
  asm volatile("msr fpcr, %0" : : "r"(control | (1ull << 24)));
#endif
}

/// Locks the process into memory; 0 or the error number.
int lockMemory() {
  // Under a memory limit MCL_FUTURE would make later allocations of the whole program fail, so it is used
  // only without one.
  rlimit limit{};
  const bool unlimited =
      geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
  if (!unlimited) return ENOMEM;
  return mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0 ? 0 : errno;
}

/// Final check before the device: whatever the callback returned, the device gets a finite wrench within its
/// limits.
Wrench safeWrench(const Wrench& wrench, const DeviceLimits& limits) {
  if (!isFinite(wrench.force) || !isFinite(wrench.torque)) return {};
  return {limited(wrench.force, limits.maxForce), limited(wrench.torque, limits.maxTorque)};
}

constexpr int kUnset = -1;

}  // namespace

struct ServoLoop::State {
  State(Device& d, Device* other, PairCallback c, double rate)
      : devices{&d, other},
        callback(std::move(c)),
        period_ns(static_cast<std::int64_t>(static_cast<double>(kNanosecondsPerSecond) / rate)) {}

  void run();
  void loop();
  void latch(const FailedAssertion& broken);
  void letGo();
  std::array<Wrench, 2> call(const std::array<DeviceSample, 2>& samples, double time);

  const std::array<Device*, 2> devices;  // the second is null where there is none
  PairCallback callback;
  const std::int64_t period_ns;
  std::thread thread;

  std::atomic<bool> stopping{false};
  std::atomic<std::uint64_t> ticks{0}, late{0}, skipped{0}, zeroed{0}, exceptions{0};
  std::atomic<int> realtimeError{kUnset}, lockError{kUnset};
  FaultLatch fault;                 // written before `faulty` is set
  std::atomic<bool> faulty{false};  // the force is zero until the next start
  DurationHistogram compute, period;
  std::array<std::atomic<float>, 256> recent{};
  std::atomic<std::uint32_t> recentNext{0};
};

std::array<Wrench, 2> ServoLoop::State::call(const std::array<DeviceSample, 2>& samples, double time) {
  try {
    const std::array<Wrench, 2> wrenches = callback(samples, time);
    return fault.raised() ? std::array<Wrench, 2>{} : wrenches;
  } catch (const FailedAssertion& broken) {
    latch(broken);
    return {};
  } catch (...) {  // an exception must not end the program with a force left on a hand
    exceptions.fetch_add(1, std::memory_order_relaxed);
    return {};
  }
}

void ServoLoop::State::latch(const FailedAssertion& broken) {
  fault.raise(broken.condition, broken.file, broken.line);
  faulty.store(true, std::memory_order_release);
}

/// Zero force on all devices. A driver whose own invariant is broken sends zero once it is no longer called.
void ServoLoop::State::letGo() {
  for (Device* device : devices) {
    try {
      if (device != nullptr) device->apply(Wrench{});
    } catch (const FailedAssertion& broken) {
      latch(broken);
    }
  }
}

void ServoLoop::State::run() {
  flushDenormals();
  realtimeError.store(becomeRealtime());
  lockError.store(lockMemory());
  const AssertionScope scope;
  try {
    loop();
  } catch (const FailedAssertion& broken) {
    latch(broken);
  }
  letGo();
}

void ServoLoop::State::loop() {
  std::array<DeviceLimits, 2> limits;
  for (std::size_t i = 0; i < 2; ++i)
    if (devices[i] != nullptr) limits[i] = devices[i]->limits();
  ServoSchedule schedule(now_ns(), period_ns);
  OverrunGuard guard;
  std::int64_t lastWoken = 0;
  while (!stopping.load(std::memory_order_relaxed)) {
    sleepUntil(schedule.deadline_ns());
    const std::int64_t woken = now_ns();
    if (schedule.woke(woken)) late.fetch_add(1, std::memory_order_relaxed);
    if (lastWoken != 0) period.record(woken - lastWoken);
    lastWoken = woken;

    const double time = 1e-9 * static_cast<double>(woken);
    std::array<DeviceSample, 2> samples;
    for (std::size_t i = 0; i < 2; ++i)
      if (devices[i] != nullptr) samples[i] = devices[i]->poll(time);
    const std::int64_t before = now_ns();
    const std::array<Wrench, 2> wrenches = call(samples, time);
    const std::int64_t spent = now_ns() - before;
    const bool zero = guard.note(spent > period_ns);
    if (zero) zeroed.fetch_add(1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < 2; ++i)
      if (devices[i] != nullptr) devices[i]->apply(zero ? Wrench{} : safeWrench(wrenches[i], limits[i]));

    compute.record(spent);
    const std::uint32_t slot = recentNext.load(std::memory_order_relaxed);
    recent[slot % recent.size()].store(1e-3f * static_cast<float>(spent), std::memory_order_relaxed);
    recentNext.store(slot + 1, std::memory_order_release);
    skipped.fetch_add(static_cast<std::uint64_t>(schedule.advance(now_ns())), std::memory_order_relaxed);
    ticks.fetch_add(1, std::memory_order_release);
  }
}

ServoLoop::ServoLoop(Device& device, Callback callback, double rate)
    : state_(std::make_unique<State>(
          device, nullptr,
          [callback = std::move(callback)](const std::array<DeviceSample, 2>& samples, double now) {
            return std::array<Wrench, 2>{callback(samples[0], now), {}};
          },
          rate)) {
  ASSERT(rate > 0.0);
}

ServoLoop::ServoLoop(Device& device, Device& second, PairCallback callback, double rate)
    : state_(std::make_unique<State>(device, &second, std::move(callback), rate)) {
  ASSERT(rate > 0.0);
}

ServoLoop::~ServoLoop() { stop(); }

int ServoLoop::becomeRealtime() {
  sched_param parameter{};
  parameter.sched_priority = kPriority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
}

void ServoLoop::start() {
  if (state_->thread.joinable()) return;
  state_->stopping.store(false);
  state_->fault = FaultLatch{};
  state_->faulty.store(false);
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

void ServoLoop::stop() {
  if (!state_->thread.joinable()) return;
  state_->stopping.store(true);
  state_->thread.join();
  state_->thread = std::thread();
}

ServoStatistics ServoLoop::statistics() const {
  const State& s = *state_;
  ServoStatistics out;
  out.ticks = s.ticks.load(std::memory_order_acquire);
  out.late = s.late.load();
  out.skipped = s.skipped.load();
  out.zeroed = s.zeroed.load();
  out.exceptions = s.exceptions.load();
  const DurationCounts compute = s.compute.counts(), period = s.period.counts();
  out.compute_us_p50 = 1e-3 * compute.quantile_ns(0.5);
  out.compute_us_p99 = 1e-3 * compute.quantile_ns(0.99);
  out.compute_us_max = 1e-3 * static_cast<double>(compute.max_ns);
  out.period_us_p99 = 1e-3 * period.quantile_ns(0.99);
  out.period_us_max = 1e-3 * static_cast<double>(period.max_ns);
  const int realtime = s.realtimeError.load(), lock = s.lockError.load();
  out.realtime = realtime == 0;
  out.memoryLocked = lock == 0;
  const auto note = [&out](const std::string& words) { out.note += (out.note.empty() ? "" : "; ") + words; };
  if (realtime > 0)
    note(std::string("no real-time priority (") + std::strerror(realtime) +
         "): allow it with a line '@realtime - rtprio 90' in /etc/security/limits.conf and the group "
         "realtime");
  if (lock > 0)
    note(std::string("memory not locked (") + std::strerror(lock) +
         "): allow it with '@realtime - memlock unlimited' in the same file");
  if (out.zeroed > 0) note("force was held at zero because ticks took longer than their period too often");
  if (out.exceptions > 0) note("the tick's callback threw; those ticks gave zero force");
  if (s.faulty.load(std::memory_order_acquire)) {
    out.fault = std::string(s.fault.file) + ":" + std::to_string(s.fault.line) + ": " + s.fault.condition;
    note("broken invariant, force held at zero: " + out.fault);
  }
  return out;
}

DurationCounts ServoLoop::computeTimes() const { return state_->compute.counts(); }

std::array<float, 256> ServoLoop::recentComputeTimes() const {
  std::array<float, 256> out{};
  const std::uint32_t next = state_->recentNext.load(std::memory_order_acquire);
  for (std::uint32_t i = 0; i < out.size(); ++i)
    out[i] = state_->recent[(next + i) % out.size()].load(std::memory_order_relaxed);
  return out;
}

double ServoLoop::now() { return 1e-9 * static_cast<double>(now_ns()); }

}  // namespace tandem::haptics
