#include "haptics/measure/ridge_depth.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

constexpr std::uint32_t kClusterSize = 32;
constexpr int kMaxCuts = 20'000;  // of one interval: far more than convex facets ever need

}  // namespace

/// A piece of an interval with an upper bound of the distance from the body's surface along it.
struct RidgeDepth::Stretch {
  Interval interval;
  double fromDistance = 0.0, toDistance = 0.0;
  double bound = 0.0;

  bool operator<(const Stretch& other) const { return bound < other.bound; }
};

RidgeDepth::RidgeDepth(const DepthModel& probe, const DepthModel& body)
    : probe_(probe), body_(body), tolerance_(std::min(probe.tolerance(), body.tolerance())) {
  makeClusters();
  const assets::Bounds& box = probe.bounds();
  centre_ = 0.5 * (box.min + box.max);
  radius_ = 0.5 * probe.size();
  placed_.resize(probe.corners().size());
  side_.resize(probe.corners().size());
  parent_.resize(probe.corners().size());
}

void RidgeDepth::makeClusters() {
  const auto& ridges = probe_.ridges();
  const auto& corners = probe_.corners();
  order_.resize(ridges.size());
  std::iota(order_.begin(), order_.end(), 0u);
  const auto middle = [&](std::uint32_t r) {
    return 0.5 * (corners[ridges[r].from] + corners[ridges[r].to]);
  };
  // Long ridges are separate from short ones, to keep the balls of short ridges small.
  const auto octave = [&](std::uint32_t r) {
    return std::ilogb(glm::length(corners[ridges[r].from] - corners[ridges[r].to]) + 1e-300);
  };
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return octave(a) > octave(b); });
  struct Range {
    std::uint32_t begin, end;
  };
  std::vector<Range> open;
  for (std::uint32_t begin = 0; begin < order_.size();) {
    std::uint32_t end = begin;
    while (end < order_.size() && octave(order_[end]) == octave(order_[begin])) ++end;
    open.push_back({begin, end});
    begin = end;
  }
  while (!open.empty()) {
    const Range range = open.back();
    open.pop_back();
    assets::Bounds box;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      for (const std::uint32_t c : {ridges[order_[i]].from, ridges[order_[i]].to}) {
        box.include(corners[c]);
      }
    }
    const glm::dvec3 extent = box.max - box.min;
    if (range.end - range.begin <= kClusterSize) {
      clusters_.push_back(
          {range.begin, range.end - range.begin, 0.5 * (box.min + box.max), 0.5 * glm::length(extent)});
      continue;
    }
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::uint32_t half = range.begin + (range.end - range.begin) / 2;
    std::nth_element(order_.begin() + range.begin, order_.begin() + half, order_.begin() + range.end,
                     [&](std::uint32_t a, std::uint32_t b) { return middle(a)[axis] < middle(b)[axis]; });
    open.push_back({range.begin, half});
    open.push_back({half, range.end});
  }
}

void RidgeDepth::travel(const Pose& bodyFromProbe) {
  if (posed_) {
    const glm::dquat rotation = bodyFromProbe.orientation * glm::conjugate(pose_.orientation);
    const double sine = std::min(1.0, glm::length(glm::dvec3(rotation.x, rotation.y, rotation.z)));
    const glm::dvec3 displacement = transformPoint(bodyFromProbe, centre_) - transformPoint(pose_, centre_);
    travelled_ += glm::length(displacement) + 2.0 * std::asin(sine) * radius_;
  }
  pose_ = bodyFromProbe;
  posed_ = true;
}

bool RidgeDepth::mayMatter(Cluster& cluster, double depth) {
  if (cluster.least - (travelled_ - cluster.at) > -depth) return false;
  const glm::dvec3 centre = transformPoint(pose_, cluster.centre);
  MeshPoint under;
  if (!body_.tree().closestPoint(centre, 1e300, under)) return false;
  const bool inside = under.distance > tolerance_ && body_.inside(centre, under);
  cluster.least = (inside ? -under.distance : under.distance) - cluster.radius - tolerance_;
  cluster.at = travelled_;
  return cluster.least <= -depth;
}

void RidgeDepth::measure(const Pose& bodyFromProbe, DeepestPoint& deepest,
                         std::vector<CrossedFacet>& crossed) {
  ASSERT(order_.size() == probe_.ridges().size() && placed_.size() == probe_.corners().size());
  travel(bodyFromProbe);
  near_.clear();
  whole_.clear();
  for (Cluster& cluster : clusters_) {
    if (!mayMatter(cluster, deepest.depth)) continue;
    near_.insert(near_.end(), order_.begin() + cluster.first, order_.begin() + cluster.first + cluster.count);
  }
  for (const std::uint32_t ridge : near_) {
    for (const std::uint32_t corner : {probe_.ridges()[ridge].from, probe_.ridges()[ridge].to}) {
      placed_[corner] = transformPoint(bodyFromProbe, probe_.corners()[corner]);
      side_[corner] = kUnknown;
      parent_[corner] = corner;
    }
  }
  // The deepest point of the last call is likely deepest again, and then prunes most others.
  const auto last = std::find(near_.begin(), near_.end(), deepestRidge_);
  if (last != near_.end()) std::iter_swap(near_.begin(), last);
  for (const std::uint32_t ridge : near_) {
    const double before = deepest.depth;
    measureRidge(ridge, deepest, crossed);
    if (deepest.depth > before) deepestRidge_ = ridge;
  }
  if (!body_.solid()) return;
  findSides();
  for (const std::uint32_t ridge : whole_) {
    const DepthRidge& r = probe_.ridges()[ridge];
    if (side_[root(r.from)] == kInside) measureInside({placed_[r.from], placed_[r.to]}, deepest);
  }
}

std::uint32_t RidgeDepth::root(std::uint32_t corner) {
  while (parent_[corner] != corner) corner = parent_[corner] = parent_[parent_[corner]];
  return corner;
}

void RidgeDepth::measureRidge(std::uint32_t ridge, DeepestPoint& deepest,
                              std::vector<CrossedFacet>& crossed) {
  const DepthRidge& r = probe_.ridges()[ridge];
  const glm::dvec3 from = placed_[r.from], to = placed_[r.to];
  found_.clear();
  body_.crossings(from, to, found_);
  if (found_.empty()) {
    whole_.push_back(ridge);
    parent_[root(r.from)] = root(r.to);
    return;
  }
  cuts_.assign({{0.0, kNoFacet}, {1.0, kNoFacet}});
  for (const SegmentCrossing& c : found_) {
    cuts_.push_back({c.t, body_.facetOf(c.triangle)});
    crossed.push_back({cuts_.back().facet, from + c.t * (to - from)});
  }
  std::sort(cuts_.begin(), cuts_.end(), [](const Cut& x, const Cut& y) { return x.t < y.t; });
  if (!body_.solid()) {
    measureOpen(from, to, deepest);
    return;
  }
  for (std::size_t i = 1; i < cuts_.size(); ++i) {
    const Interval interval{from + cuts_[i - 1].t * (to - from), from + cuts_[i].t * (to - from),
                            cuts_[i - 1].facet, cuts_[i].facet};
    if (glm::length(interval.to - interval.from) <= tolerance_ ||
        bound(interval) <= deepest.depth + tolerance_) {
      continue;
    }
    const glm::dvec3 middle = 0.5 * (interval.from + interval.to);
    if (body_.inside(middle, nearest(middle, interval))) measureInside(interval, deepest);
  }
}

/// Upper bound of the distance of an interval from the body's surface.
double RidgeDepth::bound(const Interval& interval) const {
  double least = 1e300;
  for (const std::uint32_t facet : {interval.fromFacet, interval.toFacet}) {
    if (facet == kNoFacet) continue;
    least = std::min(least, std::max(body_.distanceToFacet(facet, interval.from),
                                     body_.distanceToFacet(facet, interval.to)));
  }
  return least;
}

/// The body's point nearest to one of the interval; the facets at its ends bound the search.
MeshPoint RidgeDepth::nearest(const glm::dvec3& p, const Interval& interval) const {
  double reach = 1e300;
  for (const std::uint32_t facet : {interval.fromFacet, interval.toFacet}) {
    if (facet != kNoFacet) reach = std::min(reach, body_.distanceToFacet(facet, p) + tolerance_);
  }
  MeshPoint found;
  if (!body_.tree().closestPoint(p, reach, found)) body_.tree().closestPoint(p, 1e300, found);
  return found;
}

/// Ridges without crossings lie on one side with all that they join, so one corner decides for all of them.
void RidgeDepth::findSides() {
  for (const bool last : {false, true}) {
    for (const std::uint32_t ridge : whole_) {
      const std::uint32_t corner = probe_.ridges()[ridge].from, representative = root(corner);
      if (side_[representative] != kUnknown) continue;
      MeshPoint under;
      body_.tree().closestPoint(placed_[corner], 1e300, under);
      // A corner that touches leaves the side open, unless all corners touch.
      if (under.distance <= tolerance_ && !last) continue;
      side_[representative] = body_.inside(placed_[corner], under) ? kInside : kOutside;
    }
  }
}

void RidgeDepth::measureInside(const Interval& interval, DeepestPoint& deepest) const {
  DeepestPoint place;
  const double reach = farthest(interval, deepest.depth, place);
  if (reach <= deepest.depth + tolerance_) return;
  MeshPoint under;
  body_.tree().closestPoint(place.point, 1e300, under);
  if (!body_.inside(place.point, under)) return;
  deepest = place;
}

/// Measures an edge through a surface without an inside: at each crossing the end that reaches less far
/// counts.
void RidgeDepth::measureOpen(const glm::dvec3& from, const glm::dvec3& to, DeepestPoint& deepest) const {
  DeepestPoint before;
  for (std::size_t i = 1; i < cuts_.size(); ++i) {
    DeepestPoint after;
    const Interval interval{from + cuts_[i - 1].t * (to - from), from + cuts_[i].t * (to - from),
                            cuts_[i - 1].facet, cuts_[i].facet};
    if (glm::length(interval.to - interval.from) > tolerance_) farthest(interval, deepest.depth, after);
    const DeepestPoint& shorter = after.depth < before.depth ? after : before;
    if (i > 1 && shorter.depth > deepest.depth + tolerance_) deepest = shorter;
    before = after;
  }
}

/// The largest distance from the body's surface along an interval, within the tolerance if it exceeds
/// `enough`, else some distance below that. Branch and bound: the distance has slope 1 at most, and the
/// distance to a single facet is a convex function, which is largest at a piece's ends.
double RidgeDepth::farthest(const Interval& interval, double enough, DeepestPoint& place) const {
  std::vector<Stretch> open{{interval, 0.0, 0.0, 0.0}};
  const auto evaluate = [&](const glm::dvec3& p, const Interval& within, double& distance,
                            std::uint32_t& facet) {
    const MeshPoint under = nearest(p, within);
    distance = under.distance;
    facet = body_.facetOf(under.triangle);
    if (distance > place.depth) place = {distance, p, under.point, true};
  };
  const auto limit = [&](Stretch& s) {
    const double length = glm::length(s.interval.to - s.interval.from);
    s.bound = std::min(0.5 * (s.fromDistance + s.toDistance + length), bound(s.interval));
  };
  // An interval that begins or ends at a crossing is on the surface there.
  Stretch& whole = open.front();
  Interval& ends = whole.interval;
  if (ends.fromFacet == kNoFacet) evaluate(ends.from, interval, whole.fromDistance, ends.fromFacet);
  if (ends.toFacet == kNoFacet) evaluate(ends.to, interval, whole.toDistance, ends.toFacet);
  limit(whole);
  for (int split = 0; split < kMaxCuts && !open.empty(); ++split) {
    std::pop_heap(open.begin(), open.end());
    const Stretch worst = open.back();
    open.pop_back();
    if (worst.bound <= std::max(place.depth, enough) + tolerance_) break;
    Stretch first = worst, second = worst;
    first.interval.to = second.interval.from = 0.5 * (worst.interval.from + worst.interval.to);
    evaluate(first.interval.to, worst.interval, first.toDistance, first.interval.toFacet);
    second.fromDistance = first.toDistance;
    second.interval.fromFacet = first.interval.toFacet;
    for (Stretch* half : {&first, &second}) {
      limit(*half);
      open.push_back(*half);
      std::push_heap(open.begin(), open.end());
    }
  }
  return place.depth;
}

}  // namespace tandem::haptics
