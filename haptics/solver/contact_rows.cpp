#include "haptics/solver/contact_rows.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "assets/base/assert.h"
#include "haptics/base/simd4.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kAlignment = 16;

/// Keeps the lowest planes in order; of equal ones, those that come first.
void insertLow(const ContactRows::LowPlane& plane, ContactRows::LowPlanes& found) {
  if (found.full()) {
    if (!(plane.room < found.back().room)) return;
    found.pop_back();
  }
  found.push_back(plane);
  for (std::size_t k = found.size() - 1; k > 0 && found[k].room < found[k - 1].room; --k)
    std::swap(found[k], found[k - 1]);
}

float* aligned(float* p) {
  const auto address = reinterpret_cast<std::uintptr_t>(p);
  return reinterpret_cast<float*>((address + kAlignment - 1) / kAlignment * kAlignment);
}

}  // namespace

ContactRows::ContactRows()
    : storage_(std::make_unique<float[]>(8 * kMaxPlanes + kAlignment)),
      source_(std::make_unique<RowSource[]>(kMaxPlanes)),
      ball_(std::make_unique<Ball[]>(kMaxBalls)),
      rows_(std::make_unique<ExactRow[]>(kMaxExact)) {
  float* next = aligned(storage_.get());
  for (float*& column : wrench_) {
    column = next;
    next += kMaxPlanes;
  }
  gap_ = next;
  beside_ = next + kMaxPlanes;
  ASSERT(beside_ + kMaxPlanes <= storage_.get() + 8 * kMaxPlanes + kAlignment);
}

void ContactRows::addPlane(const glm::vec3& normal, const glm::vec3& arm, float gap, RowSource source,
                           float beside) {
  if (planes_ == kMaxPlanes) {
    ++dropped_;
    return;
  }
  const glm::vec3 moment = glm::cross(arm, normal);
  for (int k = 0; k < 3; ++k) {
    wrench_[k][planes_] = normal[k];
    wrench_[k + 3][planes_] = moment[k];
  }
  gap_[planes_] = gap;
  beside_[planes_] = beside;
  anyBeside_ = anyBeside_ || beside > 0.0f;
  source_[planes_++] = source;
}

void ContactRows::addBall(const glm::vec3& arm, float room, RowSource source) {
  if (balls_ == kMaxBalls) {
    ++dropped_;
    return;
  }
  ball_[balls_++] = {arm, room, source};
}

void ContactRows::append(const ContactRows& other, const Range& range) {
  const int planes = std::min(range.endPlane - range.firstPlane, kMaxPlanes - planes_),
            balls = std::min(range.endBall - range.firstBall, kMaxBalls - balls_);
  for (int k = 0; k < 6; ++k) std::copy_n(other.wrench_[k] + range.firstPlane, planes, wrench_[k] + planes_);
  std::copy_n(other.gap_ + range.firstPlane, planes, gap_ + planes_);
  std::copy_n(other.beside_ + range.firstPlane, planes, beside_ + planes_);
  std::copy_n(other.source_.get() + range.firstPlane, planes, source_.get() + planes_);
  std::copy_n(other.ball_.get() + range.firstBall, balls, ball_.get() + balls_);
  anyBeside_ = anyBeside_ || other.anyBeside_;
  dropped_ += range.endPlane - range.firstPlane - planes + range.endBall - range.firstBall - balls;
  planes_ += planes;
  balls_ += balls;
}

int ContactRows::addExact(const ExactRow& row) {
  if (exact_ == kMaxExact) {
    ++dropped_;
    return -1;
  }
  rows_[exact_] = row;
  if (row.pushesOut() && isSqueezed(row.source.pair)) rows_[exact_].gap = 0.0;
  anySoft_ = anySoft_ || row.compliance > 0.0;
  return exact_++;
}

void ContactRows::squeeze(int pair) {
  squeezed_.set(static_cast<std::size_t>(pair));
  for (int i = 0; i < exact_; ++i) {
    if (rows_[i].source.pair == pair && rows_[i].pushesOut()) rows_[i].gap = 0.0;
  }
}

bool ContactRows::beginPair() {
  if (pairs_ == kMaxPairs) return false;
  // Four planes are read at once, so the planes of a pair begin at a multiple of four.
  while (planes_ % 4 != 0) {
    for (float* const column : wrench_) column[planes_] = 0.0f;
    beside_[planes_] = 0.0f;
    gap_[planes_++] = 1e30f;
  }
  firstPlane_[static_cast<std::size_t>(pairs_++)] = planes_;
  return true;
}

int ContactRows::worstPlaneOf(int begin, int end, const Displacement& u, float& least) const {
  const float w[6] = {static_cast<float>(u.linear.x),  static_cast<float>(u.linear.y),
                      static_cast<float>(u.linear.z),  static_cast<float>(u.angular.x),
                      static_cast<float>(u.angular.y), static_cast<float>(u.angular.z)};
  Float4 c[6];
  for (int k = 0; k < 6; ++k) c[k] = Float4(w[k]);
  const float before = least;
  Float4 lowest(before);
  const auto room = [&](int i) {
    Float4 sum = Float4::load(gap_ + i);
    for (int k = 0; k < 6; ++k) sum = sum + Float4::load(wrench_[k] + i) * c[k];
    return sum;
  };
  const int whole = begin + (end - begin) / 4 * 4;
  for (int i = begin; i < whole; i += 4) lowest = min(lowest, room(i));
  alignas(16) float lane[4];
  lowest.store(lane);
  for (const float x : lane) least = x < least ? x : least;
  int found = -1;
  for (int i = whole; i < end; ++i) {
    float sum = gap_[i];
    for (int k = 0; k < 6; ++k) sum = sum + wrench_[k][i] * w[k];
    if (sum < least) {
      least = sum;
      found = i;
    }
  }
  if (found >= 0 || least == before) return found;
  for (int i = begin; i < whole; i += 4) {
    const int mask = lessEqualMask(room(i), Float4(least));
    if (mask == 0) continue;
    for (int k = 0; k < 4; ++k) {
      if ((mask >> k & 1) != 0) return i + k;
    }
  }
  return -1;
}

int ContactRows::worstPlane(PairMotions u, double limit) const {
  float least = static_cast<float>(-limit);
  int worst = -1;
  for (int pair = 0; pair < pairs_; ++pair) {
    const auto at = static_cast<std::size_t>(pair);
    const int found = worstPlaneOf(firstPlane_[at], endOf(pair), u[at], least);
    if (found >= 0) worst = found;
  }
  return worst;
}

void ContactRows::lowestBeside(PairMotions u, LowPlanes& found) const {
  found.clear();
  if (!anyBeside_) return;
  for (int pair = 0; pair < pairs_; ++pair) {
    const auto at = static_cast<std::size_t>(pair);
    const glm::vec3 t(u[at].linear), w(u[at].angular);
    const Float4 c[6] = {Float4(t.x), Float4(t.y), Float4(t.z), Float4(w.x), Float4(w.y), Float4(w.z)};
    const int end = endOf(pair);
    for (int i = firstPlane_[at]; i < end; i += 4) {
      const Float4 beside = Float4::load(beside_ + i);
      Float4 room = Float4::load(gap_ + i);
      for (int k = 0; k < 6; ++k) room = room + Float4::load(wrench_[k] + i) * c[k];
      const int mask = lessMask(room, found.full() ? min(beside, Float4(found.back().room)) : beside);
      if (mask == 0) continue;
      alignas(16) float lane[4];
      room.store(lane);
      for (int k = 0; k < 4 && i + k < end; ++k) {
        if ((mask >> k & 1) != 0) insertLow({i + k, lane[k]}, found);
      }
    }
  }
}

int ContactRows::nextBall(PairMotions u, int from) const {
  int pair = -1;
  glm::vec3 t(0.0f), w(0.0f);
  for (int i = from; i < balls_; ++i) {
    if (ball_[i].source.pair != pair) {
      pair = ball_[i].source.pair;
      const Displacement& of = u[static_cast<std::size_t>(pair)];
      t = glm::vec3(of.linear);
      w = glm::vec3(of.angular);
    }
    const glm::vec3 displacement = t + glm::cross(w, ball_[i].arm);
    const float room = ball_[i].room > 0.0f ? ball_[i].room : 0.0f;
    if (glm::dot(displacement, displacement) > room * room) return i;
  }
  return -1;
}

double ContactRows::safeShare(PairMotions u) const {
  double share = 1.0;
  for (int i = 0; i < balls_; ++i) {
    const Displacement& of = u[ball_[i].source.pair];
    const float length = glm::length(glm::vec3(of.linear) + glm::cross(glm::vec3(of.angular), ball_[i].arm));
    if (length > ball_[i].room)
      share = std::min(share, static_cast<double>(std::max(ball_[i].room, 0.0f) / length));
  }
  for (int pair = 0; pair < pairs_; ++pair) {
    const auto at = static_cast<std::size_t>(pair);
    const glm::vec3 t(u[at].linear), w(u[at].angular);
    for (int i = firstPlane_[at]; i < endOf(pair); ++i) {
      const float approach = -(glm::dot(glm::vec3(wrench_[0][i], wrench_[1][i], wrench_[2][i]), t) +
                               glm::dot(glm::vec3(wrench_[3][i], wrench_[4][i], wrench_[5][i]), w));
      if (approach > 0.0f && approach > gap_[i])
        share = std::min(share, static_cast<double>(std::max(gap_[i], 0.0f) / approach));
    }
  }
  // The solver has not come to all exact rows.
  for (int i = 0; i < exact_; ++i) {
    const ExactRow& row = rows_[i];
    const double approach = -row.along(u[row.source.pair]);
    if (row.compliance > 0.0 || row.isEquality || approach <= std::max(row.gap, 0.0)) continue;
    share = std::min(share, std::max(row.gap, 0.0) / approach);
  }
  return share;
}

int ContactRows::worstExact(PairMotions u, double limit, int from) const {
  double worst = limit;
  int found = -1;
  for (int i = from; i < exact_; ++i) {
    const double violation = rows_[i].violation(u[rows_[i].source.pair]);
    if (violation <= worst || rows_[i].compliance > 0.0) continue;
    worst = violation;
    found = i;
  }
  return found;
}

}  // namespace tandem::haptics
