#include "assets/base/limited_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>

namespace tandem {
namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 20;
constexpr std::size_t kLongestError = 4096;
constexpr int kCannotStart = 127;

/// One end of a pipe, closed with its owner.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }

  int get() const { return fd_; }
  bool open() const { return fd_ >= 0; }
  void set(int fd) { fd_ = fd; }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  int fd_;
};

struct Pipe {
  Descriptor read, write;

  bool make() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return false;
    read.set(ends[0]);
    write.set(ends[1]);
    return true;
  }
};

/// Splits what arrives into lines.
class Lines {
 public:
  Lines(std::size_t longest, std::function<void(const std::string&)> take)
      : longest_(longest), take_(std::move(take)) {}

  void add(const char* data, std::size_t size) {
    for (const char* end = data + size; data != end; ++data) {
      if (*data == '\n')
        finish();
      else if (line_.size() < longest_)
        line_ += *data;
    }
  }
  void finish() {
    if (!line_.empty()) take_(line_);
    line_.clear();
  }

 private:
  std::size_t longest_;
  std::function<void(const std::string&)> take_;
  std::string line_;
};

void limit(int resource, rlim_t soft, rlim_t hard) {
  const rlimit value{soft, hard};
  ::setrlimit(static_cast<__rlimit_resource_t>(resource), &value);
}

/// In the child between fork and exec: only what is safe after a fork.
[[noreturn]] void become(char* const* arguments, const ProcessLimits& limits, int output, int error,
                         pid_t parent) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kCannotStart);  // it died before the line above
  const auto seconds = static_cast<rlim_t>(std::ceil(limits.processorTime));
  limit(RLIMIT_AS, limits.memory, limits.memory);
  limit(RLIMIT_FSIZE, limits.fileSize, limits.fileSize);
  limit(RLIMIT_CPU, seconds, seconds + 2);
  limit(RLIMIT_CORE, 0, 0);
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(error, STDERR_FILENO);
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ, SIGXCPU}) ::sigaction(signal, &usual, nullptr);
  ::close_range(STDERR_FILENO + 1, ~0u, 0);
  ::execvp(arguments[0], arguments);
  ::_exit(kCannotStart);
}

/// Reads what is there; closes the descriptor at its end.
void drain(Descriptor& from, Lines& into) {
  std::array<char, 65536> buffer;
  const ssize_t count = ::read(from.get(), buffer.data(), buffer.size());
  if (count > 0)
    into.add(buffer.data(), static_cast<std::size_t>(count));
  else if (count == 0 || (errno != EINTR && errno != EAGAIN))
    from.close();
}

ProcessEnd endOf(int status, bool late, bool stopped) {
  ProcessEnd end;
  if (stopped || late) {
    end.how = stopped ? ProcessEnd::How::cancelled : ProcessEnd::How::tookTooLong;
  } else if (WIFSIGNALED(status)) {
    end.code = WTERMSIG(status);
    end.how = end.code == SIGXCPU ? ProcessEnd::How::tookTooLong : ProcessEnd::How::crashed;
  } else {
    end.code = WEXITSTATUS(status);
  }
  return end;
}

}  // namespace

Result<ProcessEnd> runLimited(const std::vector<std::string>& command, const ProcessLimits& limits,
                              const std::function<void(const std::string&)>& onLine,
                              const std::function<bool()>& cancelled) {
  using Clock = std::chrono::steady_clock;
  Pipe output, error;
  if (!output.make() || !error.make()) return Error{std::string("no pipe: ") + std::strerror(errno)};
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) return Error{std::string("no process: ") + std::strerror(errno)};
  if (child == 0) become(arguments.data(), limits, output.write.get(), error.write.get(), parent);
  ::setpgid(child, child);  // here too: whichever comes first
  output.write.close();
  error.write.close();

  std::string lastError;
  Lines lines(
      kLongestLine, onLine ? onLine : [](const std::string&) {});
  Lines errors(kLongestError, [&](const std::string& line) { lastError = line; });
  const auto end = Clock::now() + std::chrono::duration<double>(limits.wallTime);
  bool late = false, stopped = false;
  while ((output.read.open() || error.read.open()) && !late && !stopped) {
    pollfd waits[] = {{output.read.get(), POLLIN, 0}, {error.read.get(), POLLIN, 0}};
    ::poll(waits, 2, 100);
    if (waits[0].revents != 0) drain(output.read, lines);
    if (waits[1].revents != 0) drain(error.read, errors);
    late = Clock::now() > end;
    stopped = cancelled && cancelled();
  }
  if (late || stopped) ::kill(-child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  ::kill(-child, SIGKILL);  // whatever it has started
  lines.finish();
  errors.finish();
  if (!late && !stopped && WIFEXITED(status) && WEXITSTATUS(status) == kCannotStart)
    return Error{command.front() + ": cannot be started"};
  ProcessEnd result = endOf(status, late, stopped);
  result.lastError = std::move(lastError);
  return result;
}

std::string besideThisProgram(const std::string& name) {
  std::error_code failed;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", failed);
  const std::filesystem::path beside = self.parent_path() / name;
  return !failed && std::filesystem::exists(beside, failed) ? beside.string() : name;
}

}  // namespace tandem
