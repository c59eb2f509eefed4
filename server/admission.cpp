#include "server/admission.h"
#include "sync/wire/limits.h"

#include <sodium.h>

#include <algorithm>
#include <span>
#include <string_view>

namespace tandem::server {
namespace {

// What is signed: a context, so that no other signature by this key can pass for a ticket, then the
// fixed-size payload.
constexpr std::string_view kContext = "tandem-ticket-1";
constexpr std::size_t kNonceBytes = 16;
// version, kind, role, site (2, big-endian), expires (8, big-endian), nonce.
constexpr std::size_t kPayloadBytes = 1 + 1 + 1 + 2 + 8 + kNonceBytes;
// 93 bytes, a multiple of 3: base64 has no spare bits, so that a ticket has exactly one text.
constexpr std::size_t kTicketBytes = kPayloadBytes + crypto_sign_BYTES;
static_assert(kTicketBytes % 3 == 0);
constexpr std::size_t kTicketLength = kTicketBytes / 3 * 4;
static_assert(kTicketLength <= sync::kMaxCredentialLength);
constexpr std::uint8_t kVersion = 1;
constexpr std::string_view kKnockContext = "tandem-knock-1";
constexpr std::size_t kKnockHalf = std::tuple_size_v<sync::Knock> / 2;
static_assert(std::tuple_size_v<sync::Knock> == kNonceBytes);

void initialiseSodium() {
  static const int ready = sodium_init();  // 0: done now, 1: was done, -1: no randomness on this machine
  ASSERT(ready >= 0);
}

std::array<std::uint8_t, kContext.size() + kPayloadBytes> signedBytes(
    std::span<const std::uint8_t, kPayloadBytes> payload) {
  std::array<std::uint8_t, kContext.size() + kPayloadBytes> bytes{};
  std::copy(kContext.begin(), kContext.end(), bytes.begin());
  std::copy(payload.begin(), payload.end(), bytes.begin() + kContext.size());
  return bytes;
}

std::array<std::uint8_t, kPayloadBytes> payloadOf(const Ticket& ticket) {
  std::array<std::uint8_t, kPayloadBytes> out{};
  out[0] = kVersion;
  out[1] = ticket.resume ? 1 : 0;
  out[2] = static_cast<std::uint8_t>(ticket.role);
  out[3] = static_cast<std::uint8_t>(ticket.site >> 8);
  out[4] = static_cast<std::uint8_t>(ticket.site & 0xff);
  for (int i = 0; i < 8; ++i)
    out[5 + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(ticket.expires) >> (56 - 8 * i));
  std::size_t length = 0;
  const int bad = sodium_hex2bin(out.data() + 13, kNonceBytes, ticket.nonce.data(), ticket.nonce.size(),
                                 nullptr, &length, nullptr);
  ASSERT(bad == 0 && length == kNonceBytes);
  return out;
}

Result<Ticket> ticketOf(std::span<const std::uint8_t, kPayloadBytes> payload) {
  if (payload[0] != kVersion) return Error{"credential: made by another version of the server"};
  if (payload[1] > 1 || payload[2] > static_cast<std::uint8_t>(sync::Role::instructor))
    return Error{"credential: unknown kind or role"};
  Ticket ticket;
  ticket.resume = payload[1] == 1;
  ticket.role = static_cast<sync::Role>(payload[2]);
  ticket.site = static_cast<SiteId>((payload[3] << 8) | payload[4]);
  std::uint64_t expires = 0;
  for (int i = 0; i < 8; ++i) expires = (expires << 8) | payload[5 + i];
  ticket.expires = static_cast<std::int64_t>(expires);
  std::array<char, 2 * kNonceBytes + 1> hex{};
  sodium_bin2hex(hex.data(), hex.size(), payload.data() + 13, kNonceBytes);
  ticket.nonce = hex.data();
  return ticket;
}

/// The second half of the knock that begins with these bytes.
std::array<std::uint8_t, kKnockHalf> proofFor(const SigningKey& key, const sync::Knock& knock) {
  static_assert(crypto_auth_hmacsha256_KEYBYTES == std::tuple_size_v<SigningKey::Seed>);
  std::array<std::uint8_t, kKnockContext.size() + kKnockHalf> message{};
  const auto end = std::copy(kKnockContext.begin(), kKnockContext.end(), message.begin());
  std::copy_n(knock.begin(), kKnockHalf, end);
  std::array<std::uint8_t, crypto_auth_hmacsha256_BYTES> mac{};
  crypto_auth_hmacsha256(mac.data(), message.data(), message.size(), key.seed().data());
  std::array<std::uint8_t, kKnockHalf> half{};
  std::copy_n(mac.begin(), half.size(), half.begin());
  return half;
}

}  // namespace

SigningKey::SigningKey(const Seed& seed) : seed_(seed) {
  initialiseSodium();
  static_assert(crypto_sign_SEEDBYTES == sizeof(seed_));
  static_assert(crypto_sign_PUBLICKEYBYTES == sizeof(open_));
  static_assert(crypto_sign_SECRETKEYBYTES == sizeof(secret_));
  crypto_sign_seed_keypair(open_.data(), secret_.data(), seed_.data());
}

SigningKey makeSigningKey() {
  initialiseSodium();
  SigningKey::Seed seed{};
  randombytes_buf(seed.data(), seed.size());
  return SigningKey(seed);
}

std::string makeNonce() {
  initialiseSodium();
  std::array<std::uint8_t, kNonceBytes> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  std::array<char, 2 * kNonceBytes + 1> hex{};
  sodium_bin2hex(hex.data(), hex.size(), bytes.data(), bytes.size());
  return hex.data();
}

std::string makeNonce(const SigningKey& key) {
  initialiseSodium();
  sync::Knock knock{};
  randombytes_buf(knock.data(), kKnockHalf);
  const auto proof = proofFor(key, knock);
  std::copy(proof.begin(), proof.end(), knock.begin() + kKnockHalf);
  std::array<char, 2 * kNonceBytes + 1> hex{};
  sodium_bin2hex(hex.data(), hex.size(), knock.data(), knock.size());
  return hex.data();
}

bool knows(const SigningKey& key, const sync::Knock& knock) {
  initialiseSodium();
  return sodium_memcmp(proofFor(key, knock).data(), knock.data() + kKnockHalf, kKnockHalf) == 0;
}

std::string sign(const Ticket& ticket, const SigningKey& key) {
  const auto payload = payloadOf(ticket);
  const auto message = signedBytes(payload);
  std::array<std::uint8_t, kTicketBytes> bytes{};
  std::copy(payload.begin(), payload.end(), bytes.begin());
  crypto_sign_detached(bytes.data() + kPayloadBytes, nullptr, message.data(), message.size(),
                       key.secret().data());
  std::array<char, kTicketLength + 1> text{};
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(),
                    sodium_base64_VARIANT_URLSAFE_NO_PADDING);
  return text.data();
}

Result<Ticket> verify(const std::string& text, const SigningKey& key, std::int64_t unixNow) {
  const Error notOurs{"credential: not signed by this server"};
  if (text.size() != kTicketLength) return notOurs;
  std::array<std::uint8_t, kTicketBytes> bytes{};
  std::size_t length = 0;
  const int bad = sodium_base642bin(bytes.data(), bytes.size(), text.data(), text.size(), nullptr, &length,
                                    nullptr, sodium_base64_VARIANT_URLSAFE_NO_PADDING);
  if (bad != 0 || length != kTicketBytes) return notOurs;
  const std::span<const std::uint8_t, kPayloadBytes> payload(bytes.data(), kPayloadBytes);
  const auto message = signedBytes(payload);
  if (crypto_sign_verify_detached(bytes.data() + kPayloadBytes, message.data(), message.size(),
                                  key.open().data()) != 0)
    return notOurs;
  Result<Ticket> ticket = ticketOf(payload);
  if (ticket && ticket->expires <= unixNow) return Error{"credential: expired"};
  return ticket;
}

}  // namespace tandem::server
