#include "server/operation/operator_socket.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::milliseconds;

constexpr const char* kName = "control.sock";
constexpr std::size_t kMaxLine = 4096;
constexpr Milliseconds kTalkTime{2000};    // for the line of the other end
constexpr Milliseconds kAnswerTime{5000};  // for the server to carry a command out
constexpr std::array<const char*, 6> kCommands = {"kick",          "ban",         "revoke-links",
                                                  "revoke-ticket", "rotate-keys", "invite-now"};

class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  int get() const { return number_; }
  bool valid() const { return number_ >= 0; }

 private:
  int number_;
};

std::string lastError() { return std::generic_category().message(errno); }

/// The address of the socket in an open directory: a path in /proc fits into sun_path, however long the
/// directory's own is.
sockaddr_un addressIn(const Descriptor& directory) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = "/proc/self/fd/" + std::to_string(directory.get()) + '/' + kName;
  ASSERT(path.size() < sizeof address.sun_path);
  std::copy(path.begin(), path.end(), address.sun_path);
  return address;
}

const sockaddr* generic(const sockaddr_un& address) { return reinterpret_cast<const sockaddr*>(&address); }

Descriptor openDirectory(const std::string& path) {
  return Descriptor(::open(path.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
}

/// Waits until the descriptor is readable, or writable, or `until` has passed; `stop` cuts the wait short.
bool ready(int descriptor, short events, Clock::time_point until, int stop = -1) {
  for (;;) {
    const auto left = std::chrono::duration_cast<Milliseconds>(until - Clock::now()).count();
    std::array<pollfd, 2> watched{{{descriptor, events, 0}, {stop, POLLIN, 0}}};
    const int found = ::poll(watched.data(), watched.size(), static_cast<int>(std::max<long>(0, left)));
    if (found < 0 && errno == EINTR) continue;
    return found > 0 && watched[1].revents == 0 && watched[0].revents != 0;
  }
}

/// A line of at most kMaxLine bytes, without its end.
std::optional<std::string> readLine(int socket, Clock::time_point until, int stop = -1) {
  std::string line;
  std::array<char, 512> bytes;
  while (ready(socket, POLLIN, until, stop)) {
    const ssize_t size = ::recv(socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size <= 0) return std::nullopt;
    line.append(bytes.data(), static_cast<std::size_t>(size));
    const auto end = line.find('\n');
    if (end != std::string::npos) return line.substr(0, end);
    if (line.size() > kMaxLine) return std::nullopt;
  }
  return std::nullopt;
}

bool writeLine(int socket, std::string line, Clock::time_point until) {
  line += '\n';
  for (std::size_t at = 0; at < line.size();) {
    if (!ready(socket, POLLOUT, until)) return false;
    const ssize_t size = ::send(socket, line.data() + at, line.size() - at, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (size <= 0) return false;
    at += static_cast<std::size_t>(size);
  }
  return true;
}

bool isOwnUser(int socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return false;
  return peer.uid == ::geteuid() || peer.uid == 0;
}

std::string dump(const nlohmann::json& object) {
  return object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string answerLine(bool done, const std::string& text) { return dump({{"done", done}, {"text", text}}); }

std::string stringOf(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace

std::string encodeRequest(const OperatorRequest& request) {
  return dump({{"do", kCommands[static_cast<std::size_t>(request.kind)]},
               {"who", request.who},
               {"role", sync::toString(request.role)}});
}

Result<OperatorRequest> decodeRequest(const std::string& line) {
  const nlohmann::json object = nlohmann::json::parse(line, nullptr, false);
  if (!object.is_object()) return Error{"not a command"};
  const std::string kind = stringOf(object, "do"), role = stringOf(object, "role");
  const auto found = std::find(kCommands.begin(), kCommands.end(), kind);
  if (found == kCommands.end()) return Error{"no such command"};
  OperatorRequest request;
  request.kind = static_cast<OperatorRequest::Kind>(found - kCommands.begin());
  request.who = stringOf(object, "who");
  for (int i = 0; i <= static_cast<int>(sync::Role::instructor); ++i) {
    request.role = static_cast<sync::Role>(i);
    if (role == sync::toString(request.role)) return request;
  }
  return Error{"no such role"};
}

struct OperatorSocket::State {
  Descriptor directory, listening, stop;
  std::function<void()> wake;
  std::thread thread;

  std::atomic<bool> waiting{false};  // a request without an answer is there
  std::mutex mutex;                  // guards what follows
  std::condition_variable answered;
  std::optional<OperatorRequest> request;
  std::optional<std::string> answer;

  void work();
  void talk(const Descriptor& socket);
  std::string carryOut(const OperatorRequest& wish);
};

/// Hands the command to serve() and waits for the answer.
std::string OperatorSocket::State::carryOut(const OperatorRequest& wish) {
  std::unique_lock lock(mutex);
  request = wish;
  answer.reset();
  waiting = true;
  wake();
  const bool inTime = answered.wait_for(lock, kAnswerTime, [&] { return answer.has_value(); });
  request.reset();
  waiting = false;
  return inTime ? *std::exchange(answer, std::nullopt) : answerLine(false, "the server does not answer");
}

void OperatorSocket::State::talk(const Descriptor& socket) {
  if (!isOwnUser(socket.get())) return;
  const std::optional<std::string> line = readLine(socket.get(), Clock::now() + kTalkTime, stop.get());
  if (!line) return;
  const Result<OperatorRequest> wish = decodeRequest(*line);
  const std::string reply = wish ? carryOut(*wish) : answerLine(false, wish.error().message);
  writeLine(socket.get(), reply, Clock::now() + kTalkTime);
}

void OperatorSocket::State::work() {
  for (;;) {
    std::array<pollfd, 2> watched{{{listening.get(), POLLIN, 0}, {stop.get(), POLLIN, 0}}};
    if (::poll(watched.data(), watched.size(), -1) < 0 && errno != EINTR) return;
    if (watched[1].revents != 0) return;
    if (watched[0].revents == 0) continue;
    const Descriptor socket(::accept4(listening.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (socket.valid()) talk(socket);
  }
}

Result<std::unique_ptr<OperatorSocket>> OperatorSocket::open(const std::string& directory,
                                                             std::function<void()> wake) {
  const auto failed = [&] { return Error{directory + '/' + kName + ": " + lastError()}; };
  auto state = std::make_unique<State>();
  state->directory = openDirectory(directory);
  if (!state->directory.valid()) return failed();
  ::unlinkat(state->directory.get(), kName, 0);  // of a server that was killed: this one has the lock
  state->listening = Descriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!state->listening.valid()) return failed();
  const sockaddr_un address = addressIn(state->directory);
  if (::bind(state->listening.get(), generic(address), sizeof address) != 0) return failed();
  if (::fchmodat(state->directory.get(), kName, 0600, 0) != 0) return failed();
  if (::listen(state->listening.get(), 8) != 0) return failed();
  state->stop = Descriptor(::eventfd(0, EFD_CLOEXEC));
  if (!state->stop.valid()) return failed();
  state->wake = std::move(wake);
  return std::unique_ptr<OperatorSocket>(new OperatorSocket(std::move(state)));
}

OperatorSocket::OperatorSocket(std::unique_ptr<State> state) : state_(std::move(state)) {
  state_->thread = std::thread([s = state_.get()] { s->work(); });
}

OperatorSocket::~OperatorSocket() {
  serve([](const OperatorRequest&) -> Result<std::string> { return Error{"the server is stopping"}; });
  const std::uint64_t one = 1;
  static_cast<void>(!::write(state_->stop.get(), &one, sizeof one));
  state_->thread.join();
  ::unlinkat(state_->directory.get(), kName, 0);
}

void OperatorSocket::serve(const std::function<Result<std::string>(const OperatorRequest&)>& obey) {
  if (!state_->waiting) return;
  const std::lock_guard lock(state_->mutex);
  if (!state_->request) return;
  const OperatorRequest request = *std::exchange(state_->request, std::nullopt);
  const Result<std::string> done = obey(request);
  state_->answer = answerLine(done.ok(), done ? *done : done.error().message);
  state_->waiting = false;
  state_->answered.notify_one();
}

OperatorAnswer askServer(const std::string& directory, const OperatorRequest& request) {
  const Descriptor folder = openDirectory(directory);
  if (!folder.valid()) return {OperatorAnswer::Outcome::unreachable, directory + ": " + lastError()};
  const std::string path = directory + '/' + kName;
  const Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const sockaddr_un address = addressIn(folder);
  if (!socket.valid() || ::connect(socket.get(), generic(address), sizeof address) != 0)
    return {OperatorAnswer::Outcome::unreachable, path + ": no server runs here (" + lastError() + ')'};
  const Clock::time_point until = Clock::now() + kAnswerTime + 2 * kTalkTime;
  std::optional<std::string> line;
  if (writeLine(socket.get(), encodeRequest(request), until)) line = readLine(socket.get(), until);
  const nlohmann::json answer = nlohmann::json::parse(line.value_or(""), nullptr, false);
  if (!answer.is_object() || !answer.contains("done") || !answer["done"].is_boolean())
    return {OperatorAnswer::Outcome::unreachable, path + ": the server gives no answer"};
  return {answer["done"].get<bool>() ? OperatorAnswer::Outcome::done : OperatorAnswer::Outcome::refused,
          stringOf(answer, "text")};
}

}  // namespace tandem::server
