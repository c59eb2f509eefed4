#pragma once

// What an operator has of a running server besides its session: the log, the audit table, orders through the
// control socket, and what the service manager is told. One object, stepped by the server's loop; nothing
// here keeps that loop waiting.

#include <memory>
#include <string>

#include "server/data_directory.h"
#include "server/duration_histogram.h"
#include "server/operation/audit_log.h"
#include "server/operation/metrics_endpoint.h"
#include "server/operation/operator_socket.h"
#include "server/operation/server_log.h"
#include "server/operation/service_manager.h"
#include "server/program/invitations.h"
#include "server/session.h"

namespace tandem::server {

class Operation {
 public:
  /// Opens the audit table and the control socket in the data directory. `wake` ends a wait of the loop, from
  /// any thread, as long as this lives.
  static Result<std::unique_ptr<Operation>> open(DataDirectory& directory, std::function<void()> wake);
  /// Serves metrics and health by HTTP from now on. An error if it cannot listen there.
  Status serveMetrics(const std::string& host, std::uint16_t port);

  void ready(const Session& session);
  /// How long a round of the loop took, without its wait.
  void took(sync::Micros round) { rounds_.add(round); }
  /// One round of the loop, after the session's step.
  void step(Session& session, Invitations& invitations, sync::Micros now, std::int64_t unixNow);
  void stopping() { manager_.stopping(); }

 private:
  explicit Operation(DataDirectory& directory) : directory_(directory) {}
  void publishMetrics(const Session& session, sync::Micros now);
  Result<std::string> obey(const OperatorRequest& request, Session& session, Invitations& invitations,
                           std::int64_t unixNow);

  DataDirectory& directory_;
  SessionLogWriter log_;
  ServiceManager manager_;
  std::unique_ptr<AuditLog> audit_;
  std::unique_ptr<OperatorSocket> socket_;
  std::unique_ptr<MetricsEndpoint> metrics_;  // null: not asked for
  DurationHistogram rounds_;
  sync::Micros nextMetrics_ = 0;
};

}  // namespace tandem::server
