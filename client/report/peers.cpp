#include "client/report/peers.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "client/report/report_json.h"

extern char** environ;

namespace tandem::client::report {
namespace {

namespace fs = std::filesystem;

/// A new file in the temporary directory, which the destructor removes.
class TemporaryFile {
 public:
  TemporaryFile() : path_((fs::temp_directory_path() / "tandem-peers-XXXXXX").string()) {
    const int file = ::mkstemp(path_.data());
    made_ = file >= 0;
    if (made_) ::close(file);
  }
  ~TemporaryFile() {
    if (made_) ::unlink(path_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  bool made() const { return made_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  bool made_ = false;
};

Status runToEnd(const std::string& program, std::vector<std::string> arguments) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  const int failed = ::posix_spawn(&child, program.c_str(), nullptr, nullptr, argv.data(), environ);
  if (failed != 0) return Error{program + ": cannot be run: " + std::strerror(failed)};
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return Error{program + ": lost: " + std::strerror(errno)};
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return Error{program + ": " +
               (WIFEXITED(status) ? "ended with exit code " + std::to_string(WEXITSTATUS(status))
                                  : "was ended by signal " + std::to_string(WTERMSIG(status)))};
}

}  // namespace

std::string peersProgramBesideThis() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) return "";
  const fs::path program = self.parent_path() / "bench_peers";
  return fs::is_regular_file(program, error) && ::access(program.c_str(), X_OK) == 0 ? program.string() : "";
}

Result<SweepResult> measurePeers(const std::string& program, const SweepOptions& options) {
  const TemporaryFile file;
  if (!file.made()) return Error{"no temporary file can be made for the peers' figures"};
  std::vector<std::string> arguments{program, "--json", file.path()};
  if (options.quick) arguments.push_back("--quick");
  if (!options.only.empty()) arguments.push_back("--scenes");
  arguments.insert(arguments.end(), options.only.begin(), options.only.end());
  if (Status ran = runToEnd(program, std::move(arguments)); !ran) return ran.error();
  std::ifstream in(file.path());
  Result<SweepResult> read = peersFromJson(std::string(std::istreambuf_iterator<char>(in), {}));
  if (!read) return Error{program + ": " + read.error().message};
  return read;
}

}  // namespace tandem::client::report
