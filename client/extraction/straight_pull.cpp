#include "client/extraction/straight_pull.h"

#include <algorithm>
#include <array>
#include <span>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "assets/base/assert.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/tick.h"

namespace tandem::client {
namespace {

using haptics::PartCommand;

constexpr double kLead = 2e-3;     // of the size, by which the hand is ahead when it gives up
constexpr double kFollows = 0.5;   // of the way across the line, that the hand follows the part in a tick
constexpr double kStride = 0.02;   // of the size, between two poses of a path
constexpr double kPresses = 0.05;  // of maxForce, with which a part presses on what blocks it
constexpr double kAway = 1e3;      // times what the scene reaches, where parts that are away stand
constexpr int kLook = 10;          // ticks between two looks whether the part is clear

class Pull {
 public:
  Pull(const haptics::ContactScene& contact, const PullSettings& settings, const Place& from,
       const glm::dvec3& axis)
      : settings_(settings), contact_(contact), axis_(axis), state_(contact), end_{from, false, {}} {
    const double stiffness = settings.maxForce / (kLead * settings.size);
    parameters_.graspStiffness = stiffness;
    parameters_.graspRotStiffness = 0.1 * stiffness * settings.size * settings.size;
    parameters_.forceLimit = parameters_.torqueLimit = 1e12;
    parameters_.slewLimit = parameters_.torqueSlewLimit = 1e15;
    parameters_.effort.taking = haptics::ContactEffort::kTakeAtOnce;
    mass_ = contact.scene().parts[settings.part].massProperties.mass;
    partFromGrip_.position = contact.data().colliders[settings.part].centre;
  }

  PullEnd run() {
    take();
    for (int i = 1; gone_ < settings_.farthest; ++i) {
      step(std::min(1.0, static_cast<double>(i) / kPullRamp));
      if (isStuck()) {
        notePressed();
        break;
      }
      if (i % kLook != 0) continue;
      end_.free = settings_.isClear(end_.place.worldFromPart, axis_);
      if (end_.free) break;
    }
    Place& place = end_.place;
    place.path.push_back(place.worldFromPart);
    place.way.push_back({axis_, gone_});
    place.travelled += gone_;
    return std::move(end_);
  }

 private:
  haptics::DeviceSample& hand() { return input_.hands[0].device; }
  void tick(std::span<const PartCommand> commands) {
    input_.commands = commands;
    hand().time += parameters_.dt;
    out_ = haptics::tick(input_, contact_, parameters_, state_);
  }

  /// Puts away what is away and takes the part by the middle of its box.
  void take() {
    const Pose& start = end_.place.worldFromPart;
    grip_ = start_ = start * partFromGrip_;
    hand().valid = true;
    hand().worldFromDevice = grip_;
    const assets::Bounds& bounds = contact_.scene().bounds;
    const double reach = kAway * (settings_.size + glm::length(bounds.max) + glm::length(bounds.min));
    for (const PartId part : settings_.away) {
      const PartCommand put{
          PartCommand::Kind::setPose, part, {glm::dvec3((part + 1.0) * reach, 0.0, 0.0), {}}};
      tick({&put, 1});
    }
    tick(std::array<PartCommand, 2>{
        {{PartCommand::Kind::own, settings_.part, start}, {PartCommand::Kind::grasp, settings_.part, {}}}});
  }

  /// One tick, at this share of the full speed.
  void step(double speed) {
    const Pose handBefore = hand().worldFromDevice, gripBefore = grip_;
    ahead_ += kPullSpeed * settings_.size * speed;
    // The hand is where the part is, but as far along the line as it wants to be. Across, it follows.
    const glm::dvec3 goal = grip_.position + axis_ * (ahead_ - gone_);
    const glm::dvec3 along = axis_ * glm::dot(goal - handBefore.position, axis_);
    hand().worldFromDevice.position =
        handBefore.position + along + kFollows * (goal - handBefore.position - along);
    hand().worldFromDevice.orientation =
        glm::normalize(glm::slerp(handBefore.orientation, grip_.orientation, kFollows));
    tick({});
    end_.place.worldFromPart = state_.worldFromPart(settings_.part);
    grip_ = end_.place.worldFromPart * partFromGrip_;
    gone_ = glm::dot(grip_.position - start_.position, axis_);
    measure(gripBefore);
    if (gone_ - noted_ <= kStride * settings_.size) return;
    noted_ = gone_;
    end_.place.path.push_back(end_.place.worldFromPart);
  }

  /// Adds up what the hand gives beyond what speeds the part up. What pushes the part along, such as an
  /// overlap of the file, gives the hand nothing.
  void measure(const Pose& gripBefore) {
    const Wrench& felt = out_.hands[0].toHand;
    const glm::dvec3 moved = grip_.position - gripBefore.position, velocity = moved / parameters_.dt;
    const glm::dvec3 resistance = -felt.force - mass_ * (velocity - velocity_) / parameters_.dt;
    velocity_ = velocity;
    const glm::dvec3 turned =
        rotationVector(glm::normalize(grip_.orientation * glm::conjugate(gripBefore.orientation)));
    Place& place = end_.place;
    place.work += std::max(0.0, glm::dot(resistance, moved) - glm::dot(felt.torque, turned));
    place.force = std::clamp(glm::dot(resistance, axis_), place.force, settings_.maxForce);
  }

  bool isStuck() const {
    return -glm::dot(out_.hands[0].toHand.force, axis_) >= settings_.maxForce ||
           ahead_ - gone_ > 2.0 * kLead * settings_.size || (out_.flags & haptics::kFlagFault) != 0;
  }

  void notePressed() {
    for (int i = 0; i < out_.contactCount; ++i) {
      const haptics::Contact& touch = out_.contacts[static_cast<std::size_t>(i)];
      if (glm::dot(touch.normal, axis_) < 0.0 && touch.force > kPresses * settings_.maxForce)
        end_.pressed.push_back(touch.part);
    }
  }

  const PullSettings& settings_;
  const haptics::ContactScene& contact_;
  const glm::dvec3 axis_;  // unit, world
  haptics::TickState state_;
  haptics::TickParameters parameters_;
  haptics::TickInput input_;
  haptics::TickOutput out_;
  double mass_ = 0.0;  // kg, of the part
  Pose partFromGrip_;
  Pose start_, grip_;                   // world
  glm::dvec3 velocity_{0.0, 0.0, 0.0};  // m/s, of the grip
  double ahead_ = 0.0, gone_ = 0.0,
         noted_ = 0.0;  // m along the axis: hand, part, part at the last pose noted
  PullEnd end_;
};

}  // namespace

PullEnd pullStraight(const haptics::ContactScene& contact, const PullSettings& settings, const Place& from,
                     const glm::dvec3& axis) {
  ASSERT(settings.size > 0.0 && settings.maxForce > 0.0 && settings.isClear);
  return Pull(contact, settings, from, axis).run();
}

}  // namespace tandem::client
