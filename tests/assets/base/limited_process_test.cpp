#include "assets/base/limited_process.h"

#include <csignal>

#include <gtest/gtest.h>

namespace tandem {
namespace {

using How = ProcessEnd::How;

ProcessEnd shell(const std::string& script, const ProcessLimits& limits = {}) {
  return runLimited({"/bin/sh", "-c", script}, limits, {}).value();
}

TEST(LimitedProcess, TellsLinesCodeAndLastError) {
  std::vector<std::string> lines;
  const auto end = runLimited({"/bin/sh", "-c", "echo one; echo two; echo no >&2; echo why >&2; exit 3"}, {},
                              [&](const std::string& line) { lines.push_back(line); });
  ASSERT_TRUE(end.ok());
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(end->how, How::exited);
  EXPECT_EQ(end->code, 3);
  EXPECT_EQ(end->lastError, "why");
}

TEST(LimitedProcess, CrashIsToldApartFromAnExit) {
  const ProcessEnd end = shell("kill -SEGV $$");
  EXPECT_EQ(end.how, How::crashed);
  EXPECT_EQ(end.code, SIGSEGV);
}

TEST(LimitedProcess, EndsWhatTakesTooLongWithAllThatItStarted) {
  ProcessLimits limits;
  limits.wallTime = 0.3;
  EXPECT_EQ(shell("sleep 60 & sleep 60", limits).how, How::tookTooLong);  // both hold the pipe open
}

TEST(LimitedProcess, EndsWhatComputesTooLong) {
  ProcessLimits limits;
  limits.processorTime = 1.0;
  EXPECT_EQ(shell("while :; do :; done", limits).how, How::tookTooLong);
}

TEST(LimitedProcess, RefusesMoreMemory) {
  const std::string take = "x=$(head -c 100000000 /dev/zero | tr '\\0' a) && test ${#x} -eq 100000000";
  ProcessLimits limits;
  EXPECT_EQ(shell(take, limits).code, 0);
  limits.memory = std::uint64_t{64} << 20;
  const ProcessEnd end = shell(take, limits);
  EXPECT_TRUE(end.how == How::crashed || end.code != 0);
}

TEST(LimitedProcess, StopsWhenCancelled) {
  EXPECT_EQ(runLimited({"/bin/sh", "-c", "sleep 60"}, {}, {}, [] { return true; })->how, How::cancelled);
}

TEST(LimitedProcess, ProgramThatIsNotThereIsAnError) {
  EXPECT_FALSE(runLimited({"/no/such/program"}, {}, {}).ok());
}

}  // namespace
}  // namespace tandem
