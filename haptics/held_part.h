#pragma once

// The parts that one hand simulates: the one it holds, and those that settle after it let go.
//
// 1. In this version they do not collide with other parts, and do not fall: a released part loses its
// velocity within
//    kSettleTime and stays where it is left. Gravity is felt as the weight of the held part only.
// 2. Nothing here allocates.

#include <array>
#include <span>

#include "haptics/contact_world.h"
#include "haptics/controls.h"
#include "haptics/tick.h"
#include "haptics/virtual_coupling.h"

namespace tandem::haptics {

/// A part simulated here.
struct SimulatedPart {
  PartId part = kNoPart;
  RigidBody body;
  Pose bodyFromGrip;  // where the hand holds it, while held
  bool held = false;
  double sinceLetGo = 0.0;  // s; at rest from kSettleTime on. A control: since it was last moved
  MovedControl moved;       // a control moves along its axis only
};

class HeldParts {
 public:
  /// Time constant of a released part's velocity and the time after which it is at rest, s: ten time
  /// constants leave e^-10 of the velocity, which is then dropped.
  static constexpr double kSettleDecay = 0.03;
  static constexpr double kSettleTime = 0.3;

  /// Begins to simulate a part, at rest at its pose in `world`; false if there is no room. Again: no effect.
  bool own(const ContactWorld& world, PartId part);
  void disown(PartId part);
  /// Takes an owned part at the device's pose; false if it is not owned.
  bool grasp(PartId part, const Pose& worldFromDevice);
  /// Lets go of what is held, if anything.
  void letGo();

  /// What the tool puts on an owned control in the next step.
  void load(PartId part, const AxisLoad& tool);

  /// Advances all parts by parameters.dt; `device` is null in a tick without a valid sample: then nothing
  /// pulls. Returns the coupling's wrench on the hand.
  Wrench step(const DeviceSample* device, const TickParameters& parameters, const assets::Scene& scene);

  std::span<const SimulatedPart> parts() const { return {parts_.data(), static_cast<std::size_t>(count_)}; }
  PartId held() const;
  bool owns(PartId part) const;
  static bool atRest(const SimulatedPart& part) { return !part.held && part.sinceLetGo >= kSettleTime; }

 private:
  SimulatedPart* find(PartId part);

  std::array<SimulatedPart, kMaxOwnedParts> parts_;
  int count_ = 0;
};

}  // namespace tandem::haptics
