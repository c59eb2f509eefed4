#include "server/program/commands.h"

#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "assets/base/assert.h"
#include "assets/base/utc_time.h"
#include "server/operation/audit_log.h"
#include "server/operation/operator_socket.h"
#include "server/session_recovery.h"

namespace tandem::server {
namespace {

std::optional<sync::Role> roleFrom(const std::string& text) {
  for (int i = 0; i <= static_cast<int>(sync::Role::instructor); ++i)
    if (text == sync::toString(static_cast<sync::Role>(i))) return static_cast<sync::Role>(i);
  return std::nullopt;
}

int failed(int exitCode, std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '_');
  std::fprintf(stderr, "tandem-server: %s\n", text.c_str());
  return exitCode;
}

int showAudit(const std::string& data, bool json) {
  const Status shown = readAudit(data + "/audit.db", [&](const AuditRow& row) {
    std::printf("%s\n", (json ? inJson(row) : inWords(row)).c_str());
  });
  if (!shown) return failed(kExitBadInput, shown.error().message);
  return std::fflush(stdout) == 0 ? kExitDone : failed(kExitFailed, "standard output cannot be written");
}

Result<Report> mend(const CommandOptions& options, const std::string& data) {
  if (!options.restore.empty())
    if (Status taken = takeIdentity(data, options.restore); !taken) return taken.error();
  Result<DataDirectory> directory = DataDirectory::open(data);
  if (!directory) return directory.error();
  return options.recover ? recoverSession(*directory, systemUnixTime())
                         : restoreSession(*directory, options.restore, systemUnixTime());
}

int keepSession(const CommandOptions& options, const std::string& data) {
  ::umask(077);
  if (options.recover && !std::filesystem::is_directory(data))
    return failed(kExitBadInput, data + ": no such data directory");
  const Result<Report> report =
      options.backup.empty() ? mend(options, data) : backUpSession(data, options.backup);
  if (!report) return failed(kExitBadInput, report.error().message);
  for (const std::string& line : *report) std::printf("%s\n", line.c_str());
  return kExitDone;
}

OperatorRequest requestOf(const CommandOptions& options) {
  using Kind = OperatorRequest::Kind;
  OperatorRequest request;
  if (!options.kick.empty()) {
    request.kind = options.ban ? Kind::ban : Kind::kick;
    request.who = options.kick;
  } else if (!options.revokeTicket.empty()) {
    request.kind = Kind::revokeTicket;
    request.who = options.revokeTicket;
  } else if (!options.inviteNow.empty()) {
    request.kind = Kind::inviteNow;
    request.role = roleFrom(options.inviteNow).value_or(request.role);
  } else {
    request.kind = options.revokeLinks ? Kind::revokeLinks : Kind::rotateKeys;
  }
  return request;
}

int count(const CommandOptions& options) {
  return (options.backup.empty() ? 0 : 1) + (options.restore.empty() ? 0 : 1) + (options.recover ? 1 : 0) +
         (options.audit ? 1 : 0) + (options.kick.empty() ? 0 : 1) + (options.revokeTicket.empty() ? 0 : 1) +
         (options.inviteNow.empty() ? 0 : 1) + (options.revokeLinks ? 1 : 0) + (options.rotateKeys ? 1 : 0);
}

}  // namespace

bool CommandOptions::asked() const { return count(*this) > 0; }

void addCommandOptions(assets::CommandLine& app, CommandOptions& options) {
  const auto audit = app.flag("--audit", options.audit,
                              "shows who joined, left, was refused or made to go, with --data; then ends");
  app.flag("--json", options.json, "with --audit: a JSON object a line").needs(audit);
  const auto kick = app.option("--kick", options.kick,
                               "parts from a site of the server that runs with --data; its parts are free")
                        .typeName("NAME|SITE");
  app.flag("--ban", options.ban, "with --kick: its ticket admits nobody any more").needs(kick);
  app.option("--revoke-ticket", options.revokeTicket,
             "makes the ticket of a site void; the site stays for now")
      .typeName("NAME|SITE");
  app.flag("--revoke-links", options.revokeLinks, "makes every open link void; the server prints new ones");
  app.flag("--rotate-keys", options.rotateKeys,
           "new keys: every link and ticket is void but for the sites that are connected");
  app.option("--backup", options.backup, "copies the session of --data to a new folder, also while it runs")
      .typeName("DIR");
  app.option("--restore", options.restore,
             "puts a backup in place of the session of --data; parts are free, links and tickets are void")
      .typeName("DIR");
  app.flag("--recover", options.recover,
           "keeps what is sound of a damaged session; parts are free, links and tickets are void");
  app.option("--invite-now", options.inviteNow, "prints one more link of the server that runs with --data")
      .typeName("ROLE");
}

Status check(const CommandOptions& options) {
  if (count(options) > 1)
    return Error{
        "one of --audit, --kick, --revoke-ticket, --revoke-links, --rotate-keys, --invite-now, --backup, "
        "--restore, --recover at once"};
  if (!options.inviteNow.empty() && !roleFrom(options.inviteNow))
    return Error{"--invite-now " + options.inviteNow + ": must be instructor, participant or observer"};
  return {};
}

int runCommand(const CommandOptions& options, const std::string& data) {
  ASSERT(options.asked());
  if (options.audit) return showAudit(data, options.json);
  if (options.recover || !options.backup.empty() || !options.restore.empty())
    return keepSession(options, data);
  const OperatorAnswer answer = askServer(data, requestOf(options));
  switch (answer.outcome) {
    case OperatorAnswer::Outcome::done:
      std::printf("%s\n", answer.text.c_str());
      return kExitDone;
    case OperatorAnswer::Outcome::refused:
      return failed(kExitFailed, answer.text);
    default:
      return failed(kExitBadInput, answer.text);
  }
}

}  // namespace tandem::server
