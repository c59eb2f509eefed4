#include "haptics/fit/unexplained_depth.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "haptics/geometry/mesh_edges.h"

namespace tandem::haptics {

void UnexplainedDepth::begin(const PartPair& pair, bool firstIsHollow, double enough) {
  pair_ = pair;
  firstIsHollow_ = firstIsHollow;
  enough_ = enough;
  measured_.clear();
  beginAgain();
}

void UnexplainedDepth::beginAgain() {
  depth_ = 0.0;
  queries_ = 0;
  seen_ = 0;
  waiting_.clear();
  beginSide(true);
}

void UnexplainedDepth::beginSide(bool ofFirst) {
  ofFirst_ = ofFirst;
  side_ = pair_.side(ofFirst);
  const DistanceField& field = side_.to->field;
  near_.emplace(side_.from->samples, field, FloatMotion(side_.toFromSamples, field.origin()), 0.0f);
}

bool UnexplainedDepth::advance(const InterferenceFit& fit, CountedWork& work) {
  constexpr int kRead = static_cast<int>(NearSamples::kAtOnce) * CountedWork::kReading,
                kSeen = static_cast<int>(NearSamples::kAtOnce) * CountedWork::kShift;
  while (depth_ <= enough_) {
    const bool read = near_->done();
    if (read && ofFirst_) {
      beginSide(false);
      continue;
    }
    if (read && (waiting_.empty() || waiting_.begin()->most <= depth_)) return true;
    const bool asks = read || waiting_.size() + NearSamples::kAtOnce > waiting_.capacity();
    const int cost = asks ? CountedWork::kQuery : kRead + kSeen;
    if (work.pauses(cost)) return false;
    if (!work.affords(cost)) {
      depth_ = kUnknown;
      return true;
    }
    if (asks) {
      work.spend(cost);
      measureDeepest();
      continue;
    }
    work.spend(kRead);
    near_->advance([&](std::uint32_t i, const glm::vec3&, const DistanceField::Reading&) {
      work.spend(CountedWork::kShift);
      see(fit, i);
    });
  }
  return true;
}

double UnexplainedDepth::mostOf(std::size_t seen, const glm::dvec3& at) const {
  if (seen >= measured_.size()) return kUnknown;
  return measured_[seen].most + glm::length(at - measured_[seen].at);
}

void UnexplainedDepth::see(const InterferenceFit& fit, std::uint32_t index) {
  const std::size_t seen = seen_++;
  if (seen == measured_.size() && !measured_.full()) measured_.push_back({});
  const ContactSample& sample = side_.from->samples.samples()[index];
  const PartModel& in = *side_.to;
  glm::dvec3 at = transformPoint(side_.toFromSamples, sample.point);
  if (fit.depth() > 0.0) at += fit.shift(side_, sample, firstIsHollow_ == ofFirst_);
  const DistanceField::Reading read = in.field.read(glm::vec3(at - in.field.origin()));
  const auto distance = static_cast<double>(read.distance), error = static_cast<double>(read.error);
  const double most = error - distance;
  if (most <= depth_) return;
  if (error < kExact * in.field.tolerance()) {
    depth_ = most;
    return;
  }
  depth_ = std::max(depth_, -distance - error);
  if (mostOf(seen, at) <= depth_) return;
  waiting_.push_back({most, at, &in, distance < -error, seen});
  std::push_heap(waiting_.begin(), waiting_.end());
}

void UnexplainedDepth::measureDeepest() {
  std::pop_heap(waiting_.begin(), waiting_.end());
  const Place place = waiting_.back();
  waiting_.pop_back();
  if (place.most <= depth_) return;
  // Nothing is known of what there is no time to look at.
  if (++queries_ > kMaxQueries) depth_ = kUnknown;
  MeshPoint nearest;
  const bool near = place.in->tree->closestPoint(place.at, 1.001 * place.most, nearest);
  const bool inside = near && (place.surelyInside || isBehind(place.in->edges, nearest, place.at));
  if (inside) depth_ = std::max(depth_, nearest.distance);
  if (place.seen >= measured_.size()) return;
  // A sample that is inside has the surface within `most`, so one without a surface there is outside.
  const double off = near ? nearest.distance : place.most;
  measured_[place.seen] = {place.at, inside ? off : -off};
}

}  // namespace tandem::haptics
