#include "server/scene_transfer.h"

#include <algorithm>
#include <utility>

#include "assets/base/assert.h"
#include "assets/scene/scene_package.h"

namespace tandem::server {

SceneTransfer::SceneTransfer(std::span<const std::byte> package, const SessionConfig& config,
                             SessionContext& context, const sync::Transport& transport, Publisher& publisher)
    : package_(package),
      chunkBytes_(std::clamp<std::size_t>(config.chunkBytes, 1, sync::kMaxChunkBytes)),
      maxBacklogBytes_(config.maxBacklogBytes),
      hash_(assets::contentHash(package)),
      context_(context),
      transport_(transport),
      publisher_(publisher) {}

Status SceneTransfer::onRequest(Peer& peer, const sync::SceneRequest& request) {
  ASSERT(peer.stage != Stage::hello);
  if (request.offset > package_.size())
    return Error{"scene request: offset " + std::to_string(request.offset) + " is beyond the package's " +
                 std::to_string(package_.size())};
  peer.transfer.offset = request.offset;
  const bool had = std::exchange(peer.transfer.active, request.offset < package_.size());
  if (peer.transfer.active && !had) active_.push_back(peer.serial);
  return {};
}

void SceneTransfer::sendChunks(Peers& peers) {
  std::erase_if(active_, [&](PeerSerial serial) {
    Peer* peer = peers.bySerial(serial);
    if (peer != nullptr) sendChunks(*peer);
    return peer == nullptr || !peer->transfer.active;
  });
}

void SceneTransfer::sendChunks(Peer& peer) {
  TransferProgress& progress = peer.transfer;
  while (progress.active && peer.welcomed && transport_.controlBacklog(peer.connection) < maxBacklogBytes_) {
    ASSERT(progress.offset < package_.size());
    const std::size_t size = std::min<std::size_t>(chunkBytes_, package_.size() - progress.offset);
    const auto* first = reinterpret_cast<const std::uint8_t*>(package_.data()) + progress.offset;
    sync::SceneChunk chunk;
    chunk.offset = progress.offset;
    chunk.bytes.assign(first, first + size);
    publisher_.sendNow(peer.connection, chunk);
    progress.offset += size;
    progress.active = progress.offset < package_.size();
    peer.lastReceived = context_.now();  // a slow link takes its time; a dead one shows in the backlog
  }
  ASSERT(progress.offset <= package_.size());
}

}  // namespace tandem::server
