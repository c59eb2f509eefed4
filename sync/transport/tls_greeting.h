#pragma once

// The two frames with which the ends of a connection introduce themselves, before any message of the session.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sync/transport/seal.h"

namespace tandem::sync {

inline constexpr std::uint8_t kTransportVersion = 1;

/// Client to server: version, mask of algorithms.
struct Offer {
  std::uint8_t version = kTransportVersion;
  std::uint8_t algorithms = 0;
};
/// Server to client: algorithm, connection id of the datagrams.
struct Accept {
  SealAlgorithm algorithm = SealAlgorithm::chaCha20Poly1305;
  std::uint64_t wireId = 0;
};

std::array<std::byte, 2> encode(const Offer& offer);
std::array<std::byte, 9> encode(const Accept& accept);
/// Nothing if the bytes are not an offer. A later version may be longer: only version is read from it.
std::optional<Offer> parseOffer(std::span<const std::byte> bytes);
/// Nothing if the bytes are not an accept, or name an algorithm that is not in `offered`.
std::optional<Accept> parseAccept(std::span<const std::byte> bytes, std::uint8_t offered);

}  // namespace tandem::sync
