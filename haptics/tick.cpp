#include "haptics/tick.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "assets/base/assertion_scope.h"
#include "assets/base/finite.h"
#include "haptics/felt_through_parts.h"
#include "haptics/lifted_tool.h"
#include "haptics/section_change.h"
#include "haptics/tick_data.h"

namespace tandem::haptics {
namespace {

using Data = TickState::Data;

// After this gap the device may be anywhere, so the proxy is reset instead of dragged.
constexpr double kProxyResetAfter = 0.25;  // s

/// What of the change of the force in this tick has which cause. `stiffness` N/m, between hand and surface.
void explainChange(const Data& data, const TickParameters& parameters, double stiffness, ForceCause& cause) {
  const ForeignChange& foreign = data.tool.foreignChange();
  const glm::dvec3& moved = data.hands[0].displacement();
  cause.byHand = !foreign.any;
  if (!foreign.any || data.fault.raised()) return;  // under a fault the cause does not count
  if (parameters.foreignSlewLimit > 0.0) {
    cause.byMotion = -stiffness * moved;
  } else {
    cause.explained = stiffness * (glm::length(moved) + foreign.expected);
  }
}

/// s, of the session's clock, else of the reading, else `next`.
double sessionTime(const TickInput& input, double next) {
  const double own = input.hands[0].device.time;
  if (std::isfinite(input.sessionTime)) return input.sessionTime;
  return std::isfinite(own) ? own : next;
}

/// One call of tick(): the steps in the order in which they run.
class Tick {
 public:
  Tick(const TickInput& input, const TickParameters& parameters, Data& data)
      : input_(input), parameters_(parameters), data_(data) {}

  TickOutput run() {
    data_.tool.begin(parameters_);
    noteReadings();
    runCommands();
    moveParts();
    simulateOwned();
    if (data_.world.surfaces() != nullptr) feelSurfacesThroughParts(count_, data_, out_);
    updateLayers();
    updateSections();
    data_.tool.forgetIgnored(data_.held.held());
    if (first_.valid() && holdsSolid()) {
      carryTool();
    } else if (first_.valid() && input_.lifted) {
      liftTool(stiffnessInPlay(), data_);
    } else if (first_.valid()) {
      setToolDown(data_);
      data_.tool.touch(first_.steadyDevice(), parameters_, out_);
      data_.foreign.noteTouch(data_.tool);
    } else {
      data_.tool.withdraw();
    }
    if (!data_.fields.empty()) feelFields();
    out_.touched = partTouched(out_, data_);
    findPushed();
    report();
    send();
    return out_;
  }

  /// The end of a tick in which an ASSERT failed: latches the fault, so that the force ramps to zero.
  /// Whoever gave the commands believes that they ran, so those that have not begun still run.
  TickOutput abandon(const FailedAssertion& broken) {
    data_.fault.raise(broken.condition, broken.file, broken.line);
    runRemainingCommands();
    out_.contactCount = out_.ownedCount = out_.pushedCount = 0;
    out_.touched = kNoPart;
    report();
    send();
    return out_;
  }

  /// The end of a tick whose end failed too: no force at all, and the next one grows from zero.
  TickOutput silence() {
    for (Hand& hand : data_.hands) hand.sendNothing();
    TickOutput nothing;
    nothing.flags = kFlagFault;
    for (HandFeedback& hand : nothing.hands) hand.flags = kFlagFault;
    return nothing;
  }

 private:
  void noteReadings() {
    TICK_ASSERT(data_.fault, count_ == input_.handCount && input_.hands[0].parameters == nullptr);
    for (int h = 0; h < count_; ++h) {
      const HandInput& hand = input_.hands[static_cast<std::size_t>(h)];
      handOf(h).begin(hand, hand.parameters != nullptr ? *hand.parameters : parameters_);
      TICK_ASSERT(data_.fault, handOf(h).parameters().dt == parameters_.dt);
      if (h == 0 && first_.valid()) {
        data_.tool.place(first_.device().worldFromDevice.position,
                         first_.elsewhere() || first_.silence() > kProxyResetAfter);
      }
      graspAnew(h);
    }
  }

  /// A hand that was not moved to its present place in contact did not pull its part there: it grasps the
  /// part anew.
  void graspAnew(int h) {
    const Hand& hand = handOf(h);
    const PartId held = data_.held.held(h);
    if (hand.elsewhere() && held != kNoPart)
      data_.held.grasp(held, hand.device().worldFromDevice, hand.parameters(), h);
  }

  void runCommands() {
    while (commandsBegun_ < input_.commands.size()) {
      if (commandsBegun_ == static_cast<std::size_t>(kMaxPartCommands)) {
        out_.flags |= kFlagOverflow;
        return;
      }
      const PartCommand& command = input_.commands[commandsBegun_++];
      if (TICK_ASSERT(data_.fault, data_.world.has(command.part))) runCommand(command);
    }
  }

  void runRemainingCommands() {
    for (bool done = false; !done;) {
      try {
        runCommands();
        done = true;
      } catch (const FailedAssertion&) {  // the fault is latched already; the next command has its turn
      }
    }
  }

  void runCommand(const PartCommand& command) {
    switch (command.kind) {
      case PartCommand::Kind::own:
        if (!TICK_ASSERT(data_.fault, isValid(command.pose)) || data_.held.owns(command.part)) return;
        movePart(command.part, command.pose, Twist{});
        own(command.part, command.twist);
        return;
      case PartCommand::Kind::grasp:
        if (TICK_ASSERT(data_.fault, command.hand < kHands)) grasp(command.part, command.hand);
        return;
      case PartCommand::Kind::letGo:
        if (!TICK_ASSERT(data_.fault, command.hand < kHands)) return;
        if (data_.held.held(command.hand) == command.part) letGo(command.hand);
        return;
      case PartCommand::Kind::disown:
        for (int h = 0; h < kHands; ++h)
          if (data_.held.held(h) == command.part) letGo(h);
        data_.held.disown(command.part);
        if (data_.partContact != nullptr) data_.partContact->disown(command.part);
        return;
      case PartCommand::Kind::setPose:
        if (!TICK_ASSERT(data_.fault, isValid(command.pose)) || data_.held.owns(command.part)) return;
        // A part that is put somewhere does not move there: it does not sweep the tool along.
        if (data_.tool.pressesOn(command.part)) endTouchWith(command.part, data_.foreign.active());
        data_.world.setPose(command.part, command.pose, Twist{});
        if (data_.tool.started()) data_.tool.ignoreOverlapping();
        return;
    }
  }

  void own(PartId part, const Twist& twist) {
    const bool free = isFree(part);
    if (!data_.held.own(data_.world, part, free, twist)) out_.flags |= kFlagOverflow;
    if (free) beginContact(part);
  }

  void grasp(PartId part, int h) {
    const Hand& hand = handOf(h);
    if (!hand.started() || !data_.held.owns(part) || data_.held.held(h) == part) return;
    if (data_.held.held(h) != kNoPart) letGo(h);
    if (!data_.held.grasp(part, hand.device().worldFromDevice, hand.parameters(), h)) return;
    const bool alone = data_.held.held(1 - h) != part;
    if (alone) beginContact(part);
    if (h == 0)
      endTouchOfTool(part);
    else
      handOf(h).endTool();
  }

  /// The tool no longer touches what the first hand holds, and with a solid part in the hand it touches
  /// nothing. The force of those contacts must not vanish at once.
  void endTouchOfTool(PartId part) {
    data_.tool.noteForeignChange(0.0);
    if (holdsSolid()) {
      first_.fadeOut(data_.tool.contactWrench(), {stiffnessInPlay(), 0.0});
    } else {
      fadeContactsWith(part);
    }
    data_.tool.ignore(part);
  }

  /// A part moves by contact from the first hand that holds it on.
  void beginContact(PartId part) {
    if (data_.partContact == nullptr) return;
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (entry.part == part) data_.partContact->own(part, entry.body.centreOfMass);
    }
  }

  void letGo(int h) {
    Hand& hand = handOf(h);
    const bool carriesTool = h == 0 && holdsSolid();
    if (h == 0) data_.tool.noteForeignChange(0.0);
    const double springs = data_.held.letGo(hand.parameters(), h) ? 2.0 : 1.0;
    if (carriesTool) data_.tool.reset();
    hand.endCoupling(springs);
  }

  void fadeContactsWith(PartId part) {
    EndedContact ended = data_.tool.endedContactWith(part);
    if (parameters_.foreignSlewLimit > 0.0) ended.wrench.force *= first_.passedShare();
    first_.fadeOut(ended.wrench, {ended.stiffness, 0.0});
  }

  void moveParts() {
    data_.foreign.begin(parameters_.foreignSlewLimit, stiffnessInPlay(), parameters_.dt);
    const bool usable = data_.moved.apply(
        data_.world, input_.moved, data_.foreign.reach(data_.tool.reachInTick(), data_.world, data_.held),
        data_.foreign.active() ? parameters_.dt : 0.0, [&](PartId part) { return data_.held.owns(part); },
        [&](const PartMotion& motion, const Pose& before, const Twist& twistBefore) {
          follow(motion, before, twistBefore);
        });
    if (!usable) out_.flags |= kFlagOverflow;
  }

  void follow(const PartMotion& motion, const Pose& before, const Twist& twistBefore) {
    if (!data_.foreign.active() || motion.byThisPerson) {
      data_.tool.follow(motion.part, before, twistBefore, false);
    } else if (!data_.foreign.follow(data_.world, data_.held, data_.partContact.get(), data_.tool,
                                     motion.part, before, twistBefore)) {
      endTouchWith(motion.part);
      data_.tool.ignore(motion.part);
    }
  }

  /// Others end the touch of a part: what it did to the hand fades, or falls at the limited rate.
  void endTouchWith(PartId part, bool fades = true) {
    data_.tool.noteForeignChange(0.0);
    if (fades) fadeContactsWith(part);
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

  /// Loads the controls that this tick simulates with the tool's contacts of the last tick.
  void loadControls() {
    for (const SimulatedPart& entry : data_.held.parts()) {
      const assets::Control* control = entry.moved.control;
      if (control == nullptr) continue;
      const bool touches = first_.valid() && data_.tool.started() && !entry.held();
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

  /// Loads the simulated parts that are free or in the other hand with the tool's contacts of the last tick.
  void loadFreeParts() {
    if (data_.partContact == nullptr && data_.held.held(1) == kNoPart && !data_.held.links().any()) return;
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (entry.grips[0].holds || entry.moved.control != nullptr) continue;
      const bool gives = entry.grips[1].holds || data_.held.links().has(entry.part) || givesWay(entry.part);
      const bool touches =
          first_.valid() && data_.tool.started() && data_.tool.pressesOn(entry.part) && gives;
      if (!touches) {
        data_.held.push(entry.part, {});
        continue;
      }
      data_.held.push(entry.part, {-data_.tool.contactWrenchOf(entry.part).force, data_.tool.proxy().position,
                                   stiffnessInPlay()});
    }
  }

  /// Whether a part that this site does not own would move under the push of a part here if this site owned
  /// it: a free part does, and so does a control.
  bool yields(PartId part) const {
    return givesWay(part) || (data_.world.scene().parts[part].movable &&
                              assets::controlOf(data_.world.scene(), part) != nullptr);
  }

  void notePushed(PartId part) {
    if (data_.held.owns(part)) return;
    for (int i = 0; i < out_.pushedCount; ++i) {
      if (out_.pushed[static_cast<std::size_t>(i)] == part) return;
    }
    if (out_.pushedCount < kMaxPushed) out_.pushed[static_cast<std::size_t>(out_.pushedCount++)] = part;
  }

  void findPushed() {
    if (data_.partContact == nullptr) return;
    for (const PartTouch& touch : data_.partContact->touches()) {
      if (yields(touch.part)) notePushed(touch.part);
    }
    for (const HeldMagnets& magnets : data_.heldMagnets)
      for (const MagnetPull& pull : magnets.pulls())
        if (givesWay(pull.magnet)) notePushed(pull.magnet);
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (HeldParts::atRest(entry)) continue;
      data_.partContact->forEachJoined(entry.part, [&](PartId other) {
        if (givesWay(other)) notePushed(other);
      });
    }
    if (holdsSolid()) return;
    for (int i = 0; i < out_.contactCount; ++i) {
      const Contact& contact = out_.contacts[static_cast<std::size_t>(i)];
      if (contact.force > 0.0 && givesWay(contact.part)) notePushed(contact.part);
    }
  }

  /// Shows and hides the parts of layers. A part that appears around the tool is not felt until the tool
  /// has left it.
  void updateLayers() {
    data_.layers.update(data_.world, [&](PartId part, bool hide) {
      if (!hide) return data_.tool.ignoreIfOver(part);
      if (data_.tool.started()) endTouchWith(part);
    });
  }

  void updateSections() {
    if (!sectionsChange(input_.sections, data_)) return;
    const double spring = stiffnessInPlay();
    const bool usable = changeSections(input_.sections, count_, data_);
    TICK_ASSERT(data_.fault, usable);
    if (first_.valid() && !holdsSolid()) bridgeSections(parameters_, spring, data_);
  }

  void simulateOwned() {
    loadControls();
    loadFreeParts();
    const double now = noteTime();
    if (!data_.fields.empty()) pullByFields(now, count_, parameters_, data_, out_);
    const SurfaceScene* const surfaces = data_.world.surfaces();
    if (surfaces != nullptr && surfaces->magneticReach > 0.0) pullByMagnets(count_, parameters_, data_, out_);
    HandPulls pulls;
    for (int h = 0; h < count_; ++h) pulls[static_cast<std::size_t>(h)] = handOf(h).pull();
    const std::array<Wrench, kHands> onHands =
        data_.held.step(pulls, parameters_, data_.world.scene(), data_.partContact.get(), now);
    for (int h = 0; h < count_; ++h) handOf(h).setCoupling(onHands[static_cast<std::size_t>(h)]);
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

  /// Whether the first hand holds a part that collides: then the hand feels the part's contacts instead of
  /// its tool's.
  bool holdsSolid() const {
    const SimulatedPart* const held = data_.held.heldPart();
    return held != nullptr && held->moved.control == nullptr && data_.partContact != nullptr &&
           data_.partContact->constrains(held->part);
  }

  /// The tool moves with the part in the hand, and the part's contacts are reported as those of the hand.
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

  /// Time for links, which run on without a valid reading.
  double noteTime() {
    const double time = sessionTime(input_, data_.time + parameters_.dt);
    data_.time = first_.valid() || std::isfinite(input_.sessionTime) ? time : data_.time + parameters_.dt;
    return data_.time;
  }

  void feelFields() {
    data_.fieldWrench = Wrench{};
    const double share = (1.0 - data_.fieldShare[0]) * setDownShare(input_.lifted, parameters_, data_);
    if (!first_.valid() || !(share > 0.0)) return data_.fields.forgetHand();
    const FieldForces felt = data_.fields.step(data_.world, input_.hands[0].device, data_.time,
                                               fieldSettings(parameters_, data_.held.held()));
    data_.fieldWrench.force = share * felt.force;
    cause_.byTime = share * felt.sourceChange;
    out_.sourcePower += share * felt.sourcePower * first_.sentShare();
    out_.flags |= felt.flags;
  }

  void report() {
    TICK_ASSERT(data_.fault, isFinite(data_.tool.proxy().position));
    out_.worldFromProxy = {feltPosition(data_.tool.proxy(), parameters_.toolRadius),
                           first_.device().worldFromDevice.orientation};
    for (int h = 0; h < count_; ++h) reportHand(h);
    for (const SimulatedPart& entry : data_.held.parts()) {
      out_.owned[static_cast<std::size_t>(out_.ownedCount++)] = {
          entry.part,   entry.body.worldFromBody, entry.body.twist,
          entry.held(), HeldParts::atRest(entry), data_.held.links().report(entry.part)};
    }
  }

  void reportHand(int h) {
    HandFeedback& out = out_.hands[static_cast<std::size_t>(h)];
    const SimulatedPart* const held = data_.held.heldPart(h);
    out.held = held != nullptr ? held->part : kNoPart;
    out.worldFromGrip = held != nullptr
                            ? held->body.worldFromBody * held->grips[static_cast<std::size_t>(h)].bodyFromGrip
                            : handOf(h).device().worldFromDevice;
  }

  void send() {
    const Wrench tool{first_.letIn(data_.tool.contactWrench().force), data_.tool.contactWrench().torque};
    const Wrench touches = tool + data_.fieldWrench + data_.throughPart[0];
    explainChange(data_, parameters_, stiffnessInPlay(), cause_);
    for (; handsSent_ < count_; ++handsSent_) {
      const int h = handsSent_;
      Hand& hand = handOf(h);
      HandFeedback& out = out_.hands[static_cast<std::size_t>(h)];
      out.toHand =
          h == 0 ? hand.send(&touches, cause_, data_.fault)
                 : hand.send(out.held != kNoPart ? &data_.throughPart[1] : hand.tool(false), {}, data_.fault);
      out.flags = hand.flags();
    }
    out_.flags |= data_.tool.flags() | out_.hands[0].flags;
  }

  Hand& handOf(int h) { return data_.hands[static_cast<std::size_t>(h)]; }

  const TickInput& input_;
  const TickParameters& parameters_;
  Data& data_;
  const int count_ = std::clamp(input_.handCount, 1, kHands);
  Hand& first_ = data_.hands[0];  // the one whose bare tool is part of the tick
  ForceCause cause_;
  std::size_t commandsBegun_ = 0;
  int handsSent_ = 0;  // a hand's limits and fade advance once a tick
  TickOutput out_;
};

/// Output of a tick in which an ASSERT failed; no force at all if its end fails too.
TickOutput endAfter(const FailedAssertion& broken, Tick& current) {
  try {
    return current.abandon(broken);
  } catch (const FailedAssertion&) {
    return current.silence();
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
