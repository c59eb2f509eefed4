#pragma once

// Hands the scene package to the sites that ask for it, in chunks, from the byte on that they ask for.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "assets/base/result.h"
#include "server/peers.h"
#include "server/publisher.h"
#include "server/session_config.h"
#include "server/session_context.h"

namespace tandem::server {

class SceneTransfer {
 public:
  /// `package` outlives this.
  SceneTransfer(std::span<const std::byte> package, const SessionConfig& config, SessionContext& context,
                const sync::Transport& transport, Publisher& publisher);

  const std::array<std::uint8_t, 32>& hash() const { return hash_; }
  std::uint64_t size() const { return package_.size(); }

  /// Begins to send from the offset that is asked for; an error if that lies beyond the package.
  Status onRequest(Peer& peer, const sync::SceneRequest& request);
  /// Sends chunks to everybody who waits for some, until the connection's backlog is full: only after the
  /// Welcome has left.
  void sendChunks(Peers& peers);
  bool anyActive() const { return !active_.empty(); }

 private:
  void sendChunks(Peer& peer);

  std::vector<PeerSerial> active_;  // who asked and has not got all
  std::span<const std::byte> package_;
  std::size_t chunkBytes_;
  std::size_t maxBacklogBytes_;
  std::array<std::uint8_t, 32> hash_;
  SessionContext& context_;
  const sync::Transport& transport_;
  Publisher& publisher_;
};

}  // namespace tandem::server
