#include "haptics/tick.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/assertion_scope.h"
#include "assets/base/finite.h"
#include "haptics/tick_data.h"

namespace tandem::haptics {
namespace {

using Data = TickState::Data;

// After this gap the device may be anywhere, so the proxy is reset instead of dragged.
constexpr double kProxyResetAfter = 0.25;  // s
// A hand that moved less than this while the ticks stood still keeps its contacts.
constexpr double kStillInStall = 1e-3;  // m

/// One call of tick(): the steps in the order in which they run.
class Tick {
 public:
  Tick(const TickInput& input, const TickParameters& parameters, Data& data)
      : input_(input), parameters_(parameters), data_(data) {}

  TickOutput run() {
    data_.tool.begin(parameters_);
    noteSample();
    if (input_.second != nullptr) data_.second.note(*input_.second, parameters_, data_.held, data_.fault);
    runCommands();
    moveParts();
    simulateOwned();
    updateLayers();
    data_.tool.forgetIgnored(data_.held.held());
    if (valid_ && holdsSolid()) {
      carryTool();
    } else if (valid_) {
      data_.tool.touch(withoutFlicker(), parameters_, out_);
    } else {
      data_.tool.withdraw();
      data_.couplingWrench = Wrench{};
    }
    if (!data_.fields.empty()) feelFields();
    out_.touched = out_.contactCount > 0 && data_.tool.started() ? out_.contacts[0].part
                                                                 : data_.tool.partUnder(data_.held.held());
    findPushed();
    report();
    send();
    return out_;
  }

  /// The end of a tick in which an ASSERT failed: the fault is latched, and the force on its way to zero.
  TickOutput abandon(const FailedAssertion& broken) {
    data_.fault.raise(broken.condition, broken.file, broken.line);
    out_.contactCount = out_.ownedCount = out_.pushedCount = 0;
    out_.touched = kNoPart;
    report();
    send();
    return out_;
  }

 private:
  void send() {
    sendWrench();
    if (input_.second != nullptr) out_.second = data_.second.send(secondCoupling_, data_.held, data_.fault);
  }

  void noteSample() {
    const SampleGuard::Verdict verdict =
        data_.guard.judge(input_.device, parameters_, data_.invalidTime, out_.flags);
    valid_ = verdict != SampleGuard::Verdict::refused;
    if (!valid_) {
      out_.flags |= kFlagInvalidSample;
      data_.invalidTime += parameters_.dt;
      return;
    }
    if (data_.tool.started()) {
      const Pose &now = input_.device.worldFromDevice, &last = data_.device.worldFromDevice;
      handMove_ = now.position - last.position;
      handWay_ = glm::length(handMove_);
      if (data_.fade.active()) handTurn_ = rotationVector(now.orientation * glm::conjugate(last.orientation));
    }
    data_.device = input_.device;
    atRest_ = data_.reading.note(input_.device.worldFromDevice.position, parameters_.dt);
    const bool wentOn = std::exchange(data_.stalled, false) && handWay_ > kStillInStall;
    const bool elsewhere = wentOn || verdict == SampleGuard::Verdict::elsewhere;
    data_.tool.place(data_.device.worldFromDevice.position,
                     elsewhere || data_.invalidTime > kProxyResetAfter);
    // A hand that did not move to where it is now did not draw its part there: it holds the part where it is.
    if (elsewhere && data_.held.held() != kNoPart) {
      data_.held.grasp(data_.held.held(), data_.device.worldFromDevice, parameters_);
    }
    data_.invalidTime = 0.0;
  }

  /// The reading, without the flicker of an encoder's quantum that looks like a velocity of a hand at rest: no damper may
  /// follow that.
  DeviceSample withoutFlicker() const {
    DeviceSample felt = input_.device;
    if (atRest_) felt.twist.linear = glm::dvec3(0.0);
    return felt;
  }

  void runCommands() {
    int done = 0;
    for (const PartCommand& command : input_.commands) {
      if (done++ == kMaxPartCommands) {
        out_.flags |= kFlagOverflow;
        return;
      }
      if (TICK_ASSERT(data_.fault, data_.world.has(command.part))) runCommand(command);
    }
  }

  void runCommand(const PartCommand& command) {
    switch (command.kind) {
      case PartCommand::Kind::own:
        if (!TICK_ASSERT(data_.fault, isValid(command.pose)) || data_.held.owns(command.part)) return;
        movePart(command.part, command.pose, Twist{});
        own(command.part);
        return;
      case PartCommand::Kind::grasp:
        if (command.hand == 0)
          grasp(command.part);
        else
          graspBySecond(command.part);
        return;
      case PartCommand::Kind::letGo:
        if (command.hand != 0 && data_.held.held(1) == command.part) data_.second.letGo(data_.held);
        if (command.hand == 0 && data_.held.held() == command.part) letGo();
        return;
      case PartCommand::Kind::disown:
        if (data_.held.held() == command.part) letGo();
        if (data_.held.held(1) == command.part) data_.second.letGo(data_.held);
        data_.held.disown(command.part);
        return;
      case PartCommand::Kind::setPose:
        if (!TICK_ASSERT(data_.fault, isValid(command.pose)) || data_.held.owns(command.part)) return;
        // A part that is put somewhere does not move there: it does not sweep the tool along.
        if (data_.tool.pressesOn(command.part)) data_.tool.noteForeignChange(0.0);
        data_.world.setPose(command.part, command.pose, Twist{});
        if (data_.tool.started()) data_.tool.ignoreOverlapping();
        return;
    }
  }

  void own(PartId part) {
    const bool free = isFree(part);
    if (!data_.held.own(data_.world, part, free)) out_.flags |= kFlagOverflow;
    if (free) take(part);
  }

  void grasp(PartId part) {
    if (!data_.tool.started() || !data_.held.owns(part) || data_.held.held() == part) return;
    if (data_.held.held() != kNoPart) letGo();
    const bool alone = data_.held.held(1) != part;
    if (!data_.held.grasp(part, data_.device.worldFromDevice, parameters_)) return;
    data_.tool.noteForeignChange(0.0);
    if (alone) take(part);
    // The tool no longer touches what the hand holds, and with a solid part in the hand it touches nothing. The force of
    // those contacts must not vanish at once.
    if (holdsSolid()) {
      data_.fade.start(felt(data_.tool.contactWrench()), {stiffnessInPlay(), 0.0}, parameters_.fadeTime);
    } else {
      fadeContactsWith(part);
    }
    data_.tool.ignore(part);
  }

  void graspBySecond(PartId part) {
    const bool alone = data_.held.held() != part && data_.held.held(1) != part;
    if (data_.second.grasp(part, data_.held) && alone) take(part);
  }

  /// From the first hand that holds it on.
  void take(PartId part) {
    if (data_.partContact == nullptr) return;
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (entry.part == part) data_.partContact->take(part, entry.body.centreOfMass);
    }
  }

  void letGo() {
    data_.tool.noteForeignChange(0.0);
    const bool solid = holdsSolid();
    const double springs = data_.held.letGo(parameters_) ? 2.0 : 1.0;
    if (solid) data_.tool.reset();
    data_.fade.start(felt(data_.couplingWrench),
                     {springs * parameters_.graspStiffness, springs * parameters_.graspRotStiffness},
                     parameters_.fadeTime);
    data_.couplingWrench = Wrench{};
  }

  /// A wrench within the limits of the device. What fades is no more than this: the hand never got more, and a part that it
  /// takes from under a larger force would be dragged for nothing.
  Wrench felt(const Wrench& wrench) const {
    const double force = glm::length(wrench.force), torque = glm::length(wrench.torque);
    return {wrench.force * std::min(1.0, parameters_.forceLimit / std::max(force, 1e-300)),
            wrench.torque * std::min(1.0, parameters_.torqueLimit / std::max(torque, 1e-300))};
  }

  void fadeContactsWith(PartId part) {
    const EndedContact ended = data_.tool.endedContactWith(part);
    data_.fade.start(felt(ended.wrench), {ended.stiffness, 0.0}, parameters_.fadeTime);
  }

  void moveParts() {
    const bool usable = data_.moved.apply(
        data_.world, input_.moved, data_.tool.reachInTick(),
        [&](PartId part) { return data_.held.owns(part); },
        [&](PartId part, const Pose& before, const Twist& twistBefore) {
          data_.tool.follow(part, before, twistBefore, false);
        });
    if (!usable) out_.flags |= kFlagOverflow;
  }

  /// `byHand`: the part moves because this hand pushes it.
  void movePart(PartId part, const Pose& worldFromPart, const Twist& twist, bool byHand = false) {
    haptics::movePart(data_.world, part, worldFromPart, twist,
                      [&](PartId moved, const Pose& before, const Twist& twistBefore) {
                        data_.tool.follow(moved, before, twistBefore, byHand);
                      });
  }

  /// The stiffest spring between the hand and what it touches, N/m.
  double stiffnessInPlay() const {
    return data_.tool.stiffest(
        std::max(parameters_.stiffness, data_.held.held() != kNoPart ? parameters_.graspStiffness : 0.0));
  }

  /// What the tool did to the controls that this hand moves, as its contacts were in the last tick.
  void loadControls() {
    for (const SimulatedPart& entry : data_.held.parts()) {
      const assets::Control* control = entry.moved.control;
      if (control == nullptr) continue;
      const bool touches = valid_ && data_.tool.started() && !entry.held();
      data_.held.load(entry.part, touches
                                      ? toolLoad(data_.world, data_.tool.proxy(), *control,
                                                 data_.tool.contactWrenchOf(entry.part).force, parameters_)
                                      : AxisLoad{});
    }
  }

  bool isFree(PartId part) const {
    const glm::dvec3 gravity = parameters_.gravity * data_.world.scene().parts[part].gravityFactor;
    return HeldParts::isFree(part, gravity, data_.partContact.get());
  }

  /// Whether a part would move by itself if it were owned here.
  bool givesWay(PartId part) const {
    const assets::Part& given = data_.world.scene().parts[part];
    return given.movable && !given.kinematic && isFree(part) &&
           assets::controlOf(data_.world.scene(), part) == nullptr;
  }

  /// What the tool did to the parts simulated here that are free or in the other hand, as its contacts were in the last
  /// tick.
  void loadFreeParts() {
    if (data_.partContact == nullptr && data_.held.held(1) == kNoPart && !data_.held.links().any()) return;
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (entry.grips[0].holds || entry.moved.control != nullptr) continue;
      const bool gives = entry.grips[1].holds || data_.held.links().has(entry.part) || givesWay(entry.part);
      const bool touches = valid_ && data_.tool.started() && data_.tool.pressesOn(entry.part) && gives;
      if (!touches) {
        data_.held.push(entry.part, {});
        continue;
      }
      data_.held.push(entry.part, {-data_.tool.contactWrenchOf(entry.part).force, data_.tool.proxy().position,
                                   stiffnessInPlay()});
    }
  }

  void notePushed(PartId part) {
    if (data_.held.owns(part) || !givesWay(part)) return;
    for (int i = 0; i < out_.pushedCount; ++i) {
      if (out_.pushed[static_cast<std::size_t>(i)] == part) return;
    }
    if (out_.pushedCount < kMaxPushed) out_.pushed[static_cast<std::size_t>(out_.pushedCount++)] = part;
  }

  void findPushed() {
    if (data_.partContact == nullptr) return;
    for (const PartTouch& touch : data_.partContact->touches()) notePushed(touch.part);
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (HeldParts::atRest(entry)) continue;
      data_.partContact->forEachJoined(entry.part, [&](PartId other) { notePushed(other); });
    }
    if (holdsSolid()) return;
    for (int i = 0; i < out_.contactCount; ++i) {
      const Contact& contact = out_.contacts[static_cast<std::size_t>(i)];
      if (contact.force > 0.0) notePushed(contact.part);
    }
  }

  /// Parts that a layer shows or hides. One that appears around the tool cannot be felt until the tool has come out.
  void updateLayers() {
    data_.layers.update(data_.world, [&](PartId part, bool hide) {
      if (!hide) return data_.tool.ignoreIfOver(part);
      if (!data_.tool.started()) return;
      data_.tool.noteForeignChange(0.0);
      fadeContactsWith(part);
    });
  }

  void simulateOwned() {
    loadControls();
    loadFreeParts();
    const DeviceSample felt = withoutFlicker();
    HandPulls hands;
    hands[0] = {valid_ ? &felt : nullptr, HandPull::gainsOf(parameters_)};
    if (input_.second != nullptr) hands[1] = data_.second.pull();
    const std::array<Wrench, kHands> onHands =
        data_.held.step(hands, parameters_, data_.world.scene(), data_.partContact.get(), noteTime());
    data_.couplingWrench = onHands[0], secondCoupling_ = onHands[1];
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (!TICK_ASSERT(data_.fault, isValid(entry.body.worldFromBody))) continue;
      movePart(entry.part, entry.body.worldFromBody, entry.body.twist,
               entry.moved.control != nullptr || entry.tool.stiffness > 0.0);
    }
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (entry.held() && (data_.partContact == nullptr || !data_.partContact->collides(entry.part)))
        out_.flags |= kFlagHeldWithoutContact;
    }
  }

  /// Whether the hand holds a part that touches others: then that is what it feels, and not its tool.
  bool holdsSolid() const {
    const SimulatedPart* const held = data_.held.heldPart();
    return held != nullptr && held->moved.control == nullptr && data_.partContact != nullptr &&
           data_.partContact->constrains(held->part);
  }

  /// The tool goes with the part in the hand; the part's contacts are what is touched.
  void carryTool() {
    const SimulatedPart& held = *data_.held.heldPart();
    TICK_ASSERT(data_.fault, held.grips[0].holds);
    data_.tool.carry(transformPoint(held.body.worldFromBody, held.grips[0].bodyFromGrip.position));
    for (const PartTouch& touch : data_.partContact->touches()) {
      if (out_.contactCount == kMaxContacts) break;
      if (touch.of != held.part && touch.part != held.part) continue;
      const bool first = touch.of == held.part;
      out_.contacts[static_cast<std::size_t>(out_.contactCount++)] = {
          first ? touch.part : touch.of, touch.point, first ? touch.normal : -touch.normal, touch.force};
    }
    const PartContact::Work& work = data_.partContact->work();
    if (work.overflow || work.exhausted) out_.flags |= kFlagOverflow;
    if (work.infeasible > 0) out_.flags |= kFlagSqueezed;
  }

  double sessionTime() const {
    return std::isfinite(input_.sessionTime) ? input_.sessionTime : input_.device.time;
  }

  /// For links, which run on while no reading tells the time.
  double noteTime() {
    const double time = sessionTime();
    data_.time = valid_ || std::isfinite(input_.sessionTime) ? time : data_.time + parameters_.dt;
    return data_.time;
  }

  void feelFields() {
    data_.fieldWrench = Wrench{};
    if (!valid_) return data_.fields.forgetHand();
    const FieldForces felt = data_.fields.step(
        data_.world, input_.device, sessionTime(),
        {parameters_.dt, parameters_.fadeTime, parameters_.fieldDampingLimit, data_.held.held()});
    data_.fieldWrench.force = felt.force;
    cause_.byTime = felt.sourceChange;
    out_.sourcePower = felt.sourcePower * data_.sentShare;
    out_.flags |= felt.flags;
  }

  void report() {
    TICK_ASSERT(data_.fault, isFinite(data_.tool.proxy().position));
    out_.worldFromProxy = {data_.tool.proxy().position, data_.device.worldFromDevice.orientation};
    out_.held = data_.held.held();
    for (const SimulatedPart& entry : data_.held.parts()) {
      out_.owned[static_cast<std::size_t>(out_.ownedCount++)] = {
          entry.part,   entry.body.worldFromBody, entry.body.twist,
          entry.held(), HeldParts::atRest(entry), data_.held.links().report(entry.part)};
    }
  }

  void sendWrench() {
    if (data_.fade.active()) data_.fade.advance(handMove_, handTurn_, parameters_.dt);
    out_.flags |= data_.tool.flags();
    const Wrench felt = data_.tool.contactWrench() + data_.fieldWrench;
    const Wrench wanted = felt + data_.couplingWrench + data_.fade.now();
    const ForeignChange& foreign = data_.tool.foreignChange();
    cause_.byHand = !foreign.any;
    if (foreign.any) cause_.explained = stiffnessInPlay() * (handWay_ + foreign.expected);
    out_.toHand = limitOutput(wanted, valid_ ? &data_.device : nullptr, cause_, parameters_, data_.fault,
                              data_.output, out_.flags);
    data_.sentShare = sentShare(wanted.force);
  }

  /// How much of the wanted force the limits let through, 0..1, along it: what fields do to the hand in this
  /// tick, they do in this proportion.
  double sentShare(const glm::dvec3& wanted) const {
    if (!valid_ || parameters_.zeroForce) return 0.0;
    const double square = glm::dot(wanted, wanted);
    if (!(square > 0.0)) return std::clamp(parameters_.gain, 0.0, 1.0);
    return std::clamp(glm::dot(data_.output.sent.force, wanted) / square, 0.0, 1.0);
  }

  const TickInput& input_;
  const TickParameters& parameters_;
  Data& data_;
  bool valid_ = false, atRest_ = false;
  ForceCause cause_;
  glm::dvec3 handMove_{0.0}, handTurn_{0.0};  // m and rad, that the hand went since the last tick
  double handWay_ = 0.0;                      // m, the length of handMove_
  Wrench secondCoupling_;                     // what the second hand's coupling puts on it
  TickOutput out_;
};

/// What a tick gives whose ASSERT failed; no force at all if not even its end holds.
TickOutput endAfter(const FailedAssertion& broken, Tick& current) {
  try {
    return current.abandon(broken);
  } catch (const FailedAssertion&) {
    TickOutput nothing;
    nothing.flags = kFlagFault;
    return nothing;
  }
}

}  // namespace

TickOutput tick(const TickInput& input, const ContactScene& scene, const TickParameters& parameters,
                TickState& state) {
  TICK_ASSERT(state.data().fault, state.data().scene == &scene.data());
  Tick current(input, parameters, state.data());
  const AssertionScope scope;
  try {
    return current.run();
  } catch (const FailedAssertion& broken) {
    return endAfter(broken, current);
  }
}

}  // namespace tandem::haptics
