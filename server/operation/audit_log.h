#pragma once

// The audit table on a disk: audit.db in the data directory, a database of its own, so that no grant waits
// for it and damage to it stops nobody. A thread of its own writes; what it holds is bounded.
//
// 1. note() only queues. The writer commits all that is queued as one transaction, then drops the oldest rows
//    beyond the bound.
// 2. An error of the disk is said once; the writer tries again every second and keeps the newest entries
//    meanwhile. A number that is missing in the table is an entry that was lost to that.
// 3. Others may read the table while it is written.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "server/audit_trail.h"

namespace tandem::server {

inline constexpr std::int64_t kAuditRows = 100000;

class AuditLog {
 public:
  /// Opens or creates the table, with a bound of `rows`.
  static Result<std::unique_ptr<AuditLog>> open(const std::string& path, std::int64_t rows = kAuditRows);
  /// Writes what is queued, then closes.
  ~AuditLog();

  void note(std::vector<AuditEntry> entries);
  /// What has gone wrong, or is well again, since the last call; empty if nothing is new.
  std::string drainNews();

 private:
  struct State;
  explicit AuditLog(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// An entry as it stands in the table, with its number.
struct AuditRow {
  std::int64_t number = 0;
  AuditEntry entry;
};
/// Hands every row to `read`, oldest first, without changing the table.
Status readAudit(const std::string& path, const std::function<void(const AuditRow&)>& read);

/// One line: time in UTC, event, who, from where, detail.
std::string inWords(const AuditRow& row);
/// The same as one JSON object.
std::string inJson(const AuditRow& row);

}  // namespace tandem::server
