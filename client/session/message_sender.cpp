#include "client/session/message_sender.h"

#include "assets/base/assert.h"

namespace tandem::client {

using namespace sync;

MessageSender::MessageSender() { bytes_.reserve(kMaxStateBytes); }

void MessageSender::send(const ControlMessage& message) {
  ASSERT(transport_ != nullptr);
  const std::vector<std::byte> bytes = encodeControl(message);
  ASSERT(!bytes.empty() && bytes.size() <= kMaxControlBytes);
  sent_.countControl(bytes.size());
  transport_->sendControl(0, bytes);
}

void MessageSender::sendState(const StateMessage& message, const WireFrame& frame) {
  encodeState(message, frame, bytes_);
  sendEncoded(bytes_);
}

void MessageSender::sendEncoded(std::span<const std::byte> message) {
  ASSERT(transport_ != nullptr);
  ASSERT(!message.empty() && message.size() <= kMaxStateBytes);
  sent_.countState(message);
  unsent_.add(message, [this](auto datagram) { transport_->sendState(0, datagram); });
}

void MessageSender::flush() {
  ASSERT(transport_ != nullptr);
  unsent_.flush([this](auto datagram) { transport_->sendState(0, datagram); });
}

}  // namespace tandem::client
