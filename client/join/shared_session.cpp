#include "client/join/shared_session.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

#include "assets/base/assert.h"
#include "sync/transport/socket_transport.h"

namespace tandem::client {

using namespace sync;

void SharedSession::exchange(ServerConnection& connection, std::size_t partCount) {
  ASSERT(partCount <= kMaxParts);
  ToNetwork commands;
  {
    const std::lock_guard lock(mutex_);
    toMain_.sites = connection.sites();
    toMain_.owner.resize(partCount);
    toMain_.coHolders.resize(partCount);
    for (std::size_t i = 0; i < partCount; ++i) {
      const auto part = static_cast<PartId>(i);
      toMain_.owner[i] = connection.owner(part);
      const std::span<const SiteId> coHolders = connection.coHolders(part);
      toMain_.coHolders[i].assign(coHolders.begin(), coHolders.end());
    }
    takeDocument(connection.document());
    toMain_.presenting = connection.presentations().view(partCount);
    addChat(toMain_.chat, connection.presentations().drainChat());
    for (Notice& notice : connection.drainNotices()) toMain_.notices.push_back(std::move(notice));
    const TransportCounters before = toMain_.statistics.transport;
    toMain_.statistics = connection.statistics();
    measureRates(before, toMain_.statistics.transport);
    toMain_.stage = connection.stage();
    toMain_.reason = connection.reason();
    toMain_.voiceUrl = connection.voiceUrl();
    if (const auto* sockets = dynamic_cast<SocketTransport*>(connection.transport()))
      toMain_.udp = sockets->stateOverUdp(0);
    commands.worldFromCamera = toNetwork_.worldFromCamera;
    std::swap(commands.revokes, toNetwork_.revokes);
    std::swap(commands.resetParts, toNetwork_.resetParts);
    std::swap(commands.documentWishes, toNetwork_.documentWishes);
    std::swap(commands.says, toNetwork_.says);
    commands.shown = toNetwork_.shown;
  }
  connection.setCamera(commands.worldFromCamera);
  for (const PartId part : commands.revokes) connection.revoke(part);
  if (commands.resetParts) connection.resetParts();
  for (DocumentWish& wish : commands.documentWishes) connection.document().want(std::move(wish));
  connection.presentations().show(commands.shown);
  for (const Say& said : commands.says) connection.presentations().say(said);
}

/// Adds what the document's news are to those that the main thread has not read yet.
void SharedSession::takeDocument(SessionDocument& document) {
  DocumentNews news = document.drainNews();
  if (news.anew)
    toMain_.document = std::move(news);
  else
    std::move(news.entries.begin(), news.entries.end(), std::back_inserter(toMain_.document.entries));
  toMain_.documentStanding = document.standing();
}

/// Bytes since the last exchange as a rate, through a low-pass of the first order with a weight of 0.05.
void SharedSession::measureRates(const TransportCounters& before, const TransportCounters& after) {
  const auto rate = [](std::uint64_t now, std::uint64_t then, double& kbit_s) {
    // A new connection counts from zero.
    const double present = now >= then ? static_cast<double>(now - then) * 8e-3 / toSeconds(kPeriod) : 0.0;
    kbit_s += 0.05 * (present - kbit_s);
    ASSERT(kbit_s >= 0.0);
  };
  rate(after.stateBytesOut + after.controlBytesOut, before.stateBytesOut + before.controlBytesOut,
       toMain_.sentKbit_s);
  rate(after.stateBytesIn + after.controlBytesIn, before.stateBytesIn + before.controlBytesIn,
       toMain_.receivedKbit_s);
}

void SharedSession::notice(Notice notice) {
  const std::lock_guard lock(mutex_);
  toMain_.notices.push_back(std::move(notice));
}

std::vector<Notice> SharedSession::read(ViewModel& model, std::size_t partCount) {
  std::unique_lock lock(mutex_);
  model.sites = toMain_.sites;
  model.owner = toMain_.owner;
  model.owner.resize(partCount, kNoSite);
  model.coHolders = toMain_.coHolders;
  for (const SiteView& site : model.sites)
    if (site.self) model.role = site.info.role;
  model.connection.connected = toMain_.stage == ServerConnection::Stage::ready;
  model.connection.status = model.connection.connected                        ? "connected"
                            : toMain_.stage == ServerConnection::Stage::ended ? "ended: " + toMain_.reason
                            : toMain_.reason.empty()                          ? "connecting"
                                                     : "reconnecting: " + toMain_.reason;
  model.connection.roundTrip_ms = model.connection.connected ? toMain_.statistics.roundTrip_ms : 0.0;
  model.connection.lossUp = toMain_.statistics.lossUp;
  model.connection.lossDown = toMain_.statistics.lossDown;
  model.connection.playOut_ms = toMain_.statistics.playOut_ms;
  model.connection.sentKbit_s = toMain_.sentKbit_s;
  model.connection.receivedKbit_s = toMain_.receivedKbit_s;
  model.connection.stateOverUdp = toMain_.udp;
  model.connection.voiceUrl = toMain_.voiceUrl;
  model.documentStanding = toMain_.documentStanding;
  const DocumentNews news = std::exchange(toMain_.document, {});
  model.presenting = toMain_.presenting;
  std::vector<ChatLine> chat = std::exchange(toMain_.chat, {});
  std::vector<Notice> notices = std::exchange(toMain_.notices, {});
  lock.unlock();
  if (news.anew) document_.clear();
  for (const document::Entry& entry : news.entries) document_.put(entry);
  model.document = &document_;
  addChat(chat_, std::move(chat));
  model.chat = chat_;
  return notices;
}

void SharedSession::act(const ViewActions& actions) {
  const std::lock_guard lock(mutex_);
  toNetwork_.worldFromCamera = actions.worldFromCamera;
  if (actions.revoke != kNoPart) toNetwork_.revokes.push_back(actions.revoke);
  toNetwork_.resetParts = toNetwork_.resetParts || actions.resetParts;
  for (const DocumentWish& wish : actions.documentWishes) toNetwork_.documentWishes.push_back(wish);
  toNetwork_.shown = actions.shown;
  toNetwork_.says.insert(toNetwork_.says.end(), actions.says.begin(), actions.says.end());
}

void SharedSession::want(const DocumentWish& wish) {
  const std::lock_guard lock(mutex_);
  toNetwork_.documentWishes.push_back(wish);
}

bool SharedSession::ended(std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (toMain_.stage != ServerConnection::Stage::ended) return false;
  reason = toMain_.reason;
  return true;
}

ConnectionStatistics SharedSession::statistics() {
  const std::lock_guard lock(mutex_);
  return toMain_.statistics;
}

}  // namespace tandem::client
