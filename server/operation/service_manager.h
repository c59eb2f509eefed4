#pragma once

// What the service manager (systemd) is told: sd_notify(3) as the datagrams that it is, and nothing where no
// service manager asks for it.

#include <string>

#include "sync/wire/time.h"

namespace tandem::server {

class ServiceManager {
 public:
  /// Reads NOTIFY_SOCKET and WATCHDOG_USEC from the environment.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  void ready(const std::string& status);
  void stopping();
  /// Called in each round of the server's loop: says that it still turns, and what the session is like.
  void step(sync::Micros now, const std::string& status);
  bool listening() const { return socket_ >= 0; }

 private:
  void send(const std::string& text) const;

  int socket_ = -1;
  std::string address_, status_;
  sync::Micros period_ = 0, next_ = 0;  // of the watchdog; 0: none
  sync::Micros nextStatus_ = 0;
};

}  // namespace tandem::server
