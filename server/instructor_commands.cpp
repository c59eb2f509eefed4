#include "server/instructor_commands.h"

#include <utility>

#include "assets/base/assert.h"

namespace tandem::server {
namespace {

constexpr std::size_t kResetsPerStep = 64;
constexpr std::size_t kAnswersKept = 16;  // commands of one site that may be repeated
constexpr const char* kNoJournal = "the server cannot write its journal";

}  // namespace

InstructorCommands::InstructorCommands(SessionContext& context, Peers& peers, const Sites& sites,
                                       Publisher& publisher, PartService& parts)
    : context_(context), peers_(peers), sites_(sites), publisher_(publisher), parts_(parts) {}

bool InstructorCommands::mayCommand(const Peer& peer, sync::RequestId request) {
  ASSERT(peer.stage == Stage::ready);
  for (const sync::CommandReply& given : answers_[peer.site]) {
    if (given.request != request) continue;
    publisher_.sendTo(peer, given);
    return false;
  }
  if (reset_ && reset_->site == peer.site && reset_->request == request)
    return false;  // the answer follows when the reset is done
  if (peer.role != sync::Role::instructor) {
    ++context_.counts.denials;
    answer(peer.site, request, false, "only an instructor may do this");
    return false;
  }
  if (!publisher_.writable()) {
    answer(peer.site, request, false, kNoJournal);
    return false;
  }
  return true;
}

void InstructorCommands::answer(SiteId site, sync::RequestId request, bool done, const std::string& reason) {
  ASSERT(site != kNoSite);
  auto& answers = answers_[site];
  answers.push_back({request, done, reason});
  if (answers.size() > kAnswersKept) answers.pop_front();
  ASSERT(answers.size() <= kAnswersKept);
  if (const Peer* peer = peers_.bySite(site)) publisher_.sendTo(*peer, answers.back());
}

void InstructorCommands::audit(AuditEvent event, const Peer& peer, const std::string& detail) {
  context_.audit.note({event, context_.unixNow(), peer.site, peer.claimedName, sync::toString(peer.role),
                       peer.address, detail},
                      context_.now());
}

void InstructorCommands::onRevoke(const Peer& peer, const sync::Revoke& request) {
  if (!mayCommand(peer, request.request)) return;
  if (request.part >= parts_.count()) {
    answer(peer.site, request.request, false, "no such part");
    return;
  }
  const SiteId owner = parts_.table().part(request.part).owner;
  const bool revoked = parts_.revoke(request.part, peer.site);
  if (revoked)
    audit(AuditEvent::revoked, peer, "part " + parts_.nameOf(request.part) + " of " + sites_.nameOf(owner));
  answer(peer.site, request.request, revoked, revoked ? "" : "nobody owns it");
}

void InstructorCommands::onReset(const Peer& peer, const sync::ResetParts& request) {
  if (!mayCommand(peer, request.request)) return;
  if (reset_) {
    answer(peer.site, request.request, false, "another reset is under way");
    return;
  }
  reset_ = Reset{};
  reset_->site = peer.site;
  reset_->request = request.request;
  for (const sync::PartRecord& record : parts_.table().records())
    if (record.owner == kNoSite) reset_->left.push_back(record.part);
  context_.log.note("parts put back by " + sites_.nameOf(peer.site), peer.site);
  audit(AuditEvent::reset, peer, std::to_string(reset_->left.size()) + " parts");
}

void InstructorCommands::continueReset() {
  if (!reset_) return;
  for (std::size_t i = 0; i < kResetsPerStep && !reset_->left.empty() && publisher_.writable(); ++i) {
    const PartId part = reset_->left.back();
    reset_->left.pop_back();
    parts_.putBack(part);
  }
  const bool failed = !publisher_.writable();
  if (!reset_->left.empty() && !failed) return;
  const Reset ended = *std::exchange(reset_, std::nullopt);
  ASSERT(failed || ended.left.empty());
  answer(ended.site, ended.request, !failed, failed ? kNoJournal : "");
}

}  // namespace tandem::server
