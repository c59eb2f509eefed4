#pragma once

// A bar in the hand, for tests of what is felt through a part, with the energy that leaves at the device.

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/tick.h"
#include "tests/haptics/grasp/control_scenes.h"
#include "tests/haptics/hand_probe.h"

namespace tandem::test {

/// Adds a bar 10 x 10 x 60 mm of 60 g whose lower end is at `tip`.
inline PartId addBar(SceneBuilder& b, const glm::dvec3& tip) {
  return b.addPart(boxMesh({10e-3, 10e-3, 60e-3}), {tip + glm::dvec3(0.0, 0.0, 30e-3), {1.0, 0.0, 0.0, 0.0}},
                   0.06);
}

/// The hand on the bar, `gripOff` m from its middle. `held`: the part that it holds.
class BarInHand {
 public:
  static constexpr double kStiffness = 1000.0;  // N/m, of the coupling

  BarInHand(assets::Scene scene, PartId held, double couplingDamping = 2.0,
            const glm::dvec3& gripOff = glm::dvec3(0.0))
      : scene_(std::move(scene)), contact_(modelled(scene_)), state_(contact_) {
    parameters = springOnly();
    parameters.graspStiffness = kStiffness;
    parameters.graspDamping = couplingDamping;
    parameters.graspRotStiffness = 4.0;
    sample_.valid = true;
    sample_.worldFromDevice = scene_.parts[held].worldFromPart;
    sample_.worldFromDevice.position += gripOff;
    tick();
    command(haptics::PartCommand::Kind::own, held);
    command(haptics::PartCommand::Kind::grasp, held);
    tick();
  }

  BarInHand(const BarInHand&) = delete;

  void command(haptics::PartCommand::Kind kind, PartId part) {
    commands_.push_back({kind, part, state_.worldFromPart(part)});
  }

  /// Others put a part somewhere in the next tick.
  void put(PartId part, const Pose& worldFromPart) {
    commands_.push_back({haptics::PartCommand::Kind::setPose, part, worldFromPart});
  }

  /// Goes by `step` m in a tick, and counts what the hand got on the way.
  void by(const glm::dvec3& step) {
    given += glm::dot(out.hands[0].toHand.force, step);
    sampling += 0.5 * kStiffness * glm::dot(step, step);
    sample_.worldFromDevice.position += step;
    sample_.twist.linear = step / parameters.dt;
    tick();
  }
  void rest(int ticks) {
    for (int i = 0; i < ticks; ++i) by(glm::dvec3(0.0));
  }

  const Pose& pose(PartId part) const { return state_.worldFromPart(part); }
  const glm::dvec3& device() const { return sample_.worldFromDevice.position; }
  glm::dvec3 force() const { return out.hands[0].toHand.force; }
  double valueOf(const assets::Control& control) const {
    return assets::controlValue(control, pose(control.part));
  }

  haptics::TickParameters parameters;
  haptics::TickOutput out;
  double given = 0.0;     // J, to the hand
  double sampling = 0.0;  // J, that a coupling of that stiffness may make of so many held forces, at most
  std::uint32_t flags = 0;

 private:
  static haptics::ContactScene modelled(const assets::Scene& scene) {
    haptics::ContactScene contact(scene, 1);
    contact.modelParts();
    return contact;
  }
  void tick() {
    sample_.time += parameters.dt;
    haptics::TickInput input;
    input.hands[0].device = sample_;
    input.commands = commands_;
    out = haptics::tick(input, contact_, parameters, state_);
    commands_.clear();
    flags |= out.flags;
  }

  assets::Scene scene_;
  haptics::ContactScene contact_;
  haptics::TickState state_;
  haptics::DeviceSample sample_;
  std::vector<haptics::PartCommand> commands_;
};

}  // namespace tandem::test
