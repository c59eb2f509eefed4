#include "sync/wire/state_bundle.h"

#include "assets/base/assert.h"
#include "sync/wire/wire.h"

namespace tandem::sync {
namespace {

constexpr std::size_t kHead = 3;        // version, kind, length of what follows
constexpr std::size_t kLongest = 0xff;  // of a message that another one follows: its length has one byte
constexpr auto kPair = static_cast<std::byte>(StateKind::pair);

}  // namespace

bool StateBundle::add(std::span<const std::byte> message) {
  ASSERT(!message.empty());
  if (!bytes_.empty()) {
    const std::size_t before = bytes_.size() - last_;
    if (before > kLongest || bytes_.size() + kHead + message.size() > kMaxStateBytes) return false;
    const std::byte head[kHead] = {std::byte{kStateVersion}, kPair, static_cast<std::byte>(before)};
    bytes_.insert(bytes_.begin() + static_cast<std::ptrdiff_t>(last_), head, head + kHead);
  }
  last_ = bytes_.size();
  bytes_.insert(bytes_.end(), message.begin(), message.end());
  ASSERT(last_ + message.size() == bytes_.size());
  return true;
}

std::span<const std::byte> popMessage(std::span<const std::byte>& datagram) {
  std::span<const std::byte> message = datagram;
  if (datagram.size() > kHead && datagram[0] == std::byte{kStateVersion} && datagram[1] == kPair) {
    const auto length = std::to_integer<std::size_t>(datagram[2]);
    if (length > 0 && kHead + length < datagram.size()) message = datagram.subspan(kHead, length);
  }
  ASSERT(message.size() <= datagram.size());
  datagram = message.size() == datagram.size() ? datagram.subspan(datagram.size())
                                               : datagram.subspan(kHead + message.size());
  return message;
}

}  // namespace tandem::sync
