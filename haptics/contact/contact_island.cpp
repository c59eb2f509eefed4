#include "haptics/contact/contact_island.h"

#include <algorithm>
#include <limits>

#include <glm/geometric.hpp>

#include "assets/base/finite.h"

namespace tandem::haptics {

static_assert(kMaxPairs <= std::numeric_limits<decltype(RowSource::pair)>::max());

namespace {

constexpr double kRadiusWithoutGeometry = 0.01;  // m

}  // namespace

double ContactBody::motion(const Displacement& u) const {
  return glm::length(u.linear) + radius * glm::length(u.angular);
}

void ContactIsland::clear() {
  bodies_.clear();
  goals_.clear();
  clearPairs();
}

ContactBody& ContactIsland::addBody(PartId part, const glm::dvec3& centreOfMass, const Pose& pose) {
  if (!TICK_ASSERT(fault_, !bodies_.full())) return bodies_.back();
  goals_.push_back({});
  ContactBody& body = bodies_.push_back({});
  body.part = part;
  body.model = world_.model(part);
  body.centreOfMass = centreOfMass;
  const Collider& collider = world_.collider(part);
  const double radius = collider.radius > 0.0 ? collider.radius : kRadiusWithoutGeometry;
  body.radius = glm::length(collider.centre - centreOfMass) + radius;
  body.pose = pose;
  const double tolerance = body.model != nullptr ? body.model->field.tolerance() : 1e-5 * body.radius;
  tolerance_ = bodies_.size() == 1 ? tolerance : std::min(tolerance_, tolerance);
  return body;
}

const ContactBody& ContactIsland::addMoving(const MovingPart& part, double dt) {
  TICK_ASSERT(fault_, dt > 0.0 && part.body->mass > 0.0);
  const std::size_t at = bodies_.size();
  ContactBody& body = addBody(part.part, part.body->centreOfMass, part.body->worldFromBody);
  if (at == bodies_.size()) return body;
  body.goal = {dt * part.step.freeVelocity, dt * part.step.freeSpin};
  body.mass = part.body->mass;
  body.grips = part.grips;
  body.axis = part.axis;
  StepGoal& goal = goals_[at];
  goal.applied = Displacement{};
  goal.root = part.step.root;
  return body;
}

void ContactIsland::clearPairs() {
  pairs_.clear();
  rowPairs_.clear();
  push_ = 0.0;
  overflowed_ = false;
}

void ContactIsland::addPair(const ContactPair& pair) {
  if (!TICK_ASSERT(fault_, pair.first < bodyCount() && pair.second < bodyCount())) return;
  const RowPair rowPair{pair.first, pair.second, glm::dvec3(0.0)};
  if (pairs_.size() < static_cast<std::size_t>(pair.mayTouch() ? kMaxPairs - kForJoints : kMaxPairs)) {
    pairs_.push_back(pair);
    rowPairs_.push_back(rowPair);
  } else {
    overflowed_ = true;
    if (!pair.mayTouch()) return;
    const auto nearer = [](const ContactPair& a, const ContactPair& b) { return a.gap < b.gap; };
    const auto furthest = std::max_element(pairs_.begin(), pairs_.end(), nearer);
    if (furthest->gap <= pair.gap) return;
    *furthest = pair;
    rowPairs_[static_cast<std::size_t>(furthest - pairs_.begin())] = rowPair;
  }
  raisePush(pair.push);
}

void ContactIsland::raisePush(double distance) { push_ = std::max(push_, distance); }

double ContactIsland::updateGoals() {
  double longest = 0.0;
  for (int i = 0; i < bodyCount(); ++i) {
    StepGoal& goal = goals_[static_cast<std::size_t>(i)];
    goal.free = remaining(i);
    longest = std::max(longest, body(i).motion(goal.free));
  }
  return longest;
}

void ContactIsland::place() {
  for (int i = 0; i < bodyCount(); ++i) {
    ContactBody& body = bodies_[static_cast<std::size_t>(i)];
    body.centre = transformPoint(body.pose, body.centreOfMass);
  }
  for (int i = 0; i < pairCount(); ++i) {
    ContactPair& pair = pairs_[static_cast<std::size_t>(i)];
    const ContactBody& one = first(pair);
    pair.otherFromFirst = inverse(otherPose(pair)) * one.pose;
    if (pair.second >= 0)
      rowPairs_[static_cast<std::size_t>(i)].offset = one.centre - body(pair.second).centre;
  }
}

void ContactIsland::shortenGoals(double share) {
  for (int i = 0; i < bodyCount(); ++i) {
    const Displacement left = remaining(i), &done = applied(i);
    bodies_[static_cast<std::size_t>(i)].goal = {done.linear + share * left.linear,
                                                 done.angular + share * left.angular};
  }
}

void ContactIsland::moveBody(int i, const Displacement& u) {
  if (!TICK_ASSERT(fault_, i < bodyCount() && isFinite(u.linear) && isFinite(u.angular))) return;
  ContactBody& body = bodies_[static_cast<std::size_t>(i)];
  body.pose.orientation = glm::normalize(fromRotationVector(u.angular) * body.pose.orientation);
  body.pose.position = body.centre + u.linear - body.pose.orientation * body.centreOfMass;
  Displacement& applied = goals_[static_cast<std::size_t>(i)].applied;
  applied = {applied.linear + u.linear, applied.angular + u.angular};
}

int ContactIsland::bodyOf(PartId part) const {
  for (int i = 0; i < bodyCount(); ++i) {
    if (body(i).part == part) return i;
  }
  return -1;
}

const Pose& ContactIsland::otherPose(const ContactPair& pair) const {
  static const Pose kWorld;
  if (pair.second >= 0) return body(pair.second).pose;
  return pair.other != kNoPart ? world_.pose(pair.other) : kWorld;
}

Displacement ContactIsland::remaining(int i) const {
  const Displacement &goal = body(i).goal, &applied = this->applied(i);
  return {goal.linear - applied.linear, goal.angular - applied.angular};
}

Displacement ContactIsland::relative(int index, const Displacement& first, const Displacement& second) const {
  return relativeDisplacement(first, second, rowPairs_[static_cast<std::size_t>(index)].offset);
}

Displacement ContactIsland::relativeApplied(int index) const {
  const ContactPair& of = pair(index);
  return of.second < 0 ? applied(of.first) : relative(index, applied(of.first), applied(of.second));
}

Displacement ContactIsland::relativeRemaining(int index) const {
  const ContactPair& of = pair(index);
  return of.second < 0 ? remaining(of.first) : relative(index, remaining(of.first), remaining(of.second));
}

}  // namespace tandem::haptics
