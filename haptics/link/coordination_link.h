#pragma once

// One end of a coordination link, which couples this site's replica of a part to another site's replica
// across a delay, without creating energy. It uses wave variables (Anderson & Spong 1989; Niemeyer & Slotine
// 1991, "Stable adaptive teleoperation") with a spring and a matched damper at each end, in all six axes at
// once (six_axes.h). The wave transform is
//
//   v_d = (sqrt(2b) w - K e + b v) / 2b     F = K e + b (v_d - v)     e' = v_d - v     u = sqrt(2b) v_d - w
//
// v is the replica's twist at its centre of mass in world axes, F the wrench on the replica there, w the
// incoming wave, u the outgoing one, b the impedance, K the spring and e its stretch. Power is F . v = (w^2 -
// u^2) / 2 less what spring and damper keep. Each end sends the sums U = integral of u and E = integral of
// u^2 / 2; the other end plays them out a fixed time D_p later. Passivity: w may spend no more energy than
// has arrived of E plus a small reserve of what this end itself has dissipated.
//
// 1. The thread that ticks calls pull() before the replica moves and account() after it, each tick, and
//    receive() and packet() between ticks. Nothing allocates or locks; the same calls give the same bits.
// 2. The link never waits: its force decays while play-out starves, and fades in when packets return.
// 3. Poses are never set. A gap between replicas is closed slowly.

#include <cmath>
#include <cstdint>

#include "haptics/base/six_axes.h"
#include "haptics/link/link_brake.h"
#include "haptics/link/link_regime.h"
#include "haptics/link/link_reserve.h"
#include "haptics/link/link_terms.h"
#include "haptics/link/link_trust.h"
#include "haptics/link/play_out_delay.h"
#include "haptics/link/wave_play_out.h"

namespace tandem::haptics {

/// Wrench of a link on a replica in a tick, about its centre of mass, world axes: `held` less `damping` and
/// `rotDamping` times the velocity and spin that the replica takes in this tick. A step must be implicit in
/// these.
struct LinkPull {
  Wrench held;
  double damping = 0.0;     // N·s/m
  double rotDamping = 0.0;  // N·m·s/rad
};

/// Energy account of an end since it began, J. Over both ends the sum of `work`, `stored` and `reserve` never
/// becomes positive.
struct LinkAccount {
  double work = 0.0;      // done on the replica
  double stored = 0.0;    // in the spring
  double reserve = 0.0;   // may still be spent
  double borrowed = 0.0;  // spent before it had arrived, total
};

class CoordinationLink {
 public:
  explicit CoordinationLink(const LinkParameters& parameters)
      : p_(parameters),
        regime_(parameters.longestDelay),
        trust_(parameters.peerSlew, parameters.lever),
        playOutDelay_(parameters.playOutMargin) {}

  /// Restarts under an epoch; `delay` s is the known network delay. The present force decays.
  /// `firstFadeTime`: as in LinkTerms. A replica that `isLed` to its peer fades in once it is there.
  void begin(std::uint32_t epoch, double delay, double firstFadeTime = 0.0, bool isLed = false);
  /// Continues the link under a new epoch. Sums and sequence go on, and packets of the previous epoch are
  /// accepted until the first one of the new epoch arrives. For a change of owner, which the two ends learn
  /// at different times.
  void carryOn(std::uint32_t epoch);
  /// Sets the impedance of both regimes, N·s/m, from the next begin() on: links that share a mass become
  /// lighter as sites join.
  void setImpedance(double stiff, double soft) { p_.impedance = stiff, p_.softImpedance = soft; }
  /// Sets the delay, s, beyond which the link is off (link_distance.h).
  void setLongestDelay(double longestDelay) { regime_.setLongestDelay(longestDelay); }
  /// Switches this end's replica on or off. While it is off, the force decays and the packets say so.
  void setOn(bool on) { on_ = on; }

  bool on() const { return on_; }
  /// Replaces pull() and account() while the end is off: another holder moves the replica, or the link has no
  /// force left on it. `asks` requests that the owner begins.
  void follow(double now, const Pose& worldFromCentre, const Twist& twist, bool asks);
  /// The packet made last among those received, or null.
  const LinkPacket* newest() const { return playOut_.empty() ? nullptr : &playOut_.newest(); }

  /// False if the packet was dropped: invalid, of another epoch, a duplicate or too late.
  bool receive(const LinkPacket& packet) {
    const bool good = playOut_.receive(packet);
    if (playOut_.drainContradiction()) trust_.contradicted();
    return good;
  }

  /// Begins a tick at `now` (s, session clock), given the pose of the replica's centre of mass with the
  /// replica's orientation, and the twist of that point.
  LinkPull pull(double now, const Pose& worldFromCentre, const Twist& twist);
  /// Ends the tick, given the replica's new pose and the twist that it took. Returns the wrench that acted on
  /// it.
  Wrench account(const Pose& worldFromCentre, const Twist& twist);

  /// The packet to send now, about every packetPeriod.
  LinkPacket packet(double now);

  LinkRegime regime() const { return regime_.regime(); }
  double impedance() const { return b_; }
  /// Play-out delay D_p, s: how far the peer is played out behind its present.
  double delay() const { return playOutDelay_.seconds(); }
  /// Mass that the link itself adds to the part while it is up, kg: b D_p. Its inertia is that mass times
  /// lever^2.
  double addedMass() const { return regime() == LinkRegime::apart || !on_ ? 0.0 : b_ * delay(); }
  /// Fade-in of this end, 0..1.
  double fade() const { return fade_; }
  /// Whether both ends have begun to fade in, and whether they have faded in, as far as is known here.
  bool acts() const { return share_ > 0.0; }
  bool carries() const;
  /// What the link leaves of the replica, 0..1, to what leads it.
  double leftToLead() const { return isLed_ ? 1.0 - share_ : 1.0; }
  bool fresh() const { return starvedFor_ == 0.0; }
  /// A hand here holds the replica: what the peer may do to it is limited (link_trust.h).
  void setHeld(bool held) { trust_.setHeld(held); }
  /// Whether the peer has come to be doubted since the last call.
  bool drainDoubt() { return trust_.drainDoubt(); }
  const LinkAccount& account() const { return account_; }

 private:
  struct LinkGoal {
    SixAxes force;               // N, target
    SixAxes correction;          // sqrt(W): share of the wave that closes a gap of pose
    double energy = 0.0;         // J, that has arrived for this tick
    double acceptedShare = 1.0;  // accepted share of the incoming wave
    bool full = false;           // faded in: energy left over now may be spent later
  };

  void watchRegime(double now);
  void enterRegime();
  bool receives(const PlayedWave& peer) const;
  LinkGoal goalOf(const PlayedWave& peer, const Pose& pose, const SixAxes& v);
  LinkGoal onStarved(const PlayedWave& peer);
  void resume(const PlayedWave& peer);
  void fadeIn(const PlayedWave& peer, const Pose& pose);
  SixAxes gapTo(const PlayedWave& peer, const Pose& pose) const;
  SixAxes catchUp(const PlayedWave& peer) const;
  SixAxes closeGap(const PlayedWave& peer, const Pose& pose, const SixAxes& wave);
  void decayExcess(const SixAxes& v);
  SixAxes waveOf(const SixAxes& force, const SixAxes& v) const;
  SixAxes forceOf(const SixAxes& wave, const SixAxes& v) const;
  void pay(const PlayedWave& peer, const LinkGoal& goal);

  // The spring is evaluated at the end of the step, F = K e + (b + K T) (v_d - v), which creates no energy at
  // any K and b.
  double damper() const { return b_ + p_.spring * p_.period; }
  double seriesDamping() const { return b_ * damper() / (b_ + damper()); }
  double springGain() const { return p_.spring * b_ / (b_ + damper()); }
  double waveGain() const { return std::sqrt(2.0 * b_) * damper() / (b_ + damper()); }

  LinkParameters p_;
  WavePlayOut playOut_;
  RegimeByAge regime_;
  LinkReserve reserve_;
  LinkTrust trust_;
  LinkBrake brake_;
  LinkAccount account_;
  bool on_ = false, asks_ = false;
  std::uint32_t epoch_ = 0, sequence_ = 0;
  double b_ = 0.0;     // N·s/m
  double drag_ = 0.0;  // N·s/m, in this tick
  PlayOutDelay playOutDelay_;

  SixAxes stretch_;              // m: e
  SixAxes wave_, sent_;          // sqrt(W): w and u of the last tick
  SixAxes sum_;                  // sqrt(W) s: U
  double announced_ = 0.0;       // J: E
  SixAxes consumedWave_;         // sqrt(W) s: played share of the peer's U
  double spentEnergy_ = 0.0;     // J: spent share of the peer's E
  double unannounced_ = 0.0;     // J: energy of the last tick's outgoing wave that is not announced
  double announcedShare_ = 0.0;  // 0..1: share of the outgoing wave that the peer may spend
  SixAxes force_;                // N, of the last tick
  SixAxes slowForce_;            // N, low-passed
  SixAxes excess_;               // N: force in excess of its target, decaying
  double starvedFor_ = 1.0;      // s since play-out starved; 0 while fresh
  double fadeTime_ = 0.0;        // s, of this fade-in
  double newFor_ = 0.0;          // s, for which a new link still closes small gaps too
  double ledFor_ = 0.0;          // s, for which the link may yet wait until its replica is near the peer's
  bool isLed_ = false;           // in the first fade-in, by something without an energy account
  double unpaidFor_ = 0.0;       // s, until waves arrive that the peer has paid for
  double ramp_ = 0.0;            // 0..1 of the fade-in time
  double counted_ = 0.0;         // 0..1: the same of the waves that arrive
  double fade_ = 0.0;            // 0..1: m
  double peerFade_ = 0.0;        // 0..1: the peer's, which rises no faster than a fade-in does
  double share_ = 0.0;           // 0..1: g, counted share of the wave, the lesser fade of both ends
  double longestAge_ = 0.0;      // s: greatest age of the newest packet while starved
  SixAxes lastVelocity_;         // m/s, at the beginning of the last tick
  Pose drawn_;                   // end of the spring
  Twist twist_;
};

}  // namespace tandem::haptics
