#include "sync/transport/connection.h"

#include <algorithm>

#include "sync/transport/socket_core.h"

namespace tandem::sync {
namespace {

constexpr std::size_t kMaxFarewell = 200;  // bytes that are shown

/// A peer's text as one line of printable ASCII.
std::string oneLine(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes.first(std::min(bytes.size(), kMaxFarewell))) {
    const char c = static_cast<char>(byte);
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  return text;
}

}  // namespace

void Connection::onHandshake() { core_->handshakeDone(*this); }

void Connection::onFrame(FrameType type, std::span<const std::byte> bytes) {
  switch (type) {
    case FrameType::control:
    case FrameType::state:
      return core_->payload(*this, type, bytes);
    case FrameType::farewell:
      farewell = oneLine(bytes);
      return;
    default:
      return core_->greeting(*this, type, bytes);
  }
}

void Connection::onClosed(const std::string& reason) {
  if (!refusal.empty()) return core_->connectionClosed(*this, refusal);
  core_->connectionClosed(*this, farewell.empty() || closing ? reason : farewell);
}

}  // namespace tandem::sync
