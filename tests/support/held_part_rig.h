#pragma once

// A hand that holds one part of a scene and leads it along a path, tick by tick, with all that judges the
// contact: exact depth, forces, steps of forces, energy at the hand, processor time.

#include <time.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

#include "haptics/measure/held_depth.h"
#include "haptics/tick_data.h"
#include "tests/support/full_size.h"
#include "tests/support/part_cases.h"

namespace tandem::test {

/// Coupling of 1 N/mm and 4 N·m/rad, and no limit that would hide what contact does.
inline haptics::TickParameters rigParameters() {
  haptics::TickParameters p;
  p.graspStiffness = 1000.0;
  p.forceLimit = p.torqueLimit = 1e6;
  return p;
}

/// Where models are kept that several cases make in turn.
inline haptics::ModelOptions cachedModels() {
  haptics::ModelOptions options;
  options.cacheDirectory = (std::filesystem::temp_directory_path() / "tandem-test-models").string();
  return options;
}

/// Twenty pegs of one shape, or all parts of an engine in turn: at full size their models are made once.
inline haptics::ModelOptions rigModels() { return atFullSize() ? cachedModels() : haptics::ModelOptions{}; }

/// One tick as it was.
struct RigTick {
  double time = 0.0;  // s
  Pose device, part;  // world
  Twist deviceTwist;
  Wrench toHand;  // N, N·m about the device's tip
  int contacts = 0;
  glm::dvec3 firstNormal{0.0, 0.0, 0.0};
  std::uint32_t flags = 0;
  double cpu = 0.0;                                         // s of this thread
  double depth = std::numeric_limits<double>::quiet_NaN();  // m; not measured in every tick
};

/// The p-quantile (0..1) of values; 0 of none.
inline double quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1) + 0.5)];
}

class HeldPartRig {
 public:
  explicit HeldPartRig(PartCase given, const haptics::TickParameters& settings = rigParameters(),
                       const haptics::ModelOptions& modelling = rigModels())
      : case_(std::move(given)),
        contact_(modelled(case_.scene, modelling)),
        state_(contact_),
        meter_(contact_, case_.held),
        parameters_(settings) {}
  HeldPartRig(const HeldPartRig&) = delete;

  /// Takes the part, with the hand held still until it is taken, and leads it to the end of the path.
  /// Measures the depth every `depthEvery` ticks; 0 = never.
  const HeldPartRig& run(int depthEvery = 10) { return runTo(case_.duration, depthEvery); }
  /// The same to a time on the path, from where it is.
  const HeldPartRig& runTo(double time, int depthEvery = 10) {
    const int count = static_cast<int>(time / parameters_.dt + 0.5);
    for (int i = static_cast<int>(ticks_.size()); i < count; ++i) step(i, depthEvery);
    return *this;
  }
  const haptics::ContactScene& contact() const { return *present_; }
  /// Goes on with a scene whose models are refined, which must outlive this.
  void refine(const haptics::ContactScene& next) {
    present_ = &next;
    state_.refine(next);
  }

  /// Lets these threads run parts of heavy ticks (TickState::share()).
  void share(haptics::TickHelpers* helpers) { state_.share(helpers); }
  /// Whether the last tick was shared.
  bool sharesTicks() { return state_.data().partContact->isShared(); }

  const std::vector<RigTick>& ticks() const { return ticks_; }
  const RigTick& last() const { return ticks_.back(); }
  const PartCase& given() const { return case_; }
  /// False while parts in the hand pass through everything.
  bool collides() const { return (last().flags & haptics::kFlagHeldWithoutContact) == 0; }
  bool everFlagged(std::uint32_t flags) const {
    return std::any_of(ticks_.begin(), ticks_.end(),
                       [&](const RigTick& t) { return (t.flags & flags) != 0; });
  }

  /// Deepest penetration measured from a time on, m.
  double deepest(double from = 0.0) const {
    double most = 0.0;
    for (const RigTick& t : ticks_) {
      if (t.time >= from && t.depth > most) most = t.depth;
    }
    return most;
  }
  /// How much the force changes from tick to tick, N.
  std::vector<double> forceSteps(double from = 0.0) const {
    std::vector<double> steps;
    for (std::size_t i = 1; i < ticks_.size(); ++i) {
      if (ticks_[i].time >= from)
        steps.push_back(glm::length(ticks_[i].toHand.force - ticks_[i - 1].toHand.force));
    }
    return steps;
  }
  /// By how much the force's direction turns from tick to tick, rad, while it is more than `least` N.
  std::vector<double> directionSteps(double least, double from = 0.0) const {
    std::vector<double> steps;
    for (std::size_t i = 1; i < ticks_.size(); ++i) {
      const glm::dvec3 a = ticks_[i - 1].toHand.force, b = ticks_[i].toHand.force;
      if (ticks_[i].time < from || glm::length(a) < least || glm::length(b) < least) continue;
      steps.push_back(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
    }
    return steps;
  }
  /// The most that the hand has ever been given beyond what it gave, J.
  double energyGiven() const {
    double sum = 0.0, most = 0.0;
    for (std::size_t i = 1; i < ticks_.size(); ++i) {
      const Wrench& held = ticks_[i - 1].toHand;  // while the device went on to the next reading
      const Twist& way = ticks_[i].deviceTwist;
      sum += parameters_.dt * (glm::dot(held.force, way.linear) + glm::dot(held.torque, way.angular));
      most = std::max(most, sum);
    }
    return most;
  }
  /// The most force and torque from a time on, N and N·m.
  double mostForce(double from = 0.0) const {
    double most = 0.0;
    for (const RigTick& t : ticks_) most = std::max(most, t.time >= from ? glm::length(t.toHand.force) : 0.0);
    return most;
  }
  double mostTorque(double from = 0.0) const {
    double most = 0.0;
    for (const RigTick& t : ticks_)
      most = std::max(most, t.time >= from ? glm::length(t.toHand.torque) : 0.0);
    return most;
  }
  /// How far the part is from where it should be at the end: m, and rad.
  double finalOffset(const Pose& expected) const {
    return glm::length(last().part.position - expected.position);
  }
  double finalTurn(const Pose& expected) const {
    return glm::length(rotationVector(last().part.orientation * glm::conjugate(expected.orientation)));
  }
  /// The largest way of the part's origin within the last `span` s, m.
  double driftOver(double span) const {
    double most = 0.0;
    for (const RigTick& t : ticks_) {
      if (t.time >= last().time - span)
        most = std::max(most, glm::length(t.part.position - last().part.position));
    }
    return most;
  }
  std::vector<double> cpuTimes() const {
    std::vector<double> times;
    for (const RigTick& t : ticks_) times.push_back(t.cpu);
    return times;
  }

 private:
  static haptics::ContactScene modelled(const assets::Scene& scene, const haptics::ModelOptions& modelling) {
    haptics::ContactScene contact(scene, 1);
    contact.modelParts(modelling);
    return contact;
  }
  static double cpuNow() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  bool isTaking() {
    const haptics::PartContact* const contact = state_.data().partContact.get();
    return contact != nullptr && contact->isTaking(case_.held);
  }

  void step(int index, int depthEvery) {
    using Kind = haptics::PartCommand::Kind;
    RigTick t;
    t.time = parameters_.dt * index;
    t.device = case_.path(t.time);
    if (!ticks_.empty()) {
      const Pose& before = ticks_.back().device;
      t.deviceTwist.linear = (t.device.position - before.position) / parameters_.dt;
      t.deviceTwist.angular =
          rotationVector(t.device.orientation * glm::conjugate(before.orientation)) / parameters_.dt;
    }
    haptics::TickInput input;
    input.hands[0].device.worldFromDevice = t.device;
    input.hands[0].device.twist = t.deviceTwist;
    input.hands[0].device.time = t.time;
    input.hands[0].device.valid = true;
    const haptics::PartCommand take[2] = {
        {Kind::own, case_.held, case_.scene.parts[case_.held].worldFromPart}, {Kind::grasp, case_.held, {}}};
    if (index == 0) input.commands = take;
    const double begin = cpuNow();
    haptics::TickOutput out = haptics::tick(input, *present_, parameters_, state_);
    t.cpu = cpuNow() - begin;
    input.commands = {};
    while (isTaking()) out = haptics::tick(input, *present_, parameters_, state_);
    t.part = state_.worldFromPart(case_.held);
    t.toHand = out.hands[0].toHand;
    t.contacts = out.contactCount;
    if (out.contactCount > 0) t.firstNormal = out.contacts[0].normal;
    t.flags = out.flags;
    if (depthEvery > 0 && index % depthEvery == 0) t.depth = meter_.measure(state_).depth;
    ticks_.push_back(t);
  }

  PartCase case_;
  haptics::ContactScene contact_;
  const haptics::ContactScene* present_ = &contact_;
  haptics::TickState state_;
  haptics::HeldPartDepthMeter meter_;
  haptics::TickParameters parameters_;
  std::vector<RigTick> ticks_;
};

}  // namespace tandem::test
