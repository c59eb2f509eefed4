#pragma once

// Outage spring: leads a replica that no hand here holds while its link does not carry it. A spring towards
// the peer's pose of the part also carries the part's weight.
//
// 1. The spring begins slack. Its target jumps after an outage, and its end follows the target slowly while
//    something presses on the replica, so that no hand feels the jump.
// 2. The spring releases the replica slowly once the link has come up and carries it.
// 3. The spring is outside the energy account of the link, so it acts only while the link does not.

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptics/base/six_axes.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/link/coordination_link.h"

namespace tandem::haptics {

class OutageSpring {
 public:
  /// State of the link that the outage spring follows.
  struct Target {
    const LinkPacket* peer = nullptr;  // last one received, or null
    double age = 0.0;                  // s, of that packet
    double delay = 0.0;                // s, play-out delay of the peer
    bool wanted = false;               // else it releases: the link carries the replica, or no peer leads it
    bool held = false;                 // by a hand here: it releases, and its end follows the replica
    double most = 1.0;                 // 0..1: what the link leaves of the replica to the spring
  };
  static Target targetOf(const CoordinationLink& link, double now, bool held) {
    constexpr double kLongest = 0.4;  // s: an outage can make a delay of any length
    const LinkPacket* peer = link.newest();
    if (peer == nullptr) return {};
    // Both ends fade in; the lesser fade counts.
    const bool carried = std::min(link.fade(), peer->fade) == 1.0;
    return {peer, std::clamp(now - peer->time, 0.0, kLongest), std::min(link.delay(), kLongest),
            link.on() && !carried, held};
  }

  /// Advances by dt (s) for a replica with this pose and twist of its centre of mass; `lever` (m) converts
  /// angles to lengths.
  void advance(const Pose& worldFromCentre, const Twist& twist, const Target& target, double lever,
               double dt) {
    const double before = share_;
    share_ = std::clamp(share_ + (target.wanted && !target.held ? dt / kTaking : -dt / kReleasing), 0.0,
                        target.most);
    const bool isNews = receives(target, dt);
    if (target.peer != nullptr) news_ = isNews && !target.held ? std::min(1.0, news_ + dt / kNews) : 0.0;
    if (share_ == 0.0) return;
    // A rise of the stiffness keeps the force: the end moves closer.
    if (share_ > before)
      end_ = applied(worldFromCentre, (before / share_) * displacementBetween(worldFromCentre, end_, lever),
                     lever);
    const SixAxes ours = axesOf(twist, lever);
    if (target.held) return moveEnd(ours, ours, lever, dt);
    if (!isNews) return moveEnd({}, (1.0 - dt / kNews) * axesOf(twist_, lever), lever, dt);
    // Extrapolation with a delayed velocity raises the gain of the loop from hand to hand, so only a replica
    // under little load is led with it.
    const double pull = share_ * kGains.stiffness * length(displacementBetween(worldFromCentre, end_, lever));
    const double free = std::clamp(2.0 - pull / kFreePull, 0.0, 1.0);
    const SixAxes theirs = free * axesOf(target.peer->twist, lever);
    const SixAxes gap = displacementBetween(
        end_, applied(target.peer->worldFromDrawn, (target.age - dt) * theirs, lever), lever);
    // The end follows a replica that yields at the speed at which it yields, and a pressed one at a limited
    // speed; the damper neither hinders the first nor acts on the second.
    const double size = length(gap);
    const double yielding = size > 0.0 ? free * std::max(0.0, dot(ours - theirs, gap) / size) : 0.0;
    const SixAxes closing =
        shortened((1.0 / std::max(kClosing, 2.0 * target.delay)) * gap, kMaxPressedSpeed + yielding);
    moveEnd(theirs + closing, news_ * (theirs + shortened(closing, yielding)), lever, dt);
  }

  /// For a replica that nothing presses on yet: the damper follows the peer from the first packet on.
  void beginFree() { news_ = 1.0; }

  /// Share of the gains and of the replica's weight, 0..1.
  double share() const { return share_; }
  /// The coupling to apply to the replica. A heavy replica is damped critically.
  Coupling coupling(const RigidBody& body) const {
    const glm::dmat3& i = body.inertia;
    const double inertia = (i[0][0] + i[1][1] + i[2][2]) / 3.0;
    const double damping = std::max(kGains.damping, 2.0 * std::sqrt(kGains.stiffness * body.mass));
    const double rotDamping = std::max(kGains.rotDamping, 2.0 * std::sqrt(kGains.rotStiffness * inertia));
    return {{body.centreOfMass, {1.0, 0.0, 0.0, 0.0}},
            end_,
            twist_,
            {share_ * kGains.stiffness, share_ * damping, share_ * kGains.rotStiffness, share_ * rotDamping}};
  }

 private:
  static constexpr CouplingGains kGains{400.0, 28.0, 0.4, 0.03};
  static constexpr double kTaking = 0.02, kReleasing = 0.5;                // s
  static constexpr double kNews = 0.1, kMaxNewsAge = 0.1, kClosing = 0.1;  // s
  static constexpr double kFreePull = 0.8;                                 // N
  static constexpr double kMaxPressedSpeed = 0.015;  // m/s, besides the peer's own motion: 6 N/s

  /// Whether the last packet is recent enough to tell the peer's present pose; otherwise the end stands
  /// still.
  bool receives(const Target& target, double dt) {
    if (target.peer == nullptr) return false;
    sinceNews_ = target.peer->time != newestTime_ ? 0.0 : sinceNews_ + dt;
    newestTime_ = target.peer->time;
    return sinceNews_ < kMaxNewsAge;
  }

  /// Moves the end at `speed`; the damper sees the velocity `damped`.
  void moveEnd(const SixAxes& speed, const SixAxes& damped, double lever, double dt) {
    end_ = applied(end_, dt * speed, lever);
    twist_ = {damped.along, damped.about / lever};
  }

  double share_ = 0.0;
  double news_ = 0.0;  // 0..1: how far the damper follows the peer again
  double newestTime_ = std::numeric_limits<double>::quiet_NaN();  // s: time of the newest packet
  double sinceNews_ = 0.0;                                        // s, since that packet arrived
  Pose end_;
  Twist twist_;
};

}  // namespace tandem::haptics
