#include "server/program/operation.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "server/operation/metrics_text.h"

namespace tandem::server {
namespace {

std::string statusOf(const Session& session) {
  const auto& sites = session.sites();
  const auto connected =
      std::count_if(sites.begin(), sites.end(), [](const sync::SiteInfo& site) { return site.connected; });
  return std::to_string(connected) + (connected == 1 ? " site" : " sites") + " in the session";
}

}  // namespace

Result<std::unique_ptr<Operation>> Operation::open(DataDirectory& directory, std::function<void()> wake) {
  std::unique_ptr<Operation> operation(new Operation(directory));
  auto audit = AuditLog::open(directory.path() + "/audit.db");
  if (!audit) return audit.error();
  operation->audit_ = std::move(*audit);
  auto socket = OperatorSocket::open(directory.path(), std::move(wake));
  if (!socket) return socket.error();
  operation->socket_ = std::move(*socket);
  return operation;
}

Status Operation::serveMetrics(const std::string& host, std::uint16_t port) {
  auto metrics = MetricsEndpoint::open(host, port);
  if (!metrics) return metrics.error();
  metrics_ = std::move(*metrics);
  spdlog::info("metrics on {} port {}", host, metrics_->port());
  return {};
}

void Operation::ready(const Session& session) { manager_.ready(statusOf(session)); }

void Operation::step(Session& session, Invitations& invitations, sync::Micros now, std::int64_t unixNow) {
  socket_->serve(
      [&](const OperatorRequest& request) { return obey(request, session, invitations, unixNow); });
  audit_->note(session.drainAudit());
  std::vector<LogLine> lines = session.drainLog();
  if (const std::string news = audit_->drainNews(); !news.empty()) lines.push_back({news, true, kNoSite});
  log_.write(lines, now);
  if (metrics_) publishMetrics(session, now);
  if (manager_.listening()) manager_.step(now, statusOf(session));
}

void Operation::publishMetrics(const Session& session, sync::Micros now) {
  metrics_->alive();
  if (now < nextMetrics_) return;
  nextMetrics_ = now + sync::kSecond;
  metrics_->publish({session.figures(), rounds_});
}

Result<std::string> Operation::obey(const OperatorRequest& request, Session& session,
                                    Invitations& invitations, std::int64_t unixNow) {
  using Kind = OperatorRequest::Kind;
  switch (request.kind) {
    case Kind::kick:
    case Kind::ban:
      return session.kick(request.who, request.kind == Kind::ban);
    case Kind::revokeTicket:
      return session.revokeTicket(request.who);
    case Kind::inviteNow:
      session.noteInvitation(request.role);
      return invitations.make(session, request.role, unixNow);
    default:
      break;
  }
  // The keys are on the disk before anything is signed by them, or void.
  const bool all = request.kind == Kind::rotateKeys;
  if (Status replaced = directory_.replaceKeys(all); !replaced) return replaced.error();
  const std::string done = all ? session.replaceKeys(directory_.signingKey(), directory_.linkKey())
                               : session.replaceLinkKey(directory_.linkKey());
  invitations.reopen(session, unixNow);
  return done;
}

}  // namespace tandem::server
