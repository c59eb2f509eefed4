#pragma once

// A packet of a coordination link, from one end to the other.

#include <cstdint>

#include "assets/base/pose.h"
#include "haptics/base/six_axes.h"

namespace tandem::haptics {

/// What a link can do at its delay, from the best to the worst.
enum class LinkRegime : std::uint8_t { stiff, soft, apart };

/// Each packet stands for itself: sums since the epoch began, so that what is lost is made up by the next
/// one.
struct LinkPacket {
  std::uint32_t epoch = 0;                // of the link; packets of another one are dropped
  std::uint32_t sequence = 0;             // grows by one a packet within the epoch
  double time = 0.0;                      // s, session clock: when it was made
  SixAxes wave;                           // sqrt(W) s: U, integral of the waves sent
  double energy = 0.0;                    // J: E, energy announced since the epoch began; never falls
  double fade = 0.0;                      // 0..1: m, how far the sender has faded in
  bool on = false;                        // the sender simulates its replica and wants the link
  bool asks = false;                      // a follower wants the owner to begin
  LinkRegime regime = LinkRegime::apart;  // as the sender measures the path to it
  Pose
      worldFromDrawn;  // where the sender's spring ends: its replica's centre of mass and orientation, plus e
  Twist twist;         // of the sender's replica at its centre of mass
};

/// Whether every number is finite and in its range: what came over a wire may be anything.
bool isValid(const LinkPacket& packet);

}  // namespace tandem::haptics
