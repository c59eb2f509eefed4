#include "server/operation/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr sync::Micros kStatusPeriod = sync::kSecond;

std::string fromEnvironment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

}  // namespace

ServiceManager::ServiceManager() {
  address_ = fromEnvironment("NOTIFY_SOCKET");
  const bool usable = address_.size() > 1 && (address_[0] == '/' || address_[0] == '@') &&
                      address_.size() < sizeof(sockaddr_un::sun_path);
  if (!usable) return;
  if (address_[0] == '@') address_[0] = '\0';  // an abstract address
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const std::string watchdog = fromEnvironment("WATCHDOG_USEC"), pid = fromEnvironment("WATCHDOG_PID");
  if (!pid.empty() && pid != std::to_string(::getpid())) return;
  sync::Micros limit = 0;
  std::from_chars(watchdog.data(), watchdog.data() + watchdog.size(), limit);
  period_ = std::max<sync::Micros>(0, limit / 2);
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceManager::send(const std::string& text) const {
  if (socket_ < 0) return;
  ASSERT(address_.size() < sizeof(sockaddr_un::sun_path));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(address_.begin(), address_.end(), address.sun_path);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  // A manager that does not read is no reason to wait.
  static_cast<void>(::sendto(socket_, text.data(), text.size(), MSG_NOSIGNAL,
                             reinterpret_cast<const sockaddr*>(&address), size));
}

void ServiceManager::ready(const std::string& status) {
  status_ = status;
  send("READY=1\nSTATUS=" + status);
}

void ServiceManager::stopping() { send("STOPPING=1"); }

void ServiceManager::step(sync::Micros now, const std::string& status) {
  if (socket_ < 0) return;
  if (period_ > 0 && now >= next_) {
    next_ = now + period_;
    send("WATCHDOG=1");
  }
  if (now < nextStatus_ || status == status_) return;
  nextStatus_ = now + kStatusPeriod;
  status_ = status;
  send("STATUS=" + status);
}

}  // namespace tandem::server
