#pragma once

// Encodes one StateUpdate for many receivers at the cost of a few encodings: receivers that have the same
// baseline get the same bytes, but for the two numbers that are their own (sync/wire/state_stream.h).
//
// 1. At most every kKeyInterval an update is a key: its parts go whole to everybody, marked to be kept. Every
//    receiver that has acknowledged it therefore has the same baseline, whichever others it has.
// 2. An update is encoded against the newest key that its receiver has acknowledged, if that is not older
//    than kLongestKeyAge; else whole. One encoding serves all receivers with the same key.
// 3. The sequence of an update and its distance to the baseline count in the receiver's own numbers, as with
//    a StateSender. Both may send to one receiver by turns, because neither relies on a baseline that the
//    other's could have displaced at the receiver.
// 4. No allocation once its buffers have grown. One thread.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sync/wire/state_writer.h"

namespace tandem::sync {

inline constexpr Micros kKeyInterval = 200 * kMillisecond;  // by the update's own times
inline constexpr Micros kLongestKeyAge = kSecond;           // of a key that an update is encoded against
/// An update with more parts may not fit whole into one datagram; a StateSender sends it.
inline constexpr std::size_t kMaxSharedParts = 25;

/// Which keys one receiver has.
class SharedReceiver {
 public:
  void acknowledged(const StateAck& ack);

 private:
  friend class SharedStateSender;
  /// Of one origin, by its slot in the sender.
  struct Origin {
    std::uint32_t generation = 0;  // of the slot
    std::uint32_t key = 0;         // the newest one acknowledged; 0: none
    std::uint32_t sequence = 0;    // in which that key went to this receiver
    int presences = 0;             // sent in full, up to kCameraAtFirst
  };
  struct SentKey {
    std::uint32_t sequence = 0, generation = 0, key = 0;
    std::uint32_t slot = 0;
  };
  static constexpr std::uint32_t kSentKeys = 512;

  Origin& origin(std::size_t slot, std::uint32_t generation);
  void sent(const SentKey& key);

  std::vector<Origin> origins_;
  std::vector<SentKey> sent_;  // a ring, by rising sequence
  std::uint32_t sentCount_ = 0;
};

class SharedStateSender {
 public:
  /// The next update. `toAll`: all receivers get it, so that it may be a key. It must have at most
  /// kMaxSharedParts parts, and outlive the calls of encodeFor().
  void begin(const StateUpdate& update, const WireFrame& frame, bool toAll);
  /// The update for one receiver, whose updates so far end before `sequence`. Valid until the next call.
  std::span<const std::byte> encodeFor(SharedReceiver& receiver, std::uint32_t sequence);
  /// Frees the stream of an origin that is not coming back.
  void forget(SiteId origin);

  /// Encodings since the start, and messages that they made.
  std::uint64_t encodings() const { return encodings_; }

 private:
  static constexpr std::size_t kKeys = 8;
  static constexpr std::size_t kMaxVariants = 16;
  struct Key {
    std::uint32_t number = 0;
    KeptUpdate content;
  };
  struct Origin {
    SiteId site = kNoSite;  // none: the slot is free
    std::uint32_t generation = 1;
    std::uint32_t lastKey = 0;
    Micros keyAt = 0;
    int presences = 0;  // sent to all since the camera moved
    Pose camera;        // as sent to all last
    std::array<Key, kKeys> keys;
  };
  struct Variant {
    std::uint32_t key = 0;
    StateWriter::With with;
    std::vector<std::byte> bytes;
  };

  std::size_t slotOf(SiteId origin);
  StateWriter::With chooseForAll(Origin& origin, bool toAll) const;
  const Key* keyFor(const SharedReceiver::Origin& receiver, std::uint32_t sequence) const;
  Variant& variant(const Key* key, StateWriter::With with);

  std::vector<Origin> origins_;
  StateWriter writer_;
  const StateUpdate* update_ = nullptr;
  WireFrame frame_;
  std::size_t slot_ = 0;
  bool isKey_ = false;
  StateWriter::With with_;
  std::vector<Variant> variants_;
  std::size_t variantCount_ = 0;
  std::uint64_t encodings_ = 0;
};

}  // namespace tandem::sync
