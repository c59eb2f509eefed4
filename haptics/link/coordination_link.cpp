#include "haptics/link/coordination_link.h"

#include <algorithm>
#include <cmath>

#include "assets/base/assert.h"
#include "haptics/base/minimum_jerk.h"

namespace tandem::haptics {
namespace {

constexpr double kOutage = PlayOutDelay::kOutage;
constexpr double kCatchUpTime = 0.05;  // s
constexpr double kDecay = 4.0;         // N/s
constexpr double kCalmDecay = 1.5;     // N/s, where an end has been switched off: the hand has time to adapt
constexpr double kMaxDecay = 100.0;    // N/s
constexpr double kJump = 0.1;          // change of the counted share of the wave that counts as a jump
constexpr double kGapIgnored =
    1e-3;  // m: dead band, else the noise of the waves would be rectified into creep
constexpr double kNewGapIgnored = 2e-4, kNewFor = 2.0;        // m, s: the same of a link that has just begun
constexpr double kLedWithin = 2e-3, kLongestLead = 1.0;       // m, s
constexpr double kGapRate = 2.0;                              // 1/s
constexpr double kGapSpeed = 0.05;                            // m/s: the hand feels b / 2 times that
constexpr double kForceFilterTime = 0.05;                     // s
constexpr double kReserveKept = 0.002, kReserveEasy = 0.004;  // J
constexpr double kTicksKept = 3.0;                            // of the last tick's cost
constexpr double kFull = 0.999;

}  // namespace

void CoordinationLink::begin(std::uint32_t epoch, double delay, double firstFadeTime, bool isLed) {
  ASSERT(p_.period > 0.0 && p_.packetPeriod > 0.0);
  epoch_ = epoch;
  sequence_ = 0;
  sum_ = consumedWave_ = {};
  announced_ = spentEnergy_ = unannounced_ = 0.0;
  playOut_.restart(epoch);
  regime_.restart(delay);
  on_ = true;
  fadeTime_ = firstFadeTime > 0.0 ? firstFadeTime : p_.fadeTime;
  newFor_ = firstFadeTime > 0.0 ? kNewFor : 0.0;
  isLed_ = isLed;
  ledFor_ = isLed ? kLongestLead : 0.0;
  enterRegime();
}

void CoordinationLink::carryOn(std::uint32_t epoch) {
  epoch_ = epoch;
  playOut_.carryOn(epoch);
}

// Each regime has its own impedance and play-out delay; both start with a zero wave.
void CoordinationLink::enterRegime() {
  b_ = regime() == LinkRegime::stiff ? p_.impedance : p_.softImpedance;
  playOutDelay_.restart(regime_.age(), p_.packetPeriod, p_.period);
  starvedFor_ = 1.0;
}

void CoordinationLink::watchRegime(double now) {
  if (playOut_.empty()) return;
  const LinkPacket& newest = playOut_.newest();
  const double age = std::max(0.0, now - newest.time);
  playOutDelay_.advance(age);
  longestAge_ = std::max(longestAge_, age);
  if (starvedFor_ > kOutage && age <= delay()) playOutDelay_.lengthen(longestAge_);
  if (starvedFor_ == 0.0 || age <= delay()) longestAge_ = 0.0;
  // A network path that has become longer than the play-out delay also needs a restart.
  const bool tooLong = regime_.age() > delay();
  if (tooLong) regime_.beginAnew();
  if (regime_.advance(age, newest.regime, p_.period) || tooLong) enterRegime();
}

void CoordinationLink::follow(double now, const Pose& worldFromCentre, const Twist& twist, bool asks) {
  watchRegime(now);
  playOut_.play(now - delay());
  starvedFor_ = 1.0;
  ramp_ = counted_ = fade_ = share_ = peerFade_ = announcedShare_ = unannounced_ = 0.0;
  stretch_ = force_ = excess_ = {};
  drawn_ = worldFromCentre;
  twist_ = twist;
  asks_ = asks;
}

bool CoordinationLink::carries() const { return share_ > kFull; }

bool CoordinationLink::receives(const PlayedWave& peer) const {
  return peer.fresh && peer.state.on && playOut_.newest().on && on_ && !trust_.doubts() &&
         regime() != LinkRegime::apart;
}

LinkPull CoordinationLink::pull(double now, const Pose& worldFromCentre, const Twist& twist) {
  watchRegime(now);
  const SixAxes v = axesOf(twist, p_.lever);
  trust_.advance(v, p_.period);
  const PlayedWave peer = playOut_.play(now - delay());
  const bool wasFresh = fresh(), isFresh = receives(peer);
  const double shareBefore = share_;
  LinkGoal goal = isFresh ? goalOf(peer, worldFromCentre, v) : onStarved(peer);
  // A jump of the target force does not reach the hand: the force in excess of the target decays.
  if (isFresh != wasFresh || std::abs(share_ - shareBefore) > kJump) {
    excess_ = force_ - goal.force;
    trust_.beginAnew(goal.force);
  } else {
    goal.force = trust_.admit(goal.force, -share_ * b_ * (v - lastVelocity_), p_.period);
  }
  lastVelocity_ = v;
  brake_.advance(kDecay, p_.period);
  decayExcess(v);
  // Energy bound: the wave of a tick of length T spends no more than has arrived and the reserve holds,
  // T |w|^2 / 2 <= goal.energy + reserve.
  const double bound = std::sqrt(std::max(0.0, 2.0 * (goal.energy + reserve_.energy()) / p_.period));
  const SixAxes wanted = waveOf(goal.force + excess_, v);
  wave_ = shortened(wanted, bound);
  if (trust_.limits() && trust_.held())
    brake_.replace(waveGain() * (wanted - wave_), v);
  else
    brake_.release();  // no hand here would feel it
  pay(peer, goal);
  const SixAxes held = forceOf(wave_, {});
  // While the reserve is not full, extra drag on the replica fills it as soon as the replica moves.
  drag_ = p_.drag + p_.fillingDrag * (1.0 - reserve_.energy() / LinkReserve::kMax) + brake_.damping(v);
  const double damping = seriesDamping() + drag_;
  return {wrenchOf(held, p_.lever), damping, damping * p_.lever * p_.lever};
}

// The goal of a tick while the peer is played out: its wave, and a share of the gap of pose, as far as both
// ends have faded in.
CoordinationLink::LinkGoal CoordinationLink::goalOf(const PlayedWave& peer, const Pose& pose,
                                                    const SixAxes& v) {
  if (starvedFor_ > kOutage) resume(peer);
  starvedFor_ = 0.0;
  fadeIn(peer, pose);
  LinkGoal goal;
  goal.acceptedShare = reserve_.acceptedShare();
  SixAxes wave = goal.acceptedShare * catchUp(peer);
  goal.correction = closeGap(peer, pose, wave);
  wave += goal.correction;
  goal.full = share_ > kFull;
  goal.force = share_ * forceOf(wave, v);
  goal.energy = peer.state.energy - spentEnergy_ + unannounced_;
  return goal;
}

// Starved play-out: the last wave is never repeated; the force decays. For up to kOutage the end borrows the
// energy that this costs from its reserve. After that, or where the reserve does not hold the next ticks, it
// may spend the wave that it sends itself, and does not announce that wave to the peer: else the force of two
// hands that hold still would break off, since they have filled no reserve.
CoordinationLink::LinkGoal CoordinationLink::onStarved(const PlayedWave& peer) {
  starvedFor_ += p_.period;
  share_ = 0.0;
  LinkGoal goal;
  goal.energy = std::max(0.0, peer.state.energy - spentEnergy_);
  if (reserve_.energy() < kTicksKept * 0.5 * dot(wave_, wave_) * p_.period) announcedShare_ = 0.0;
  if (starvedFor_ > kOutage) fade_ = ramp_ = counted_ = announcedShare_ = 0.0;
  goal.energy += unannounced_;
  return goal;
}

// After an outage neither the missed displacement nor the missed energy is made up.
void CoordinationLink::resume(const PlayedWave& peer) {
  ramp_ = counted_ = 0.0;
  consumedWave_ = peer.state.wave;
  spentEnergy_ = std::max(spentEnergy_, peer.state.energy);
}

// The lesser fade of both ends counts, so neither end spends more than the other end pays for. A replica that
// is still led to its peer does not fade in: what leads it has no account, and it would drive the peer as far
// as it goes. Once it is there it counts the waves a round trip later than it says so, because only then do
// those arrive that the peer has paid for: without them the link would brake the replica, and what leads it
// would pay for the wave to the peer.
void CoordinationLink::fadeIn(const PlayedWave& peer, const Pose& pose) {
  ledFor_ = length(gapTo(peer, pose)) > kLedWithin ? std::max(0.0, ledFor_ - p_.period) : 0.0;
  if (ramp_ == 0.0) unpaidFor_ = isLed_ ? 2.0 * delay() : 0.0;
  const double step = p_.period / fadeTime_;
  ramp_ = ledFor_ > 0.0 ? 0.0 : std::min(1.0, ramp_ + step);
  if (ramp_ > 0.0) unpaidFor_ -= p_.period;
  counted_ = unpaidFor_ > 0.0 ? 0.0 : std::min(ramp_, counted_ + step);
  if (counted_ == 1.0) fadeTime_ = p_.fadeTime, isLed_ = false;
  fade_ = minimumJerk(ramp_);
  peerFade_ = std::min(peer.state.fade, peerFade_ + WavePlayOut::kFastestFade * p_.period);
  share_ = announcedShare_ = std::min(minimumJerk(counted_), peerFade_);
  if (share_ <= kFull) consumedWave_ = peer.state.wave - p_.period * peer.rate;
}

// The wave is the slope between the two interpolated packets, plus a slow correction of what was missed:
// w = dU/dt + (U - U_consumed - T dU/dt) / kCatchUpTime. A difference of U from tick to tick would be a spike
// where packets are missing.
SixAxes CoordinationLink::catchUp(const PlayedWave& peer) const {
  return peer.rate + (1.0 / kCatchUpTime) * (peer.state.wave - consumedWave_ - p_.period * peer.rate);
}

// The peer's pose is extrapolated to the present.
SixAxes CoordinationLink::gapTo(const PlayedWave& peer, const Pose& pose) const {
  return displacementBetween(applied(pose, stretch_, p_.lever), peer.state.worldFromDrawn, p_.lever) +
         delay() * axesOf(peer.state.twist, p_.lever);
}

// Sums of waves keep the poses together except for what energy bound, fade and outage have cut off.
// F D_p / b is the gap that belongs to the force. The correction is free as far as it cancels the wave;
// beyond that the reserve pays for it. Both have no jump where the wave changes sign.
SixAxes CoordinationLink::closeGap(const PlayedWave& peer, const Pose& pose, const SixAxes& wave) {
  slowForce_ += (p_.period / kForceFilterTime) * (force_ - slowForce_);
  SixAxes gap = gapTo(peer, pose) - (delay() / b_) * slowForce_;
  gap -= shortened(gap, newFor_ > 0.0 ? kNewGapIgnored : kGapIgnored);
  newFor_ = std::max(0.0, newFor_ - p_.period);
  const SixAxes correction = std::sqrt(0.5 * b_) * shortened(kGapRate * gap, kGapSpeed);
  const double square = dot(correction, correction);
  if (square == 0.0) return correction;
  const double paid = std::clamp((reserve_.energy() - kReserveKept) / kReserveEasy, 0.0, 1.0);
  const double free = std::min(1.0, -dot(correction, wave) / square);
  return std::max(paid, free) * correction;
}

// An excess force that drives the replica must decay before it has spent the reserve: a force F that decays
// at the rate r while it delivers the power P costs F P / 2r.
void CoordinationLink::decayExcess(const SixAxes& v) {
  const bool switchedOff = !on_ || (!playOut_.empty() && !playOut_.newest().on);
  double rate = switchedOff && !trust_.doubts() ? kCalmDecay : kDecay;
  const double power = dot(excess_, v);
  if (power > 0.0) {
    const double budget = std::max(1e-6, 0.8 * reserve_.energy());
    const double asked = rate;
    rate = std::min(kMaxDecay, std::max(rate, length(excess_) * power / (2.0 * budget)));
    brake_.add(std::min(length(excess_), (rate - asked) * p_.period));
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

// Accounts for the energy of this tick's wave, T |w|^2 / 2.
void CoordinationLink::pay(const PlayedWave& peer, const LinkGoal& goal) {
  const double cost = 0.5 * dot(wave_, wave_) * p_.period;
  account_.borrowed += std::max(0.0, cost - goal.energy);
  if (goal.full) {
    consumedWave_ += (p_.period / goal.acceptedShare) * (wave_ - goal.correction);
    spentEnergy_ += reserve_.account(goal.energy, cost);
  } else {
    const bool borrows = !fresh() && starvedFor_ <= kOutage;
    if (borrows) consumedWave_ += p_.period * wave_;
    reserve_.accountAll(goal.energy, cost, borrows);
    spentEnergy_ = std::max(spentEnergy_, peer.state.energy);
  }
}

Wrench CoordinationLink::account(const Pose& worldFromCentre, const Twist& twist) {
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
  unannounced_ = (1.0 - announcedShare_) * outgoing;
  const double damping = b_ + 0.5 * p_.spring * p_.period;  // includes the loss of the implicit spring
  reserve_.fill(p_.period * (damping * dot(slip, slip) + drag_ * dot(v, v)));
  const SixAxes acting = force_ - drag_ * v;
  account_.work += p_.period * dot(acting, v);
  account_.stored = 0.5 * p_.spring * dot(stretch_, stretch_);
  account_.reserve = reserve_.energy();
  drawn_ = applied(worldFromCentre, stretch_, p_.lever);
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
  packet.on = on_ && !trust_.doubts();
  packet.asks = asks_ || on_;
  packet.regime = regime_.measured();
  packet.worldFromDrawn = drawn_;
  packet.twist = twist_;
  return packet;
}

}  // namespace tandem::haptics
