#pragma once

// /metrics and /healthz over HTTP, for Prometheus and for what restarts a server. A thread of its own
// (libmicrohttpd) writes the answers from the figures that were published last; the loop of the server only
// publishes, and waits for no client.
//
// 1. At most 16 connections at once, of one address at most 8, each with 8 KiB for its request and with five
//    seconds of silence. GET and HEAD only; a body ends the connection.
// 2. /healthz is 200 while the journal is sound and the loop has stepped within two seconds, else 503 with
//    the reason. /metrics is 503 before the first figures.

#include <cstdint>
#include <memory>
#include <string>

#include "assets/base/result.h"
#include "server/operation/metrics_text.h"

namespace tandem::server {

class MetricsEndpoint {
 public:
  /// Listens on an address in digits. Port 0: any free one.
  static Result<std::unique_ptr<MetricsEndpoint>> open(const std::string& host, std::uint16_t port);
  ~MetricsEndpoint();

  std::uint16_t port() const;
  /// The loop has stepped.
  void alive();
  void publish(ServerFigures figures);

 private:
  struct State;
  explicit MetricsEndpoint(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tandem::server
