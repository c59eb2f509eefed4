#include "server/journal/database_head.h"

#include <cstring>

namespace tandem::server {

Digest chainOf(const DatabaseHead& head) {
  Bytes bytes;
  bytes.text("head").digest(head.session).text(head.scene).number(head.sequence).digest(head.previousChain);
  bytes.digest(head.sum.value()).number(static_cast<std::uint64_t>(head.sessionTime));
  bytes.number(head.epochFloor).number(head.lastSite);
  return digestOf(bytes.view());
}

DigestSum sumOf(const Digest& value) {
  DigestSum sum;
  sum.add(value);
  return sum;
}

std::string inRow(const DatabaseHead& head) {
  Bytes bytes;
  bytes.digest(head.previousChain).digest(head.sum.value()).digest(head.chain);
  return bytes.number(static_cast<std::uint64_t>(head.sessionTime)).view();
}

bool takeFromRow(const std::string& bytes, DatabaseHead& head) {
  Digest parts[3];
  std::uint64_t time = 0;
  if (bytes.size() != sizeof parts + sizeof time) return false;
  std::memcpy(parts, bytes.data(), sizeof parts);
  for (std::size_t i = 0; i < sizeof time; ++i)
    time |= std::uint64_t{static_cast<std::uint8_t>(bytes[sizeof parts + i])} << (8 * i);
  head.previousChain = parts[0];
  head.sum = sumOf(parts[1]);
  head.chain = parts[2];
  head.sessionTime = static_cast<sync::Micros>(time);
  return true;
}

}  // namespace tandem::server
