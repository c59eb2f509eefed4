#include "server/document_service.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"
#include "assets/document/entry_check.h"
#include "sync/wire/document_codec.h"
#include "sync/wire/limits.h"

namespace tandem::server {
namespace {

using document::Refusal;

constexpr std::size_t kChunkBytes = 32 * 1024;  // one entry may exceed it by its own size

}  // namespace

DocumentService::DocumentService(const SessionConfig& config, SessionContext& context,
                                 const sync::Transport& transport, const Sites& sites, Publisher& publisher)
    : maxBacklogBytes_(config.maxBacklogBytes),
      context_(context),
      transport_(transport),
      sites_(sites),
      publisher_(publisher) {}

void DocumentService::restore(const JournalContents& contents) {
  document_.restore(contents.document);
  durable_ = content().revision();
}

void DocumentService::onPut(const Peer& peer, const sync::PutEntry& request) {
  ASSERT(peer.stage == Stage::ready);
  if (!publisher_.writable()) {
    publisher_.sendTo(peer,
                      sync::PutReply{request.request, Refusal::notNow, toString(Refusal::notNow), 0, 0});
    return;
  }
  const document::By by{peer.site, sites_.all().at(peer.site).info.name, request.request, context_.unixNow()};
  SharedDocument::Answer answer = document_.put(request, peer.role, by);
  if (!answer.record) {
    publisher_.sendTo(peer, std::move(answer.reply));
    return;
  }
  publisher_.keep(*answer.record);
  undurable_.push_back({publisher_.lastKept(), answer.record->entry.revision});
  publisher_.sendTo(peer, std::move(answer.reply));
  publisher_.publish(sync::DocumentChanged{std::move(answer.record->entry)});
}

void DocumentService::onRequest(Peer& peer, const sync::DocumentRequest& request) {
  DocumentProgress& progress = peer.document;
  if (!progress.active) active_.push_back(peer.serial);
  progress = {};
  progress.active = true;
  progress.target = content().revision();
  const bool current = request.known != 0 && request.known == progress.target;
  progress.first = !current;
  if (current) progress.sent = progress.target;
}

void DocumentService::takeDurable() {
  const std::uint64_t durable = publisher_.durableUpTo();
  while (!undurable_.empty() && undurable_.front().number <= durable) {
    durable_ = undurable_.front().revision;
    undurable_.pop_front();
  }
}

void DocumentService::sendChunks(Peers& peers) {
  takeDurable();
  std::erase_if(active_, [&](PeerSerial serial) {
    Peer* peer = peers.bySerial(serial);
    if (peer != nullptr) sendChunks(*peer);
    return peer == nullptr || !peer->document.active;
  });
}

void DocumentService::sendChunks(Peer& peer) {
  DocumentProgress& progress = peer.document;
  while (progress.active && peer.welcomed && transport_.controlBacklog(peer.connection) < maxBacklogBytes_) {
    const sync::DocumentChunk chunk = nextChunk(progress);
    if (chunk.entries.empty() && !chunk.last) return;
    publisher_.sendNow(peer.connection, chunk);
    progress.first = false;
    progress.active = !chunk.last;
    peer.lastReceived = context_.now();  // a slow link takes its time; a dead one shows in the backlog
  }
}

sync::DocumentChunk DocumentService::nextChunk(DocumentProgress& progress) const {
  sync::DocumentChunk chunk;
  chunk.first = progress.first;
  chunk.revision = progress.target;
  std::size_t bytes = 0;
  auto next = content().after(progress.sent);
  const auto end = content().after(std::min(progress.target, durable_));
  for (; next != end && bytes < kChunkBytes && chunk.entries.size() < sync::kMaxChunkEntries; ++next) {
    const document::Entry& entry = *content().find(next->second);
    bytes += sync::kEntryHead + entry.authorName.size() + document::sizeOf(entry.body);
    chunk.entries.push_back(entry);
    progress.sent = next->first;
  }
  chunk.last = next == content().after(progress.target);
  return chunk;
}

}  // namespace tandem::server
