#pragma once

// What an operator has of a running server besides its session: the log, the audit table, orders through the
// control socket, and what the service manager is told. One object, stepped by the server's loop; nothing
// here keeps that loop waiting.

#include <memory>
#include <string>

#include "server/data_directory.h"
#include "server/operation/audit_log.h"
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

  void ready(const Session& session);
  /// One round of the loop, after the session's step.
  void step(Session& session, Invitations& invitations, sync::Micros now, std::int64_t unixNow);
  void stopping() { manager_.stopping(); }

 private:
  explicit Operation(DataDirectory& directory) : directory_(directory) {}
  Result<std::string> obey(const OperatorRequest& request, Session& session, Invitations& invitations,
                           std::int64_t unixNow);

  DataDirectory& directory_;
  SessionLogWriter log_;
  ServiceManager manager_;
  std::unique_ptr<AuditLog> audit_;
  std::unique_ptr<OperatorSocket> socket_;
};

}  // namespace tandem::server
