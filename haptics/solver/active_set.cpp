#include "haptics/solver/active_set.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem::haptics {
namespace {

// Share of a direction's square below which the row depends on those that are active.
constexpr double kDependent = 1e-10;
// Rate below which a multiplier does not change as another row's grows.
constexpr double kNoRate = 1e-12;
// Rows that may leave the set while one is added.
constexpr int kMaxDrops = 16;

}  // namespace

void ActiveSet::begin(std::size_t bodies, const BodyVectors& start) {
  ASSERT(bodies <= start.size());
  bodies_ = bodies;
  moveTo(start);
  clear();
}

void ActiveSet::moveTo(const BodyVectors& point) {
  for (std::size_t b = 0; b < bodies_; ++b) y_[b] = point[b];
}

void ActiveSet::clear() {
  rows_.clear();
  factored_ = 0;
}

// Cholesky factor of the capacitance matrix of the active rows, C_ij = d_i . d_j + c_i [i = j]: the system
// that remains of all bodies once their displacements are eliminated (Hager 1989, "Updating the inverse of a
// matrix", SIAM Review 31(2)).
void ActiveSet::factor() {
  const Row* const rows = rows_.data();
  for (std::size_t i = factored_; i < rows_.size(); ++i) {
    auto& g = factor_[i];
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = rows[i].direction.dot(rows[j].direction);
      if (i == j) sum += rows[i].compliance;
      for (std::size_t k = 0; k < j; ++k) sum -= g[k] * factor_[j][k];
      g[j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / factor_[j][j];
    }
  }
  factored_ = rows_.size();
}

ActiveSet::Step ActiveSet::stepTowards(const Row& row) {
  factor();
  const std::size_t n = rows_.size();
  const Row* const rows = rows_.data();
  Step step;
  auto& r = step.rates;
  for (std::size_t i = 0; i < n; ++i) {
    r[i] = rows[i].direction.dot(row.direction);
    for (std::size_t k = 0; k < i; ++k) r[i] -= factor_[i][k] * r[k];
    r[i] /= factor_[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) r[i] -= factor_[k][i] * r[k];
    r[i] /= factor_[i][i];
  }
  for (std::size_t b = 0; b < bodies_; ++b) step.path[b].fill(0.0);
  row.direction.addTo(step.path, 1.0);
  step.square = row.compliance;
  for (std::size_t i = 0; i < n; ++i) {
    rows[i].direction.addTo(step.path, -r[i]);
    step.square += r[i] * r[i] * rows[i].compliance;
  }
  for (std::size_t b = 0; b < bodies_; ++b) step.square += dot(step.path[b], step.path[b]);
  return step;
}

void ActiveSet::drop(std::size_t i) {
  ASSERT(i < rows_.size());
  factored_ = std::min(factored_, i);
  std::copy(rows_.begin() + static_cast<std::ptrdiff_t>(i) + 1, rows_.end(),
            rows_.begin() + static_cast<std::ptrdiff_t>(i));
  rows_.pop_back();
}

bool ActiveSet::activate(Row& row) {
  const double square = row.direction.dot(row.direction) + row.compliance;
  const std::size_t maxRigid = 6 * bodies_;
  for (int guard = 0; guard < kMaxDrops; ++guard) {
    const Step step = stepTowards(row);
    std::size_t rigid = 0;
    for (const Row& active : rows_) rigid += active.compliance == 0.0 ? 1 : 0;
    const bool dependent =
        (rigid >= maxRigid && row.compliance == 0.0) || !(step.square >= kDependent * square);
    // t1 of the paper: the first multiplier that falls to zero blocks the step.
    double shortest = std::numeric_limits<double>::infinity();
    std::size_t blocking = kMaxRows;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& active = rows_[i];
      const double rate = step.rates[i];
      if (rate <= kNoRate || active.isEquality) continue;
      const double length = active.multiplier / rate;
      if (length >= shortest) continue;
      shortest = length;
      blocking = i;
    }
    if ((dependent || rows_.full()) && blocking == kMaxRows) return false;
    // t2 of the paper: the step that obeys the row.
    const double full =
        dependent || rows_.full()
            ? std::numeric_limits<double>::infinity()
            : (row.bound - row.direction.dot(y_) - row.compliance * row.multiplier) / step.square;
    const double length = std::min(shortest, full);
    if (!dependent) {
      for (std::size_t b = 0; b < bodies_; ++b) {
        for (std::size_t k = 0; k < 6; ++k) y_[b][k] += length * step.path[b][k];
      }
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].multiplier -= length * step.rates[i];
    row.multiplier += length;
    if (full <= shortest) {
      rows_.push_back(row);
      return true;
    }
    if (blocking == kMaxRows) return false;
    drop(blocking);
  }
  return false;
}

bool ActiveSet::add(Row row, Conflict& conflict) {
  before_ = rows_;
  const BodyVectors y = y_;
  if (activate(row)) return true;
  const Step step = stepTowards(row);
  conflict.clear();
  conflict.push_back(row.row);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (std::abs(step.rates[i]) > kNoRate) conflict.push_back(rows_[i].row);
  }
  // Rows that left the set before the contradiction showed come back.
  rows_ = before_;
  factored_ = 0;
  y_ = y;
  return false;
}

}  // namespace tandem::haptics
