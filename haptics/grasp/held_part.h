#pragma once

// The parts that one person's hands simulate: those they hold, and those that settle after they let go.
//
// 1. They collide where the scene has part models, and joints hold them (part_contact.h).
// 2. A part is *free* if gravity pulls it and it has a model, or if a joint holds it: while nobody holds
//    it, it falls, is pushed and pushes. Any other part loses its velocity within kSettleTime and stays
//    where it is left.
// 3. A free part that has not moved further than a thousandth of its size within kSettleTime is at rest and
//    costs nothing, until something touches it or moves beside it.
// 4. Both couplings of a part in two hands act in one implicit step, and each hand feels its own. Where one
//    of them lets go, its wrench on the part fades.
// 5. A part that other sites simulate too is coupled to their replicas by links, which act on it in the
//    same implicit step (replica_links.h). It never rests while it is linked.
// 6. A part that is being taken (part_taking.h) stands still and pulls at no hand, until all is known of it
//    that its first step needs. One that cannot stand still is taken in a hurry.
// 7. Nothing here allocates.

#include <array>
#include <span>

#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "haptics/body/fade.h"
#include "haptics/body/virtual_coupling.h"
#include "haptics/contact/part_contact.h"
#include "haptics/grasp/controls.h"
#include "haptics/grasp/felt_damper.h"
#include "haptics/link/replica_links.h"
#include "haptics/scene/contact_world.h"

namespace tandem::haptics {

/// Push of the tool on a free part.
struct ToolPush {
  glm::dvec3 force{0.0, 0.0, 0.0};  // N, world
  glm::dvec3 point{0.0, 0.0, 0.0};  // m, world: where
  double stiffness = 0.0;           // N/m, by which the force falls as the part yields; 0: there is no push
};

/// What acts on a part in a hand without contact, at its centre of mass.
struct FieldPull {
  glm::dvec3 force{0.0, 0.0, 0.0};    // N, world, that does not depend on the velocity
  glm::dvec3 damping{0.0, 0.0, 0.0};  // N, of dampers at the present velocity
  double curvature = 0.0;             // N/m, by which the force may change as the part moves, at most
  double dampingRate = 0.0;           // N·s/m, the greatest of the dampers

  bool acts() const { return force != glm::dvec3(0.0) || curvature > 0.0 || dampingRate > 0.0; }
};

/// A hand's coupling to a part.
struct Grip {
  bool holds = false;
  bool limited = false;  // its springs give the part no more than the device gives the hand
  double rounded = 0.0;  // 0..1: how far it approaches that limit smoothly
  Pose bodyFromGrip;
  Wrench onHand;          // of the last step
  double firmness = 1.0;  // 0..1: how far the fingers have closed
  double waited = 0.0;    // s, with open fingers, for the link to carry the part
  double damped = 1.0;    // 0..1: share of its damper, which a hand feels that moved while the part was taken
  FeltDamper felt{};
};

/// A part simulated here.
struct SimulatedPart {
  PartId part = kNoPart;
  RigidBody body;
  std::array<Grip, kHands> grips;
  Fade ended;  // on the part: what a hand put on it that let go while the other one, or another site, held on
  glm::dvec3 endedAt{0.0, 0.0, 0.0};  // m, body frame: where
  double sinceLetGo = 0.0;    // s; at rest from kSettleTime on. A control or a free part: since it last moved
  Pose restPose;              // of a free part, where it was then
  ToolPush tool;              // of the last tick
  FieldPull field;            // of the next step, while a hand holds the part
  Wrench rubbed;              // the same, of the surfaces that it slides on, about the centre of mass
  Wrench attracted;           // by magnets, about the centre of mass
  MovedControl moved;         // a control moves along its axis only
  double sinceTouched = 1.0;  // s, since it pressed on another part or was kept from slipping faster
  bool slips = false;         // it may slip in the next step: paceOf()

  bool held() const { return grips[0].holds || grips[1].holds; }
  /// Whether a hand that holds it has begun to close.
  bool grasped() const;
};

/// What pulls at the part that a hand holds.
struct HandPull {
  const DeviceSample* device = nullptr;  // null: no valid reading, or no such hand: nothing
  CouplingGains gains;
  double forceLimit = 0.0;   // N, the most that the hand is given; 0: any
  double torqueLimit = 0.0;  // N·m, the same, > 0 with it
  double way = 0.0;          // m, of the hand in a tick, the fastest of the last ones

  static CouplingGains gainsOf(const TickParameters& p) {
    return {p.graspStiffness, p.graspDamping, p.graspRotStiffness, p.graspRotDamping};
  }
};
using HandPulls = std::array<HandPull, kHands>;

class HeldParts {
 public:
  /// Time constant of a released part's velocity and the time after which it is at rest, s: ten time
  /// constants leave e^-10 of the velocity, which is then dropped.
  static constexpr double kSettleDecay = 0.03;
  static constexpr double kSettleTime = 0.3;

  /// Begins to simulate a part from its pose in `world`: at rest, or `awake`, to fall if nothing holds it, or
  /// moving with `twist`. False if there is no room. Again: no effect.
  bool own(const ContactWorld& world, PartId part, bool awake = false, const Twist& twist = {});
  void disown(PartId part);
  /// A hand takes an owned part at its device's pose, and lets go of what it held; false if the part is not
  /// owned, or is a control that the other hand holds. `parameters` are the hand's.
  bool grasp(PartId part, const Pose& worldFromDevice, const TickParameters& parameters, int hand = 0);
  /// A hand lets go of what it holds, if anything. Whether the other one still holds that, or another site
  /// may.
  bool letGo(const TickParameters& parameters, int hand = 0);

  /// Links an owned part to a peer's replica; false if it is not owned, is a control, or there is no room.
  bool beginLink(const LinkTerms& terms);
  ReplicaLinks& links() { return links_; }
  const ReplicaLinks& links() const { return links_; }

  /// What the tool puts on an owned control in the next step.
  void load(PartId part, const AxisLoad& tool);
  /// What the tool puts on an owned free part in the next step.
  void push(PartId part, const ToolPush& tool);
  /// What force fields put on a part in a hand in the next step.
  void pull(PartId part, const FieldPull& field);
  /// What magnets put on an owned part that is in a hand or free, about its centre of mass, in steps until
  /// forgetMagnets(). Adds up.
  void attract(PartId part, const Wrench& magnet);
  void forgetMagnets();
  /// What touched surfaces put on a part in a hand in the next step, about its centre of mass.
  void rub(PartId part, const Wrench& surfaces);

  /// Advances all parts by parameters.dt (s) under parameters.gravity. Returns what the couplings put on
  /// each hand. `contact`: what keeps the parts off their neighbours, or null. `now` s: the session's
  /// clock, for links.
  std::array<Wrench, kHands> step(const HandPulls& hands, const TickParameters& parameters,
                                  const assets::Scene& scene, PartContact* contact, double now);

  std::span<const SimulatedPart> parts() const { return {parts_.data(), parts_.size()}; }
  PartId held(int hand = 0) const;
  /// What a hand holds, or null.
  const SimulatedPart* heldPart(int hand = 0) const;
  bool owns(PartId part) const;
  static bool atRest(const SimulatedPart& part) { return !part.held() && part.sinceLetGo >= kSettleTime; }

  /// Whether a part that nobody holds moves by itself, under this gravity.
  static bool isFree(PartId part, const glm::dvec3& gravity, const PartContact* contact);

 private:
  SimulatedPart* find(PartId part);
  /// Goes on with the parts that are being taken.
  void take(PartContact& contact, const TickParameters& parameters);
  /// Keeps a part that is being taken where it is, in open hands.
  static void stand(SimulatedPart& entry, const HandPulls& hands);
  /// Puts into `moving` the step of a part that hands or links pull at, and a GripPace for each hand if the
  /// part may slip. False if nothing pulls.
  bool pulledStep(SimulatedPart& entry, const HandPulls& hands, const TickParameters& parameters,
                  const glm::dvec3& gravity, double now, MovingPart& moving);
  /// Adds the wrenches of the couplings on the hands after a part has moved, and reports its motion to its
  /// links. `touches` others, and `slipChange`: FeltDamper::force().
  void react(SimulatedPart& entry, const HandPulls& hands, const CoupledStep& step,
             const glm::dvec3& velocity, const glm::dvec3& spin, bool touches, double slipChange,
             std::array<Wrench, kHands>& onHands);
  /// The step of a part that nobody holds; false if it stays where it is.
  static bool freeStep(SimulatedPart& entry, const glm::dvec3& gravity, double dt, const PartContact* contact,
                       const assets::Scene& scene, CoupledStep& step);
  static void noteRest(SimulatedPart& entry, double dt);
  /// Parts that press on each other, or that a joint ties together, rest together or not at all.
  void wakeTouched(const PartContact& contact, const TickParameters& parameters, const assets::Scene& scene);
  void wakeJoined(const PartContact& contact, const TickParameters& parameters, const assets::Scene& scene);
  /// Neither has rested for longer than the other.
  static void restTogether(SimulatedPart& a, SimulatedPart& b, const PartContact& contact,
                           const TickParameters& parameters, const assets::Scene& scene);

  FixedVector<SimulatedPart, kMaxOwnedParts> parts_;
  ReplicaLinks links_;
};

}  // namespace tandem::haptics
