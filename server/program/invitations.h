#pragma once

// The links that a server hands out: as many open ones a role as were asked for, each replaced when it is
// used or expires.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "server/program/options.h"
#include "server/session.h"
#include "sync/transport/join_link.h"

namespace tandem::server {

class Invitations {
 public:
  Invitations(const Options& options, std::string host, std::uint16_t port, std::string pin);

  /// Prints the first links on standard output, one a line: the role, blanks, the link.
  void open(const Session& session, std::int64_t unixNow);
  /// One more link, which is not replaced when it is used.
  std::string make(const Session& session, sync::Role role, std::int64_t unixNow);
  /// Every link is void: prints new ones.
  void reopen(const Session& session, std::int64_t unixNow);
  /// Prints new links for those that were used or have expired.
  void renew(const Session& session, const std::vector<sync::Role>& used, std::int64_t unixNow);

 private:
  void print(const Session& session, sync::Role role, std::int64_t unixNow);

  std::array<int, 3> wanted_;
  std::int64_t lifetime_s_;
  sync::JoinLink link_;
  std::array<std::vector<std::int64_t>, 3> expiries_;  // Unix time in s, of each open link, oldest first
};

/// The host to put into links when none was given: the one listened on, or this machine's first outward
/// address.
std::string defaultLinkHost(const std::string& listenHost);

}  // namespace tandem::server
