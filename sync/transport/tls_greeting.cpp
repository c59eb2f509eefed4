#include "sync/transport/tls_greeting.h"

namespace tandem::sync {

std::array<std::byte, 2> encode(const Offer& offer) {
  return {std::byte{offer.version}, std::byte{offer.algorithms}};
}

std::array<std::byte, 9> encode(const Accept& accept) {
  std::array<std::byte, 9> bytes;
  bytes[0] = static_cast<std::byte>(accept.algorithm);
  for (std::size_t i = 0; i < 8; ++i)
    bytes[1 + i] = static_cast<std::byte>(accept.wireId >> (56 - 8 * i) & 0xff);
  return bytes;
}

std::optional<Offer> parseOffer(std::span<const std::byte> bytes) {
  if (bytes.size() < 2) return std::nullopt;
  const Offer offer{std::to_integer<std::uint8_t>(bytes[0]), std::to_integer<std::uint8_t>(bytes[1])};
  if (offer.version == kTransportVersion && bytes.size() != 2) return std::nullopt;
  return offer;
}

std::optional<Accept> parseAccept(std::span<const std::byte> bytes, std::uint8_t offered) {
  if (bytes.size() != 9) return std::nullopt;
  const auto algorithm = std::to_integer<std::uint8_t>(bytes[0]);
  if (algorithm < 1 || algorithm > 2 || (offered >> (algorithm - 1) & 1) == 0) return std::nullopt;
  Accept accept{static_cast<SealAlgorithm>(algorithm), 0};
  for (std::size_t i = 0; i < 8; ++i)
    accept.wireId = accept.wireId << 8 | std::to_integer<std::uint64_t>(bytes[1 + i]);
  return accept;
}

}  // namespace tandem::sync
