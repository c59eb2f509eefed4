#include "haptics/link/coordination_link.h"

#include <algorithm>
#include <cmath>

#include "assets/base/assert.h"
#include "haptics/base/minimum_jerk.h"

namespace tandem::haptics {
namespace {

constexpr double kOutage = PlayOutDelay::kOutage;
constexpr double kCatchUpTime = 0.05;  // s
constexpr double kRunOut = 4.0;        // N/s
constexpr double kCalmRunOut = 1.5;    // N/s, where an end has been switched off: the hand has time to adapt
constexpr double kFastestRunOut = 100.0;  // N/s
constexpr double kJump = 0.1;             // change of the counted share of the wave that counts as a jump
constexpr double kGapIgnored =
    1e-3;                           // m: dead band, else the noise of the waves would be rectified into creep
constexpr double kGapRate = 2.0;    // 1/s
constexpr double kGapSpeed = 0.05;  // m/s: the hand feels b / 2 times that
constexpr double kForceFilterTime = 0.05;                     // s
constexpr double kReserveKept = 0.002, kReserveEasy = 0.004;  // J
constexpr double kFull = 0.999;

}  // namespace

void CoordinationLink::begin(std::uint32_t epoch, double delay) {
  ASSERT(p_.period > 0.0 && p_.packetPeriod > 0.0);
  epoch_ = epoch;
  sequence_ = 0;
  sum_ = used_ = {};
  announced_ = spent_ = kept_ = 0.0;
  playOut_.restart(epoch);
  regime_.restart(delay);
  on_ = true;
  enterRegime();
}

void CoordinationLink::carryOn(std::uint32_t epoch) {
  epoch_ = epoch;
  playOut_.carryOn(epoch);
}

// Rule 8: each regime has its impedance and its play-out delay; both start with a zero wave.
void CoordinationLink::enterRegime() {
  b_ = regime() == LinkRegime::stiff ? p_.impedance : p_.softImpedance;
  playOutDelay_.restart(regime_.age(), p_.packetPeriod, p_.period);
  dry_ = 1.0;
}

void CoordinationLink::watchRegime(double now) {
  if (playOut_.empty()) return;
  const LinkPacket& newest = playOut_.newest();
  const double age = std::max(0.0, now - newest.time);
  playOutDelay_.advance(age);
  longestAge_ = std::max(longestAge_, age);
  if (dry_ > kOutage && age <= delay()) playOutDelay_.lengthen(longestAge_);
  if (dry_ == 0.0 || age <= delay()) longestAge_ = 0.0;
  // A network path that has become longer than the play-out delay also needs a restart.
  const bool tooLong = regime_.age() > delay();
  if (tooLong) regime_.beginAnew();
  if (regime_.advance(age, newest.regime, p_.period) || tooLong) enterRegime();
}

void CoordinationLink::follow(double now, const Pose& worldFromCentre, const Twist& twist, bool asks) {
  watchRegime(now);
  playOut_.play(now - delay());
  dry_ = 1.0;
  ramp_ = fade_ = share_ = announcedShare_ = kept_ = 0.0;
  stretch_ = force_ = excess_ = {};
  drawn_ = worldFromCentre;
  twist_ = twist;
  asks_ = asks;
}

bool CoordinationLink::hears(const PlayedWave& peer) const {
  return peer.fresh && peer.state.on && playOut_.newest().on && on_ && regime() != LinkRegime::apart;
}

LinkPull CoordinationLink::pull(double now, const Pose& worldFromCentre, const Twist& twist) {
  watchRegime(now);
  const SixAxes v = axesOf(twist, p_.lever);
  const PlayedWave peer = playOut_.play(now - delay());
  const bool wasFresh = fresh(), isFresh = hears(peer);
  const double shareBefore = share_;
  const Aim aim = isFresh ? follow(peer, worldFromCentre, v) : runDry(peer);
  // Rule 3: a jump of the target force does not reach the hand; the force in excess of its target decays.
  if (isFresh != wasFresh || std::abs(share_ - shareBefore) > kJump) excess_ = force_ - aim.force;
  runOut(v);
  // Rule 1, the energy bound: a wave spends no more energy than has arrived and the reserve holds.
  const double most = std::sqrt(std::max(0.0, 2.0 * (aim.energy + reserve_.energy()) / p_.period));
  wave_ = shortened(waveOf(aim.force + excess_, v), most);
  pay(peer, aim);
  const SixAxes held = forceOf(wave_, {});
  // Rule 2: while the reserve is not full, extra drag on the replica fills it as soon as the replica moves.
  drag_ = p_.drag + p_.fillingDrag * (1.0 - reserve_.energy() / LinkReserve::kMost);
  const double damping = seriesDamping() + drag_;
  return {wrenchOf(held, p_.lever), damping, damping * p_.lever * p_.lever};
}

// Rules 1 (rate), 3, 5 and 6 while the peer is heard.
CoordinationLink::Aim CoordinationLink::follow(const PlayedWave& peer, const Pose& pose, const SixAxes& v) {
  if (dry_ > kOutage) resume(peer);
  dry_ = 0.0;
  fadeIn(peer);
  Aim aim;
  aim.taken = reserve_.taken();
  SixAxes wave = aim.taken * catchUp(peer);
  aim.correction = closeGap(peer, pose, wave);
  wave += aim.correction;
  aim.full = share_ > kFull;
  aim.force = share_ * forceOf(wave, v);
  aim.energy = peer.state.energy - spent_ + kept_;
  return aim;
}

// Rule 4, starved play-out: the last wave is never repeated; the force decays. For a short time the reserve
// lends the energy that this costs. After that this end may spend the wave that it sends, and does not
// announce it.
CoordinationLink::Aim CoordinationLink::runDry(const PlayedWave& peer) {
  dry_ += p_.period;
  share_ = 0.0;
  Aim aim;
  aim.energy = std::max(0.0, peer.state.energy - spent_);
  if (dry_ > kOutage) fade_ = ramp_ = announcedShare_ = 0.0;
  aim.energy += kept_;
  return aim;
}

// Rule 5: after an outage neither the missed displacement nor the missed energy is made up.
void CoordinationLink::resume(const PlayedWave& peer) {
  ramp_ = 0.0;
  used_ = peer.state.wave;
  spent_ = std::max(spent_, peer.state.energy);
}

// Rule 5: neither end spends more than the other end pays for.
void CoordinationLink::fadeIn(const PlayedWave& peer) {
  ramp_ = std::min(1.0, ramp_ + p_.period / p_.fadeTime);
  fade_ = minimumJerk(ramp_);
  share_ = announcedShare_ = std::min(fade_, peer.state.fade);
  if (share_ <= kFull) used_ = peer.state.wave - p_.period * peer.rate;
}

// Rule 1: the wave is the slope between the two interpolated packets, plus a slow correction of what was
// missed. A difference from tick to tick would be a spike where packets are missing.
SixAxes CoordinationLink::catchUp(const PlayedWave& peer) const {
  return peer.rate + (1.0 / kCatchUpTime) * (peer.state.wave - used_ - p_.period * peer.rate);
}

// Rule 6: cumulative waves keep the poses together except for what cap, fade and outage have cut off. The
// peer's pose is extrapolated to the present; F D_p / b is the gap that belongs to the force. The correction
// costs nothing as far as it cancels the wave and is paid from the reserve beyond that, both without a jump
// where the wave changes sign.
SixAxes CoordinationLink::closeGap(const PlayedWave& peer, const Pose& pose, const SixAxes& wave) {
  slowForce_ += (p_.period / kForceFilterTime) * (force_ - slowForce_);
  const SixAxes ahead = delay() * axesOf(peer.state.twist, p_.lever);
  SixAxes gap = wayBetween(gone(pose, stretch_, p_.lever), peer.state.worldFromDrawn, p_.lever) + ahead -
                (delay() / b_) * slowForce_;
  gap -= shortened(gap, kGapIgnored);
  const SixAxes correction = std::sqrt(0.5 * b_) * shortened(kGapRate * gap, kGapSpeed);
  const double square = dot(correction, correction);
  if (square == 0.0) return correction;
  const double paid = std::clamp((reserve_.energy() - kReserveKept) / kReserveEasy, 0.0, 1.0);
  const double free = std::min(1.0, -dot(correction, wave) / square);
  return std::max(paid, free) * correction;
}

// Rule 3: an excess force that drives the replica must decay before it has spent the reserve.
void CoordinationLink::runOut(const SixAxes& v) {
  const bool putOff = !on_ || (!playOut_.empty() && !playOut_.newest().on);
  double rate = putOff ? kCalmRunOut : kRunOut;
  const double power = dot(excess_, v);
  if (power > 0.0) {
    const double budget = std::max(1e-6, 0.8 * reserve_.energy());
    rate = std::min(kFastestRunOut, std::max(rate, length(excess_) * power / (2.0 * budget)));
  }
  excess_ -= shortened(excess_, rate * p_.period);
}

// Wave transform: the incoming wave w that gives this force on a replica of this velocity (Niemeyer & Slotine
// 1991, with the implicit spring of this link).
SixAxes CoordinationLink::waveOf(const SixAxes& force, const SixAxes& v) const {
  return (1.0 / waveGain()) * (force - springGain() * stretch_ + seriesDamping() * v);
}

SixAxes CoordinationLink::forceOf(const SixAxes& wave, const SixAxes& v) const {
  return springGain() * stretch_ + waveGain() * wave - seriesDamping() * v;
}

// Rules 2 and 4: accounts for the energy of this tick's wave.
void CoordinationLink::pay(const PlayedWave& peer, const Aim& aim) {
  const double cost = 0.5 * dot(wave_, wave_) * p_.period;
  account_.lent += std::max(0.0, cost - aim.energy);
  if (aim.full) {
    used_ += (p_.period / aim.taken) * (wave_ - aim.correction);
    spent_ += reserve_.settle(aim.energy, cost);
  } else {
    const bool lends = !fresh() && dry_ <= kOutage;
    if (lends) used_ += p_.period * wave_;
    reserve_.settleAll(aim.energy, cost, lends);
    spent_ = std::max(spent_, peer.state.energy);
  }
}

Wrench CoordinationLink::settle(const Pose& worldFromCentre, const Twist& twist) {
  const SixAxes v = axesOf(twist, p_.lever);
  const SixAxes drawn =  // v_d
      (1.0 / (b_ + damper())) * (std::sqrt(2.0 * b_) * wave_ - p_.spring * stretch_ + damper() * v);
  const SixAxes slip = drawn - v;
  force_ = p_.spring * stretch_ + damper() * slip;
  stretch_ += p_.period * slip;
  sent_ = std::sqrt(2.0 * b_) * drawn - wave_;
  sum_ += p_.period * sent_;
  const double outgoing = 0.5 * dot(sent_, sent_) * p_.period;
  announced_ += announcedShare_ * outgoing;
  kept_ = (1.0 - announcedShare_) * outgoing;
  const double damping = b_ + 0.5 * p_.spring * p_.period;  // includes the loss of the implicit spring
  reserve_.fill(p_.period * (damping * dot(slip, slip) + drag_ * dot(v, v)));
  const SixAxes acting = force_ - drag_ * v;
  account_.work += p_.period * dot(acting, v);
  account_.stored = 0.5 * p_.spring * dot(stretch_, stretch_);
  account_.reserve = reserve_.energy();
  drawn_ = gone(worldFromCentre, stretch_, p_.lever);
  twist_ = twist;
  return wrenchOf(acting, p_.lever);
}

LinkPacket CoordinationLink::packet(double now) {
  LinkPacket packet;
  packet.epoch = epoch_;
  packet.sequence = sequence_++;
  packet.time = now;
  packet.wave = sum_;
  packet.energy = announced_;
  packet.fade = fade_;
  packet.on = on_;
  packet.asks = asks_ || on_;
  packet.regime = regime_.measured();
  packet.worldFromDrawn = drawn_;
  packet.twist = twist_;
  return packet;
}

}  // namespace tandem::haptics
