#include "server/operator_commands.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

namespace tandem::server {
namespace {

const Error kNothingChanged{"the server cannot write its journal, so nothing is changed"};

std::optional<unsigned> numberFrom(const std::string& text) {
  unsigned number = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || at != end) return std::nullopt;
  return number;
}

std::string listOf(const std::vector<SiteId>& sites) {
  std::string list;
  for (const SiteId site : sites) list += (list.empty() ? "" : ", ") + std::to_string(site);
  return list;
}

std::string times(std::size_t count, const std::string& what) {
  return std::to_string(count) + ' ' + what + (count == 1 ? "" : "s");
}

}  // namespace

OperatorCommands::OperatorCommands(SessionContext& context, Peers& peers, Sites& sites,
                                   const Publisher& publisher, SiteAdmission& admission)
    : context_(context), peers_(peers), sites_(sites), publisher_(publisher), admission_(admission) {}

Result<SiteId> OperatorCommands::find(const std::string& who) const {
  if (const auto number = numberFrom(who)) {
    if (*number == kNoSite || *number > 0xffff || sites_.find(static_cast<SiteId>(*number)) == nullptr)
      return Error{"there is no site " + who};
    return static_cast<SiteId>(*number);
  }
  std::vector<SiteId> connected, absent;
  for (const auto& [id, site] : sites_.all()) {
    if (site.info.name != who) continue;
    if (site.info.connected)
      connected.push_back(id);
    else if (!site.left)
      absent.push_back(id);
  }
  const std::vector<SiteId>& named = connected.empty() ? absent : connected;
  if (named.empty()) return Error{"there is no site named \"" + who + "\""};
  if (named.size() > 1)
    return Error{"several sites are named \"" + who + "\": " + listOf(named) + "; give a number"};
  return named.front();
}

void OperatorCommands::audit(AuditEvent event, SiteId site, const std::string& detail) {
  AuditEntry entry{event, context_.unixNow(), site, {}, {}, {}, detail};
  if (const KnownSite* known = sites_.find(site)) {
    entry.name = known->info.name;
    entry.role = sync::toString(known->info.role);
  }
  if (const Peer* peer = site == kNoSite ? nullptr : peers_.bySite(site)) entry.address = peer->address;
  context_.audit.note(std::move(entry), context_.now());
}

Result<std::string> OperatorCommands::kick(const std::string& who, bool ban) {
  if (!publisher_.writable()) return kNothingChanged;
  const Result<SiteId> id = find(who);
  if (!id) return id.error();
  KnownSite& site = *sites_.find(*id);
  const bool connected = peers_.bySite(*id) != nullptr;
  if (!connected && (!ban || site.left))
    return Error{sites_.nameOf(*id) + (site.left ? " has left" : " is not connected")};
  audit(ban ? AuditEvent::banned : AuditEvent::kicked, *id, {});
  admission_.remove(site, ban,
                    ban ? "the operator of the server has banned this site"
                        : "the operator of the server has parted from this site");
  const std::string done = sites_.nameOf(*id) + (ban ? " is banned" : " is parted from");
  context_.log.note(done + " by the operator", *id);
  return done + (site.left ? ": its ticket admits nobody any more" : ": its ticket is still good");
}

Result<std::string> OperatorCommands::revokeTicket(const std::string& who) {
  if (!publisher_.writable()) return kNothingChanged;
  const Result<SiteId> id = find(who);
  if (!id) return id.error();
  KnownSite& site = *sites_.find(*id);
  if (site.left) return Error{"the ticket of " + sites_.nameOf(*id) + " is void already"};
  audit(AuditEvent::ticketRevoked, *id, {});
  admission_.voidTicket(site);
  const std::string done = "the ticket of " + sites_.nameOf(*id) + " is void";
  context_.log.note(done + ", by the operator", *id);
  return done + (peers_.bySite(*id) == nullptr ? "" : "; the site stays until its connection ends");
}

std::string OperatorCommands::linksRevoked() {
  audit(AuditEvent::linksRevoked, kNoSite, {});
  context_.log.note("every open link is void, by the operator");
  return "every link made before is void";
}

std::string OperatorCommands::keysRotated() {
  const std::size_t renewed = admission_.renewTickets();
  const std::string detail =
      times(renewed, "connected site") + (renewed == 1 ? " has" : " have") + " a new ticket";
  audit(AuditEvent::keysRotated, kNoSite, detail);
  context_.log.note("new keys, by the operator: " + detail);
  return "every link and ticket made before is void; " + detail;
}

void OperatorCommands::invited(sync::Role role) {
  audit(AuditEvent::invited, kNoSite, std::string("a link for one ") + sync::toString(role));
}

}  // namespace tandem::server
