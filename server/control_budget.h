#pragma once

// How many control messages one site may send: a token bucket (RFC 2697 calls its depth the burst size). It
// outlives the site's connections, so that connecting anew refills nothing.
//
// 1. A person's session stays far below it: a grab, a touch and their answers are a few messages a second.
// 2. A site beyond it is held: what it sends waits unread, so that TCP slows it and nobody else.
// 3. A site that stays beyond it for long is parted from.

#include <cstddef>

#include "sync/wire/time.h"

namespace tandem::server {

class ControlBudget {
 public:
  static constexpr double kRate = 200.0;              // messages a second that one site may send
  static constexpr double kBurst = 400.0;             // messages that it may send at once after a pause
  static constexpr double kConnection = 40.0;         // messages that a new connection of the site counts for
  static constexpr double kBytesPerMessage = 1024.0;  // a message of so many bytes counts for one more
  /// Others whom the server tells what comes of a message, for each further message that it counts for.
  static constexpr double kToldPerMessage = 32.0;
  /// Time held, less half of the time since, after which a site is parted from.
  static constexpr sync::Micros kPatience = 10 * sync::kSecond;

  /// Charges `messages`. False: nothing more of this site may be handled until mayResume().
  bool spend(sync::Micros now, double messages);
  /// Whether a site that is held may be heard again: half a second's messages are there.
  bool mayResume(sync::Micros now);
  /// Whether there is nothing left to spend.
  bool exhausted(sync::Micros now);
  bool held() const { return held_; }
  /// Whether the site has been held for so long that it is to be parted from.
  bool abused(sync::Micros now);
  /// Whether to tell a person that the site is held: not more often than every 10 s.
  bool drainNotice(sync::Micros now);

 private:
  void advance(sync::Micros now);

  double allowance_ = kBurst;
  sync::Micros at_ = 0;      // session time up to which `allowance_` and `excess_` are right
  sync::Micros excess_ = 0;  // time held, less half of the time since
  sync::Micros noticed_ = 0;
  bool held_ = false, everNoticed_ = false;
};

}  // namespace tandem::server
