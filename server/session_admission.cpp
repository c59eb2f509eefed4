// Who is here: hello, resume, refusals, leaving, and the scene that a new site needs.

#include <algorithm>

#include "server/session_state.h"

namespace tandem::server {
namespace {

constexpr sync::Micros kHelloPatience = 10 * sync::kSecond;    // from connecting to the hello
constexpr sync::Micros kLoadPatience = 600 * sync::kSecond;    // without a word from a loading site
constexpr sync::Micros kReadyPatience = 15 * sync::kSecond;    // without a word from a ready site
constexpr sync::Micros kListedAfterLoss = 60 * sync::kSecond;  // how long the others still see a lost site
constexpr std::size_t kMaxPartsInWelcome = 8192;  // what fits into kMaxControlBytes; others follow it
constexpr std::size_t kMaxLastSite = 0xfffe;

/// A name as it may be shown and logged: no control characters, never empty.
std::string shownName(const std::string& name, SiteId site) {
  std::string shown = name;
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return shown.empty() ? "site " + std::to_string(site) : shown;
}

}  // namespace

void Session::State::onHello(Peer& peer, const sync::Hello& hello) {
  if (hello.protocolVersion != sync::kProtocolVersion) {
    refuse(peer, sync::Refusal::protocolVersion,
           "this server speaks protocol version " + std::to_string(sync::kProtocolVersion) +
               ", the site version " + std::to_string(hello.protocolVersion) +
               ": use programs of one release");
    return;
  }
  if (!journalFailure.empty()) {
    refuse(peer, sync::Refusal::sessionFull, "the server cannot write its journal and admits nobody");
    return;
  }
  const Result<Ticket> ticket = verify(hello.credential, config.key, 0);
  if (!ticket) {
    refuse(peer, sync::Refusal::badCredential, ticket.error().message);
  } else if (ticket->resume != hello.resume) {
    refuse(peer, sync::Refusal::badCredential,
           hello.resume ? "credential: a join token, not a resume ticket"
                        : "credential: a resume ticket, not a join token");
  } else if (ticket->expires <= unixNow) {
    refuse(peer, sync::Refusal::expired,
           hello.resume ? "the resume ticket has expired: ask for a new link"
                        : "the link has expired: ask for a new one");
  } else if (hello.resume) {
    resume(peer, hello, *ticket);
  } else {
    join(peer, hello, *ticket);
  }
}

bool Session::State::full() const {
  const auto connected = std::count_if(peers.begin(), peers.end(),
                                       [](const auto& entry) { return entry.second.site != kNoSite; });
  return static_cast<std::size_t>(connected) >= config.maxSites;
}

void Session::State::join(Peer& peer, const sync::Hello& hello, const Ticket& ticket) {
  if (usedNonces.contains(ticket.nonce)) {
    refuse(peer, sync::Refusal::alreadyUsed, "the link was used before: ask for a new one");
    return;
  }
  if (full() || nextSite > kMaxLastSite) {
    refuse(peer, sync::Refusal::sessionFull, "the session is full");
    return;
  }
  // The nonce first: the Welcome waits for it, so that no crash lets a token in twice.
  usedNonces[ticket.nonce] = ticket.expires;
  keep(UsedNonce{ticket.nonce, ticket.expires});
  usedTokens.push_back(ticket.role);
  KnownSite& site = known[nextSite];
  site.info.site = nextSite++;
  site.info.role = ticket.role;
  admit(peer, site, hello);
}

void Session::State::resume(Peer& peer, const sync::Hello& hello, const Ticket& ticket) {
  const auto at = known.find(ticket.site);
  if (at == known.end() || at->second.left || at->second.info.role != ticket.role) {
    refuse(peer, sync::Refusal::badCredential, "the site of this resume ticket has left the session");
    return;
  }
  if (Peer* former = peerOf(ticket.site)) {
    // The site knows better than the server which of its connections is dead.
    sendControl(former->connection, sync::encodeControl(sync::Refused{sync::Refusal::alreadyUsed,
                                                                      "the site has connected anew"}));
    transport.close(former->connection);
    peers.erase(former->connection);
  } else if (full()) {
    refuse(peer, sync::Refusal::sessionFull, "the session is full");
    return;
  }
  admit(peer, at->second, hello);
}

/// The first colour that the fewest of the listed sites have.
sync::SiteColour Session::State::freeColour(SiteId except) const {
  const auto uses = [&](const sync::SiteColour& colour) {
    return std::count_if(known.begin(), known.end(), [&](const auto& entry) {
      return entry.first != except && entry.second.listed && entry.second.info.colour == colour;
    });
  };
  return *std::min_element(sync::kSiteColours.begin(), sync::kSiteColours.end(),
                           [&](const auto& a, const auto& b) { return uses(a) < uses(b); });
}

void Session::State::admit(Peer& peer, KnownSite& site, const sync::Hello& hello) {
  site.info.name = shownName(hello.name, site.info.site);
  if (hello.colour != sync::kAnyColour)
    site.info.colour = hello.colour;
  else if (!hello.resume)
    site.info.colour = freeColour(site.info.site);  // who comes back keeps the one that they had
  site.info.connected = true;
  site.listed = true;
  keep(SiteRecord{site.info, false});
  tellAll(sync::SiteChanged{site.info});  // not to this one: it is still in the hello stage
  peer.site = site.info.site;
  peer.role = site.info.role;
  peer.stage = Stage::loading;
  relist();

  std::vector<sync::PartRecord> parts;
  tell(peer, welcomeFor(site, parts));
  for (const sync::PartRecord& part : parts) tell(peer, sync::OwnershipChanged{part});
  for (const sync::MemberRecord& members : table.allMembers()) tell(peer, sync::MembersChanged{members});
  say(nameOf(peer.site) + " joined as " + sync::toString(peer.role) + (hello.resume ? " (came back)" : ""));
}

sync::Welcome Session::State::welcomeFor(const KnownSite& site, std::vector<sync::PartRecord>& parts) const {
  Ticket ticket;
  ticket.resume = true;
  ticket.role = site.info.role;
  ticket.site = site.info.site;
  ticket.nonce = std::string(32, '0');  // a resume ticket may be used more than once
  ticket.expires = unixNow + config.ticketLifetime_s;

  sync::Welcome welcome;
  welcome.site = site.info.site;
  welcome.role = site.info.role;
  welcome.resumeTicket = sign(ticket, config.key);
  welcome.sceneHash = sceneHash;
  welcome.sceneBytes = package.size();
  welcome.lease = config.lease.lease;
  welcome.sites = listed;
  parts = table.records();
  const auto inWelcome = std::min(parts.size(), kMaxPartsInWelcome);
  welcome.parts.assign(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(inWelcome));
  parts.erase(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(inWelcome));
  return welcome;
}

/// Says why and closes. `peer` is gone afterwards.
void Session::State::refuse(Peer& peer, sync::Refusal refusal, const std::string& reason) {
  ++(peer.stage == Stage::hello ? counts.refusedHellos : counts.refusedMessages);
  const sync::ConnectionId connection = peer.connection;
  sendControl(connection,
              sync::encodeControl(sync::Refused{refusal, reason.substr(0, sync::kMaxTextLength)}));
  transport.close(connection);
  if (peer.stage == Stage::hello)
    say("connection " + std::to_string(connection) + " refused (" + sync::toString(refusal) + "): " + reason);
  forget(connection, std::string("refused (") + sync::toString(refusal) + "): " + reason);
}

void Session::State::onGoodbye(Peer& peer) {
  if (!journalFailure.empty()) {  // nothing can be kept, so the parts stay where they are
    refuse(peer, sync::Refusal::unexpectedMessage, "goodbye; the server cannot write its journal");
    return;
  }
  const SiteId id = peer.site;
  const sync::ConnectionId connection = peer.connection;
  freeParts(table.leave(id), "its owner left");
  KnownSite& site = known[id];
  site.left = true;
  site.listed = false;
  site.info.connected = false;
  keep(SiteRecord{site.info, true});
  transport.close(connection);
  peers.erase(connection);
  tellAll(sync::SiteLeft{id});
  forgetStates(id);
  relist();
  say(nameOf(id) + " left");
}

/// The connection is over; the site may come back with its ticket. Its parts are its own until their leases
/// run out.
void Session::State::forget(sync::ConnectionId connection, const std::string& reason) {
  const auto at = peers.find(connection);
  if (at == peers.end()) return;
  const SiteId id = at->second.site;
  peers.erase(at);
  if (id == kNoSite) return;
  KnownSite& site = known[id];
  site.info.connected = false;
  site.disconnectedAt = now;
  tellAll(sync::SiteChanged{site.info});
  relist();
  say(nameOf(id) + " lost: " + reason);
}

void Session::State::dropSilent() {
  std::vector<sync::ConnectionId> silent;
  for (const auto& [connection, peer] : peers) {
    const sync::Micros patience = peer.stage == Stage::hello     ? kHelloPatience
                                  : peer.stage == Stage::loading ? kLoadPatience
                                                                 : kReadyPatience;
    if (now - peer.lastHeard > patience) silent.push_back(connection);
  }
  for (const sync::ConnectionId connection : silent) {
    transport.close(connection);
    forget(connection, "nothing heard from it for too long");
  }
}

/// Rebuilds the list that the others see: a lost site is forgotten after a while, the longest lost first if
/// there are more than a Welcome can hold.
void Session::State::relist() {
  const auto unlist = [&](KnownSite& site) {
    site.listed = false;
    tellAll(sync::SiteLeft{site.info.site});
    forgetStates(site.info.site);
  };
  std::vector<KnownSite*> lost;
  std::size_t shown = 0;
  for (auto& [id, site] : known) {
    if (!site.listed) continue;
    if (!site.info.connected && now - site.disconnectedAt > kListedAfterLoss) {
      unlist(site);
      continue;
    }
    ++shown;
    if (!site.info.connected) lost.push_back(&site);
  }
  std::stable_sort(lost.begin(), lost.end(),
                   [](const auto* a, const auto* b) { return a->disconnectedAt < b->disconnectedAt; });
  for (std::size_t i = 0; shown > sync::kMaxSites && i < lost.size(); ++i, --shown) unlist(*lost[i]);
  listed.clear();
  for (const auto& [id, site] : known)
    if (site.listed) listed.push_back(site.info);
}

void Session::State::onSceneRequest(Peer& peer, const sync::SceneRequest& request) {
  if (request.offset > package.size()) {
    refuse(peer, sync::Refusal::unexpectedMessage,
           "scene request: offset " + std::to_string(request.offset) + " is beyond the package's " +
               std::to_string(package.size()));
    return;
  }
  peer.transferOffset = request.offset;
  peer.transferring = request.offset < package.size();
}

void Session::State::sendChunks(Peer& peer) {
  while (peer.transferring && peer.welcomed &&
         transport.controlBacklog(peer.connection) < config.maxBacklogBytes) {
    const std::size_t size = std::min<std::size_t>(config.chunkBytes, package.size() - peer.transferOffset);
    const auto* first = reinterpret_cast<const std::uint8_t*>(package.data()) + peer.transferOffset;
    sync::SceneChunk chunk;
    chunk.offset = peer.transferOffset;
    chunk.bytes.assign(first, first + size);
    sendControl(peer.connection, sync::encodeControl(chunk));
    peer.transferOffset += size;
    peer.transferring = peer.transferOffset < package.size();
    peer.lastHeard = now;  // a slow link takes its time; a dead one shows in the backlog
  }
}

void Session::State::forgetOldNonces() {
  std::erase_if(usedNonces, [&](const auto& entry) { return entry.second <= unixNow; });
}

}  // namespace tandem::server
