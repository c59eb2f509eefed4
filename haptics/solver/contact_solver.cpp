#include "haptics/solver/contact_solver.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

constexpr int kMaxSaturations = 3;
// The rounds end once no friction force changes by this share of the largest normal force, and no change of
// one moves its point by this many metres.
constexpr double kAgreed = 1e-3, kSlipAgreed = 5e-7;

/// Squeezes the pairs of all conflicting rows that push out of a penetration: without that push all rows
/// can be obeyed. False if no row pushes out.
bool squeeze(const ActiveSet::Conflict& conflict, ContactRows& rows) {
  bool any = false;
  for (const int index : conflict) {
    const ExactRow& row = rows.exact(index);
    if (!row.pushesOut()) continue;
    rows.squeeze(row.source.pair);
    any = true;
  }
  return any;
}

}  // namespace

ActiveSet::Row ContactSolver::activeRowOf(const ExactRow& row, int index) const {
  const RowPair& pair = space_.pair(row.source.pair);
  ActiveSet::Row result;
  result.row = index;
  result.direction = space_.direction(pair, row.normal, glm::cross(row.arm, row.normal) + row.angular);
  result.bound = row.violation(space_.freeMotion(pair));
  result.compliance = row.compliance;
  result.isEquality = row.isEquality;
  return result;
}

void ContactSolver::enforce(int index, ContactRows& rows) {
  ASSERT(index >= 0 && index < rows.exactRows());
  ActiveSet::Row row = activeRowOf(rows.exact(index), index);
  const double missing = row.bound - row.direction.dot(active_.point());
  if (row.isEquality && missing < 0.0) {
    row.bound = -row.bound;
    for (Vector6& of : row.direction.of) {
      for (double& x : of) x = -x;
    }
  }
  if (active_.add(row, conflict_)) return space_.moveTo(active_.point());
  squeezed_ = squeeze(conflict_, rows);
  // An equation that the others imply is no contradiction.
  if (!row.isEquality || std::abs(missing) > tolerance_) ++infeasible_;
  if (!squeezed_) rows.dropExact(index);
}

void ContactSolver::restoreActive(ContactRows& rows) {
  FixedVector<int, ActiveSet::kMaxRows> before;
  for (const ActiveSet::Row& active : active_.rows()) before.push_back(active.row);
  active_.clear();
  for (int i = 0; i < rows.exactRows() && !squeezed_; ++i) {
    if (rows.exact(i).isEquality) enforce(i, rows);
  }
  const PairMotions u = space_.pairMotions();
  for (std::size_t i = 0; i < before.size() && !squeezed_; ++i) {
    const ExactRow& row = rows.exact(before[i]);
    if (!row.isEquality && row.violation(u[row.source.pair]) > tolerance_) enforce(before[i], rows);
  }
}

int ContactSolver::nextExact(const ContactRows& rows) const {
  const PairMotions u = space_.pairMotions();
  const int worst = rows.worstExact(u, tolerance_);
  if (worst >= 0 || !rows.anySoft()) return worst;
  // A compliant row stays violated while it acts, so it counts only until it is active.
  for (int i = 0; i < rows.exactRows(); ++i) {
    const ExactRow& row = rows.exact(i);
    if (row.compliance == 0.0 || row.isEquality || row.violation(u[row.source.pair]) <= tolerance_) continue;
    const auto acts = [&](const ActiveSet::Row& active) { return active.row == i; };
    if (std::none_of(active().begin(), active().end(), acts)) return i;
  }
  return -1;
}

void ContactSolver::solveNormals(const BodyVectors& start, ContactRows& rows, RowRefiner& refiner) {
  do {
    squeezed_ = false;
    active_.moveTo(start);
    space_.moveTo(start);
    restoreActive(rows);
    if (!squeezed_) obeyRows(rows, refiner);
  } while (squeezed_);
}

void ContactSolver::obeyRows(ContactRows& rows, RowRefiner& refiner) {
  while (iterations_ < maxIterations_) {
    for (int worst = nextExact(rows); worst >= 0 && iterations_ < maxIterations_; ++iterations_) {
      enforce(worst, rows);
      if (squeezed_) return;
      worst = nextExact(rows);
    }
    if (!refineViolated(rows, refiner)) return;
  }
}

bool ContactSolver::refine(RowSource source, PairMotions u, ContactRows& rows, RowRefiner& refiner) {
  ++iterations_;
  const int first = rows.exactRows();
  refiner.refine(source, u[source.pair], rows);
  return rows.worstExact(u, tolerance_, first) >= 0;
}

int ContactSolver::prepareBalls(int ball, const ContactRows& rows, RowRefiner& refiner) const {
  const PairMotions u = space_.pairMotions();
  FixedVector<RowSource, RowRefiner::kMostAhead> sources;
  const auto left = static_cast<std::size_t>(maxIterations_ - iterations_);
  for (; ball >= 0 && !sources.full() && sources.size() < left; ball = rows.nextBall(u, ball + 1))
    sources.push_back(rows.ballSource(ball));
  refiner.prepare({sources.data(), sources.size()}, u);
  return static_cast<int>(sources.size());
}

bool ContactSolver::refineViolated(ContactRows& rows, RowRefiner& refiner) {
  const PairMotions u = space_.pairMotions();
  // u changes only when an exact row is violated, so candidates are refined until one is.
  const int alreadyExact = rows.exactRows();
  int prepared = 0;
  for (int ball = rows.nextBall(u, 0); ball >= 0 && iterations_ < maxIterations_;
       ball = rows.nextBall(u, ball), --prepared) {
    if (prepared <= 0 && refiner.prepares()) prepared = prepareBalls(ball, rows, refiner);
    rows.dropBall(ball);
    if (refine(rows.ballSource(ball), u, rows, refiner)) break;
  }
  if (rows.worstExact(u, tolerance_, alreadyExact) >= 0) return true;
  for (int plane = rows.worstPlane(u, tolerance_); plane >= 0 && iterations_ < maxIterations_;
       plane = rows.worstPlane(u, tolerance_)) {
    rows.dropPlane(plane);
    if (refine(rows.planeSource(plane), u, rows, refiner)) return true;
  }
  return refineBeside(rows, refiner);
}

bool ContactSolver::refineBeside(ContactRows& rows, RowRefiner& refiner) {
  const PairMotions u = space_.pairMotions();
  ContactRows::LowPlanes lowest;
  rows.lowestBeside(u, lowest);
  for (const ContactRows::LowPlane& low : lowest) {
    if (iterations_ >= maxIterations_) break;
    const RowSource source = rows.planeSource(low.plane);
    if (!refiner.mayTouchBeside(source, rows.planeNormal(low.plane), low.room, u[source.pair])) continue;
    rows.dropPlane(low.plane);
    if (refine(source, u, rows, refiner)) return true;
  }
  return false;
}

bool ContactSolver::saturate(ContactRows& rows, BodyVectors& saturated) {
  bool any = false;
  for (const ActiveSet::Row& active : active_.rows()) {
    const double greatest = rows.exact(active.row).maxMultiplier;
    if (!(std::abs(active.multiplier) > greatest)) continue;
    active.direction.addTo(saturated, std::copysign(greatest, active.multiplier));
    rows.dropExact(active.row);
    any = true;
  }
  return any;
}

void ContactSolver::solve(std::span<const StepGoal> goals, std::span<const RowPair> pairs, double tolerance,
                          int maxIterations, ContactRows& rows, RowRefiner& refiner) {
  space_.begin(goals, pairs);
  tolerance_ = tolerance;
  maxIterations_ = maxIterations;
  iterations_ = rounds_ = infeasible_ = 0;
  BodyVectors saturated, friction, start;
  space_.setToZero(saturated);
  space_.setToZero(friction);
  friction_.addTo(space_, rows, friction);
  active_.begin(space_.bodyCount(), friction);
  const auto solveWith = [&] {
    for (std::size_t b = 0; b < space_.bodyCount(); ++b) {
      for (std::size_t k = 0; k < 6; ++k) start[b][k] = saturated[b][k] + friction[b][k];
    }
    solveNormals(start, rows, refiner);
  };
  solveWith();
  for (int pass = 0; pass < kMaxSaturations && saturate(rows, saturated); ++pass) solveWith();
  for (; rounds_ < kMaxRounds; ++rounds_) {
    const ContactFriction::Change change =
        friction_.solve(space_, active_.rows(), rows, refiner, saturated, friction);
    if (change.force < kAgreed && change.slip < kSlipAgreed) break;
    solveWith();
  }
}

}  // namespace tandem::haptics
