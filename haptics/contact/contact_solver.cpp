#include "haptics/contact/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

using Vector6 = ContactSolver::Vector6;
using Vectors = ContactSolver::Vectors;
using Direction = ContactSolver::Direction;

// Share of a direction's square below which the row depends on those that are active.
constexpr double kDependent = 1e-10;

double dot(const Vector6& a, const Vector6& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < 6; ++k) sum += a[k] * b[k];
  return sum;
}

double dot(const Direction& a, const Direction& b) {
  double sum = 0.0;
  for (int i = 0; i < 2 && a.body[i] >= 0; ++i) {
    for (int j = 0; j < 2 && b.body[j] >= 0; ++j) {
      if (a.body[i] == b.body[j]) sum += dot(a.of[i], b.of[j]);
    }
  }
  return sum;
}

double dot(const Direction& a, const Vectors& y) {
  double sum = 0.0;
  for (int i = 0; i < 2 && a.body[i] >= 0; ++i) sum += dot(a.of[i], y[static_cast<std::size_t>(a.body[i])]);
  return sum;
}

void addTo(Vectors& sum, double factor, const Direction& d) {
  for (int i = 0; i < 2 && d.body[i] >= 0; ++i) {
    Vector6& of = sum[static_cast<std::size_t>(d.body[i])];
    for (std::size_t k = 0; k < 6; ++k) of[k] += factor * d.of[i][k];
  }
}

/// Solves L x = (force, moment) for a wrench on one body.
Vector6 solveRoot(const StepGoal& goal, const glm::dvec3& force, const glm::dvec3& moment) {
  Vector6 d{force.x, force.y, force.z, moment.x, moment.y, moment.z};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t k = 0; k < i; ++k) d[i] -= goal.root[i][k] * d[k];
    d[i] /= goal.root[i][i];
  }
  return d;
}

Displacement displacementOf(const StepGoal& goal, Vector6 y) {
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t k = i + 1; k < 6; ++k) y[i] -= goal.root[k][i] * y[k];
    y[i] /= goal.root[i][i];
  }
  return {goal.free.linear + glm::dvec3(y[0], y[1], y[2]), goal.free.angular + glm::dvec3(y[3], y[4], y[5])};
}

/// Two directions across a unit vector and each other.
void acrossOf(const glm::dvec3& normal, glm::dvec3 (&tangent)[2]) {
  const glm::dvec3 other = std::abs(normal.x) < 0.7 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  tangent[0] = glm::normalize(glm::cross(normal, other));
  tangent[1] = glm::cross(normal, tangent[0]);
}

}  // namespace

Direction ContactSolver::whitened(const RowPair& pair, const glm::dvec3& force,
                                  const glm::dvec3& moment) const {
  Direction d;
  d.body[0] = pair.first;
  d.body[1] = pair.second;
  d.of[0] = solveRoot(goals_[static_cast<std::size_t>(pair.first)], force, moment);
  if (pair.second >= 0) {
    d.of[1] = solveRoot(goals_[static_cast<std::size_t>(pair.second)], -force,
                        -moment - glm::cross(pair.apart, force));
  }
  return d;
}

ContactSolver::ActiveRow ContactSolver::whiten(const ExactRow& row, int index) const {
  ActiveRow result;
  const RowPair& pair = pairs_[row.source.pair];
  result.row = index;
  result.direction = whitened(pair, row.normal, glm::cross(row.arm, row.normal) + row.turn);
  const Displacement& first = goals_[static_cast<std::size_t>(pair.first)].free;
  result.bound = row.violation(
      pair.second < 0 ? first
                      : seenFrom(first, goals_[static_cast<std::size_t>(pair.second)].free, pair.apart));
  result.give = row.give;
  result.bothWays = row.bothWays;
  return result;
}

void ContactSolver::setToZero(Vectors& v) const {
  for (std::size_t b = 0; b < goals_.size(); ++b) v[b].fill(0.0);
}

void ContactSolver::updateMotions() {
  for (std::size_t b = 0; b < goals_.size(); ++b) u_[b] = displacementOf(goals_[b], y_[b]);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const RowPair& pair = pairs_[p];
    const Displacement& first = u_[static_cast<std::size_t>(pair.first)];
    motion_[p] =
        pair.second < 0 ? first : seenFrom(first, u_[static_cast<std::size_t>(pair.second)], pair.apart);
  }
}

ContactSolver::Step ContactSolver::stepTowards(const ActiveRow& row) {
  const auto n = static_cast<std::size_t>(count_);
  for (auto i = static_cast<std::size_t>(factored_); i < n; ++i) {
    auto& g = factor_[i];
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = dot(active_[i].direction, active_[j].direction);
      if (i == j) sum += active_[i].give;
      for (std::size_t k = 0; k < j; ++k) sum -= g[k] * factor_[j][k];
      g[j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / factor_[j][j];
    }
  }
  factored_ = count_;
  Step step;
  auto& b = step.rates;
  for (std::size_t i = 0; i < n; ++i) {
    b[i] = dot(active_[i].direction, row.direction);
    for (std::size_t k = 0; k < i; ++k) b[i] -= factor_[i][k] * b[k];
    b[i] /= factor_[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) b[i] -= factor_[k][i] * b[k];
    b[i] /= factor_[i][i];
  }
  setToZero(step.way);
  addTo(step.way, 1.0, row.direction);
  step.left = row.give;
  for (std::size_t i = 0; i < n; ++i) {
    addTo(step.way, -b[i], active_[i].direction);
    step.left += b[i] * b[i] * active_[i].give;
  }
  for (std::size_t body = 0; body < goals_.size(); ++body) step.left += dot(step.way[body], step.way[body]);
  return step;
}

void ContactSolver::drop(int i) {
  factored_ = std::min(factored_, i);
  for (; i + 1 < count_; ++i) active_[static_cast<std::size_t>(i)] = active_[static_cast<std::size_t>(i) + 1];
  --count_;
}

bool ContactSolver::activate(ActiveRow& row) {
  const double square = dot(row.direction, row.direction) + row.give;
  const int mostRigid = 6 * static_cast<int>(goals_.size());
  for (int guard = 0; guard < 16; ++guard) {
    const Step step = stepTowards(row);
    int rigid = 0;
    for (int i = 0; i < count_; ++i) rigid += active_[static_cast<std::size_t>(i)].give == 0.0 ? 1 : 0;
    const bool dependent = (rigid >= mostRigid && row.give == 0.0) || !(step.left >= kDependent * square);
    double shortest = std::numeric_limits<double>::infinity();
    int blocking = -1;
    for (int i = 0; i < count_; ++i) {
      const ActiveRow& active = active_[static_cast<std::size_t>(i)];
      const double rate = step.rates[static_cast<std::size_t>(i)];
      if (rate <= 1e-12 || active.bothWays) continue;
      const double length = active.multiplier / rate;
      if (length >= shortest) continue;
      shortest = length;
      blocking = i;
    }
    if ((dependent || count_ == kMostActive) && blocking < 0) return false;
    const double full = dependent || count_ == kMostActive
                            ? std::numeric_limits<double>::infinity()
                            : (row.bound - dot(row.direction, y_) - row.give * row.multiplier) / step.left;
    const double length = std::min(shortest, full);
    if (!dependent) {
      for (std::size_t b = 0; b < goals_.size(); ++b) {
        for (std::size_t k = 0; k < 6; ++k) y_[b][k] += length * step.way[b][k];
      }
    }
    for (int i = 0; i < count_; ++i) {
      active_[static_cast<std::size_t>(i)].multiplier -= length * step.rates[static_cast<std::size_t>(i)];
    }
    row.multiplier += length;
    if (full <= shortest) {
      active_[static_cast<std::size_t>(count_++)] = row;
      return true;
    }
    if (blocking < 0) return false;
    drop(blocking);
  }
  return false;
}

bool ContactSolver::hold(const ActiveRow& row, ContactRows& rows) {
  bool any = false;
  const auto holdPairOf = [&](int index) {
    const ExactRow& exact = rows.exact(index);
    if (!exact.asksOut()) return;
    rows.hold(exact.source.pair);
    any = true;
  };
  const Step step = stepTowards(row);
  holdPairOf(row.row);
  for (int i = 0; i < count_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (std::abs(step.rates[at]) > 1e-12) holdPairOf(active_[at].row);
  }
  return any;
}

void ContactSolver::take(int index, double tolerance, ContactRows& rows) {
  const int count = count_;
  std::copy_n(active_.begin(), count, spare_.begin());
  const Vectors y = y_;
  ActiveRow row = whiten(rows.exact(index), index);
  const double missing = row.bound - dot(row.direction, y_);
  if (row.bothWays && missing < 0.0) {
    row.bound = -row.bound;
    for (Vector6& of : row.direction.of) {
      for (double& x : of) x = -x;
    }
  }
  if (activate(row)) return updateMotions();
  squeezed_ = hold(row, rows);
  // The row contradicts the others: what it gave until that turned out is taken back.
  std::copy_n(spare_.begin(), count, active_.begin());
  count_ = count;
  factored_ = 0;  // of other rows, if any was let go meanwhile
  y_ = y;
  // An equation that the others imply is no contradiction.
  if (!rows.exact(index).bothWays || std::abs(missing) > tolerance) ++infeasible_;
  if (!squeezed_) rows.dropExact(index);
}

void ContactSolver::takeKnown(double tolerance, ContactRows& rows) {
  std::array<int, kMostActive> before;
  const int known = count_;
  for (int i = 0; i < known; ++i)
    before[static_cast<std::size_t>(i)] = active_[static_cast<std::size_t>(i)].row;
  count_ = factored_ = 0;
  for (int i = 0; i < rows.exactRows() && !squeezed_; ++i) {
    if (rows.exact(i).bothWays) take(i, tolerance, rows);
  }
  for (int i = 0; i < known && !squeezed_; ++i) {
    const int row = before[static_cast<std::size_t>(i)];
    const ExactRow& exact = rows.exact(row);
    if (!exact.bothWays && exact.violation(motion_[exact.source.pair]) > tolerance)
      take(row, tolerance, rows);
  }
}

int ContactSolver::nextExact(double tolerance, const ContactRows& rows) const {
  const int worst = rows.worstExact(pairMotions(), tolerance);
  if (worst >= 0 || !rows.anySoft()) return worst;
  // A compliant row stays violated while it acts, so it counts only until it is active.
  for (int i = 0; i < rows.exactRows(); ++i) {
    const ExactRow& row = rows.exact(i);
    if (row.give == 0.0 || row.bothWays || row.violation(motion_[row.source.pair]) <= tolerance) continue;
    const auto acts = [&](const ActiveRow& active) { return active.row == i; };
    if (std::none_of(active().begin(), active().end(), acts)) return i;
  }
  return -1;
}

void ContactSolver::solveNormals(double tolerance, const Vectors& start, ContactRows& rows,
                                 RowRefiner* refiner) {
  do {
    squeezed_ = false;
    for (std::size_t b = 0; b < goals_.size(); ++b) y_[b] = start[b];
    updateMotions();
    takeKnown(tolerance, rows);
    if (!squeezed_) obeyRows(tolerance, rows, refiner);
  } while (squeezed_);
}

void ContactSolver::obeyRows(double tolerance, ContactRows& rows, RowRefiner* refiner) {
  while (picks_ < mostPicks_) {
    const PairMotions u = pairMotions();
    for (int worst = nextExact(tolerance, rows); worst >= 0 && picks_ < mostPicks_; ++picks_) {
      take(worst, tolerance, rows);
      if (squeezed_) return;
      worst = nextExact(tolerance, rows);
    }
    if (refiner == nullptr) return;
    // u changes only when an exact row is violated, so candidates are refined until one is.
    const int alreadyExact = rows.exactRows();
    for (int ball = rows.nextBall(u, 0); ball >= 0 && picks_ < mostPicks_; ball = rows.nextBall(u, ball)) {
      ++picks_;
      const RowSource source = rows.ballSource(ball);
      rows.dropBall(ball);
      const int first = rows.exactRows();
      refiner->refine(source, u[source.pair], rows);
      if (rows.worstExact(u, tolerance, first) >= 0) break;
    }
    if (rows.worstExact(u, tolerance, alreadyExact) >= 0) continue;
    const int plane = rows.worstPlane(u, tolerance);
    if (plane < 0) return;
    ++picks_;
    const RowSource source = rows.planeSource(plane);
    rows.dropPlane(plane);
    refiner->refine(source, u[source.pair], rows);
  }
}

bool ContactSolver::saturate(ContactRows& rows, Vectors& pushed) {
  bool any = false;
  for (const ActiveRow& active : this->active()) {
    const double most = rows.exact(active.row).most;
    if (!(std::abs(active.multiplier) > most)) continue;
    addTo(pushed, std::copysign(most, active.multiplier), active.direction);
    rows.dropExact(active.row);
    any = true;
  }
  return any;
}

int ContactSolver::makePads(const ContactRows& rows, const RowRefiner& refiner) {
  int count = 0;
  for (const ActiveRow& active : this->active()) {
    const ExactRow& row = rows.exact(active.row);
    if (row.staticFriction <= 0.0 && row.dynamicFriction <= 0.0) continue;
    Pad& pad = pads_[static_cast<std::size_t>(count++)];
    pad.row = active.row;
    pad.slidingLimit = row.dynamicFriction * active.multiplier;
    pad.limit = std::max(row.staticFriction * active.multiplier, pad.slidingLimit);
    pad.sticks = false;
    acrossOf(row.normal, pad.tangent);
    const RowPair& pair = pairs_[row.source.pair];
    const StepGoal& first = goals_[static_cast<std::size_t>(pair.first)];
    glm::dvec3 slip = first.before.at(row.arm) + first.free.at(row.arm);
    if (pair.second >= 0) {
      const StepGoal& second = goals_[static_cast<std::size_t>(pair.second)];
      slip -= second.before.at(row.arm + pair.apart) + second.free.at(row.arm + pair.apart);
    } else {
      slip -= refiner.surfaceMotion(row);
    }
    glm::dvec3 force(0.0);
    for (const Friction& last : friction()) {
      if (last.source == row.source) force = last.force, pad.sticks = last.sticks;
    }
    for (int k = 0; k < 2; ++k) {
      pad.direction[k] = whitened(pair, pad.tangent[k], glm::cross(row.arm, pad.tangent[k]));
      pad.slip[k] = glm::dot(pad.tangent[k], slip);
      pad.force[k] = glm::dot(pad.tangent[k], force);
    }
  }
  return count;
}

double ContactSolver::solveFriction(const ContactRows& rows, const RowRefiner& refiner, const Vectors& pushed,
                                    Vectors& part) {
  const int count = makePads(rows, refiner);
  Vectors y;
  for (std::size_t b = 0; b < goals_.size(); ++b) y[b] = pushed[b];
  double largest = 0.0;
  for (const ActiveRow& active : this->active()) {
    addTo(y, active.multiplier, active.direction);
    largest = std::max(largest, active.multiplier);
  }
  const std::span<Pad> pads(pads_.data(), static_cast<std::size_t>(count));
  for (const Pad& pad : pads) {
    for (int k = 0; k < 2; ++k) addTo(y, pad.force[k], pad.direction[k]);
  }
  constexpr int kSweeps = 24;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0.0;
    for (Pad& pad : pads) {
      const double stiffness =
          dot(pad.direction[0], pad.direction[0]) + dot(pad.direction[1], pad.direction[1]);
      double wanted[2];
      for (int k = 0; k < 2; ++k)
        wanted[k] = pad.force[k] - (pad.slip[k] + dot(pad.direction[k], y)) / stiffness;
      const double length = std::hypot(wanted[0], wanted[1]);
      pad.sticks = length <= (pad.sticks || sweep == 0 ? pad.limit : pad.slidingLimit);
      const double scale = pad.sticks || length == 0.0 ? 1.0 : pad.slidingLimit / length;
      for (int k = 0; k < 2; ++k) {
        const double step = scale * wanted[k] - pad.force[k];
        pad.force[k] += step;
        addTo(y, step, pad.direction[k]);
        change = std::max(change, std::abs(step));
      }
    }
    if (change <= 1e-6 * largest) break;
  }
  setToZero(part);
  double change = 0.0;
  std::array<glm::dvec3, kMostActive> force;
  for (std::size_t i = 0; i < pads.size(); ++i) {
    const Pad& pad = pads[i];
    force[i] = pad.force[0] * pad.tangent[0] + pad.force[1] * pad.tangent[1];
    glm::dvec3 before(0.0);
    for (const Friction& last : friction()) {
      if (last.source == rows.exact(pad.row).source) before = last.force;
    }
    change = std::max(change, glm::length(force[i] - before));
    for (int k = 0; k < 2; ++k) addTo(part, pad.force[k], pad.direction[k]);
  }
  for (std::size_t i = 0; i < pads.size(); ++i)
    friction_[i] = {rows.exact(pads[i].row).source, force[i], pads[i].sticks};
  frictionCount_ = count;
  return largest > 0.0 ? change / largest : 0.0;
}

void ContactSolver::addLastFriction(const ContactRows& rows, Vectors& sum) const {
  for (const Friction& last : friction()) {
    const double size = glm::length(last.force);
    if (!(size > 0.0)) continue;
    for (int i = 0; i < rows.exactRows(); ++i) {
      const ExactRow& row = rows.exact(i);
      if (row.source != last.source) continue;
      const glm::dvec3 way = last.force / size;
      addTo(sum, size, whitened(pairs_[row.source.pair], way, glm::cross(row.arm, way)));
      break;
    }
  }
}

void ContactSolver::solve(std::span<const StepGoal> goals, std::span<const RowPair> pairs, double tolerance,
                          int mostPicks, ContactRows& rows, RowRefiner& refiner) {
  goals_ = goals;
  pairs_ = pairs;
  mostPicks_ = mostPicks;
  count_ = factored_ = picks_ = rounds_ = infeasible_ = 0;
  Vectors pushed, friction, start;
  setToZero(pushed);
  setToZero(friction);
  addLastFriction(rows, friction);
  const auto solveWith = [&] {
    for (std::size_t b = 0; b < goals_.size(); ++b) {
      for (std::size_t k = 0; k < 6; ++k) start[b][k] = pushed[b][k] + friction[b][k];
    }
    solveNormals(tolerance, start, rows, &refiner);
  };
  solveWith();
  for (int pass = 0; pass < 3 && saturate(rows, pushed); ++pass) solveWith();
  for (; rounds_ < kMostRounds; ++rounds_) {
    const double change = solveFriction(rows, refiner, pushed, friction);
    if (change < 1e-3) break;
    solveWith();
  }
}

}  // namespace tandem::haptics
