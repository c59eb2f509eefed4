#include "haptics/contact/contact_step.h"

#include <algorithm>

#include "haptics/contact/axis_rows.h"
#include "haptics/contact/candidate_rows.h"

namespace tandem::haptics {
namespace {

// In tolerances: a remaining motion below kStill is no motion, and a step is solved to within the same. A
// reach of kShortReach finds resting contacts, and a first step below kOneStep needs no second one.
constexpr double kStill = 0.02, kShortReach = 30.0, kOneStep = 20.0;
// The reach beyond kShortReach, in motions of the last step.
constexpr double kGrowth = 3.0;
// Rows of a tick from which on the next one wakes helpers: gathering them takes some 100 us.
constexpr int kWorthSharing = 800;

}  // namespace

ContactStep::ContactStep(const ContactWorld& world, ContactIsland& island, Overlaps& overlaps,
                         PartJoints& joints, ContactHistory& history, FaultLatch& fault)
    : island_(island),
      overlaps_(overlaps),
      joints_(joints),
      history_(history),
      fault_(fault),
      refiner_(world, island, overlaps, fault),
      clocks_(world) {}

void ContactStep::move(std::span<MovingPart* const> moving, const Tick& tick, int maxIterations) {
  if (!TICK_ASSERT(fault_, moving.size() == static_cast<std::size_t>(island_.bodyCount()))) return;
  TICK_ASSERT(fault_, tick.dt > 0.0 && tick.work != nullptr && tick.touches != nullptr);
  lastMotion_ = 0.0;
  for (const MovingPart* part : moving) lastMotion_ = std::max(lastMotion_, history_.lastMotion(part->part));
  pushed_ = mayBePushed(moving, tick.dt);
  slips_ = false;
  history_.recallFriction(island_, solver_);
  const int maxSteps = std::clamp(tick.effort.steps, 1, kMaxSteps), iterationsBefore = tick.work->iterations;
  const double tolerance = island_.tolerance();
  int steps = 0;
  while (steps < maxSteps) {
    const double longest = island_.updateGoals();
    if (longest + island_.push() < kStill * tolerance) break;
    island_.place();
    reach_ = std::min(longest + island_.push(), shortReach(island_) + kGrowth * lastMotion_);
    refiner_.beginStep(tick.dt, reach_, tick.effort);
    gather(reach_, tick.dt);
    joints_.addRows(island_, tick.dt, rows_);
    addAxisRows(island_, tick.dt, rows_);
    overlaps_.endStep();
    refineCached();
    solve(tick, maxIterations - (tick.work->iterations - iterationsBefore));
    ++steps;
    if (advance(steps == 1, *tick.work)) break;
  }
  tick.work->steps = std::max(tick.work->steps, steps);
  for (int i = 0; i < island_.bodyCount(); ++i) {
    history_.noteMotion(island_.body(i).part, lastMotion_);
    finish(*moving[static_cast<std::size_t>(i)], i, steps > 0, tick.dt);
  }
  history_.noteFriction(island_, solver_);
  if (steps > 0) noteTouches(tick);
}

void ContactStep::gather(double reach, double dt) {
  rows_.clear();
  overlaps_.beginStep();
  const SharedGather::Step step{island_, overlaps_, refiner_.memory(), clocks_, rows_, reach};
  if (sharing_) shared_->findSides(step);
  for (int i = 0; i < island_.pairCount(); ++i) {
    if (!TICK_ASSERT(fault_, rows_.beginPair())) return;
    if (!island_.pair(i).mayTouch()) continue;
    sharing_ ? shared_->appendPair(i, step) : gatherPair(i, step);
    if (overlaps_.contained(i)) rows_.addExact(overlaps_.exitRow(i, dt));
  }
}

void ContactStep::gatherPair(int pair, const SharedGather::Step& step) {
  for (const std::uint16_t side : {std::uint16_t{0}, std::uint16_t{1}}) {
    const SideQuery query(island_, overlaps_, static_cast<std::uint16_t>(pair), side,
                          island_.pair(pair).closing(step.reach));
    const SideTimes times(query, clocks_);
    for (std::size_t part = 0; part < times.parts(); ++part)
      overlaps_.noteDepth(pair, CandidateRows(query, times, step.memory, rows_).gather(part));
    times.close(query.from->samples);
  }
}

void ContactStep::share(TickHelpers* helpers) {
  shared_.reset();
  if (helpers != nullptr && helpers->count() > 0) shared_ = std::make_unique<SharedGather>(*helpers, clocks_);
}

TickHelpers::Awake ContactStep::beginTick(const ContactWork& last) {
  sharing_ = shared_ != nullptr && last.planes + last.balls >= kWorthSharing;
  refiner_.share(sharing_ ? &shared_->helpers() : nullptr);
  return TickHelpers::Awake(sharing_ ? &shared_->helpers() : nullptr);
}

double ContactStep::shortReach(const ContactIsland& island) { return kShortReach * island.tolerance(); }

bool ContactStep::readAhead(double dt, const ContactEffort& effort, CountedWork& work) {
  const double reach = shortReach(island_);
  overlaps_.beginStep();
  for (int i = 0; i < island_.pairCount(); ++i) {
    if (!island_.pair(i).mayTouch() || overlaps_.contained(i)) continue;
    for (const std::uint16_t side : {std::uint16_t{0}, std::uint16_t{1}}) {
      const SideQuery query(island_, overlaps_, static_cast<std::uint16_t>(i), side, reach);
      const auto ask = [&](RowSource source) {
        refiner_.beginAhead(dt, reach, effort);
        rows_.clear();
        refiner_.refine(source, {}, rows_);
      };
      const SideTimes times(query, clocks_);
      if (!CandidateRows(query, times, refiner_.memory(), rows_).readAhead(ask, work)) return false;
    }
  }
  return true;
}

void ContactStep::refineCached() {
  history_.forEachContact(island_, [&](const RowSource& source) {
    refiner_.refine(source, island_.relativeRemaining(source.pair), rows_);
  });
}

void ContactStep::solve(const Tick& tick, int maxIterations) {
  TICK_ASSERT(fault_, rows_.exactRows() <= ContactRows::kMaxExact);
  ContactWork& work = *tick.work;
  work.planes += rows_.planes();
  work.balls += rows_.balls();
  solver_.solve(island_.goals(), island_.rowPairs(), kStill * island_.tolerance(), maxIterations, rows_,
                refiner_);
  work.exact += refiner_.queries();
  work.overflow = work.overflow || rows_.dropped() > 0;
  work.iterations += solver_.iterations();
  work.infeasible += solver_.infeasible();
}

double ContactStep::mayBePushed(std::span<MovingPart* const> moving, double dt) const {
  const bool paced =
      std::any_of(moving.begin(), moving.end(), [](const MovingPart* part) { return !part->grips.empty(); });
  if (!paced) return 0.0;
  double longest = 0.0;
  for (int b = 0; b < island_.bodyCount(); ++b) {
    const ContactBody& body = island_.body(b);
    if (!body.grips.empty()) continue;
    const RigidBody& moved = *moving[static_cast<std::size_t>(b)]->body;
    const glm::dvec3 centre = transformPoint(moved.worldFromBody, moved.centreOfMass);
    const Displacement last{dt * velocityAt(moved.worldFromBody, moved.twist, centre),
                            dt * moved.twist.angular};
    longest = std::max(longest, body.motion(last));
  }
  return island_.push() + longest;
}

double ContactStep::paceOfStep() const {
  double pace = 1.0;
  for (int b = 0; b < island_.bodyCount(); ++b) {
    for (const GripPace& grip : island_.body(b).grips) {
      const auto shareOf = [&](const Displacement& next) {
        return shareWithin(grip, island_.applied(b), next, pushed_);
      };
      // Where the hand alone would keep the pace, contacts push the part beyond it, which is not held back.
      pace = std::min(pace, std::max(shareOf(solver_.displacement(b)), shareOf(island_.remaining(b))));
    }
  }
  return pace;
}

bool ContactStep::advance(bool isFirst, ContactWork& work) {
  const bool exhausted = solver_.exhausted();
  const double pace = exhausted ? 1.0 : paceOfStep();
  double share = 1.0, motion = 0.0;
  for (int b = 0; b < island_.bodyCount(); ++b) {
    const double length = pace * island_.body(b).motion(solver_.displacement(b));
    motion = std::max(motion, length);
    if (length > reach_) share = std::min(share, reach_ / length);
  }
  if (pace < 1.0) {
    slips_ = true;
    island_.shortenGoals(pace);
  }
  if (exhausted) {
    // The bodies move as far as no unseen sample can touch, and on in the next tick.
    share = std::min(share, rows_.safeShare(solver_.pairMotions()));
    work.exhausted = true;
  }
  TICK_ASSERT(fault_, share >= 0.0 && share <= 1.0);
  for (int b = 0; b < island_.bodyCount(); ++b) {
    const Displacement& whole = solver_.displacement(b);
    island_.moveBody(b, {share * pace * whole.linear, share * pace * whole.angular});
  }
  history_.noteContacts(island_, rows_, solver_);
  // After a step that was cut short the next one reaches at least half as far as was sought. A shorter reach
  // would need as many answers for less of the way, and the part would fall behind its hand ever further.
  lastMotion_ = std::max(share * motion, exhausted ? 0.5 * std::min(motion, reach_) : 0.0);
  return exhausted || (share == 1.0 && (!isFirst || motion < kOneStep * island_.tolerance()));
}

void ContactStep::finish(MovingPart& part, int index, bool moved, double dt) const {
  const ContactBody& body = island_.body(index);
  if (!TICK_ASSERT(fault_, part.part == body.part)) return;
  if (!moved) {
    // A body that is slower than contact resolves stands still and keeps its momentum until its motion is
    // long enough to check.
    part.displacement = body.goal;
    setVelocity(*part.body, part.step.freeVelocity, part.step.freeSpin);
    return;
  }
  const Displacement& applied = island_.applied(index);
  part.body->worldFromBody = body.pose;
  setVelocity(*part.body, applied.linear / dt, applied.angular / dt);
  part.displacement = applied;
  part.slips = slips_;
  part.cutShort = solver_.exhausted();
}

void ContactStep::noteTouches(const Tick& tick) const {
  for (const ActiveSet::Row& active : solver_.active()) {
    const ExactRow& row = rows_.exact(active.row);
    if (!TICK_ASSERT(fault_, row.source.pair < island_.pairCount())) continue;
    const ContactPair& pair = island_.pair(row.source.pair);
    if (!pair.mayTouch() || tick.touches->full()) continue;
    const ContactBody& first = island_.first(pair);
    tick.touches->add(
        {first.part, pair.other, first.centre + row.arm, row.normal, active.multiplier / (tick.dt * tick.dt)},
        fault_);
  }
}

}  // namespace tandem::haptics
