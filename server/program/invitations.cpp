#include "server/program/invitations.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <cstdio>

namespace tandem::server {

Invitations::Invitations(const Options& options, std::string host, std::uint16_t port, std::string pin)
    : wanted_(options.invites), lifetime_s_(options.tokenLifetime_s) {
  link_.host = std::move(host);
  link_.port = port;
  link_.pin = std::move(pin);
}

std::string Invitations::make(const Session& session, sync::Role role, std::int64_t unixNow) {
  link_.role = role;
  link_.token = session.makeToken(role, unixNow + lifetime_s_);
  return sync::toString(link_);
}

void Invitations::reopen(const Session& session, std::int64_t unixNow) {
  for (auto& expiries : expiries_) expiries.clear();
  open(session, unixNow);
}

void Invitations::print(const Session& session, sync::Role role, std::int64_t unixNow) {
  expiries_[static_cast<std::size_t>(role)].push_back(unixNow + lifetime_s_);
  std::printf("%-11s %s\n", sync::toString(role), make(session, role, unixNow).c_str());
  std::fflush(stdout);  // others read it through a pipe
}

void Invitations::open(const Session& session, std::int64_t unixNow) {
  for (int role = 2; role >= 0; --role)  // instructor first
    for (int i = 0; i < wanted_[static_cast<std::size_t>(role)]; ++i)
      print(session, static_cast<sync::Role>(role), unixNow);
}

void Invitations::renew(const Session& session, const std::vector<sync::Role>& used, std::int64_t unixNow) {
  for (const sync::Role role : used) {
    auto& expiries = expiries_[static_cast<std::size_t>(role)];
    // Links of an earlier run work too; only what this run printed is replaced.
    if (expiries.empty()) continue;
    expiries.erase(expiries.begin());
    print(session, role, unixNow);
  }
  for (std::size_t role = 0; role < expiries_.size(); ++role) {
    auto& expiries = expiries_[role];
    while (!expiries.empty() && expiries.front() <= unixNow) {
      expiries.erase(expiries.begin());
      print(session, static_cast<sync::Role>(role), unixNow);
    }
  }
}

std::string defaultLinkHost(const std::string& listenHost) {
  if (!listenHost.empty() && listenHost != "0.0.0.0" && listenHost != "::") return listenHost;
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return "127.0.0.1";
  std::string found = "127.0.0.1";
  for (const ifaddrs* at = all; at != nullptr; at = at->ifa_next) {
    const bool usable = (at->ifa_flags & IFF_UP) != 0 && (at->ifa_flags & IFF_LOOPBACK) == 0;
    if (at->ifa_addr == nullptr || at->ifa_addr->sa_family != AF_INET || !usable) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto* address = reinterpret_cast<const sockaddr_in*>(at->ifa_addr);
    if (::inet_ntop(AF_INET, &address->sin_addr, text, sizeof text) == nullptr) continue;
    found = text;
    break;
  }
  ::freeifaddrs(all);
  return found;
}

}  // namespace tandem::server
