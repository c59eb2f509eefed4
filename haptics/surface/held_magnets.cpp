#include "haptics/surface/held_magnets.h"

#include <algorithm>
#include <tuple>

#include <glm/geometric.hpp>

#include "haptics/base/tick_types.h"

namespace tandem::haptics {
namespace {

constexpr double kBeyond = 2.0;       // of a magnet's reach, within which its nearest place is sought
constexpr int kBalls = 4;             // that a search looks at in a tick
constexpr int kRounds = 4;            // of going from one part to the other and back
constexpr double kSettled = 1e-6;     // of the distance: less is no gain
constexpr double kRounding = 1e-12;   // of the parts' size
constexpr double kFine = 1.0 / 16.0;  // of the distance: balls of that size are looked at as a whole

}  // namespace

bool HeldMagnets::Near::before(const Near& other) const {
  return std::tie(gap, part, magnet) < std::tie(other.gap, other.part, other.magnet);
}

HeldMagnets::NearList HeldMagnets::nearest(const ContactWorld& world, PartId held, std::uint32_t& flags) {
  NearList list;
  const Collider& ball = world.collider(held);
  const SurfaceScene& surfaces = *world.surfaces();
  const glm::dvec3 middle = transformPoint(world.pose(held), ball.centre),
                   grow(ball.radius + kBeyond * surfaces.magneticReach);
  world.forEachNear({middle - grow, middle + grow}, [&](PartId part) {
    const std::vector<Magnet>* const magnets = surfaces.parts[part].magnets;
    if (magnets == nullptr || part == held || world.hidden(part) || world.model(part) == nullptr ||
        !world.mayCollide(held, part))
      return;
    const Collider& other = world.collider(part);
    const double apart = glm::distance(middle, transformPoint(world.pose(part), other.centre));
    const double gap = std::max(0.0, apart - ball.radius - other.radius);
    for (std::size_t i = 0; i < magnets->size(); ++i) {
      const assets::Surface& surface = world.scene().surfaces[(*magnets)[i].surface];
      if (gap > kBeyond * surface.magneticDistance) continue;
      const Near near{gap, part, i};
      if (list.full()) {
        flags |= kFlagOverflow;
        if (!near.before(list.back())) continue;
        list.pop_back();
      }
      list.insert(std::upper_bound(list.begin(), list.end(), near,
                                   [](const Near& a, const Near& b) { return a.before(b); }),
                  near);
    }
  });
  return list;
}

/// The nearest pair of points of one magnet in one tick.
class HeldMagnets::Search {
 public:
  Search(const ContactWorld& world, PartId held, Track& track)
      : world_(world),
        held_(held),
        track_(track),
        magnet_((*world.surfaces()->parts[track.part].magnets)[track.magnet]),
        rounding_(kRounding * (world.collider(held).radius + world.collider(track.part).radius)),
        reach_(most()) {
    if (!track.known) return;
    onHeld_ = transformPoint(world.pose(held), track.onHeld);
    onMagnet_ = transformPoint(world.pose(track.part), track.onMagnet);
    reach_ = glm::distance(onHeld_, onMagnet_);
  }

  void run() {
    // What is not there any more has been exchanged, or sections cut it away.
    if (track_.known && !settle(onMagnet_)) {
      track_.known = false;
      reach_ = most();
    }
    for (int i = 0; i < kBalls; ++i) lookAtNext();
    if (!track_.known) return;
    track_.onHeld = transformPoint(inverse(world_.pose(held_)), onHeld_);
    track_.onMagnet = transformPoint(inverse(world_.pose(track_.part)), onMagnet_);
  }

  /// The spring between the two points, if they are within the reach of the magnet.
  MagnetPull pull() const {
    const assets::Surface& surface = world_.scene().surfaces[magnet_.surface];
    const double x = reach_ / surface.magneticDistance;
    if (!track_.known || !(x < 1.0)) return {};
    return {track_.part, onHeld_, onMagnet_,
            (1.0 - x) * 4.0 * surface.magneticForce / surface.magneticDistance};
  }

 private:
  bool nearestOfHeld(const glm::dvec3& p, double reach, glm::dvec3& found) const {
    SurfacePoint at;
    if (!world_.nearest(held_, p, reach, at)) return false;
    found = at.point;
    return true;
  }
  bool nearestOfMagnet(const glm::dvec3& p, double reach, glm::dvec3& found) const {
    const Pose& pose = world_.pose(track_.part);
    const Sections cut = world_.sectionsOf(track_.part);
    MeshPoint at;
    if (!magnet_.tree->closestPoint(transformPoint(inverse(pose), p), reach, at,
                                    cut.empty() ? nullptr : &cut))
      return false;
    found = transformPoint(pose, at.point);
    return true;
  }

  /// m, as far as a nearest place is sought.
  double most() const { return kBeyond * world_.scene().surfaces[magnet_.surface].magneticDistance; }

  /// Goes from a point of the magnet to the nearest one of the part and back, as long as they come nearer
  /// than what is known. False if the point is further than that.
  bool settle(glm::dvec3 onMagnet) {
    for (int i = 0; i < kRounds; ++i) {
      glm::dvec3 onHeld, back;
      if (!nearestOfHeld(onMagnet, reach_ + rounding_, onHeld)) return i > 0;
      const double before = glm::distance(onHeld, onMagnet);
      if (!nearestOfMagnet(onHeld, before + rounding_, back)) return i > 0;
      track_.known = true;
      reach_ = glm::distance(onHeld, back);
      onHeld_ = onHeld;
      onMagnet_ = back;
      if (!(reach_ < before * (1.0 - kSettled))) return true;
      onMagnet = back;
    }
    return true;
  }

  /// Looks at one ball of samples: goes on to its halves where a pair of points in it may be nearer.
  void lookAtNext() {
    if (track_.balls.empty()) {
      track_.throughHeld = !track_.throughHeld;
      track_.balls.push_back(0);
    }
    const PartId sampled = track_.throughHeld ? held_ : track_.part;
    const auto nodes = world_.model(sampled)->samples.nodes();
    const std::uint32_t n = track_.balls.back();
    track_.balls.pop_back();
    if (n >= nodes.size()) return;  // the mesh has been exchanged, or has no samples
    const ContactSamples::Node& ball = nodes[n];
    const auto radius = static_cast<double>(ball.radius);
    const glm::dvec3 centre =
        transformPoint(world_.pose(sampled), {ball.centre[0], ball.centre[1], ball.centre[2]});
    glm::dvec3 onOther;
    const double most = reach_ * (1.0 - kSettled) + radius;
    if (!(track_.throughHeld ? nearestOfMagnet(centre, most, onOther) : nearestOfHeld(centre, most, onOther)))
      return;
    if (ball.second == 0 || radius < kFine * reach_) {
      glm::dvec3 onMagnet = onOther;
      if (track_.throughHeld || nearestOfMagnet(onOther, 2.0 * most, onMagnet)) settle(onMagnet);
    } else if (track_.balls.size() + 2 <= track_.balls.capacity()) {
      track_.balls.push_back(ball.second);
      track_.balls.push_back(n + 1);
    }
  }

  const ContactWorld& world_;
  const PartId held_;
  Track& track_;
  const Magnet& magnet_;
  const double rounding_;  // m
  double reach_;           // m, of the pair, once it is known; only what is nearer is sought
  glm::dvec3 onHeld_{0.0}, onMagnet_{0.0};
};

HeldMagnets::Pulls HeldMagnets::find(const ContactWorld& world, PartId held, double fade,
                                     std::uint32_t& flags) {
  if (held != held_) forget();
  held_ = held;
  const NearList near = nearest(world, held, flags);
  const auto isOf = [](const Track& track, const Near& entry) {
    return track.part == entry.part && track.magnet == entry.magnet;
  };
  const auto end = std::remove_if(tracks_.begin(), tracks_.end(), [&](const Track& track) {
    return std::none_of(near.begin(), near.end(), [&](const Near& entry) { return isOf(track, entry); });
  });
  tracks_.shrink(static_cast<std::size_t>(end - tracks_.begin()));
  Pulls pulls;
  for (const Near& entry : near) {
    auto track = std::find_if(tracks_.begin(), tracks_.end(), [&](const Track& t) { return isOf(t, entry); });
    if (track == tracks_.end()) {
      tracks_.push_back({entry.part, entry.magnet});
      track = tracks_.end() - 1;
    }
    Search search(world, held, *track);
    search.run();
    track->share = std::min(1.0, track->share + fade);
    MagnetPull pull = search.pull();
    pull.stiffness *= track->share;
    if (pull.stiffness > 0.0) pulls.push_back(pull);
  }
  return pulls;
}

}  // namespace tandem::haptics
