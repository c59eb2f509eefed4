#pragma once

// What is done to a session's files while no server serves them: recovery after damage, restoring a backup;
// and the backup itself, which may run beside the server.
//
// 1. Recovery and restoring keep the poses of parts whose records are sound. Every part is free, in an epoch
//    beyond all that may have been told; the signing key is new, so that no link or ticket from before is
//    good. What was there stays in a folder beside.
// 2. They write the new key, then the mark, then the database: cut off anywhere, the next start refuses, and
//    the command can be given again.

#include <string>
#include <vector>

#include "assets/base/result.h"
#include "server/data_directory.h"

namespace tandem::server {

/// Lines that say what was kept and what was not.
using Report = std::vector<std::string>;

Result<Report> recoverSession(DataDirectory& directory, std::int64_t unixNow);
/// `backup` is a folder made by backUpSession(); one that is damaged is refused.
Result<Report> restoreSession(DataDirectory& directory, const std::string& backup, std::int64_t unixNow);
/// Copies the session in the data directory `data` to a new folder, and verifies the copy.
Result<Report> backUpSession(const std::string& data, const std::string& backup);
/// Gives a data directory that has none the TLS identity of a backup. Before DataDirectory::open().
Status takeIdentity(const std::string& data, const std::string& backup);

}  // namespace tandem::server
