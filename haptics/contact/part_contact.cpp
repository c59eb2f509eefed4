#include "haptics/contact/part_contact.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "haptics/base/fixed_vector.h"
#include "haptics/base/tick_types.h"
#include "haptics/contact/islands.h"

namespace tandem::haptics {

static_assert(kMaxOwnedParts <= kMaxBodies);

namespace {

constexpr int kAtOnce = 20'000;  // units of work, for a part that is taken in a hurry

}  // namespace

PartContact::PartContact(const ContactWorld& world, FaultLatch& fault)
    : world_(world),
      fault_(fault),
      joints_(world.scene(), fault),
      finder_(world, joints_),
      island_(world, fault),
      overlaps_(island_, fault),
      history_(fault),
      step_(world, island_, overlaps_, joints_, history_, fault),
      standing_(world, finder_, island_, overlaps_, step_, fault),
      atOnce_(world, finder_, island_, overlaps_, step_, fault) {}

void PartContact::own(PartId part, const glm::dvec3& centreOfMass) {
  if (!TICK_ASSERT(fault_, world_.has(part))) return;
  history_.forget(part);
  joints_.restart(part);
  if (!collides(part)) return overlaps_.forget(part);
  if (isTaking(part)) return;
  const Waiting waiting{part, centreOfMass};
  if (waiting_.full()) return takeAtOnce(waiting, true);
  waiting_.push_back(waiting);
}

void PartContact::disown(PartId part) {
  const Waiting* const waiting = waitingFor(part);
  if (waiting == nullptr) return;
  if (waiting == waiting_.data()) begun_ = false;
  waiting_.erase(waiting_.begin() + (waiting - waiting_.data()));
}

void PartContact::hurry(PartId part) {
  for (Waiting& waiting : waiting_)
    if (waiting.part == part) waiting.hurried = true;
}

const PartContact::Waiting* PartContact::waitingFor(PartId part) const {
  const auto found = std::find_if(waiting_.begin(), waiting_.end(),
                                  [part](const Waiting& waiting) { return waiting.part == part; });
  return found != waiting_.end() ? &*found : nullptr;
}

void PartContact::take(double dt, const ContactEffort& effort) {
  dt_ = dt;
  if (begun_ && !standing_.undisturbed()) waiting_[0].hurried = true;
  for (std::size_t i = 0; i < waiting_.size();) {
    const Waiting waiting = waiting_[i];
    if (waiting.hurried) {
      disown(waiting.part);
      takeAtOnce(waiting, true);
    } else {
      ++i;
    }
  }
  CountedWork work(std::max(effort.taking, CountedWork::kLargest));
  while (!waiting_.empty()) {
    const Waiting& waiting = waiting_[0];
    if (!begun_) standing_.begin(waiting.part, waiting.centreOfMass, dt);
    begun_ = true;
    if (!standing_.advance(effort, work)) break;
    disown(waiting.part);
  }
  takingWork_ = work.spent();
  // What still waits touches nothing; other parts find their touches anew.
  if (!waiting_.empty()) touches_.clear();
}

void PartContact::takeAtOnce(const Waiting& waiting, bool exits) {
  CountedWork work(kAtOnce, true);
  atOnce_.begin(waiting.part, waiting.centreOfMass, dt_, exits);
  const bool taken = atOnce_.advance({}, work);
  TICK_ASSERT(fault_, taken);
}

void PartContact::modelsChanged() {
  if (begun_ && !standing_.hasSameModels()) begun_ = false;
  const auto left = std::remove_if(waiting_.begin(), waiting_.end(),
                                   [&](const Waiting& waiting) { return !collides(waiting.part); });
  waiting_.shrink(static_cast<std::size_t>(left - waiting_.begin()));
}

void PartContact::sectionsMoved(PartId part, const glm::dvec3& centreOfMass) {
  if (!isTaking(part) && collides(part)) takeAtOnce({part, centreOfMass}, false);
}

void PartContact::letPass(PartId part, PartId other) {
  history_.forget(part);
  overlaps_.letPass(part, other);
}

bool PartContact::pressesWhereCut(PartId part) const {
  constexpr double kLeast = 1e-3;  // N
  return std::any_of(touches().begin(), touches().end(), [&](const PartTouch& touch) {
    return (touch.of == part || touch.part == part) && touch.force > kLeast &&
           isCutAway(world_.sections(), touch.point);
  });
}

void PartContact::move(std::span<MovingPart> moving, double dt, const ContactEffort& effort) {
  const TickHelpers::Awake helpers = step_.beginTick(work_);
  work_ = Work{};
  touches_.clear();
  dt_ = dt;
  TICK_ASSERT(fault_, dt > 0.0 && moving.size() <= kMaxBodies);
  FixedVector<MovingPart*, kMaxBodies> parts;
  for (MovingPart& part : moving.first(std::min<std::size_t>(moving.size(), kMaxBodies))) {
    if (!TICK_ASSERT(fault_, world_.has(part.part) && part.body != nullptr)) return;
    parts.push_back(&part);
  }
  gather({parts.data(), parts.size()});
  work_.neighbours = island_.pairCount();
  history_.beginTick(island_);
  const Islands islands(island_, {parts.data(), parts.size()}, fault_);
  const ContactStep::Tick tick{dt, effort, &work_, &touches_};
  for (int i = 0; i < islands.count(); ++i) {
    if (islands.count() > 1) gather(islands[i]);
    // Iterations that one island does not use are left to those after it.
    step_.move(islands[i], tick, (effort.sampleQueries - work_.iterations) / (islands.count() - i));
  }
  history_.endTick();
  touches_.sortStrongestFirst();
  for (const MovingPart* part : parts) TICK_ASSERT(fault_, isValid(part->body->worldFromBody));
}

void PartContact::gather(Moving moving) {
  island_.clear();
  double longest = 0.0;
  for (const MovingPart* part : moving) {
    const ContactBody& body = island_.addMoving(*part, dt_);
    longest = std::max(longest, body.motion(body.goal));
  }
  // Two moving parts may approach each other.
  finder_.findTouching(island_.bodyCount() > 1 ? 2.0 * longest : longest, dt_, island_);
  island_.raisePush(overlaps_.longestExit(dt_));
  finder_.findJoined(dt_, island_);
  work_.overflow = work_.overflow || island_.overflowed();
}

bool PartContact::disturbed(PartId part) const {
  const Collider& collider = world_.collider(part);
  const double radius = collider.radius > 0.0 ? collider.radius : 0.01;
  const auto moves = [&](PartId other) {
    const Twist& twist = world_.twist(other);
    return glm::length(twist.linear) + radius * glm::length(twist.angular) > kRestShare * radius;
  };
  bool found = false;
  forEachJoined(part, [&](PartId other) { found = found || moves(other); });
  if (found || !collides(part)) return found;
  const glm::dvec3 middle = transformPoint(world_.pose(part), collider.centre),
                   grow(collider.radius * (1.0 + kRestShare));
  world_.forEachNear({middle - grow, middle + grow}, [&](PartId other) {
    if (other != part && !found && collides(other) && moves(other)) found = finder_.mayTouch(part, other);
  });
  return found;
}

double PartContact::radiusNear(PartId control, const RigidBody& body, std::span<const MovingPart> moving,
                               double dt) const {
  if (!collides(control) || world_.hidden(control)) return 0.0;
  const Collider& ball = world_.collider(control);
  const glm::dvec3 middle = transformPoint(body.worldFromBody, ball.centre);
  constexpr double kRoom = 0.1;  // of the control's radius
  for (const MovingPart& other : moving) {
    const Collider& theirs = world_.collider(other.part);
    const double apart = glm::distance(middle, transformPoint(other.body->worldFromBody, theirs.centre));
    const double motion = dt * (glm::length(other.step.freeVelocity) + glm::length(body.twist.linear) +
                                theirs.radius * glm::length(other.step.freeSpin) +
                                ball.radius * glm::length(body.twist.angular));
    if (collides(other.part) && apart < ball.radius * (1.0 + kRoom) + theirs.radius + motion)
      return ball.radius + glm::distance(ball.centre, body.centreOfMass);
  }
  return 0.0;
}

bool PartContact::presses(PartId part) const {
  const std::span<const PartTouch> all = touches();
  return std::any_of(all.begin(), all.end(), [part](const PartTouch& touch) {
    return touch.force > 0.0 && (touch.of == part || touch.part == part);
  });
}

}  // namespace tandem::haptics
