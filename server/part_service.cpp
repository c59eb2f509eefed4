#include "server/part_service.h"

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

std::vector<bool> movableParts(const assets::Scene& scene) {
  std::vector<bool> movable;
  for (const auto& part : scene.parts) movable.push_back(part.movable);
  return movable;
}

std::vector<Pose> restPoses(const assets::Scene& scene) {
  std::vector<Pose> poses;
  for (const auto& part : scene.parts) poses.push_back(part.worldFromPart);
  return poses;
}

}  // namespace

PartService::PartService(const assets::Scene& scene, const sync::LeaseRules& lease, SessionContext& context,
                         Publisher& publisher, const Sites& sites)
    : scene_(scene),
      frame_(sync::wireFrame(scene.bounds)),
      context_(context),
      publisher_(publisher),
      sites_(sites),
      table_(movableParts(scene), restPoses(scene), lease),
      moved_(scene.parts.size(), false) {
  movedParts_.reserve(scene.parts.size());
}

void PartService::restore(const std::vector<sync::PartRecord>& records, Epoch floor) {
  std::vector<sync::PartRecord> parts;
  for (const auto& record : records)
    if (record.part < count()) parts.push_back(record);
  if (!parts.empty() || floor > 0) table_.restore(parts, context_.now(), floor);
}

void PartService::resume(const Abandoned& abandoned) {
  for (const sync::PartRecord& grant : abandoned.denied)
    if (table_.withdraw(grant))
      context_.log.note("part " + nameOf(grant.part) + " is free: its grant to " +
                        sites_.nameOf(grant.owner) + " was denied");
  for (const PartId part : abandoned.parts) change(table_.part(part));
}

const std::string& PartService::nameOf(PartId part) const {
  ASSERT(part < count());
  return scene_.parts[part].name;
}

void PartService::keep(const sync::PartRecord& record) {
  ASSERT(record.part < count());
  moved_[record.part] = false;
  publisher_.keep(record);
}

void PartService::change(const sync::PartRecord& record) {
  keep(record);
  publisher_.publish(sync::OwnershipChanged{record});
}

void PartService::freed(const std::vector<sync::PartRecord>& records, const char* why) {
  for (const sync::PartRecord& record : records) {
    change(record);
    const std::string heir = record.owner == kNoSite ? "free" : "with " + sites_.nameOf(record.owner);
    context_.log.note("part " + nameOf(record.part) + " is " + heir + ": " + why);
  }
}

void PartService::answerGrab(const Peer& peer, const sync::OwnershipTable::Decision& decision) {
  const bool granted = decision.reply.denial == sync::Denial::none;
  if (!granted && !decision.repeated) ++context_.counts.denials;
  if (!decision.changed) {
    publisher_.sendTo(peer, decision.reply);
    return;
  }
  const sync::PartRecord& record = decision.reply.part;
  keep(record);
  publisher_.sendTo(peer, decision.reply);
  publisher_.publish(sync::OwnershipChanged{record});
  if (!granted) return;
  ASSERT(record.owner == peer.site);
  ++context_.counts.grants;
  context_.log.note("part " + nameOf(record.part) + " granted to " + sites_.nameOf(peer.site) + ", epoch " +
                        std::to_string(record.epoch),
                    peer.site);
}

/// The record that answers a request while the journal cannot be written; the part may be one that the scene
/// does not have. The table may hold an owner and an epoch that never became durable: no site may learn of
/// them, since the next server gives that epoch to another one (S1).
sync::PartRecord PartService::recordWithoutOwner(PartId part) const {
  sync::PartRecord record;
  record.part = part;
  if (part < count()) record.worldFromPart = table_.part(part).worldFromPart;
  return record;
}

void PartService::onGrab(const Peer& peer, const sync::Grab& request) {
  ASSERT(peer.stage == Stage::ready);
  if (!publisher_.writable()) {
    ++context_.counts.denials;
    publisher_.sendTo(
        peer, sync::GrabReply{request.request, sync::Denial::recovering, recordWithoutOwner(request.part)});
    return;
  }
  if (!assets::roleMaySet(scene_, request.part, static_cast<unsigned>(peer.role))) {
    ++context_.counts.denials;
    context_.log.note(sites_.nameOf(peer.site) + " may not set the control " + nameOf(request.part),
                      peer.site);
    publisher_.sendTo(peer,
                      sync::GrabReply{request.request, sync::Denial::roleForbids, table_.part(request.part)});
    return;
  }
  answerGrab(peer, table_.grab(peer.site, peer.role, request, context_.now()));
}

Pose PartService::poseOf(PartId part, const Pose& worldFromPart) {
  if (part >= count() || sync::contains(frame_, worldFromPart.position)) return worldFromPart;
  ++context_.counts.refusedPoses;
  return table_.part(part).worldFromPart;
}

void PartService::onReclaim(const Peer& peer, const sync::Reclaim& request) {
  ASSERT(peer.stage == Stage::ready);
  if (!publisher_.writable()) {
    ++context_.counts.denials;
    publisher_.sendTo(
        peer, sync::GrabReply{request.request, sync::Denial::recovering, recordWithoutOwner(request.part)});
    return;
  }
  sync::Reclaim checked = request;
  checked.worldFromPart = poseOf(request.part, request.worldFromPart);
  answerGrab(peer, table_.reclaim(peer.site, peer.role, checked, context_.now()));
}

void PartService::onRelease(const Peer& peer, const sync::Release& request) {
  ASSERT(peer.stage == Stage::ready);
  const bool observer = peer.role == sync::Role::observer;
  if (observer || !publisher_.writable()) {
    ++context_.counts.denials;
    publisher_.sendTo(
        peer,
        sync::ReleaseReply{request.request, observer ? sync::Denial::roleForbids : sync::Denial::recovering,
                           recordWithoutOwner(request.part)});
    return;
  }
  sync::Release checked = request;
  checked.worldFromPart = poseOf(request.part, request.worldFromPart);
  const auto decision = table_.release(peer.site, checked);
  if (!decision.changed) {
    if (decision.reply.denial != sync::Denial::none) ++context_.counts.denials;
    publisher_.sendTo(peer, decision.reply);
    return;
  }
  ++context_.counts.releases;
  const sync::PartRecord& record = decision.reply.part;
  ASSERT(record.owner != peer.site);
  keep(record);
  publisher_.sendTo(peer, decision.reply);
  publisher_.publish(sync::OwnershipChanged{record});
  context_.log.note("part " + nameOf(record.part) + " released by " + sites_.nameOf(peer.site) +
                        (record.owner == kNoSite ? "" : ", now with " + sites_.nameOf(record.owner)),
                    peer.site);
}

void PartService::onEngage(const Peer& peer, const sync::Engage& request) {
  if (!publisher_.writable()) {
    ++context_.counts.denials;
    publisher_.sendTo(peer,
                      sync::EngageReply{request.request, sync::Denial::recovering, {request.part, 0, 0, {}}});
    return;
  }
  const auto decision = table_.engage(peer.site, peer.role, request, context_.now());
  if (decision.reply.denial != sync::Denial::none) ++context_.counts.denials;
  if (decision.changed) publisher_.expectPublish();
  if (decision.changed)
    context_.log.note(sites_.nameOf(peer.site) + " is a co-holder of part " + nameOf(request.part),
                      peer.site);
  publisher_.sendTo(peer, decision.reply);
}

void PartService::onDisengage(const Peer& peer, const sync::Disengage& request) {
  const auto decision = table_.disengage(peer.site, request);
  if (decision.changed) publisher_.expectPublish();
  if (decision.changed)
    context_.log.note(sites_.nameOf(peer.site) + " lets part " + nameOf(request.part) + " be", peer.site);
  publisher_.sendTo(peer, decision.reply);
}

void PartService::publishCoHolders() {
  for (const sync::CoHolderRecord& coHolders : table_.drainChangedCoHolders())
    publisher_.publish(sync::MembersChanged{coHolders});
}

bool PartService::revoke(PartId part, SiteId by) {
  ASSERT(part < count());
  const auto record = table_.revoke(part);
  if (!record) return false;
  ASSERT(record->owner == kNoSite);
  change(*record);
  context_.log.note("part " + nameOf(part) + " taken away by " + sites_.nameOf(by), by);
  return true;
}

void PartService::putBack(PartId part) {
  ASSERT(part < count());
  if (table_.part(part).owner != kNoSite) return;
  if (const auto record = table_.reset(part)) change(*record);
}

void PartService::leave(SiteId site) {
  ASSERT(site != kNoSite);
  freed(table_.leave(site), "its owner left");
}

void PartService::expireLeases() {
  if (!publisher_.writable()) return;
  const auto expired = table_.expire(context_.now());
  context_.counts.expiries += expired.size();
  freed(expired, "its lease ran out");
}

bool PartService::accept(SiteId site, const sync::PartState& state) {
  if (!table_.accept(site, state)) return false;
  ASSERT(state.part < count());
  if (!moved_[state.part]) {
    moved_[state.part] = true;
    movedParts_.push_back(state.part);
  }
  return true;
}

void PartService::keepPoses() {
  for (const PartId part : movedParts_) {
    if (!moved_[part]) continue;  // a newer record of it was kept meanwhile
    moved_[part] = false;
    if (publisher_.writable()) keep(table_.part(part));
  }
  movedParts_.clear();
}

}  // namespace tandem::server
