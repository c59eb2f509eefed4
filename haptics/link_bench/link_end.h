#pragma once

// One end of what couples two replicas of a part across the network, as LinkBench drives it.

#include <functional>
#include <memory>

#include "haptics/link/coordination_link.h"

namespace tandem::bench {

class LinkEnd {
 public:
  virtual ~LinkEnd() = default;
  virtual void receive(const haptics::LinkPacket& packet) = 0;
  /// pull() and account() begin and end a tick, like those of CoordinationLink.
  virtual haptics::LinkPull pull(double now, const Pose& worldFromCentre, const Twist& twist) = 0;
  virtual void account(const Pose& worldFromCentre, const Twist& twist) = 0;
  virtual haptics::LinkPacket packet(double now) = 0;

  /// Mass that the link itself adds to the part, kg.
  virtual double addedMass() const { return 0.0; }
  /// Whether nothing couples the replicas at this delay, so that each has the whole mass of the part.
  virtual bool apart() const { return false; }
  /// Play-out delay of the peer, s.
  virtual double delay() const { return 0.0; }
  virtual haptics::LinkAccount account() const { return {}; }
};

/// Makes an end for a network delay of `delay` s.
using LinkEndMaker =
    std::function<std::unique_ptr<LinkEnd>(const haptics::LinkParameters& parameters, double delay)>;

/// The coordination link of sessions.
class CoordinationLinkEnd : public LinkEnd {
 public:
  CoordinationLinkEnd(const haptics::LinkParameters& parameters, double delay) : link_(parameters) {
    link_.begin(1, delay);
  }
  void receive(const haptics::LinkPacket& packet) override { link_.receive(packet); }
  haptics::LinkPull pull(double now, const Pose& worldFromCentre, const Twist& twist) override {
    return link_.pull(now, worldFromCentre, twist);
  }
  void account(const Pose& worldFromCentre, const Twist& twist) override {
    link_.account(worldFromCentre, twist);
  }
  haptics::LinkPacket packet(double now) override { return link_.packet(now); }
  double addedMass() const override { return link_.addedMass(); }
  bool apart() const override { return link_.regime() == haptics::LinkRegime::apart; }
  double delay() const override { return link_.delay(); }
  haptics::LinkAccount account() const override { return link_.account(); }

 private:
  haptics::CoordinationLink link_;
};

/// A spring and damper to the last known pose of the peer's replica, the baseline for a link. Stable only
/// while stiffness times delay is small against the damping around it.
class PlainSpringEnd : public LinkEnd {
 public:
  struct Gains {
    double stiffness = 400.0, damping = 5.0;  // N/m, N·s/m
  };
  PlainSpringEnd(const Gains& gains, const haptics::LinkParameters& parameters)
      : gains_(gains), period_(parameters.period), lever_(parameters.lever) {}

  void receive(const haptics::LinkPacket& packet) override;
  haptics::LinkPull pull(double now, const Pose& worldFromCentre, const Twist& twist) override;
  void account(const Pose& worldFromCentre, const Twist& twist) override;
  haptics::LinkPacket packet(double now) override;

 private:
  static constexpr double kDrag = 0.1;  // N·s/m, as a link has on its replica
  Gains gains_;
  double period_, lever_;  // s, m
  haptics::LinkPacket peer_, own_;
  bool heard_ = false;
};

}  // namespace tandem::bench
