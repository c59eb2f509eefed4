#pragma once

// One end of the line that ties this site's replica of a part to another site's replica of it, across a delay, without
// making energy. Wave variables (Anderson & Spong 1989; Niemeyer & Slotine 1991, "Stable adaptive teleoperation") with a
// spring and a matched damper at each end, in all six axes at once (six_axes.h):
//
//   v_d = (sqrt(2b) w - K e + b v) / 2b      F = K e + b (v_d - v)      e' = v_d - v      u = sqrt(2b) v_d - w
//
// v is the replica's twist at its centre of mass in world axes, F what acts on the replica there, w the wave that comes
// in, u the one that goes out; F . v = (w^2 - u^2) / 2 less what spring and damper keep. The sums U = integral of u and
// E = integral of u^2 / 2 are sent; the other end plays them out a fixed time later, and w may spend no more than what
// has arrived of E and a small reserve of what this end itself has lost.
//
// 1. Use from the thread that ticks: pull() before the replica moves, settle() after, each tick. receive() and packet()
//    between ticks. No allocation, no lock; the same calls give the same bits.
//
// 2. The link never waits: with nothing to play out its force runs out, with packets back it fades in.
//
// 3. Poses are never set. A gap between replicas is drawn shut, slowly.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "haptics/base/link_packet.h"
#include "haptics/base/six_axes.h"
#include "haptics/link/link_regime.h"
#include "haptics/link/link_reserve.h"
#include "haptics/link/play_out_delay.h"
#include "haptics/link/wave_play_out.h"

namespace tandem::haptics {

struct LinkParameters {
  double period = 1e-3;         // s, of the tick
  double packetPeriod = 4e-3;   // s, between the peer's packets
  double lever = 0.05;          // m, of the part, both ends alike: an angle counts as the way at its end
  double impedance = 27.0;      // N s/m: b, in the regime stiff
  double softImpedance = 14.0;  // N s/m: b, in the regime soft
  double spring = 10000.0;      // N/m: K
  double drag = 0.1;            // N s/m, on the replica at all times
  double fillingDrag = 0.6;     // N s/m, more while the reserve is empty
  double fadeTime = 0.5;        // s, in which the link comes up
  double farthest = 0.15;       // s, of delay: beyond it there is no link
  double playOutMargin = 0.0;   // s, later than PlayOutDelay finds enough
};

/// The most that lines from one site may weigh together, kg: b D_p of them all is what whoever leads has to carry.
inline constexpr double kMostLineMass = 1.7;

/// The impedance of each of `lines` lines that begin at one site, `most` where they stay light enough, N s/m. Both ends
/// of a line must be given the same, so one of them decides.
inline double lineImpedance(double most, double playOutDelay, int lines) {
  return std::min(most, kMostLineMass / (playOutDelay * lines));
}

/// What a link does to a replica in a tick, about its centre of mass, world axes: `held` less `damping` and `rotDamping`
/// times the velocity and spin that the replica takes in this tick. A step must be implicit in these.
struct LinkPull {
  Wrench held;
  double damping = 0.0;     // N s/m
  double rotDamping = 0.0;  // N m s/rad
};

/// What an end has done since it began, J. Over both ends the sum of `work`, `stored` and `reserve` never passes zero.
struct LinkAccount {
  double work = 0.0;     // on the replica
  double stored = 0.0;   // in the spring
  double reserve = 0.0;  // may still be spent
  double lent = 0.0;     // spent beyond what had arrived, all in all
};

class CoordinationLink {
 public:
  explicit CoordinationLink(const LinkParameters& parameters)
      : p_(parameters), regime_(parameters.farthest), playOutDelay_(parameters.playOutMargin) {}

  /// Begins anew under an epoch; `delay` s is what the way is known to take. What force there was runs out.
  void begin(std::uint32_t epoch, double delay);
  /// The same link under a new epoch: sums and sequence go on, and packets of the epoch before are taken until the first
  /// one of this is heard. For a change of owner, where the two ends are told at different times.
  void carryOn(std::uint32_t epoch);
  /// Of the two regimes, N s/m, from the next begin() on: lines that share a weight become lighter as sites join.
  void setImpedance(double stiff, double soft) { p_.impedance = stiff, p_.softImpedance = soft; }
  /// s, of delay: beyond it there is no link. The lesser one of both ends counts, for the worse regime does.
  void setFarthest(double farthest) { regime_.setFarthest(farthest); }
  /// Whether this end's replica takes part. Off, the force runs out and the peer is told.
  void setOn(bool on) { on_ = on; }

  bool on() const { return on_; }
  /// Instead of pull() and settle(), off: somebody else moves the replica, or nothing of the link is left on it. `asks`:
  /// the owner is to begin.
  void follow(double now, const Pose& worldFromCentre, const Twist& twist, bool asks);
  /// What was heard last, or null.
  const LinkPacket* newest() const { return playOut_.empty() ? nullptr : &playOut_.newest(); }

  /// False if the packet was dropped: invalid, of another epoch, known or too late.
  bool receive(const LinkPacket& packet) { return playOut_.receive(packet); }

  /// Begins a tick at `now` (s, session clock): the replica's centre of mass with the replica's orientation, and the
  /// twist of that point.
  LinkPull pull(double now, const Pose& worldFromCentre, const Twist& twist);
  /// Ends it: where the replica now is, and the twist that it took. Returns what acted on it.
  Wrench settle(const Pose& worldFromCentre, const Twist& twist);

  /// What to send now, about every packetPeriod.
  LinkPacket packet(double now);

  LinkRegime regime() const { return regime_.regime(); }
  double impedance() const { return b_; }
  /// s, by which the peer is played out late: D_p.
  double delay() const { return playOutDelay_.seconds(); }
  /// Mass that the line itself adds to the part while it is up, kg: b D_p. Its inertia is that times lever^2.
  double lineMass() const { return regime() == LinkRegime::apart || !on_ ? 0.0 : b_ * delay(); }
  /// 0..1: how far this end has faded in.
  double fade() const { return fade_; }
  bool fresh() const { return dry_ == 0.0; }
  const LinkAccount& account() const { return account_; }

 private:
  struct Aim {
    SixAxes force;        // N, that the rules want
    SixAxes correction;   // sqrt(W): the part of the wave that closes a gap of pose
    double energy = 0.0;  // J, that has arrived for this tick
    double taken = 1.0;   // of the wave that arrives
    bool full = false;    // faded in: what is not spent now may be spent later
  };

  void watchRegime(double now);
  void enterRegime();
  bool hears(const PlayedWave& peer) const;
  Aim follow(const PlayedWave& peer, const Pose& pose, const SixAxes& v);
  Aim runDry(const PlayedWave& peer);
  void resume(const PlayedWave& peer);
  void fadeIn(const PlayedWave& peer);
  SixAxes catchUp(const PlayedWave& peer) const;
  SixAxes closeGap(const PlayedWave& peer, const Pose& pose, const SixAxes& wave);
  void runOut(const SixAxes& v);
  SixAxes waveOf(const SixAxes& force, const SixAxes& v) const;
  SixAxes forceOf(const SixAxes& wave, const SixAxes& v) const;
  void pay(const PlayedWave& peer, const Aim& aim);

  // The spring is taken at the end of the step: F = K e + (b + K T) (v_d - v), which makes no energy at any K and b.
  double damper() const { return b_ + p_.spring * p_.period; }
  double seriesDamping() const { return b_ * damper() / (b_ + damper()); }
  double springGain() const { return p_.spring * b_ / (b_ + damper()); }
  double waveGain() const { return std::sqrt(2.0 * b_) * damper() / (b_ + damper()); }

  LinkParameters p_;
  WavePlayOut playOut_;
  RegimeByAge regime_;
  LinkReserve reserve_;
  LinkAccount account_;
  bool on_ = false, asks_ = false;
  std::uint32_t epoch_ = 0, sequence_ = 0;
  double b_ = 0.0;     // N s/m
  double drag_ = 0.0;  // N s/m, in this tick
  PlayOutDelay playOutDelay_;

  SixAxes stretch_;              // m: e
  SixAxes wave_, sent_;          // sqrt(W): w and u of the last tick
  SixAxes sum_;                  // sqrt(W) s: U
  double announced_ = 0.0;       // J: E
  SixAxes used_;                 // sqrt(W) s: what of the peer's U has been played
  double spent_ = 0.0;           // J: what of the peer's E has been used
  double kept_ = 0.0;            // J: of the wave sent in the last tick, not announced
  double announcedShare_ = 0.0;  // 0..1: of the wave sent, what the peer may spend
  SixAxes force_;                // N, of the last tick
  SixAxes slowForce_;            // N, low-passed
  SixAxes excess_;               // N: what the force is beyond its aim, on its way to zero
  double dry_ = 1.0;             // s without anything to play; 0 while fresh
  double ramp_ = 0.0;            // 0..1 of the time to fade in
  double fade_ = 0.0;            // 0..1: m
  double share_ = 0.0;           // 0..1: g, of the wave that counts: the lesser fade of both ends
  double longestAge_ = 0.0;      // s: of the newest packet while dry
  Pose drawn_;                   // where the spring ends
  Twist twist_;
};

}  // namespace tandem::haptics
