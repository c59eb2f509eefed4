#pragma once

// A hand in a scene whose parts move by themselves too: joints, gravity, parts that are pushed.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/tick_data.h"
#include "tests/support/part_cases.h"

namespace tandem::test {

class MovingRig {
 public:
  using Kind = haptics::PartCommand::Kind;

  /// Gravity in m/s^2. The scene's parts are not owned yet.
  explicit MovingRig(assets::Scene given, const glm::dvec3& gravity = glm::dvec3(0.0),
                     double fieldScale = 1.0)
      : scene_(std::move(given)), contact_(modelled(scene_, fieldScale)), state_(contact_) {
    parameters.graspStiffness = 1000.0;
    parameters.forceLimit = parameters.torqueLimit = 1e6;
    parameters.gravity = gravity;
    sample_.valid = true;
  }
  MovingRig(const MovingRig&) = delete;

  /// Everything stands as in the file again, and nothing is owned.
  void restart() { state_ = haptics::TickState(*present_); }

  /// From the next tick on.
  void own(PartId part) { commands_.push_back({Kind::own, part, pose(part)}); }
  void grasp(PartId part) { commands_.push_back({Kind::grasp, part, {}}); }
  void letGo(PartId part) { commands_.push_back({Kind::letGo, part, {}}); }
  /// Owns a part that moves with a twist.
  void throwPart(PartId part, const Twist& twist) {
    commands_.push_back({Kind::own, part, pose(part), 0, twist});
  }
  void disown(PartId part) { commands_.push_back({Kind::disown, part, {}}); }

  /// The hand is put at a pose: the first time, or to hold still there.
  void at(const Pose& device) {
    sample_.worldFromDevice = device;
    sample_.twist = {};
  }

  /// The hand begins at a pose, and from the next tick on holds the part there, which it owns.
  void ownAndGrasp(PartId part, const Pose& device) {
    at(device);
    tick();
    own(part);
    grasp(part);
  }

  /// The same, and holds still until the part is taken.
  void takeHold(PartId part, const Pose& device) {
    ownAndGrasp(part, device);
    do {
      tick();
    } while (contact().isTaking(part));
  }

  void tick(int count = 1) {
    for (int i = 0; i < count; ++i) {
      haptics::TickInput input;
      sample_.time = time_ += parameters.dt;
      input.hands[0].device = sample_;
      input.commands = commands_;
      input.moved = moved;
      input.sections = sections;
      out = haptics::tick(input, *present_, parameters, state_);
      commands_.clear();
      flags |= out.flags;
      if (each) each();
    }
  }

  /// From now on ticks use `next`, the same scene with refined contact models; it must outlive this rig.
  void refine(const haptics::ContactScene& next) {
    present_ = &next;
    state_.refine(next);
  }

  /// Leads the hand along a path of `duration` s, from its beginning.
  void lead(const std::function<Pose(double)>& path, double duration) {
    const int ticks = static_cast<int>(duration / parameters.dt + 0.5);
    for (int i = 0; i < ticks; ++i) {
      const Pose before = path(parameters.dt * i), now = path(parameters.dt * (i + 1));
      sample_.worldFromDevice = now;
      sample_.twist.linear = (now.position - before.position) / parameters.dt;
      sample_.twist.angular =
          rotationVector(now.orientation * glm::conjugate(before.orientation)) / parameters.dt;
      tick();
    }
    sample_.twist = {};
  }

  /// Owns whatever is pushed, as a session would, and gives back what rests.
  void answer() {
    for (int i = 0; i < out.pushedCount; ++i) own(out.pushed[static_cast<std::size_t>(i)]);
    for (int i = 0; i < out.ownedCount; ++i) {
      const haptics::OwnedPart& owned = out.owned[static_cast<std::size_t>(i)];
      if (owned.atRest && !owned.held) disown(owned.part);
    }
  }

  const Pose& pose(PartId part) const { return state_.worldFromPart(part); }
  const assets::Scene& scene() const { return scene_; }
  const haptics::ContactScene& contactScene() const { return *present_; }
  haptics::TickState& state() { return state_; }
  const haptics::PartContact& contact() { return *state_.data().partContact; }
  const haptics::OwnedPart& owned(PartId part) const {
    const haptics::OwnedPart* found = out.simulated(part);
    return found != nullptr ? *found : out.owned[0];
  }
  double jointValue(std::uint32_t joint, bool angular) { return contact().jointValue(joint, angular); }

  haptics::TickParameters parameters;
  haptics::TickOutput out;
  std::uint32_t flags = 0;                 // of all ticks
  std::function<void()> each;              // after every tick
  std::vector<haptics::PartMotion> moved;  // by others, in every tick
  std::vector<haptics::Section> sections;

 private:
  static haptics::ContactScene modelled(const assets::Scene& scene, double fieldScale) {
    haptics::ContactScene contact(scene, 1);
    haptics::ModelOptions options;
    options.fieldScale = fieldScale;
    contact.modelParts(options);
    return contact;
  }

  assets::Scene scene_;
  haptics::ContactScene contact_;
  const haptics::ContactScene* present_ = &contact_;
  haptics::TickState state_;
  haptics::DeviceSample sample_;
  std::vector<haptics::PartCommand> commands_;
  double time_ = 0.0;
};

}  // namespace tandem::test
