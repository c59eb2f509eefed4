#include "server/site_admission.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr std::size_t kMaxStrangers = 1024;                  // that have sent no Hello; sockets allow fewer
constexpr sync::Micros kHelloPatience = 5 * sync::kSecond;   // from connecting to the Hello
constexpr sync::Micros kLoadPatience = 600 * sync::kSecond;  // without a message of a loading site
constexpr sync::Micros kReadyPatience = 15 * sync::kSecond;  // without a message of a ready site
constexpr std::size_t kMaxPartsInWelcome = 8192;  // what fits into kMaxControlBytes; others follow it

/// A name as it may be shown and logged: no control characters, never empty.
std::string shownName(const std::string& name, SiteId site) {
  std::string shown = name;
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return shown.empty() ? "site " + std::to_string(site) : shown;
}

sync::Micros patienceFor(Stage stage) {
  return stage == Stage::hello ? kHelloPatience : stage == Stage::loading ? kLoadPatience : kReadyPatience;
}

}  // namespace

SiteAdmission::SiteAdmission(const Ground& ground) : ground_(ground) { ASSERT(ground.config.places.fit()); }

void SiteAdmission::restore(const std::vector<UsedNonce>& nonces) {
  ASSERT(usedNonces_.empty());
  for (const auto& record : nonces) usedNonces_.insert(record.nonce);
}

void SiteAdmission::onConnected(sync::ConnectionId connection) {
  if (ground_.peers.strangers() >= kMaxStrangers) {
    ++ground_.context.counts.refusedHellos;
    ground_.transport.close(connection);
    return;
  }
  Peer& peer = ground_.peers.add(connection, ground_.context.now());
  peer.address = ground_.transport.addressOf(connection);
}

void SiteAdmission::onHello(Peer& peer, const sync::Hello& hello) {
  ASSERT(peer.stage == Stage::hello && peer.site == kNoSite);
  peer.claimedName = hello.name;
  if (hello.protocolVersion != sync::kProtocolVersion) {
    refuse(peer, sync::Refusal::protocolVersion,
           "this server speaks protocol version " + std::to_string(sync::kProtocolVersion) +
               ", the site version " + std::to_string(hello.protocolVersion) +
               ": use programs of one release");
    return;
  }
  if (!ground_.publisher.writable()) {
    refuse(peer, sync::Refusal::sessionFull, "the server cannot write its journal and admits nobody");
    return;
  }
  const SigningKey& ticketKey = ground_.config.key;
  const SigningKey& key = hello.resume ? ticketKey : ground_.config.linkKey.value_or(ticketKey);
  const Result<Ticket> ticket = verify(hello.credential, key, 0);
  if (!ticket) {
    refuse(peer, sync::Refusal::badCredential, ticket.error().message);
  } else if (ticket->resume != hello.resume) {
    refuse(peer, sync::Refusal::badCredential,
           hello.resume ? "credential: a join token, not a resume ticket"
                        : "credential: a resume ticket, not a join token");
  } else if (ticket->expires <= ground_.context.unixNow()) {
    refuse(peer, sync::Refusal::expired,
           hello.resume ? "the resume ticket has expired: ask for a new link"
                        : "the link has expired: ask for a new one");
  } else if (hello.resume) {
    resume(peer, hello, *ticket);
  } else {
    join(peer, hello, *ticket);
  }
}

std::optional<std::string> SiteAdmission::noPlaceFor(sync::Role role) const {
  return ground_.config.places.refusal(role, ground_.peers.admitted());
}

void SiteAdmission::join(Peer& peer, const sync::Hello& hello, const Ticket& ticket) {
  ASSERT(!ticket.resume);
  if (usedNonces_.contains(ticket.nonce)) {
    refuse(peer, sync::Refusal::alreadyUsed, "the link was used before: ask for a new one");
    return;
  }
  if (const auto reason = noPlaceFor(ticket.role)) {
    refuse(peer, sync::Refusal::sessionFull, *reason);
    return;
  }
  if (ground_.sites.exhausted()) {
    refuse(peer, sync::Refusal::sessionFull, "the session has had as many sites as there are numbers");
    return;
  }
  // The nonce first: the Welcome waits for it, so that no crash lets a token in twice.
  usedNonces_.insert(ticket.nonce);
  ground_.publisher.keep(UsedNonce{ticket.nonce, ticket.expires});
  usedTokens_.push_back(ticket.role);
  admit(peer, ground_.sites.add(ticket.role), hello);
}

void SiteAdmission::resume(Peer& peer, const sync::Hello& hello, const Ticket& ticket) {
  ASSERT(ticket.resume);
  KnownSite* site = ground_.sites.find(ticket.site);
  if (site == nullptr || site->left || site->info.role != ticket.role) {
    refuse(peer, sync::Refusal::badCredential, "the site of this resume ticket has left the session");
    return;
  }
  if (site->budget.exhausted(ground_.context.now())) {
    refuse(peer, sync::Refusal::unexpectedMessage, "this site connects or asks too often");
    return;
  }
  if (const Peer* former = ground_.peers.bySite(ticket.site)) {
    // The site knows better than the server which of its connections is dead.
    const sync::ConnectionId connection = former->connection;
    ground_.publisher.sendNow(connection,
                              sync::Refused{sync::Refusal::alreadyUsed, "the site has connected anew"});
    ground_.transport.close(connection);
    ground_.peers.erase(connection);
  } else if (const auto reason = noPlaceFor(ticket.role)) {
    refuse(peer, sync::Refusal::sessionFull, *reason);
    return;
  }
  admit(peer, *site, hello);
}

void SiteAdmission::admit(Peer& peer, KnownSite& site, const sync::Hello& hello) {
  ASSERT(ground_.peers.bySite(site.info.site) == nullptr);
  ground_.transport.trust(peer.connection);
  site.info.name = shownName(hello.name, site.info.site);
  if (hello.colour != sync::kAnyColour)
    site.info.colour = hello.colour;
  else if (!hello.resume)
    site.info.colour = ground_.sites.freeColour(site.info.site);  // a site that comes back keeps its colour
  site.budget.spend(ground_.context.now(), ControlBudget::kConnection);
  site.info.connected = true;
  site.listed = true;
  ground_.publisher.keep(SiteRecord{site.info, false});
  ground_.publisher.publish(sync::SiteChanged{site.info});  // not to this one: it is still in the hello stage
  peer.site = site.info.site;
  peer.role = site.info.role;
  peer.stage = Stage::loading;
  relist();
  audit(hello.resume ? AuditEvent::returned : AuditEvent::joined, peer, {});

  std::vector<sync::PartRecord> rest;
  ground_.publisher.sendTo(peer, welcomeFor(site, rest));
  for (const sync::PartRecord& part : rest) ground_.publisher.sendTo(peer, sync::OwnershipChanged{part});
  for (const sync::CoHolderRecord& coHolders : ground_.parts.table().allCoHolders())
    ground_.publisher.sendTo(peer, sync::MembersChanged{coHolders});
  ground_.context.log.note(ground_.sites.nameOf(peer.site) + " joined as " + sync::toString(peer.role) +
                               (hello.resume ? " (came back)" : ""),
                           peer.site);
}

std::string SiteAdmission::ticketFor(const KnownSite& site) const {
  Ticket ticket;
  ticket.resume = true;
  ticket.role = site.info.role;
  ticket.site = site.info.site;
  // It is kept nowhere: a resume ticket may be used more than once.
  ticket.nonce = makeNonce(ground_.config.key);
  ticket.expires = ground_.context.unixNow() + ground_.config.ticketLifetime_s;
  return sign(ticket, ground_.config.key);
}

sync::Welcome SiteAdmission::welcomeFor(const KnownSite& site, std::vector<sync::PartRecord>& rest) const {
  sync::Welcome welcome;
  welcome.site = site.info.site;
  welcome.role = site.info.role;
  welcome.resumeTicket = ticketFor(site);
  welcome.sceneHash = ground_.scene.hash();
  welcome.sceneBytes = ground_.scene.size();
  welcome.lease = ground_.config.lease.lease;
  welcome.voiceUrl = ground_.config.voiceUrl;
  welcome.sites = ground_.sites.listed();
  rest = ground_.parts.table().records();
  const auto inWelcome = static_cast<std::ptrdiff_t>(std::min(rest.size(), kMaxPartsInWelcome));
  welcome.parts.assign(rest.begin(), rest.begin() + inWelcome);
  rest.erase(rest.begin(), rest.begin() + inWelcome);
  ASSERT(welcome.site != kNoSite && welcome.parts.size() <= kMaxPartsInWelcome);
  return welcome;
}

void SiteAdmission::refuse(Peer& peer, sync::Refusal refusal, const std::string& reason) {
  SessionContext& context = ground_.context;
  ++(peer.stage == Stage::hello ? context.counts.refusedHellos : context.counts.refusedMessages);
  const sync::ConnectionId connection = peer.connection;
  audit(peer.stage == Stage::hello ? AuditEvent::refused : AuditEvent::parted, peer,
        std::string(sync::toString(refusal)) + ": " + reason);
  ground_.publisher.sendNow(connection, sync::Refused{refusal, reason.substr(0, sync::kMaxTextLength)});
  ground_.transport.close(connection);
  if (peer.stage == Stage::hello)
    context.log.note("connection " + std::to_string(connection) + " refused (" + sync::toString(refusal) +
                     "): " + reason);
  disconnect(connection, std::string("refused (") + sync::toString(refusal) + "): " + reason);
}

void SiteAdmission::onGoodbye(Peer& peer) {
  if (!ground_.publisher.writable()) {  // nothing can be kept, so the parts stay where they are
    refuse(peer, sync::Refusal::unexpectedMessage, "goodbye; the server cannot write its journal");
    return;
  }
  const SiteId id = peer.site;
  const sync::ConnectionId connection = peer.connection;
  audit(AuditEvent::left, peer, {});
  ground_.transport.close(connection);
  ground_.peers.erase(connection);
  takeOff(ground_.sites.at(id), true);
  ground_.context.log.note(ground_.sites.nameOf(id) + " left", id);
}

void SiteAdmission::takeOff(KnownSite& site, bool forGood) {
  const SiteId id = site.info.site;
  ASSERT(ground_.publisher.writable() && ground_.peers.bySite(id) == nullptr);
  ground_.parts.leave(id);
  site.left = site.left || forGood;
  site.listed = false;
  site.info.connected = false;
  ground_.publisher.keep(SiteRecord{site.info, site.left});
  ground_.publisher.publish(sync::SiteLeft{id});
  ground_.relay.forget(id);
  relist();
}

void SiteAdmission::remove(KnownSite& site, bool forGood, const std::string& reason) {
  if (const Peer* peer = ground_.peers.bySite(site.info.site)) {
    const sync::ConnectionId connection = peer->connection;
    ground_.publisher.sendNow(connection, sync::Refused{sync::Refusal::removed, reason});
    ground_.transport.close(connection);
    ground_.peers.erase(connection);
  }
  takeOff(site, forGood);
}

void SiteAdmission::voidTicket(KnownSite& site) {
  site.left = true;
  ground_.publisher.keep(SiteRecord{site.info, true});
}

std::size_t SiteAdmission::renewTickets() {
  std::size_t renewed = 0;
  for (const auto& [connection, peer] : ground_.peers) {
    if (peer.site == kNoSite || ground_.sites.at(peer.site).left) continue;
    ground_.publisher.sendTo(peer, sync::NewTicket{ticketFor(ground_.sites.at(peer.site))});
    ++renewed;
  }
  return renewed;
}

void SiteAdmission::onLost(sync::ConnectionId connection, const std::string& reason) {
  const Peer* peer = ground_.peers.find(connection);
  if (peer == nullptr) return;
  if (peer->site != kNoSite) audit(AuditEvent::lost, *peer, reason);
  disconnect(connection, reason);
}

void SiteAdmission::disconnect(sync::ConnectionId connection, const std::string& reason) {
  const Peer* peer = ground_.peers.find(connection);
  ASSERT(peer != nullptr);
  const SiteId id = peer->site;
  ground_.peers.erase(connection);
  if (id == kNoSite) return;
  KnownSite& site = ground_.sites.at(id);
  site.info.connected = false;
  site.disconnectedAt = ground_.context.now();
  ground_.publisher.publish(sync::SiteChanged{site.info});
  relist();
  ground_.context.log.note(ground_.sites.nameOf(id) + " lost: " + reason, id);
}

void SiteAdmission::audit(AuditEvent event, const Peer& peer, const std::string& detail) {
  AuditEntry entry{event, ground_.context.unixNow(), peer.site, peer.claimedName, {}, peer.address, detail};
  if (peer.site != kNoSite) entry.role = sync::toString(peer.role);
  ground_.context.audit.note(std::move(entry), ground_.context.now());
}

void SiteAdmission::dropSilent() {
  std::vector<sync::ConnectionId> silent;
  for (const auto& [connection, peer] : ground_.peers)
    if (ground_.context.now() - peer.lastReceived > patienceFor(peer.stage)) silent.push_back(connection);
  for (const sync::ConnectionId connection : silent) {
    ground_.transport.close(connection);
    onLost(connection, "nothing heard from it for too long");
  }
}

void SiteAdmission::relist() {
  for (const SiteId site : ground_.sites.relist(ground_.context.now())) {
    ground_.publisher.publish(sync::SiteLeft{site});
    ground_.relay.forget(site);
  }
}

void SiteAdmission::housekeeping() {
  dropSilent();
  relist();
}

std::vector<sync::Role> SiteAdmission::drainUsedTokens() { return std::exchange(usedTokens_, {}); }

}  // namespace tandem::server
