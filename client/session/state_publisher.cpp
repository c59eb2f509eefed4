#include "client/session/state_publisher.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "sync/wire/limits.h"

namespace tandem::client {

using namespace sync;

namespace {

constexpr double kSmoothEnough = 25.0;  // Hz, of hand and camera where updates are few
constexpr Micros kEarly =
    3 * kMillisecond / 2;         // by which an update may leave early, rather than a link packet later
constexpr int kQuickRepeats = 4;  // at the minimum rate: at 5 % of loss all are lost once in 3 million cases
constexpr Micros kSlowestRepeat = 500 * kMillisecond;
constexpr double kErrorFloor = 0x1p-18;     // of the frame's half extent: some steps of the wire
constexpr double kPresenceMoved = 0x1p-13;  // of the frame's half extent: under a pixel of a whole view
constexpr double kPresenceTurned = 0.01;    // rad
constexpr double kPresenceForce = 0.05;     // N

Micros period(double hz) { return static_cast<Micros>(1e6 / hz); }

double angleBetween(const glm::dquat& a, const glm::dquat& b) {
  return glm::length(rotationVector(a * glm::conjugate(b)));
}

double reachOf(const assets::ImplicitShape& shape) {
  const double radius = std::max(shape.radiusTop, shape.radiusBottom);
  const bool flat =
      shape.kind == assets::ImplicitShape::Kind::box || shape.kind == assets::ImplicitShape::Kind::plane;
  return glm::length(shape.partFromShape.position) +
         (flat ? 0.5 * glm::length(shape.size) : radius + 0.5 * shape.height);
}
/// An upper bound of the distance of the part's points from its origin, about which it turns; m.
double reachOf(const assets::Scene& scene, const assets::Part& part) {
  double reach = 0.0;
  if (part.mesh != assets::kNone) {
    const assets::Bounds& bounds = scene.meshes[part.mesh].bounds;
    reach = glm::length(glm::max(glm::abs(bounds.min), glm::abs(bounds.max)));
  }
  for (const assets::ImplicitShape& shape : part.shapes) reach = std::max(reach, reachOf(shape));
  return reach;
}

}  // namespace

StatePublisher::StatePublisher(const assets::Scene& scene, const WireFrame& frame, const PublishRates& rates)
    : frame_(frame), rates_(rates) {
  for (const assets::Part& part : scene.parts) reach_.push_back(reachOf(scene, part));
  rates_.min = std::min(rates_.min, rates_.max);
  rates_.presence = std::min({rates_.presence, rates_.max, std::max(kSmoothEnough, 0.25 * rates_.max)});
}

void StatePublisher::reset() {
  next_ = 0;
  sent_.clear();
  parts_ = presence_ = {};
}

bool StatePublisher::Repeated::due(Micros now, double least) const {
  if (unchanged < 0) return true;
  const int doublings = std::clamp(unchanged - kQuickRepeats, 0, 16);
  return now - sentAt + kEarly >= std::min(period(least) << doublings, kSlowestRepeat);
}

void StatePublisher::Repeated::sent(Micros now, bool changed) {
  sentAt = now;
  unchanged = changed || unchanged < 0 ? 0 : unchanged + 1;
}

const StatePublisher::Sent* StatePublisher::lastOf(const PartState& state) const {
  for (const Sent& sent : sent_)
    if (sent.state.part == state.part && sent.state.epoch == state.epoch) return &sent;
  return nullptr;
}

/// An upper bound of the displacement of the part's points between two poses, m.
double StatePublisher::distance(const Pose& a, const Pose& b, PartId part) const {
  ASSERT(part < reach_.size());
  return glm::length(a.position - b.position) + reach_[part] * angleBetween(a.orientation, b.orientation);
}

bool StatePublisher::partDue(const OfferedPart& part, Micros now, Micros time) const {
  const Sent* last = lastOf(part.state);
  if (last == nullptr || part.coHeld) return true;
  const bool rests = isStill(part.state.twist);
  if (rests != isStill(last->state.twist)) return true;
  const Pose &pose = part.state.worldFromPart, &lastPose = last->state.worldFromPart;
  if (rests) return pose.position != lastPose.position || pose.orientation != lastPose.orientation;
  if (rates_.deadband <= 0.0 || now - parts_.sentAt + kEarly >= period(rates_.min)) return true;
  const Pose extrapolated = integrate(lastPose, last->state.twist, toSeconds(time - last->time));
  const double wrong = distance(pose, extrapolated, part.state.part),
               displacement = distance(pose, lastPose, part.state.part);
  return wrong > kErrorFloor * frame_.halfExtent + rates_.deadband * displacement;
}

bool StatePublisher::partsDue(Micros now, Micros time, std::span<const OfferedPart> parts) const {
  return std::any_of(parts.begin(), parts.end(),
                     [&](const OfferedPart& part) { return partDue(part, now, time); });
}

bool StatePublisher::moved(const Pose& from, const Pose& to) const {
  return glm::length(to.position - from.position) > kPresenceMoved * frame_.halfExtent ||
         angleBetween(to.orientation, from.orientation) > kPresenceTurned;
}

bool StatePublisher::presenceChanged(const Presence& presence) const {
  const Presence& last = lastPresence_;
  const double force = glm::length(presence.force - last.force);
  const std::optional<Pose>&now = presence.worldFromSecondTool, &before = last.worldFromSecondTool;
  if (now.has_value() != before.has_value() || (now && moved(*before, *now))) return true;
  return presence.touched != last.touched || moved(last.worldFromTool, presence.worldFromTool) ||
         moved(last.worldFromCamera, presence.worldFromCamera) ||
         force > kPresenceForce + rates_.deadband * glm::length(last.force);
}

bool StatePublisher::due(Micros now, Micros time, std::span<const OfferedPart> parts,
                         const Presence& presence, bool& newPresence) {
  if (!mayBeDue(now)) return false;
  ASSERT(parts.size() <= kMaxStateParts);
  const bool partsNew =
      partsDue(now, time, parts);  // false: there are no parts, or receivers extrapolate them well
  const bool partsGo = partsNew || (!parts.empty() && parts_.due(now, rates_.min));
  const bool presenceNew =
      presenceChanged(presence) && now - presence_.sentAt + kEarly >= period(rates_.presence);
  newPresence = presenceNew || presence_.due(now, std::min(rates_.min, rates_.presence));
  if (!partsGo && !newPresence) return false;

  next_ = std::max(next_ + period(rates_.max), now - kMillisecond);
  if (!parts.empty()) parts_.sent(now, partsNew);  // every update carries all parts
  sent_.clear();
  for (const OfferedPart& part : parts) sent_.push_back({part.state, time});
  if (newPresence) {
    presence_.sent(now, presenceNew);
    lastPresence_ = presence;
  }
  return true;
}

}  // namespace tandem::client
