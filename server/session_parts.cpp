// Who owns what: requests about parts, leases, and the poses that the journal keeps.

#include <algorithm>

#include "server/session_state.h"

namespace tandem::server {
namespace {

constexpr std::size_t kResetsPerStep = 64;
constexpr std::size_t kAnswersKept = 16;  // commands of one site that may be repeated

}  // namespace

/// Writes a part's new record to the journal, then tells all.
void Session::State::partChanged(const sync::PartRecord& record) {
  moved[record.part] = false;
  keep(record);
  tellAll(sync::OwnershipChanged{record});
}

void Session::State::freeParts(const std::vector<sync::PartRecord>& records, const char* why) {
  for (const sync::PartRecord& record : records) {
    partChanged(record);
    const std::string heir = record.owner == kNoSite ? "free" : "with " + nameOf(record.owner);
    say("part " + scene.parts[record.part].name + " is " + heir + ": " + why);
  }
}

void Session::State::answerGrab(Peer& peer, const sync::OwnershipTable::Decision& decision) {
  const bool granted = decision.reply.denial == sync::Denial::none;
  if (!granted && !decision.repeated) ++counts.denials;
  if (!decision.changed) {
    tell(peer, decision.reply);
    return;
  }
  const sync::PartRecord& record = decision.reply.part;
  moved[record.part] = false;
  keep(record);
  tell(peer, decision.reply);
  tellAll(sync::OwnershipChanged{record});
  if (!granted) return;
  ++counts.grants;
  say("part " + scene.parts[record.part].name + " granted to " + nameOf(peer.site) + ", epoch " +
      std::to_string(record.epoch));
}

/// What a request is answered with while the journal cannot be written.
static sync::PartRecord partAsItIs(const sync::OwnershipTable& table, std::size_t partCount, PartId part) {
  if (part < partCount) return table.part(part);
  sync::PartRecord unknown;
  unknown.part = part;
  return unknown;
}

void Session::State::onGrab(Peer& peer, const sync::Grab& request) {
  if (!journalFailure.empty()) {
    ++counts.denials;
    tell(peer, sync::GrabReply{request.request, sync::Denial::recovering,
                               partAsItIs(table, scene.parts.size(), request.part)});
    return;
  }
  if (!assets::roleMaySet(scene, request.part, static_cast<unsigned>(peer.role))) {
    ++counts.denials;
    say(nameOf(peer.site) + " may not set the control " + scene.parts[request.part].name);
    tell(peer, sync::GrabReply{request.request, sync::Denial::roleForbids, table.part(request.part)});
    return;
  }
  answerGrab(peer, table.grab(peer.site, peer.role, request, now));
}

void Session::State::onReclaim(Peer& peer, const sync::Reclaim& request) {
  if (!journalFailure.empty()) {
    ++counts.denials;
    tell(peer, sync::GrabReply{request.request, sync::Denial::recovering,
                               partAsItIs(table, scene.parts.size(), request.part)});
    return;
  }
  answerGrab(peer, table.reclaim(peer.site, peer.role, request, now));
}

void Session::State::onRelease(Peer& peer, const sync::Release& request) {
  const bool observer = peer.role == sync::Role::observer;
  if (observer || !journalFailure.empty()) {
    ++counts.denials;
    tell(peer,
         sync::ReleaseReply{request.request, observer ? sync::Denial::roleForbids : sync::Denial::recovering,
                            partAsItIs(table, scene.parts.size(), request.part)});
    return;
  }
  const auto decision = table.release(peer.site, request);
  if (!decision.changed) {
    if (decision.reply.denial != sync::Denial::none) ++counts.denials;
    tell(peer, decision.reply);
    return;
  }
  ++counts.releases;
  const sync::PartRecord& record = decision.reply.part;
  moved[record.part] = false;
  keep(record);
  tell(peer, decision.reply);
  tellAll(sync::OwnershipChanged{record});
  say("part " + scene.parts[record.part].name + " released by " + nameOf(peer.site) +
      (record.owner == kNoSite ? "" : ", now with " + nameOf(record.owner)));
}

void Session::State::onEngage(Peer& peer, const sync::Engage& request) {
  const auto decision = table.engage(peer.site, peer.role, request, now);
  if (decision.reply.denial != sync::Denial::none) ++counts.denials;
  if (decision.changed) say(nameOf(peer.site) + " is engaged in part " + scene.parts[request.part].name);
  tell(peer, decision.reply);
}

void Session::State::onDisengage(Peer& peer, const sync::Disengage& request) {
  const auto decision = table.disengage(peer.site, request);
  if (decision.changed) say(nameOf(peer.site) + " lets part " + scene.parts[request.part].name + " be");
  tell(peer, decision.reply);
}

/// Behind the records of the parts: what has changed since the last time.
void Session::State::tellMembers() {
  for (const sync::MemberRecord& members : table.takeChangedMembers()) tellAll(sync::MembersChanged{members});
}

/// Whether this is a new command of an instructor; otherwise it has been answered.
bool Session::State::mayCommand(Peer& peer, sync::RequestId request) {
  for (const sync::CommandReply& answer : known[peer.site].answers) {
    if (answer.request != request) continue;
    tell(peer, answer);
    return false;
  }
  if (reset && reset->site == peer.site && reset->request == request)
    return false;  // its answer is on the way
  if (peer.role != sync::Role::instructor) {
    ++counts.denials;
    answerCommand(peer.site, request, false, "only an instructor may do this");
    return false;
  }
  if (!journalFailure.empty()) {
    answerCommand(peer.site, request, false, "the server cannot write its journal");
    return false;
  }
  return true;
}

void Session::State::answerCommand(SiteId site, sync::RequestId request, bool done,
                                   const std::string& reason) {
  auto& answers = known[site].answers;
  answers.push_back({request, done, reason});
  if (answers.size() > kAnswersKept) answers.pop_front();
  if (const Peer* peer = peerOf(site)) tell(*peer, answers.back());
}

void Session::State::onRevoke(Peer& peer, const sync::Revoke& request) {
  if (!mayCommand(peer, request.request)) return;
  if (request.part >= scene.parts.size()) {
    answerCommand(peer.site, request.request, false, "no such part");
    return;
  }
  const auto record = table.revoke(request.part, now);
  if (record) {
    partChanged(*record);
    say("part " + scene.parts[request.part].name + " taken away by " + nameOf(peer.site));
  }
  answerCommand(peer.site, request.request, record.has_value(), record ? "" : "nobody owns it");
}

void Session::State::onReset(Peer& peer, const sync::ResetParts& request) {
  if (!mayCommand(peer, request.request)) return;
  if (reset) {
    answerCommand(peer.site, request.request, false, "another reset is under way");
    return;
  }
  reset = State::Reset{};
  reset->site = peer.site;
  reset->request = request.request;
  for (const sync::PartRecord& record : table.records())
    if (record.owner == kNoSite) reset->left.push_back(record.part);
  say("parts put back by " + nameOf(peer.site));
}

void Session::State::continueReset() {
  if (!reset) return;
  for (std::size_t i = 0; i < kResetsPerStep && !reset->left.empty() && journalFailure.empty(); ++i) {
    const PartId part = reset->left.back();
    reset->left.pop_back();
    if (table.part(part).owner != kNoSite) continue;  // taken meanwhile
    if (const auto record = table.reset(part, now)) partChanged(*record);
  }
  const bool failed = !journalFailure.empty();
  if (!reset->left.empty() && !failed) return;
  const Reset ended = *std::exchange(reset, std::nullopt);
  answerCommand(ended.site, ended.request, !failed, failed ? "the server cannot write its journal" : "");
}

/// Where owned parts are now and then, so that a crash of the server and of an owner together loses little.
void Session::State::keepPoses() {
  for (const PartId part : movedParts) {
    if (!moved[part]) continue;  // a newer record of it was kept meanwhile
    moved[part] = false;
    if (journalFailure.empty()) keep(table.part(part));
  }
  movedParts.clear();
}

}  // namespace tandem::server
