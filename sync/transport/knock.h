#pragma once

// The first proof: part of a site's token or ticket, which it shows in its first TLS message (ALPN, RFC
// 7301), so that a server tells it from strangers before it spends anything on them.
//
// 1. A knock is not secret and admits nobody: it gives a site its turn before strangers, some times a minute.
// 2. Only the server can make one: half of it authenticates the other half (server/admission.h).

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace tandem::sync {

/// Bytes 13 to 28 of a credential: its nonce.
using Knock = std::array<std::uint8_t, 16>;

/// The knock of a token or ticket; nothing if the text is no credential of this form.
std::optional<Knock> knockOf(const std::string& credential);

/// The name that a client puts into its list of protocols.
std::string protocolName(const Knock& knock);

/// What a client's first bytes are.
struct FirstBytes {
  enum class Kind : std::uint8_t { incomplete, foreign, clientHello };
  Kind kind = Kind::incomplete;
  std::optional<Knock> knock;
};
inline constexpr std::size_t kMaxFirstBytes = 4096;  // a longer ClientHello is taken without its knock

/// Reads the first bytes of a TCP connection, as far as they have come: a TLS record with a ClientHello (RFC
/// 8446, sections 5.1 and 4.1.2), or something else.
FirstBytes readFirstBytes(std::span<const std::uint8_t> bytes);

}  // namespace tandem::sync
