#include "haptics/contact/part_contact.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {}  // namespace

PartContact::PartContact(const ContactWorld& world) : world_(world) {
  for (PartId part = 0; world.has(part); ++part) {
    const PartModel* model = world.model(part);
    looks_.emplace_back(model != nullptr ? kLooks * model->samples.samples().size() : 0);
  }
  const assets::Scene& scene = world.scene();
  if (scene.joints.empty()) return;
  jointsOf_.resize(scene.parts.size());
  for (const assets::Joint& joint : scene.joints) {
    HeldJoint& held = joints_.emplace_back();
    held.joint = &joint;
    held.sprung = !joint.drives.empty() || joint.detents.force > 0.0 ||
                  std::any_of(joint.limits.begin(), joint.limits.end(),
                              [](const assets::JointLimit& limit) { return limit.stiffness > 0.0; });
    const auto index = static_cast<std::uint32_t>(joints_.size() - 1);
    for (const PartId part : {joint.partA, joint.partB}) {
      // A control has its own mechanics.
      if (part != kNoPart && assets::controlOf(scene, part) == nullptr) jointsOf_[part].push_back(index);
    }
  }
}

// --- the parts and pairs of a tick

int PartContact::bodyOf(PartId part) const {
  for (int i = 0; i < bodyCount_; ++i) {
    if (bodies_[static_cast<std::size_t>(i)].part == part) return i;
  }
  return -1;
}

void PartContact::addBody(PartId part, const glm::dvec3& centreOfMass, const Pose& pose) {
  Body& body = bodies_[static_cast<std::size_t>(bodyCount_++)];
  body = Body{};
  body.part = part;
  body.model = world_.model(part);
  body.centreOfMass = centreOfMass;
  const Collider& collider = world_.collider(part);
  const double radius = collider.radius > 0.0 ? collider.radius : 0.01;
  body.radius = glm::length(collider.centre - centreOfMass) + radius;
  body.pose = pose;
  for (int i = 0; i < lastPaceCount_; ++i) {
    const Pace& pace = lastPace_[static_cast<std::size_t>(i)];
    if (pace.part == part) body.lastMotion = pace.motion;
  }
  const double tolerance = body.model != nullptr ? body.model->field.tolerance() : 1e-5 * body.radius;
  tolerance_ = bodyCount_ == 1 ? tolerance : std::min(tolerance_, tolerance);
}

void PartContact::addPair(const Pair& pair) {
  int at = pairCount_;
  if (at == (pair.joint < 0 ? kMostPairs - kForJoints : kMostPairs)) {
    work_.overflow = true;
    if (pair.joint >= 0) return;
    const auto further = [](const Pair& a, const Pair& b) { return a.gap < b.gap; };
    at = static_cast<int>(std::max_element(pairs_.begin(), pairs_.begin() + at, further) - pairs_.begin());
    if (pairs_[static_cast<std::size_t>(at)].gap <= pair.gap) return;
  } else {
    ++pairCount_;
  }
  rowPairs_[static_cast<std::size_t>(at)] = {pair.first, pair.second, glm::dvec3(0.0)};
  pairs_[static_cast<std::size_t>(at)] = pair;
  push_ = std::max(push_, pair.push);
}

double PartContact::leastGap(const Body& body, const Pose& bodyFromWorld, PartId other) const {
  const assets::Bounds& own = body.model->tree->bounds();
  const Collider& ball = world_.collider(other);
  const glm::dvec3 centre = transformPoint(bodyFromWorld * world_.pose(other), ball.centre);
  return glm::length(centre - glm::clamp(centre, own.min, own.max)) - ball.radius;
}

double PartContact::motionOf(const Body& body, const Displacement& u) {
  return glm::length(u.linear) + body.radius * glm::length(u.angular);
}

Displacement PartContact::left(std::size_t body) const {
  const Displacement &goal = bodies_[body].goal, &gone = goals_[body].before;
  return {goal.linear - gone.linear, goal.angular - gone.angular};
}

bool PartContact::mayTouch(PartId a, PartId b) const {
  if (world_.hidden(b) || !world_.mayCollide(a, b)) return false;
  if (!joined(a) || !joined(b)) return true;
  return std::none_of(jointsOf_[a].begin(), jointsOf_[a].end(), [&](std::uint32_t index) {
    const assets::Joint& joint = *joints_[index].joint;
    return !joint.collide && (joint.partA == b || joint.partB == b);
  });
}

double PartContact::pushOf(PartId part) const {
  const Twist& twist = world_.twist(part);
  const Collider& other = world_.collider(part);
  const double arm = glm::length(other.centre) + other.radius;
  return dt_ * (glm::length(twist.linear) + arm * glm::length(twist.angular));
}

void PartContact::findPairs(double reach) {
  pairCount_ = 0;
  push_ = 0.0;
  for (int i = 0; i < bodyCount_; ++i) {
    const Body& body = bodies_[static_cast<std::size_t>(i)];
    if (body.model == nullptr) continue;
    const Collider& collider = world_.collider(body.part);
    const glm::dvec3 middle = transformPoint(body.pose, collider.centre), grow(collider.radius + reach);
    const int own = pairCount_;
    const Pose bodyFromWorld = inverse(body.pose);
    world_.forEachNear({middle - grow, middle + grow}, [&](PartId part) {
      const PartModel* model = world_.model(part);
      if (part == body.part || model == nullptr || !mayTouch(body.part, part)) return;
      const int second = bodyOf(part);
      for (int k = 0; second >= 0 && k < own; ++k) {
        const Pair& known = pairs_[static_cast<std::size_t>(k)];
        if (known.first == second && known.second == i) return;
      }
      Pair pair;
      pair.first = i;
      pair.second = second;
      pair.other = part;
      pair.model = model;
      if (second < 0) pair.push = pushOf(part);
      pair.gap = leastGap(body, bodyFromWorld, part);
      if (pair.gap <= reach + pair.push) addPair(pair);
    });
  }
  for (int k = 0; k < overlapCount_; ++k) {
    const Overlap& overlap = overlaps_[static_cast<std::size_t>(k)];
    const int body = bodyOf(overlap.a);
    if (overlap.contained && body >= 0)
      push_ = std::max(push_, wayOutATick(bodies_[static_cast<std::size_t>(body)]));
  }
}

void PartContact::findJoints() {
  if (joints_.empty()) return;
  for (int i = 0; i < bodyCount_; ++i) {
    const PartId part = bodies_[static_cast<std::size_t>(i)].part;
    for (const std::uint32_t index : jointsOf_[part]) {
      const assets::Joint& joint = *joints_[index].joint;
      const PartId other = joint.partA == part ? joint.partB : joint.partA;
      const int second = other != kNoPart ? bodyOf(other) : -1;
      if (second >= 0 && second < i) continue;  // the other one has it
      Pair pair;
      pair.first = i;
      pair.second = second;
      pair.other = other;
      pair.joint = static_cast<std::int32_t>(index);
      if (second < 0 && other != kNoPart) pair.push = pushOf(other);
      if (joints_[index].sprung)
        pair.push = std::max(pair.push, wayOutATick(bodies_[static_cast<std::size_t>(i)]));
      addPair(pair);
    }
  }
}

void PartContact::recallFriction() {
  std::array<ContactSolver::Friction, ContactSolver::kMostActive> known;
  std::size_t count = 0;
  for (int i = 0; i < lastFrictionCount_ && count < known.size(); ++i) {
    const KeptFriction& last = lastFriction_[static_cast<std::size_t>(i)];
    for (int k = 0; k < pairCount_; ++k) {
      const Pair& pair = pairs_[static_cast<std::size_t>(k)];
      if (pair.joint >= 0 || pair.other != last.other ||
          bodies_[static_cast<std::size_t>(pair.first)].part != last.first)
        continue;
      known[count] = last.friction;
      known[count++].source.pair = static_cast<std::uint16_t>(k);
      break;
    }
  }
  solver_.recallFriction({known.data(), count});
}

void PartContact::keepFriction() {
  for (const ContactSolver::Friction& friction : solver_.friction()) {
    const Pair& pair = pairs_[friction.source.pair];
    if (frictionCount_ == kMostFrictions) return;
    friction_[static_cast<std::size_t>(frictionCount_++)] = {
        bodies_[static_cast<std::size_t>(pair.first)].part, pair.other, friction};
  }
}

const Pose& PartContact::poseOf(const Pair& pair) const {
  static const Pose kWorld;
  if (pair.second >= 0) return bodies_[static_cast<std::size_t>(pair.second)].pose;
  return pair.other != kNoPart ? world_.pose(pair.other) : kWorld;
}

void PartContact::place() {
  for (int i = 0; i < bodyCount_; ++i) {
    Body& body = bodies_[static_cast<std::size_t>(i)];
    body.centre = transformPoint(body.pose, body.centreOfMass);
  }
  for (int i = 0; i < pairCount_; ++i) {
    Pair& pair = pairs_[static_cast<std::size_t>(i)];
    const Body& first = bodies_[static_cast<std::size_t>(pair.first)];
    pair.otherFromFirst = inverse(poseOf(pair)) * first.pose;
    if (pair.second >= 0)
      rowPairs_[static_cast<std::size_t>(i)].apart =
          first.centre - bodies_[static_cast<std::size_t>(pair.second)].centre;
  }
}

bool PartContact::disturbed(PartId part) const {
  const Collider& collider = world_.collider(part);
  const double radius = collider.radius > 0.0 ? collider.radius : 0.01;
  const auto moves = [&](PartId other) {
    const Twist& twist = world_.twist(other);
    return glm::length(twist.linear) + radius * glm::length(twist.angular) > kRestShare * radius;
  };
  if (joined(part)) {
    for (const std::uint32_t index : jointsOf_[part]) {
      const assets::Joint& joint = *joints_[index].joint;
      const PartId other = joint.partA == part ? joint.partB : joint.partA;
      if (other != kNoPart && moves(other)) return true;
    }
  }
  if (!collides(part)) return false;
  const glm::dvec3 middle = transformPoint(world_.pose(part), collider.centre),
                   grow(collider.radius * (1.0 + kRestShare));
  bool found = false;
  world_.forEachNear({middle - grow, middle + grow}, [&](PartId other) {
    if (other != part && !found && collides(other) && moves(other)) found = mayTouch(part, other);
  });
  return found;
}

// --- one step

void PartContact::gather(double reach) {
  for (int i = 0; i < pairCount_; ++i) {
    Pair& pair = pairs_[static_cast<std::size_t>(i)];
    if (!rows_.beginPair()) return;
    if (pair.joint >= 0) continue;
    const PartId part = bodies_[static_cast<std::size_t>(pair.first)].part;
    pair.deepest = 0.0;
    pair.overlap = -1;
    for (int k = 0; k < overlapCount_; ++k) {
      const Overlap& overlap = overlaps_[static_cast<std::size_t>(k)];
      if ((overlap.a == part && overlap.b == pair.other) || (overlap.b == part && overlap.a == pair.other))
        pair.overlap = k;
    }
    const auto index = static_cast<std::uint16_t>(i);
    const double closing = pair.second >= 0 ? 2.0 * reach : reach;
    gatherSide(index, 0, closing);
    gatherSide(index, 1, closing);
    if (isContained(pair)) bringOut(pair, index);
  }
}

void PartContact::addJoints() {
  for (int i = 0; i < pairCount_; ++i) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    if (pair.joint < 0) continue;
    HeldJoint& held = joints_[static_cast<std::size_t>(pair.joint)];
    const Body& first = bodies_[static_cast<std::size_t>(pair.first)];
    PlacedJoint& placed = held.placed;
    placed.joint = held.joint;
    placed.firstIsB = held.joint->partB == first.part;
    placed.worldFromA = (placed.firstIsB ? poseOf(pair) : first.pose) * held.joint->aFromJoint;
    placed.worldFromB = (placed.firstIsB ? first.pose : poseOf(pair)) * held.joint->bFromJoint;
    placed.centre = first.centre;
    placed.lever = first.radius;
    placed.mass = first.mass;
    placed.inertia = 0.4 * first.mass * first.radius * first.radius;
    placed.pair = static_cast<std::uint16_t>(i);
    if (!held.started) held.state = startJoint(placed);
    held.started = true;
    followTurn(placed, held.state);
    addJointRows(placed, held.state, push_ + wayOutATick(first), dt_, rows_);
  }
}

double PartContact::jointValue(std::uint32_t joint, bool angular) const {
  const HeldJoint& held = joints_[joint];
  return held.started ? haptics::jointValue(held.placed, held.state, angular) : 0.0;
}

void PartContact::refineKept() {
  for (int k = 0; k < keptCount_; ++k) {
    Kept& kept = kept_[static_cast<std::size_t>(k)];
    for (int i = 0; i < pairCount_; ++i) {
      const Pair& pair = pairs_[static_cast<std::size_t>(i)];
      const auto at = static_cast<std::size_t>(pair.first);
      if (pair.joint >= 0 || pair.other != kept.other || bodies_[at].part != kept.first) continue;
      kept.source.pair = static_cast<std::uint16_t>(i);
      Displacement expected = left(at);
      if (pair.second >= 0)
        expected = seenFrom(expected, left(static_cast<std::size_t>(pair.second)),
                            rowPairs_[static_cast<std::size_t>(i)].apart);
      refine(kept.source, expected, rows_);
    }
  }
}

void PartContact::keepContacts() {
  for (int k = 0; k < keptCount_; ++k) {
    Kept& kept = kept_[static_cast<std::size_t>(k)];
    if (bodyOf(kept.first) >= 0) ++kept.unused;
  }
  for (const ContactSolver::ActiveRow& active : solver_.active()) {
    RowSource source = rows_.exact(active.row).source;
    if (source.sample == assets::kNone) continue;
    source.side &= 1;
    const Pair& pair = pairs_[source.pair];
    const PartId first = bodies_[static_cast<std::size_t>(pair.first)].part;
    int at = 0, oldest = 0;
    for (; at < keptCount_; ++at) {
      const Kept& kept = kept_[static_cast<std::size_t>(at)];
      if (kept.first == first && kept.other == pair.other && kept.source.side == source.side &&
          kept.source.sample == source.sample)
        break;
      if (kept.unused > kept_[static_cast<std::size_t>(oldest)].unused) oldest = at;
    }
    if (at == keptCount_) at = keptCount_ < kMostKept ? keptCount_++ : oldest;
    kept_[static_cast<std::size_t>(at)] = {first, pair.other, source, 0};
  }
  const auto end = std::remove_if(kept_.begin(), kept_.begin() + keptCount_,
                                  [](const Kept& kept) { return kept.unused > kKeptFor; });
  keptCount_ = static_cast<int>(end - kept_.begin());
}

glm::dvec3 PartContact::surfaceMotion(const ExactRow& row) const {
  const Pair& pair = pairs_[row.source.pair];
  const glm::dvec3 point = bodies_[static_cast<std::size_t>(pair.first)].centre + row.arm;
  return dt_ * velocityAt(world_.pose(pair.other), world_.twist(pair.other), point);
}

// --- a tick

void PartContact::move(std::span<MovingPart> moving, double dt, const ContactEffort& effort) {
  work_ = Work{};
  effort_ = effort;
  dt_ = dt;
  touchCount_ = frictionCount_ = paceCount_ = 0;
  std::array<MovingPart*, kMostBodies> parts;
  const std::size_t count = std::min<std::size_t>(moving.size(), kMostBodies);
  for (std::size_t i = 0; i < count; ++i) parts[i] = &moving[i];
  gatherBodies({parts.data(), count});
  work_.neighbours = pairCount_;
  for (int k = 0; k < keptCount_; ++k) {
    Kept& kept = kept_[static_cast<std::size_t>(k)];
    if (bodyOf(kept.first) < 0) ++kept.unused;  // asleep, or put down
  }
  std::array<std::size_t, kMostBodies> ends{};
  const int islands = splitIntoIslands({parts.data(), count}, ends);
  std::size_t begin = 0;
  for (int i = 0; i < islands; ++i) {
    const std::size_t end = ends[static_cast<std::size_t>(i)];
    const Moving island{parts.data() + begin, end - begin};
    if (islands > 1) gatherBodies(island);
    // What one island does not look at is left to those after it.
    moveIsland(island, (effort.looks - work_.picks) / (islands - i));
    begin = end;
  }
  std::swap(friction_, lastFriction_);
  lastFrictionCount_ = frictionCount_;
  std::swap(pace_, lastPace_);
  lastPaceCount_ = paceCount_;
  std::sort(touches_.begin(), touches_.begin() + touchCount_,
            [](const PartTouch& a, const PartTouch& b) { return a.force > b.force; });
}

void PartContact::gatherBodies(Moving moving) {
  bodyCount_ = 0;
  lastMotion_ = 0.0;
  double longest = 0.0;
  for (const MovingPart* part : moving) {
    const auto at = static_cast<std::size_t>(bodyCount_);
    addBody(part->part, part->body->centreOfMass, part->body->worldFromBody);
    bodies_[at].goal = {dt_ * part->step.freeVelocity, dt_ * part->step.freeSpin};
    bodies_[at].mass = part->body->mass;
    goals_[at].before = Displacement{};
    goals_[at].root = part->step.root;
    longest = std::max(longest, motionOf(bodies_[at], bodies_[at].goal));
    lastMotion_ = std::max(lastMotion_, bodies_[at].lastMotion);
  }
  // Two of them may come towards each other.
  findPairs(bodyCount_ > 1 ? 2.0 * longest : longest);
  findJoints();
}

int PartContact::splitIntoIslands(std::span<MovingPart*> moving,
                                  std::array<std::size_t, kMostBodies>& ends) const {
  std::array<int, kMostBodies> island;  // the lowest body of each one's
  for (int i = 0; i < bodyCount_; ++i) island[static_cast<std::size_t>(i)] = i;
  for (int i = 0; i < pairCount_; ++i) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    if (pair.second < 0) continue;
    const int a = island[static_cast<std::size_t>(pair.first)],
              b = island[static_cast<std::size_t>(pair.second)];
    std::replace(island.begin(), island.begin() + bodyCount_, std::max(a, b), std::min(a, b));
  }
  std::array<MovingPart*, kMostBodies> before;
  std::copy(moving.begin(), moving.end(), before.begin());
  int count = 0;
  std::size_t next = 0;
  for (int i = 0; i < bodyCount_; ++i) {
    if (island[static_cast<std::size_t>(i)] != i) continue;
    for (std::size_t k = 0; k < moving.size(); ++k) {
      if (island[k] == i) moving[next++] = before[k];
    }
    ends[static_cast<std::size_t>(count++)] = next;
  }
  return count;
}

void PartContact::moveIsland(Moving moving, int mostPicks) {
  recallFriction();
  const int most = std::clamp(effort_.steps, 1, kMostSteps), picksBefore = work_.picks;
  int steps = 0;
  for (int step = 0; step < most; ++step) {
    double way = 0.0;
    for (std::size_t b = 0; b < static_cast<std::size_t>(bodyCount_); ++b) {
      goals_[b].free = left(b);
      way = std::max(way, motionOf(bodies_[b], goals_[b].free));
    }
    if (way + push_ < 0.02 * tolerance_) break;
    place();
    reach_ = std::min(way + push_, 30.0 * tolerance_ + 3.0 * lastMotion_);
    ++stepNumber_;
    rows_.clear();
    gather(reach_);
    addJoints();
    if (overlapCount_ > 0) updateOverlaps();
    refineKept();
    ++steps;
    work_.planes += rows_.planes();
    work_.balls += rows_.balls();
    work_.overflow = work_.overflow || rows_.dropped() > 0;
    const auto bodies = static_cast<std::size_t>(bodyCount_), pairs = static_cast<std::size_t>(pairCount_);
    solver_.solve({goals_.data(), bodies}, {rowPairs_.data(), pairs}, 0.02 * tolerance_,
                  mostPicks - (work_.picks - picksBefore), rows_, *this);
    work_.picks += solver_.picks();
    work_.infeasible += solver_.infeasible();
    if (advance(step)) break;
  }
  work_.steps = std::max(work_.steps, steps);
  for (std::size_t b = 0; b < static_cast<std::size_t>(bodyCount_); ++b) {
    pace_[static_cast<std::size_t>(paceCount_++)] = {bodies_[b].part, lastMotion_};
    MovingPart& part = *moving[b];
    if (steps == 0) {
      // Slower than contact can tell, it stands still and keeps its momentum, until there is a way to look at.
      part.way = bodies_[b].goal;
      setVelocity(*part.body, part.step.freeVelocity, part.step.freeSpin);
      continue;
    }
    const Displacement& gone = goals_[b].before;
    part.body->worldFromBody = bodies_[b].pose;
    setVelocity(*part.body, gone.linear / dt_, gone.angular / dt_);
    part.way = gone;
  }
  keepFriction();
  if (steps > 0) noteTouches();
}

bool PartContact::advance(int step) {
  double share = 1.0, motion = 0.0;
  for (int b = 0; b < bodyCount_; ++b) {
    const double of = motionOf(bodies_[static_cast<std::size_t>(b)], solver_.displacement(b));
    motion = std::max(motion, of);
    if (of > reach_) share = std::min(share, reach_ / of);
  }
  const bool exhausted = solver_.exhausted();
  if (exhausted) {
    // What nobody has looked at is not gone through: the parts go as far as is safe, and on in the next tick.
    share = std::min(share, rows_.safeShare(solver_.pairMotions()));
    work_.exhausted = true;
  }
  for (int b = 0; b < bodyCount_; ++b) {
    const auto at = static_cast<std::size_t>(b);
    Body& body = bodies_[at];
    const Displacement &whole = solver_.displacement(b), u{share * whole.linear, share * whole.angular};
    body.pose.orientation = glm::normalize(fromRotationVector(u.angular) * body.pose.orientation);
    body.pose.position = body.centre + u.linear - body.pose.orientation * body.centreOfMass;
    Displacement& gone = goals_[at].before;
    gone = {gone.linear + u.linear, gone.angular + u.angular};
  }
  keepContacts();
  lastMotion_ = share * motion;
  return exhausted || (share == 1.0 && (step > 0 || motion < 20.0 * tolerance_));
}

void PartContact::noteTouches() {
  for (const ContactSolver::ActiveRow& active : solver_.active()) {
    const ExactRow& row = rows_.exact(active.row);
    const Pair& pair = pairs_[row.source.pair];
    if (pair.joint >= 0 || touchCount_ == kMostTouches) continue;
    const Body& first = bodies_[static_cast<std::size_t>(pair.first)];
    touches_[static_cast<std::size_t>(touchCount_++)] = {first.part, pair.other, first.centre + row.arm,
                                                         row.normal, active.multiplier / (dt_ * dt_)};
  }
}

}  // namespace tandem::haptics
