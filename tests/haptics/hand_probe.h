#pragma once

// A scene, a tick and a scripted device for tests: set the device, tick, look.

#include <vector>

#include "haptics/tick.h"
#include "tests/support/shapes.h"

namespace tandem::test {

/// Parameters under which a contact force is the bare spring: no damping, no limits in reach.
inline haptics::TickParameters springOnly(double stiffness = 800.0) {
  haptics::TickParameters p;
  p.stiffness = stiffness;
  p.damping = 0.0;
  p.forceLimit = 1e6;
  p.torqueLimit = 1e6;
  p.slewLimit = 1e12;
  return p;
}

/// One hand in one scene.
class HandProbe {
 public:
  explicit HandProbe(assets::Scene scene, const haptics::TickParameters& settings = springOnly())
      : parameters(settings), scene_(std::move(scene)), contact(scene_, 1), state(contact) {}

  /// Puts the device there, with the velocity that brought it, and ticks.
  const haptics::TickOutput& at(const glm::dvec3& position) {
    sample.twist.linear =
        started_ ? (position - sample.worldFromDevice.position) / parameters.dt : glm::dvec3(0.0);
    sample.worldFromDevice.position = position;
    sample.valid = true;
    started_ = true;
    return tick();
  }

  /// Goes there in a straight line in steps of at most `step` m.
  const haptics::TickOutput& to(const glm::dvec3& target, double step) {
    const glm::dvec3 from = sample.worldFromDevice.position;
    const int n = std::max(1, static_cast<int>(std::ceil(glm::length(target - from) / step)));
    for (int i = 1; i <= n; ++i) at(glm::mix(from, target, static_cast<double>(i) / n));
    return out;
  }

  const haptics::TickOutput& tick() {
    sample.time += parameters.dt;
    out = haptics::tick(
        {.hands = {{{sample}}}, .moved = moved, .commands = commands, .sections = sections, .lifted = lifted},
        contact, parameters, state);
    moved.clear();
    commands.clear();
    return out;
  }

  void command(haptics::PartCommand::Kind kind, PartId part) {
    commands.push_back({kind, part, state.worldFromPart(part)});
  }

  haptics::TickParameters parameters;
  haptics::DeviceSample sample;
  std::vector<haptics::PartMotion> moved;
  std::vector<haptics::PartCommand> commands;
  std::vector<haptics::Section> sections;
  bool lifted = false;
  haptics::TickOutput out;

 private:
  assets::Scene scene_;
  bool started_ = false;

 public:
  haptics::ContactScene contact;
  haptics::TickState state;
};

}  // namespace tandem::test
