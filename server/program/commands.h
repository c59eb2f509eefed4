#pragma once

// What tandem-server does beside serving: shows the audit table, gives orders to the server that runs on a
// data directory, backs the session up, and recovers or restores it.

#include <string>

#include "assets/base/command_line.h"
#include "assets/base/result.h"

namespace tandem::server {

inline constexpr int kExitDone = 0, kExitFailed = 1, kExitBadInput = 2;

struct CommandOptions {
  bool audit = false, json = false;
  std::string kick, revokeTicket, inviteNow;  // empty: not asked for
  std::string backup, restore;
  bool recover = false;
  bool ban = false, revokeLinks = false, rotateKeys = false;

  bool asked() const;
};

void addCommandOptions(assets::CommandLine& app, CommandOptions& options);
/// Whether the options make one command.
Status check(const CommandOptions& options);
/// Carries the command out on the data directory; prints its answer and returns the exit code.
int runCommand(const CommandOptions& options, const std::string& data);

}  // namespace tandem::server
