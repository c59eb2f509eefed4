#pragma once

// One direction of a modelled network, on virtual time.

#include <algorithm>
#include <functional>
#include <random>
#include <vector>

#include "haptics/base/link_packet.h"
#include "haptics/link_bench/six_axis_arm.h"

namespace tandem::bench {

struct Network {
  double delay = 0.025;  // s, one way
  double jitter = 0.2, loss = 0.02, duplicate = 0.0;
  double packetPeriod = 4e-3;             // s
  std::function<double(double)> delayAt;  // instead of `delay`
  double blackoutAt = 1e9, blackoutFor = 0.0;
  bool burst = true;     // packets held back arrive when the blackout ends; else they are lost
  bool shuffled = true;  // jitter may reorder; else packets that overtake are held back

  double delayNow(double now) const { return delayAt ? delayAt(now) : delay; }
};

/// Delays, loses, duplicates and reorders packets, by a seed.
template <typename Packet>
class DelayedLine {
 public:
  DelayedLine(const Network& network, unsigned seed) : network_(network), random_(seed) {}

  void send(double now, const Packet& packet) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const double lost = uniform(random_), jitter = uniform(random_), twice = uniform(random_),
                 again = uniform(random_);
    if (lost < network_.loss) return;
    fly(now, jitter, packet);
    if (twice < network_.duplicate) {
      Flying copy = flying_.back();
      copy.arrives += 0.05 * again;
      flying_.push_back(copy);
    }
  }

  /// Calls receive(packet) for all packets that arrive.
  template <typename Receive>
  void deliver(double now, const Receive& receive) {
    for (std::size_t i = 0; i < flying_.size();) {
      if (flying_[i].arrives > now + 1e-9) {
        ++i;
        continue;
      }
      receive(flying_[i].packet);
      flying_.erase(flying_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

 private:
  struct Flying {
    double arrives;
    Packet packet;
  };

  void fly(double now, double jitter, const Packet& packet) {
    double arrives =
        now + std::max(kTick, network_.delayNow(now) * (1.0 + network_.jitter * (2.0 * jitter - 1.0)));
    const double end = network_.blackoutAt + network_.blackoutFor;
    if (arrives > network_.blackoutAt && now < end) {
      if (!network_.burst) return;
      arrives = std::max(arrives, end);
    }
    if (!network_.shuffled) arrives = last_ = std::max(last_, arrives);
    flying_.push_back({arrives, packet});
  }

  Network network_;
  std::mt19937 random_;
  double last_ = 0.0;
  std::vector<Flying> flying_;
};

using LinkLine = DelayedLine<haptics::LinkPacket>;

/// Send schedule of packets whose mean rate is exact at any tick.
class PacketClock {
 public:
  explicit PacketClock(double period) : period_(period) {}
  /// Once a tick, `now` s from 0 on.
  bool due(double now) {
    if (now < next_ - 0.5 * kTick) return false;
    next_ += period_;
    return true;
  }

 private:
  double period_, next_ = 0.0;  // s
};

}  // namespace tandem::bench
