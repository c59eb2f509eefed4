#include "sync/transport/seal.h"

#include <sodium.h>

#include <algorithm>
#include <cstring>

#include "assets/base/assert.h"

namespace tandem::sync {
namespace {

static_assert(kSealTagBytes == crypto_aead_aes256gcm_ABYTES);
static_assert(kSealTagBytes == crypto_aead_chacha20poly1305_ietf_ABYTES);

constexpr std::uint64_t kCounterMask = kSealCounterLimit - 1;

void ensureSodium() {
  static const bool ready = sodium_init() >= 0;
  ASSERT(ready);
}

void storeBig(std::uint64_t value, std::byte* out) {
  for (int i = 7; i >= 0; --i, value >>= 8) out[i] = static_cast<std::byte>(value & 0xff);
}

std::uint64_t loadBig(const std::byte* in) {
  std::uint64_t value = 0;
  for (int i = 0; i < 8; ++i) value = value << 8 | std::to_integer<std::uint64_t>(in[i]);
  return value;
}

const unsigned char* raw(const std::byte* bytes) { return reinterpret_cast<const unsigned char*>(bytes); }
unsigned char* raw(std::byte* bytes) { return reinterpret_cast<unsigned char*>(bytes); }

}  // namespace

std::uint8_t offeredAlgorithms() {
  ensureSodium();
  constexpr std::uint8_t kChaCha = 1u << 1, kAes = 1u << 0;
  return crypto_aead_aes256gcm_is_available() != 0 ? kChaCha | kAes : kChaCha;
}

SealAlgorithm chooseAlgorithm(std::uint8_t offeredHere, std::uint8_t offeredThere) {
  return (offeredHere & offeredThere & 1u) != 0 ? SealAlgorithm::aes256Gcm : SealAlgorithm::chaCha20Poly1305;
}

struct Aead::State {
  SealAlgorithm algorithm;
  SealKey key;
  crypto_aead_aes256gcm_state aes;  // the key schedule, computed once

  ~State() { sodium_memzero(this, sizeof *this); }

  std::array<unsigned char, 12> nonce(std::uint64_t counter) const {
    std::array<unsigned char, 12> bytes;
    std::memcpy(bytes.data(), key.iv.data(), bytes.size());
    for (std::size_t i = 0; i < 8; ++i, counter >>= 8)
      bytes[11 - i] ^= static_cast<unsigned char>(counter & 0xff);
    return bytes;
  }
};

Aead::Aead(SealAlgorithm algorithm, const SealKey& key) : state_(std::make_unique<State>()) {
  ensureSodium();
  state_->algorithm = algorithm;
  state_->key = key;
  if (algorithm == SealAlgorithm::aes256Gcm) {
    ASSERT(crypto_aead_aes256gcm_is_available() != 0);
    crypto_aead_aes256gcm_beforenm(&state_->aes, raw(key.key.data()));
  }
}
Aead::~Aead() = default;
Aead::Aead(Aead&&) noexcept = default;
Aead& Aead::operator=(Aead&&) noexcept = default;

void Aead::encrypt(std::uint64_t counter, std::span<const std::byte> associated,
                   std::span<const std::byte> plain, std::byte* out) const {
  const auto nonce = state_->nonce(counter);
  if (state_->algorithm == SealAlgorithm::aes256Gcm) {
    crypto_aead_aes256gcm_encrypt_afternm(raw(out), nullptr, raw(plain.data()), plain.size(),
                                          raw(associated.data()), associated.size(), nullptr, nonce.data(),
                                          &state_->aes);
  } else {
    crypto_aead_chacha20poly1305_ietf_encrypt(raw(out), nullptr, raw(plain.data()), plain.size(),
                                              raw(associated.data()), associated.size(), nullptr,
                                              nonce.data(), raw(state_->key.key.data()));
  }
}

bool Aead::decrypt(std::uint64_t counter, std::span<const std::byte> associated,
                   std::span<const std::byte> cipher, std::byte* out) const {
  const auto nonce = state_->nonce(counter);
  if (state_->algorithm == SealAlgorithm::aes256Gcm) {
    return crypto_aead_aes256gcm_decrypt_afternm(raw(out), nullptr, nullptr, raw(cipher.data()),
                                                 cipher.size(), raw(associated.data()), associated.size(),
                                                 nonce.data(), &state_->aes) == 0;
  }
  return crypto_aead_chacha20poly1305_ietf_decrypt(raw(out), nullptr, nullptr, raw(cipher.data()),
                                                   cipher.size(), raw(associated.data()), associated.size(),
                                                   nonce.data(), raw(state_->key.key.data())) == 0;
}

bool ReplayWindow::fresh(std::uint64_t counter) const {
  if (counter == 0) return false;
  if (counter > highest_) return true;
  if (highest_ - counter >= kWindow) return false;
  return (seen_[counter / 64 % kWords] >> (counter % 64) & 1u) == 0;
}

void ReplayWindow::mark(std::uint64_t counter) {
  ASSERT(fresh(counter));
  if (counter > highest_) {
    const std::uint64_t words = std::min<std::uint64_t>(counter / 64 - highest_ / 64, kWords);
    for (std::uint64_t i = 1; i <= words; ++i) seen_[(highest_ / 64 + i) % kWords] = 0;
    highest_ = counter;
  }
  seen_[counter / 64 % kWords] |= std::uint64_t{1} << (counter % 64);
  ASSERT(!fresh(counter) && highest_ >= counter);
}

Sealer::Sealer(SealAlgorithm algorithm, const SealKey& key, std::uint64_t connection)
    : aead_(algorithm, key), connection_(connection) {}

std::size_t Sealer::seal(DatagramKind kind, std::span<const std::byte> plain, std::byte* out) {
  if (counter_ + 1 >= kSealCounterLimit) return 0;
  ++counter_;
  ASSERT(out != nullptr && counter_ > 0 && counter_ < kSealCounterLimit);  // a nonce is used once
  storeBig(connection_, out);
  storeBig(static_cast<std::uint64_t>(kind) << 48 | counter_, out + 8);
  aead_.encrypt(counter_, {out, kSealHeaderBytes}, plain, out + kSealHeaderBytes);
  return plain.size() + kSealOverheadBytes;
}

Opener::Opener(SealAlgorithm algorithm, const SealKey& key, std::uint64_t connection)
    : aead_(algorithm, key), connection_(connection) {}

Opener::Opened Opener::open(std::span<const std::byte> datagram, std::byte* out) {
  if (datagram.size() < kSealOverheadBytes || connectionIdOf(datagram) != connection_) return {};
  const std::uint64_t word = loadBig(datagram.data() + 8);
  const std::uint64_t counter = word & kCounterMask, kind = word >> 48;
  if (!window_.fresh(counter)) return {.verdict = Verdict::replayed};
  if (!aead_.decrypt(counter, datagram.first(kSealHeaderBytes), datagram.subspan(kSealHeaderBytes), out) ||
      kind > static_cast<std::uint64_t>(DatagramKind::answer)) {
    return {};
  }
  const bool newest = counter > window_.highest();
  window_.mark(counter);
  return {Verdict::accepted, static_cast<DatagramKind>(kind), datagram.size() - kSealOverheadBytes, newest};
}

std::uint64_t connectionIdOf(std::span<const std::byte> datagram) {
  ASSERT(datagram.size() >= kSealOverheadBytes);
  return loadBig(datagram.data());
}

}  // namespace tandem::sync
