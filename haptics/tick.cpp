#include "haptics/tick.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "assets/base/finite.h"
#include "haptics/proxy/contact_force.h"
#include "haptics/tick_data.h"

namespace tandem::haptics {
namespace {

using Data = TickState::Data;

// A hand unseen for longer than this may be anywhere: dragging the old proxy after it would mean nothing to
// it.
constexpr double kProxyResetAfter = 0.25;  // s
// A hand that went less far while ticks stood still feels on.
constexpr double kStillInStall = 1e-3;  // m
constexpr int kMaxTouchQueries = 32;

bool samePose(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation == b.orientation;
}

/// One call of tick(): the steps in the order in which they run.
class Tick {
 public:
  Tick(const TickInput& input, const TickParameters& parameters, Data& data)
      : input_(input), parameters_(parameters), data_(data) {}

  TickOutput run() {
    if (data_.meshChange.pending) followNewMeshes();
    noteSample();
    if (input_.second != nullptr) data_.second.note(*input_.second, parameters_, data_.held, data_.fault);
    runCommands();
    moveParts();
    simulateOwned();
    updateLayers();
    forgetIgnored();
    if (valid_ && holdsSolid()) {
      carryTool();
    } else if (valid_) {
      moveTool();
      // What a device tells of the speed of a hand at rest is the flicker of a quantum: nothing damps it.
      DeviceSample felt = input_.device;
      if (atRest_) felt.twist.linear = glm::dvec3(0.0);
      const glm::dvec3 force = contactForce(data_.world, data_.proxy, felt, parameters_, out_);
      data_.contactWrench = {
          applySurface(data_.world, data_.proxy, felt, parameters_, force, data_.surface, out_),
          glm::dvec3(0.0)};
      if (data_.surface.letGo != kNoPart) popThrough(data_.surface.letGo);
    } else {
      data_.contactWrench = data_.couplingWrench = Wrench{};
    }
    if (!data_.fields.empty()) feelFields();
    findTouched();
    findPushed();
    report();
    sendWrench();
    if (input_.second != nullptr) out_.second = data_.second.send(secondCoupling_, data_.held, data_.fault);
    return out_;
  }

 private:
  void noteSample() {
    const SampleGuard::Verdict verdict =
        data_.guard.judge(input_.device, parameters_, data_.invalidTime, out_.flags);
    valid_ = verdict != SampleGuard::Verdict::refused;
    if (!valid_) {
      out_.flags |= kFlagInvalidSample;
      data_.invalidTime += parameters_.dt;
      return;
    }
    if (data_.started) {
      const Pose &now = input_.device.worldFromDevice, &last = data_.device.worldFromDevice;
      handMove_ = now.position - last.position;
      handWay_ = glm::length(handMove_);
      if (data_.fade.active()) handTurn_ = rotationVector(now.orientation * glm::conjugate(last.orientation));
    }
    data_.device = input_.device;
    atRest_ = data_.reading.note(input_.device.worldFromDevice.position, parameters_.dt);
    const bool wentOn = std::exchange(data_.stalled, false) && handWay_ > kStillInStall;
    const bool elsewhere = wentOn || verdict == SampleGuard::Verdict::elsewhere;
    if (!data_.started || elsewhere || data_.invalidTime > kProxyResetAfter) resetProxy();
    // A hand that is somewhere else holds its part where it now is: it did not draw it there.
    if (elsewhere && data_.held.held() != kNoPart) {
      data_.held.grasp(data_.held.held(), data_.device.worldFromDevice, parameters_);
    }
    data_.started = true;
    data_.invalidTime = 0.0;
  }

  /// The triangles under the proxy are others than in the last tick.
  void followNewMeshes() {
    if (!data_.started) {
      data_.meshChange.pending = false;
      return;
    }
    const glm::dvec3 before = data_.proxy.position;
    const bool touched = data_.proxy.planeCount > 0;
    const FollowedMeshes followed = followMeshes(data_.world, radius(), data_.meshChange, data_.proxy);
    if (followed.overflow) out_.flags |= kFlagOverflow;
    for (const PartId part : followed.squeezed()) {
      out_.flags |= kFlagSqueezed;
      data_.world.setIgnored(part, false);  // until it is on the list of those ignored
      ignore(part);
    }
    if (touched || data_.proxy.position != before) noteOthers(0.0);
  }

  /// Puts the proxy onto the device. What the device is inside of cannot be felt until it has come out.
  void resetProxy() {
    out_.flags |= kFlagProxyReset;
    data_.proxy = Proxy{};
    data_.proxy.position = data_.device.worldFromDevice.position;
    ignoreOverlapping();
  }

  void ignoreOverlapping() {
    const glm::dvec3& p = data_.proxy.position;
    const glm::dvec3 grow(radius());
    data_.world.forEachNear({p - grow, p + grow}, [&](PartId part) {
      if (data_.world.touchable(part) && data_.world.overlaps(part, p, radius())) ignore(part);
    });
  }

  void ignore(PartId part) {
    if (data_.world.ignored(part)) return;
    if (data_.ignoredCount == kMaxIgnored) {
      out_.flags |= kFlagOverflow;
      return;
    }
    data_.ignored[static_cast<std::size_t>(data_.ignoredCount++)] = part;
    data_.world.setIgnored(part, true);
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
        // A part put somewhere is not a part that moves there: it does not sweep the tool along.
        if (pressesOn(command.part)) noteOthers(0.0);
        data_.world.setPose(command.part, command.pose, Twist{});
        if (data_.started) ignoreOverlapping();
        return;
    }
  }

  void own(PartId part) {
    const bool free = isFree(part);
    if (!data_.held.own(data_.world, part, free)) out_.flags |= kFlagOverflow;
    if (free) take(part);
  }

  void grasp(PartId part) {
    if (!data_.started || !data_.held.owns(part) || data_.held.held() == part) return;
    if (data_.held.held() != kNoPart) letGo();
    const bool alone = data_.held.held(1) != part;
    if (!data_.held.grasp(part, data_.device.worldFromDevice, parameters_)) return;
    noteOthers(0.0);
    if (alone) take(part);
    // The tool no longer touches what it holds, nor with a solid part anything. The force of those contacts must
    // not vanish at once.
    if (holdsSolid()) {
      data_.fade.start(felt(data_.contactWrench), {stiffnessInPlay(), 0.0}, parameters_.fadeTime);
    } else {
      fadeContactsWith(part);
    }
    ignore(part);
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
    noteOthers(0.0);
    const bool solid = holdsSolid();
    const double springs = data_.held.letGo(parameters_) ? 2.0 : 1.0;
    if (solid) resetProxy();
    data_.fade.start(felt(data_.couplingWrench),
                     {springs * parameters_.graspStiffness, springs * parameters_.graspRotStiffness},
                     parameters_.fadeTime);
    data_.couplingWrench = Wrench{};
  }

  /// What of a wrench the device can give. What fades is that: the hand never got more, and a part that it takes from
  /// under a larger one would be dragged for nothing.
  Wrench felt(const Wrench& wrench) const {
    const double force = glm::length(wrench.force), torque = glm::length(wrench.torque);
    return {wrench.force * std::min(1.0, parameters_.forceLimit / std::max(force, 1e-300)),
            wrench.torque * std::min(1.0, parameters_.torqueLimit / std::max(torque, 1e-300))};
  }

  /// Share of the last tick's contact force that came from one part.
  Wrench forceOfContactsWith(PartId part) const {
    double all = 0.0, his = 0.0;
    for (int i = 0; i < data_.proxy.planeCount; ++i) {
      const ProxyPlane& plane = data_.proxy.planes[static_cast<std::size_t>(i)];
      all += plane.multiplier;
      if (plane.surface.part == part) his += plane.multiplier;
    }
    const double share = all > 0.0 ? his / all : 0.0;
    return {data_.contactWrench.force * share, data_.contactWrench.torque * share};
  }

  /// As a spring that is as deep as those contacts were.
  void fadeContactsWith(PartId part) {
    glm::dvec3 depth(0.0);
    for (int i = 0; i < data_.proxy.planeCount; ++i) {
      const ProxyPlane& plane = data_.proxy.planes[static_cast<std::size_t>(i)];
      if (plane.surface.part == part) depth += plane.multiplier * plane.surface.normal;
    }
    const Wrench ended = forceOfContactsWith(part);
    const double length = glm::length(depth);
    const double stiffness = length > 0.0 ? glm::length(ended.force) / length : 0.0;
    data_.fade.start(felt(ended), {stiffness, 0.0}, parameters_.fadeTime);
  }

  void moveParts() {
    // Twists of the last tick are kept until each part has moved: they tell a motion from a jump.
    std::swap(data_.moving, data_.movedBefore);
    data_.moving.clear();
    ++data_.tickNumber;
    moveListed();
    for (const PartId part : data_.movedBefore) {
      if (data_.movedAt[part] != data_.tickNumber) data_.world.setTwist(part, Twist{});
    }
  }

  void moveListed() {
    const bool many = input_.moved.size() > kManyMoving;
    if (!many && !data_.world.anyLoose()) return moveFew();
    data_.world.beginMotions(regionOfTick());
    if (many) sortOutNear();
    data_.world.endMotions();
    if (!many) return moveFew();
    for (const std::uint32_t i : data_.near) {
      const PartMotion& motion = input_.moved[i];
      const Pose before = data_.world.pose(motion.part);
      const Twist twistBefore = data_.world.twist(motion.part);
      data_.world.setNearPose(motion.part, motion.worldFromPart, motion.twist);
      noteMoving(motion.part);
      if (!samePose(before, motion.worldFromPart)) push(motion.part, before, twistBefore);
    }
  }

  void moveFew() {
    for (const PartMotion& motion : input_.moved) {
      if (!takes(motion)) continue;
      movePart(motion.part, motion.worldFromPart, motion.twist);
      noteMoving(motion.part);
    }
  }

  void noteMoving(PartId part) {
    data_.moving.push_back(part);
    data_.movedAt[part] = data_.tickNumber;
  }

  /// Moves the parts that are far from the tool; notes the others in data_.near.
  void sortOutNear() {
    data_.near.clear();
    for (std::size_t i = 0; i < input_.moved.size(); ++i) {
      const PartMotion& motion = input_.moved[i];
      if (!takes(motion) || !data_.world.noteMotion(motion.part, motion.worldFromPart)) continue;
      if (data_.near.size() < data_.near.capacity()) data_.near.push_back(static_cast<std::uint32_t>(i));
    }
  }

  /// These come from elsewhere: what cannot be used is dropped, never trusted.
  bool takes(const PartMotion& motion) {
    const glm::dvec3 &p = motion.worldFromPart.position, &v = motion.twist.linear, &w = motion.twist.angular;
    const glm::dquat& q = motion.worldFromPart.orientation;
    const double sum = p.x + p.y + p.z + v.x + v.y + v.z + w.x + w.y + w.z;
    const double norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    const bool good = data_.world.has(motion.part) && sum - sum == 0.0 && std::abs(norm - 1.0) < 2e-6;
    if (!good) out_.flags |= kFlagOverflow;
    return good && (data_.held.parts().empty() || !data_.held.owns(motion.part));
  }

  /// Where the tool can come to in this tick, and some way around.
  assets::Bounds regionOfTick() const {
    const glm::dvec3 &p = data_.proxy.position, &d = data_.device.worldFromDevice.position;
    const glm::dvec3 grow(2.0 * glm::length(d - p) + 4.0 * radius() + 2.0 * data_.touchReach);
    return {p - grow, p + grow};
  }

  /// `byHand`: the part moves because this hand pushes it.
  void movePart(PartId part, const Pose& worldFromPart, const Twist& twist, bool byHand = false) {
    const Pose before = data_.world.pose(part);
    if (samePose(before, worldFromPart)) return data_.world.setTwist(part, twist);
    const Twist twistBefore = data_.world.twist(part);
    data_.world.setPose(part, worldFromPart, twist);
    push(part, before, twistBefore, byHand);
  }

  void push(PartId part, const Pose& before, const Twist& twistBefore, bool byHand = false) {
    if (!data_.started) return;
    const glm::dvec3 proxyBefore = data_.proxy.position;
    const bool free = pushProxy(data_.world, part, before, radius(), data_.proxy);
    if (!byHand && (data_.proxy.position != proxyBefore || pressesOn(part))) {
      noteOthers(explainedBy(before, twistBefore, proxyBefore));
    }
    if (!free) {
      out_.flags |= kFlagSqueezed;
      ignore(part);
    }
  }

  bool pressesOn(PartId part) const {
    for (int i = 0; i < data_.proxy.planeCount; ++i) {
      const ProxyPlane& plane = data_.proxy.planes[static_cast<std::size_t>(i)];
      if (plane.surface.part == part && presses(plane)) return true;
    }
    return false;
  }

  /// Others have changed the force by something of which `way` m were to be expected.
  void noteOthers(double way) {
    cause_.byHand = false;
    othersWay_ += way;
  }

  /// How far the surface under the proxy would have come in this tick at the last tick's velocity, m: a
  /// motion that goes on is felt as it is, one that begins with a jump is not.
  double explainedBy(const Pose& before, const Twist& twist, const glm::dvec3& proxy) const {
    const double arm = glm::length(proxy - data_.device.worldFromDevice.position);
    return parameters_.dt *
           (glm::length(velocityAt(before, twist, proxy)) + glm::length(twist.angular) * arm);
  }

  /// The stiffest spring between the hand and what it touches, N/m.
  double stiffnessInPlay() const {
    double most =
        std::max(parameters_.stiffness, data_.held.held() != kNoPart ? parameters_.graspStiffness : 0.0);
    for (int i = 0; i < data_.proxy.planeCount; ++i) {
      const SurfacePoint& surface = data_.proxy.planes[static_cast<std::size_t>(i)].surface;
      most = std::max(most, data_.world.material(surface.part, surface.triangle).stiffness);
    }
    return most;
  }

  /// What the tool did to the controls that this hand moves, as its contacts were in the last tick.
  void loadControls() {
    for (const SimulatedPart& entry : data_.held.parts()) {
      const assets::Control* control = entry.moved.control;
      if (control == nullptr) continue;
      const bool touches = valid_ && data_.started && !entry.held();
      data_.held.load(entry.part, touches ? toolLoad(data_.world, data_.proxy, *control,
                                                     forceOfContactsWith(entry.part).force, parameters_)
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
    if (data_.partContact == nullptr && data_.held.held(1) == kNoPart && !data_.held.ties().any()) return;
    for (const SimulatedPart& entry : data_.held.parts()) {
      if (entry.grips[0].holds || entry.moved.control != nullptr) continue;
      const bool gives = entry.grips[1].holds || data_.held.ties().has(entry.part) || givesWay(entry.part);
      const bool touches = valid_ && data_.started && pressesOn(entry.part) && gives;
      if (!touches) {
        data_.held.push(entry.part, {});
        continue;
      }
      data_.held.push(entry.part,
                      {-forceOfContactsWith(entry.part).force, data_.proxy.position, stiffnessInPlay()});
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

  /// Parts that a layer shows or hides. One that appears around the tool cannot be felt until it has come
  /// out.
  void updateLayers() {
    data_.layers.update(data_.world, [&](PartId part, bool hide) {
      if (!data_.started) return;
      if (hide) {
        noteOthers(0.0);
        return fadeContactsWith(part);
      }
      if (data_.world.overlaps(part, data_.device.worldFromDevice.position, radius()) ||
          data_.world.overlaps(part, data_.proxy.position, radius()))
        ignore(part);
    });
  }

  void simulateOwned() {
    loadControls();
    loadFreeParts();
    // The flicker of an encoder's quantum is no speed of the hand: no damper shall follow it.
    DeviceSample felt = input_.device;
    if (atRest_) felt.twist.linear = glm::dvec3(0.0);
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

  /// The tool may touch a part again once both the device and the proxy are out of it: then there is no
  /// depth, and so no force that could begin with a step.
  void forgetIgnored() {
    if (!data_.started) return;
    int kept = 0;
    for (int i = 0; i < data_.ignoredCount; ++i) {
      const PartId part = data_.ignored[static_cast<std::size_t>(i)];
      const bool stays = part == data_.held.held() ||
                         data_.world.overlaps(part, data_.device.worldFromDevice.position, radius()) ||
                         data_.world.overlaps(part, data_.proxy.position, radius());
      if (stays) {
        data_.ignored[static_cast<std::size_t>(kept++)] = part;
      } else {
        data_.world.setIgnored(part, false);
      }
    }
    data_.ignoredCount = kept;
  }

  /// A surface that gave way is passed through at once, so that it is left, and felt again, on its other
  /// side.
  void popThrough(PartId part) {
    out_.flags |= kFlagPopThrough;
    ignore(part);
    moveTool();
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
    data_.proxy = Proxy{};
    data_.proxy.position = transformPoint(held.body.worldFromBody, held.grips[0].bodyFromGrip.position);
    data_.contactWrench = Wrench{};
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

  void moveTool() {
    moveProxy(data_.world, data_.device.worldFromDevice.position, radius(), data_.proxy);
    if (!TICK_ASSERT(data_.fault, isFinite(data_.proxy.position))) resetProxy();
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

  /// The part under the tool: what it touches, else what it is inside of, else the nearest within that part's
  /// reach.
  void findTouched() {
    if (!data_.started) return;
    if (out_.contactCount > 0) {
      out_.touched = out_.contacts[0].part;
      return;
    }
    for (int i = 0; i < data_.ignoredCount; ++i) {
      const PartId part = data_.ignored[static_cast<std::size_t>(i)];
      if (part == data_.held.held()) continue;
      out_.touched = part;
      return;
    }
    const glm::dvec3& p = data_.proxy.position;
    const glm::dvec3 grow(std::max(data_.touchReach, radius() * 3.0));
    double nearest = 1e300;
    int queries = 0;
    data_.world.forEachNear({p - grow, p + grow}, [&](PartId part) {
      if (!data_.world.touchable(part) || queries == kMaxTouchQueries) return;
      const Collider& collider = data_.world.collider(part);
      const double reach =
          std::min(nearest, radius() + std::max(2.0 * radius(), kTouchShare * 2.0 * collider.radius));
      const glm::dvec3 centre = transformPoint(data_.world.pose(part), collider.centre);
      if (glm::length(centre - p) > collider.radius + reach) return;
      ++queries;
      SurfacePoint found;
      if (!data_.world.nearest(part, p, reach, found) || found.distance >= nearest) return;
      nearest = found.distance;
      out_.touched = part;
    });
  }

  void report() {
    out_.worldFromProxy = {data_.proxy.position, data_.device.worldFromDevice.orientation};
    out_.held = data_.held.held();
    for (const SimulatedPart& entry : data_.held.parts()) {
      out_.owned[static_cast<std::size_t>(out_.ownedCount++)] = {
          entry.part,   entry.body.worldFromBody, entry.body.twist,
          entry.held(), HeldParts::atRest(entry), data_.held.ties().report(entry.part)};
    }
  }

  void sendWrench() {
    if (data_.fade.active()) data_.fade.advance(handMove_, handTurn_, parameters_.dt);
    const Wrench felt = data_.contactWrench + data_.fieldWrench;
    const Wrench wanted = felt + data_.couplingWrench + data_.fade.now();
    if (!cause_.byHand) cause_.explained = stiffnessInPlay() * (handWay_ + othersWay_);
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

  double radius() const { return parameters_.toolRadius; }

  const TickInput& input_;
  const TickParameters& parameters_;
  Data& data_;
  bool valid_ = false, atRest_ = false;
  ForceCause cause_;
  glm::dvec3 handMove_{0.0}, handTurn_{0.0};  // m and rad, that the hand went since the last tick
  double handWay_ = 0.0, othersWay_ = 0.0;    // m, that the hand and what it touches went in this tick
  Wrench secondCoupling_;                     // what the second hand's coupling puts on it
  TickOutput out_;
};

}  // namespace

TickOutput tick(const TickInput& input, const ContactScene& scene, const TickParameters& parameters,
                TickState& state) {
  TICK_ASSERT(state.data().fault, state.data().scene == &scene.data());
  return Tick(input, parameters, state.data()).run();
}

}  // namespace tandem::haptics
