#pragma once

// What leads a replica that no hand here holds while its link does not carry it: a spring to where the peer has it.
//
// 1. It begins slack. Where its end is to go jumps after an outage; the end goes there slowly while something presses on
//    the replica, so that no hand feels the jump.
// 2. It lets go once the link has come up, slowly: the link takes over what it held.
// 3. Nobody pays for its energy. That is why it lets go.

#include <algorithm>

#include "haptics/link_packet.h"
#include "haptics/six_axes.h"
#include "haptics/virtual_coupling.h"

namespace tandem::haptics {

class Leash {
 public:
  /// What there is to lead by.
  struct Lead {
    const LinkPacket* peer = nullptr;  // heard last, or null
    double age = 0.0, delay = 0.0;     // s, of it; by which the peer is played out late
    bool isNews = false;  // it tells where the peer has the replica by now; else the end stands still
    bool wanted = false;  // else it lets go: the link carries the replica, or does not lead anywhere
    bool held = false;    // by a hand here: it lets go, and its end goes along
  };

  /// Advances by dt (s) for a replica whose centre of mass is here and moves so; an angle counts as the way at the end of
  /// `lever` m.
  void advance(const Pose& worldFromCentre, const Twist& twist, const Lead& lead, double lever, double dt) {
    const double before = lead_;
    lead_ = std::clamp(lead_ + (lead.wanted && !lead.held ? dt / kTaking : -dt / kLettingGo), 0.0, 1.0);
    if (lead_ == 0.0) return;
    // It becomes stiffer, not tighter.
    if (lead_ > before)
      end_ = gone(worldFromCentre, (before / lead_) * wayBetween(worldFromCentre, end_, lever), lever);
    const SixAxes ours = axesOf(twist, lever);
    if (lead.held) return draw(ours, ours, lever, dt);
    news_ = lead.isNews ? std::min(1.0, news_ + dt / kNews) : 0.0;
    if (!lead.isNews) return draw({}, {}, lever, dt);
    // What a delayed velocity is carried on by adds to the gain from hand to hand and back: only a replica that nothing
    // presses on is led by it.
    const double stretch = length(wayBetween(worldFromCentre, end_, lever));
    const double free = std::clamp(2.0 - stretch / kFreeStretch, 0.0, 1.0);
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

  bool leads() const { return lead_ > 0.0; }
  /// To a body with this centre of mass, body frame.
  Coupling coupling(const glm::dvec3& centreOfMass) const {
    return {{centreOfMass, {1.0, 0.0, 0.0, 0.0}},
            end_,
            twist_,
            {lead_ * kGains.stiffness, lead_ * kGains.damping, lead_ * kGains.rotStiffness,
             lead_ * kGains.rotDamping}};
  }

 private:
  static constexpr CouplingGains kGains{400.0, 28.0, 0.4, 0.03};
  static constexpr double kTaking = 0.05, kLettingGo = 0.5;  // s
  static constexpr double kNews = 0.1, kClosing = 0.1;       // s
  static constexpr double kFreeStretch = 2e-3;               // m: 0.8 N
  static constexpr double kFastestPressed = 0.015;           // m/s, beside the peer's own motion: 6 N/s

  /// The end goes on by `speed`; the damper is told `damped`.
  void draw(const SixAxes& speed, const SixAxes& damped, double lever, double dt) {
    end_ = gone(end_, dt * speed, lever);
    twist_ = {damped.along, damped.about / lever};
  }

  double lead_ = 0.0;  // 0..1
  double news_ = 0.0;  // 0..1: how far the damper follows the peer again
  Pose end_;
  Twist twist_;
};

}  // namespace tandem::haptics
