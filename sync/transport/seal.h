#pragma once

// Sealed datagrams: authenticated encryption of one state packet at a time, with protection against replay.
//
//   connection id (8) | kind (2) counter (6) | ciphertext | tag (16)          all integers big-endian
//
// 1. The first 16 bytes are associated data: a change of them breaks the tag.
// 2. The nonce is the direction's initial vector XOR the counter. The counter starts at 1 and never repeats;
//    a key is used up before 2^48 packets (the owner closes the connection).
// 3. A counter is marked as seen only after the tag has verified, so a forged packet cannot push genuine ones
//    out of the window.
// 4. Each direction has its own key, so a packet sent back to its sender is a forgery.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace tandem::sync {

enum class SealAlgorithm : std::uint8_t { aes256Gcm = 1, chaCha20Poly1305 = 2 };

/// The algorithms this machine offers, as a mask of 1 << (algorithm - 1). AES only where the processor has
/// instructions for it: without them it is slow and leaks its key through the cache.
std::uint8_t offeredAlgorithms();
/// The best algorithm that both ends offer; ChaCha20-Poly1305 is always one of them.
SealAlgorithm chooseAlgorithm(std::uint8_t offeredHere, std::uint8_t offeredThere);

/// Key and initial vector of one direction, as they come out of the TLS exporter.
struct SealKey {
  std::array<std::byte, 32> key{};
  std::array<std::byte, 12> iv{};
};

/// What a datagram carries. Authenticated, and readable without the key.
enum class DatagramKind : std::uint16_t { state = 0, probe = 1, answer = 2 };

inline constexpr std::size_t kSealHeaderBytes = 16;
inline constexpr std::size_t kSealTagBytes = 16;
inline constexpr std::size_t kSealOverheadBytes = kSealHeaderBytes + kSealTagBytes;
inline constexpr std::uint64_t kSealCounterLimit = std::uint64_t{1} << 48;

/// One key with its cipher. Both functions write exactly plain.size() + tag, or cipher.size() - tag, bytes.
class Aead {
 public:
  Aead(SealAlgorithm algorithm, const SealKey& key);
  ~Aead();
  Aead(Aead&&) noexcept;
  Aead& operator=(Aead&&) noexcept;

  void encrypt(std::uint64_t counter, std::span<const std::byte> associated, std::span<const std::byte> plain,
               std::byte* out) const;
  /// False, and nothing useful in `out`, if the tag does not verify.
  [[nodiscard]] bool decrypt(std::uint64_t counter, std::span<const std::byte> associated,
                             std::span<const std::byte> cipher, std::byte* out) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Which counters have been seen: exact for the last kWindow below the highest; all older ones count as seen
/// (RFC 6479).
class ReplayWindow {
 public:
  static constexpr std::uint64_t kWindow = 1024;

  bool fresh(std::uint64_t counter) const;
  void mark(std::uint64_t counter);
  std::uint64_t highest() const { return highest_; }

 private:
  static constexpr std::size_t kWords = 32;  // twice the window, so that moving it clears whole words
  std::array<std::uint64_t, kWords> seen_{};
  std::uint64_t highest_ = 0;
};

/// The sending end of one direction.
class Sealer {
 public:
  Sealer(SealAlgorithm algorithm, const SealKey& key, std::uint64_t connection);

  /// Writes plain.size() + kSealOverheadBytes bytes to `out` and returns their number, or 0 if the key is
  /// used up.
  [[nodiscard]] std::size_t seal(DatagramKind kind, std::span<const std::byte> plain, std::byte* out);
  /// Continues after this counter; only for tests of the limit.
  void skipTo(std::uint64_t counter) { counter_ = counter; }

 private:
  Aead aead_;
  std::uint64_t connection_;
  std::uint64_t counter_ = 0;
};

/// The receiving end of one direction.
class Opener {
 public:
  Opener(SealAlgorithm algorithm, const SealKey& key, std::uint64_t connection);

  enum class Verdict : std::uint8_t { accepted, forged, replayed };
  struct Opened {
    Verdict verdict = Verdict::forged;
    DatagramKind kind = DatagramKind::state;
    std::size_t size = 0;  // of the plain text
    bool newest = false;   // the highest counter so far
  };
  /// `out` has room for datagram.size() - kSealOverheadBytes bytes.
  [[nodiscard]] Opened open(std::span<const std::byte> datagram, std::byte* out);

 private:
  Aead aead_;
  ReplayWindow window_;
  std::uint64_t connection_;
};

/// The connection id in front of a datagram of at least kSealOverheadBytes.
std::uint64_t connectionIdOf(std::span<const std::byte> datagram);

}  // namespace tandem::sync
