#pragma once

// What leads a replica that no hand here holds while its link does not carry it: a spring to where the peer has it, which
// carries its weight as well.
//
// 1. It begins slack. Where its end is to go jumps after an outage; the end goes there slowly while something presses on
//    the replica, so that no hand feels the jump.
// 2. It lets go once the link has come up, slowly: the link takes over what it held.
// 3. Nobody pays for its energy. That is why it lets go.

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptics/base/six_axes.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/link/coordination_link.h"

namespace tandem::haptics {

class Leash {
 public:
  /// What there is to lead by.
  struct Lead {
    const LinkPacket* peer = nullptr;  // heard last, or null
    double age = 0.0;                  // s, of it
    double delay = 0.0;                // s, by which the peer is played out late
    bool wanted = false;               // else it lets go: the link carries the replica, or leads nowhere
    bool held = false;                 // by a hand here: it lets go, and its end goes along
  };
  static Lead leadOf(const CoordinationLink& link, double now, bool held) {
    constexpr double kLongest = 0.4;  // s: an outage makes a delay of any length
    const LinkPacket* peer = link.newest();
    if (peer == nullptr) return {};
    // Both ends fade in; the lesser one counts.
    const bool carried = std::min(link.fade(), peer->fade) == 1.0;
    return {peer, std::clamp(now - peer->time, 0.0, kLongest), std::min(link.delay(), kLongest),
            link.on() && !carried, held};
  }

  /// Advances by dt (s) for a replica whose centre of mass is here and moves so; an angle counts as the way at the end of
  /// `lever` m.
  void advance(const Pose& worldFromCentre, const Twist& twist, const Lead& lead, double lever, double dt) {
    const double before = share_;
    share_ = std::clamp(share_ + (lead.wanted && !lead.held ? dt / kTaking : -dt / kLettingGo), 0.0, 1.0);
    const bool isNews = hears(lead, dt);
    news_ = isNews && !lead.held ? std::min(1.0, news_ + dt / kNews) : 0.0;
    if (share_ == 0.0) return;
    // It becomes stiffer, not tighter.
    if (share_ > before)
      end_ = gone(worldFromCentre, (before / share_) * wayBetween(worldFromCentre, end_, lever), lever);
    const SixAxes ours = axesOf(twist, lever);
    if (lead.held) return draw(ours, ours, lever, dt);
    if (!isNews) return draw({}, (1.0 - dt / kNews) * axesOf(twist_, lever), lever, dt);
    // What a delayed velocity is carried on by adds to the gain from hand to hand and back: only a replica that hardly
    // anything presses on is led by it.
    const double pull = share_ * kGains.stiffness * length(wayBetween(worldFromCentre, end_, lever));
    const double free = std::clamp(2.0 - pull / kFreePull, 0.0, 1.0);
    const SixAxes theirs = free * axesOf(lead.peer->twist, lever);
    const SixAxes left =
        wayBetween(end_, gone(lead.peer->worldFromDrawn, (lead.age - dt) * theirs, lever), lever);
    // What gives way is drawn on as fast as it goes, what is pressed only so fast; the damper never hinders the former nor
    // feels the latter.
    const double size = length(left);
    const double yielding = size > 0.0 ? free * std::max(0.0, dot(ours - theirs, left) / size) : 0.0;
    const SixAxes closing =
        shortened((1.0 / std::max(kClosing, 2.0 * lead.delay)) * left, kFastestPressed + yielding);
    draw(theirs + closing, news_ * (theirs + shortened(closing, yielding)), lever, dt);
  }

  /// 0..1: of its gains, and of the replica's weight.
  double share() const { return share_; }
  /// To the replica. A heavy one is damped critically.
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
  static constexpr double kTaking = 0.02, kLettingGo = 0.5;             // s
  static constexpr double kNews = 0.1, kOldNews = 0.1, kClosing = 0.1;  // s
  static constexpr double kFreePull = 0.8;                              // N
  static constexpr double kFastestPressed = 0.015;  // m/s, beside the peer's own motion: 6 N/s

  /// Whether what was heard tells where the peer has the replica by now. Else the end stands still.
  bool hears(const Lead& lead, double dt) {
    if (lead.peer == nullptr) return false;
    sinceHeard_ = lead.peer->time != heard_ ? 0.0 : sinceHeard_ + dt;
    heard_ = lead.peer->time;
    return sinceHeard_ < kOldNews;
  }

  /// The end goes on by `speed`; the damper is told `damped`.
  void draw(const SixAxes& speed, const SixAxes& damped, double lever, double dt) {
    end_ = gone(end_, dt * speed, lever);
    twist_ = {damped.along, damped.about / lever};
  }

  double share_ = 0.0;
  double news_ = 0.0;  // 0..1: how far the damper follows the peer again
  double heard_ = std::numeric_limits<double>::quiet_NaN();  // s: time of the newest packet
  double sinceHeard_ = 0.0;                                  // s, since it came
  Pose end_;
  Twist twist_;
};

}  // namespace tandem::haptics
