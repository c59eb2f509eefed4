#include "haptics/contact/overlaps.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/finite.h"

namespace tandem::haptics {
namespace {

// Of a share that is computed in float.
constexpr float kShareRounding = 1e-4f;

double sizeOf(const assets::Bounds& bounds) { return glm::length(bounds.max - bounds.min); }

/// A share of 1 within the bounds that falls to 0 at `margin` (m) beside them, because a jump would be
/// felt.
double shareBeside(const assets::Bounds& bounds, double margin, const glm::dvec3& p) {
  const double off = glm::length(p - glm::clamp(p, bounds.min, bounds.max));
  return off < margin ? 1.0 - off / margin : 0.0;
}

/// A lower bound of that share for all places at most `radius` from p.
float leastShare(const glm::vec3& middle, const glm::vec3& half, float margin, const glm::vec3& p,
                 float radius) {
  const glm::vec3 off = glm::max(glm::abs(p - middle) + radius - half, glm::vec3(0.0f));
  return 1.0f - glm::length(off) / margin;
}

}  // namespace

float AllowedDepth::least(const glm::vec3& inSampled, const glm::vec3& inTarget, float radius) const {
  if (!(depth > 0.0f)) return 0.0f;
  const float share = std::max(leastShare(sampledMiddle, sampledHalf, margin, inSampled, radius),
                               leastShare(targetMiddle, targetHalf, margin, inTarget, radius));
  return depth * std::max(share - kShareRounding, 0.0f);
}

const Overlaps::Overlap& Overlaps::overlapOf(int pair) const {
  return overlaps_[static_cast<std::size_t>(of_[static_cast<std::size_t>(pair)])];
}

const InterferenceFit* Overlaps::fit(int pair, bool& firstIsHollow) const {
  if (!has(pair) || !TICK_ASSERT(fault_, pair < island_.pairCount())) return nullptr;
  const Overlap& overlap = overlapOf(pair);
  if (overlap.fit == kNoFit) return nullptr;
  firstIsHollow = overlap.aIsHollow == (overlap.a == island_.first(island_.pair(pair)).part);
  return &*fits_[static_cast<std::size_t>(overlap.fit)];
}

bool Overlaps::contained(int pair) const { return has(pair) && overlapOf(pair).contained; }

double Overlaps::allowedAt(int pair, const glm::dvec3& inFirst, const glm::dvec3& inOther) const {
  if (!has(pair) || !TICK_ASSERT(fault_, pair < island_.pairCount())) return 0.0;
  const Overlap& overlap = overlapOf(pair);
  if (overlap.fit != kNoFit) return 0.0;
  const bool firstIsA = overlap.a == island_.first(island_.pair(pair)).part;
  const double share = std::max(shareBeside(overlap.inA, overlap.margin, firstIsA ? inFirst : inOther),
                                shareBeside(overlap.inB, overlap.margin, firstIsA ? inOther : inFirst));
  return share * overlap.allowed;
}

bool AllowedDepth::sameBoxes(const AllowedDepth& other) const {
  return margin == other.margin && sampledMiddle == other.sampledMiddle && sampledHalf == other.sampledHalf &&
         targetMiddle == other.targetMiddle && targetHalf == other.targetHalf;
}

AllowedDepth Overlaps::allowed(int pair, bool ofFirst, const glm::dvec3& fieldOrigin) const {
  AllowedDepth depth;
  if (!has(pair)) return depth;
  const Overlap& overlap = overlapOf(pair);
  const bool sampledIsA = ofFirst == (overlap.a == island_.first(island_.pair(pair)).part);
  const assets::Bounds &inSampled = sampledIsA ? overlap.inA : overlap.inB,
                       &inTarget = sampledIsA ? overlap.inB : overlap.inA;
  if (overlap.contained || overlap.fit != kNoFit || !(overlap.margin > 0.0)) return depth;
  depth.depth = static_cast<float>(overlap.allowed);
  depth.margin = static_cast<float>(overlap.margin);
  depth.sampledMiddle = glm::vec3(0.5 * (inSampled.min + inSampled.max));
  depth.sampledHalf = glm::vec3(0.5 * (inSampled.max - inSampled.min));
  depth.targetMiddle = glm::vec3(0.5 * (inTarget.min + inTarget.max) - fieldOrigin);
  depth.targetHalf = glm::vec3(0.5 * (inTarget.max - inTarget.min));
  return depth;
}

double Overlaps::longestExit(double dt) const {
  double longest = 0.0;
  for (const Overlap& overlap : overlaps_) {
    const int body = island_.bodyOf(overlap.a);
    if (overlap.contained && body >= 0) longest = std::max(longest, island_.body(body).escapeDistance(dt));
  }
  return longest;
}

ExactRow Overlaps::exitRow(int index, double dt) const {
  ExactRow row;
  if (!TICK_ASSERT(fault_, contained(index))) return row;
  const ContactPair& pair = island_.pair(index);
  const Overlap& overlap = overlapOf(index);
  const ContactBody& first = island_.first(pair);
  const bool firstInside = overlap.a == first.part;
  const Pose& container = firstInside ? island_.otherPose(pair) : first.pose;
  row.normal = container.orientation * overlap.exit * (firstInside ? 1.0 : -1.0);
  row.gap = glm::dot(row.normal, island_.relativeApplied(index).linear) - first.escapeDistance(dt);
  row.source = {static_cast<std::uint16_t>(index), 0, assets::kNone};
  return row;
}

void Overlaps::beginStep() {
  for (int i = 0; i < island_.pairCount(); ++i) {
    const ContactPair& pair = island_.pair(i);
    int& of = of_[static_cast<std::size_t>(i)];
    of = -1;
    deepest_[static_cast<std::size_t>(i)] = 0.0;
    if (!pair.mayTouch()) continue;
    const PartId part = island_.first(pair).part;
    for (std::size_t k = 0; k < overlaps_.size(); ++k) {
      const Overlap& overlap = overlaps_[k];
      if (isOf(overlap, part, pair.other)) of = static_cast<int>(k);
    }
  }
}

void Overlaps::noteDepth(int pair, double depth) {
  if (!TICK_ASSERT(fault_, pair >= 0 && pair < island_.pairCount())) return;
  double& deepest = deepest_[static_cast<std::size_t>(pair)];
  deepest = std::max(deepest, depth);
}

void Overlaps::endStep() {
  if (overlaps_.empty()) return;
  std::array<int, kMaxOverlaps> now;
  std::size_t remaining = 0;
  for (std::size_t k = 0; k < overlaps_.size(); ++k) {
    Overlap overlap = overlaps_[k];
    if (overlap.fit != kNoFit) {
      now[k] = static_cast<int>(remaining);
      overlaps_[remaining++] = overlap;
      continue;
    }
    // Where neither part moves here, nothing has changed.
    bool near = island_.bodyOf(overlap.a) < 0 && island_.bodyOf(overlap.b) < 0;
    for (int i = 0; i < island_.pairCount(); ++i) {
      if (of_[static_cast<std::size_t>(i)] != static_cast<int>(k)) continue;
      const double deepest = deepest_[static_cast<std::size_t>(i)];
      near = deepest > 0.0;
      overlap.allowed = std::min(overlap.allowed, deepest);
    }
    now[k] = near ? static_cast<int>(remaining) : -1;
    if (near) overlaps_[remaining++] = overlap;
  }
  while (overlaps_.size() > remaining) overlaps_.pop_back();
  for (int i = 0; i < island_.pairCount(); ++i) {
    int& index = of_[static_cast<std::size_t>(i)];
    if (index >= 0) index = now[static_cast<std::size_t>(index)];
  }
}

void Overlaps::letPass(PartId first, PartId other) {
  const auto end = std::remove_if(overlaps_.begin(), overlaps_.end(),
                                  [&](const Overlap& o) { return o.fit == kNoFit && isOf(o, first, other); });
  overlaps_.shrink(static_cast<std::size_t>(end - overlaps_.begin()));
  if (overlaps_.full()) overlaps_.erase(overlaps_.begin());
  // The last of several overlaps counts: a fit waits until the parts have passed.
  Overlap& overlap = overlaps_.push_back({});
  overlap.a = first;
  overlap.b = other;
  overlap.passing = true;
}

bool Overlaps::passes(PartId part) const {
  return std::any_of(overlaps_.begin(), overlaps_.end(), [part](const Overlap& overlap) {
    return overlap.passing && (overlap.a == part || overlap.b == part);
  });
}

void Overlaps::forget(PartId part) {
  const auto end = std::remove_if(overlaps_.begin(), overlaps_.end(), [&](const Overlap& o) {
    return o.fit == kNoFit && !o.passing && (o.a == part || o.b == part);
  });
  for (auto left = overlaps_.end() - end; left > 0; --left) overlaps_.pop_back();
}

const Overlaps::Overlap* Overlaps::fitted(PartId one, PartId other) const {
  const auto known = std::find_if(overlaps_.begin(), overlaps_.end(), [&](const Overlap& overlap) {
    return overlap.fit != kNoFit && isOf(overlap, one, other);
  });
  return known != overlaps_.end() ? &*known : nullptr;
}

OverlapMeasure::KnownFit Overlaps::knownFit(PartId first, PartId other) const {
  const Overlap* const known = fitted(first, other);
  if (known == nullptr) return {};
  return {&*fits_[static_cast<std::size_t>(known->fit)], known->aIsHollow == (known->a == first)};
}

int Overlaps::freeFit() const {
  for (std::size_t i = 0; i < kMaxFits; ++i) {
    const auto uses = [&](const Overlap& overlap) { return overlap.fit == static_cast<int>(i); };
    if (std::none_of(overlaps_.begin(), overlaps_.end(), uses)) return static_cast<int>(i);
  }
  return kNoFit;
}

void Overlaps::remember(PartId first, PartId other, const MeasuredOverlap& measured,
                        const InterferenceFit* fit) {
  if (measured.keepsFit) return;
  const auto passes = std::find_if(overlaps_.begin(), overlaps_.end(), [&](const Overlap& overlap) {
    return overlap.passing && isOf(overlap, first, other);
  });
  if (passes != overlaps_.end()) {
    if (measured.depth > 0.0) return;
    overlaps_.erase(passes);
  }
  if (const Overlap* const known = fitted(first, other))
    overlaps_.erase(overlaps_.begin() + (known - overlaps_.data()));
  if (!(measured.depth > 0.0)) return;
  if (overlaps_.full()) overlaps_.erase(overlaps_.begin());
  Overlap& overlap = overlaps_.push_back({});
  overlap = {first, other, measured.depth, measured.inFirst, measured.inOther};
  overlap.margin = 0.25 * sizeOf(overlap.inA);
  overlap.contained = measured.contained;
  overlap.exit = measured.exit;
  if (const int free = fit != nullptr ? freeFit() : kNoFit; free != kNoFit) {
    fits_[static_cast<std::size_t>(free)] = *fit;
    overlap.fit = free;
    overlap.aIsHollow = measured.firstIsHollow;
  }
  TICK_ASSERT(fault_, overlap.allowed > 0.0 && isFinite(overlap.exit));
}

}  // namespace tandem::haptics
