#pragma once

// Who may enter, in which role: tokens that the server signs (Ed25519, libsodium), valid for a time and once,
// and resume tickets for sites that lost their connection.

#include <array>
#include <cstdint>
#include <string>

#include "assets/base/result.h"
#include "sync/transport/knock.h"
#include "sync/wire/participant_messages.h"

namespace tandem::server {

/// A server's signing key: 32 bytes of seed, kept in the data directory so that links outlive a restart, and
/// the pair of Ed25519 that follows from it.
class SigningKey {
 public:
  using Seed = std::array<std::uint8_t, 32>;

  SigningKey() : SigningKey(Seed{}) {}
  explicit SigningKey(const Seed& seed);

  const Seed& seed() const { return seed_; }
  const std::array<std::uint8_t, 32>& open() const { return open_; }
  const std::array<std::uint8_t, 64>& secret() const { return secret_; }

 private:
  Seed seed_;
  std::array<std::uint8_t, 32> open_{};
  std::array<std::uint8_t, 64> secret_{};
};
SigningKey makeSigningKey();

/// 32 random hexadecimal digits.
std::string makeNonce();
/// 32 hexadecimal digits, half of them random; the other half proves that the holder of the key made them.
std::string makeNonce(const SigningKey& key);
/// Whether a knock is a nonce that was made with this key: cheap, and no right to enter.
bool knows(const SigningKey& key, const sync::Knock& knock);

struct Ticket {
  bool resume = false;  // false: a join token
  sync::Role role = sync::Role::observer;
  SiteId site = kNoSite;     // resume tickets only
  std::string nonce;         // 32 hexadecimal digits
  std::int64_t expires = 0;  // Unix time, s
};

/// Signs a ticket; ASCII, fits in a link, at most kMaxCredentialLength.
std::string sign(const Ticket& ticket, const SigningKey& key);
/// The ticket, if its signature and form are good and it has not expired at `unixNow`. The session checks
/// whether it was used before.
Result<Ticket> verify(const std::string& text, const SigningKey& key, std::int64_t unixNow);

}  // namespace tandem::server
