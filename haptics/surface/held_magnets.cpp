#include "haptics/surface/held_magnets.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <glm/geometric.hpp>
#include <glm/gtx/norm.hpp>

#include "haptics/base/tick_types.h"
#include "haptics/geometry/query_work.h"

namespace tandem::haptics {
namespace {

constexpr double kBeyond = 2.0;      // of a magnet's reach, within which its nearest place is sought
constexpr int kBalls = 48;           // that a search reads in a tick
constexpr int kLeaves = 8;           // the same, whose samples it reads
constexpr int kTries = 2;            // the same, from which it looks for a nearer pair
constexpr int kWork = 250;           // nodes of trees a tick; what a query takes more is saved later
constexpr int kRounds = 4;           // of going from one part to the other and back
constexpr double kGain = 1e-3;       // of the distance, by which a pair must be nearer to be sought
constexpr double kSettled = 1e-6;    // of the distance: less is no gain
constexpr double kRounding = 1e-12;  // of the parts' size and place
constexpr double kHeld = 1.0;        // of 1 / (T^2 W)

/// The pull of a surface as a spring of stiffness k(d), held to `most`.
class PullLaw {
 public:
  PullLaw(const assets::Surface& surface, double most)
      : distance_(surface.magneticDistance),
        soft_(4.0 * surface.magneticForce / distance_),
        most_(most),
        kink_(soft_ > most ? distance_ * (1.0 - most / soft_) : 0.0) {}

  /// N/m, force over distance.
  double stiffness(double d) const {
    return d < distance_ ? std::min(most_, soft_ * (1.0 - d / distance_)) : 0.0;
  }
  /// J, that it takes to pull the part out of reach.
  double depth(double d) const {
    if (!(d < distance_)) return 0.0;
    const double from = std::max(d, kink_);
    const double law = soft_ * (0.5 * (distance_ * distance_ - from * from) -
                                (distance_ * distance_ * distance_ - from * from * from) / (3.0 * distance_));
    return law + 0.5 * most_ * (d < kink_ ? kink_ * kink_ - d * d : 0.0);
  }

 private:
  double distance_, soft_, most_;
  double kink_;  // m, below which it is held
};

/// Transforms points of one part into the frame of the distance field of another part.
struct InField {
  Pose fieldFromPart;
  glm::dvec3 origin;
  glm::vec3 operator()(const glm::vec3& p) const {
    return glm::vec3(transformPoint(fieldFromPart, glm::dvec3(p)) - origin);
  }
};

/// An upper bound of the mobility of a part at a point, in any direction, 1/kg; 0 if it does not move here.
double mobilityAt(std::span<const MagneticBody> bodies, PartId part, const glm::dvec3& point) {
  for (const MagneticBody& body : bodies) {
    if (body.part != part) continue;
    double norm = 0.0;
    for (int i = 0; i < 3; ++i) norm += glm::length2(body.mobility[i]);
    return 1.0 / body.mass + glm::length2(point - body.centre) * std::sqrt(norm);
  }
  return 0.0;
}

const Magnet& magnetOf(const ContactWorld& world, PartId part, std::size_t magnet) {
  return (*world.surfaces()->parts[part].magnets)[magnet];
}

}  // namespace

bool HeldMagnets::Near::before(const Near& other) const {
  return std::tie(gap, part, magnet) < std::tie(other.gap, other.part, other.magnet);
}

const HeldMagnets::Track* HeldMagnets::trackOf(PartId part, std::size_t magnet) const {
  const auto found = std::find_if(tracks_.begin(), tracks_.end(), [&](const Track& track) {
    return track.part == part && track.magnet == magnet;
  });
  return found != tracks_.end() ? &*found : nullptr;
}

/// What pulls goes on to pull. Of the others those that may be nearest are looked at, and those that turn out
/// to be far make way.
double HeldMagnets::rank(const Track* track, double gap, double distance) {
  if (track == nullptr || !(track->known || track->searched)) return gap;
  if (!track->known) return kBeyond * distance;
  return track->distance < distance ? -1.0 : track->distance;
}

HeldMagnets::NearList HeldMagnets::nearest(const ContactWorld& world, PartId held,
                                           std::uint32_t& flags) const {
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
    for (std::size_t i = 0; i < magnets->size(); ++i) {
      const assets::Surface& surface = world.scene().surfaces[(*magnets)[i].surface];
      const assets::Bounds& box = (*magnets)[i].tree->bounds();
      const glm::dvec3 there = transformPoint(inverse(world.pose(part)), middle);
      const double gap = glm::distance(there, glm::clamp(there, box.min, box.max)) - ball.radius;
      if (gap > kBeyond * surface.magneticDistance) continue;
      const Near near{rank(trackOf(part, i), std::max(0.0, gap), surface.magneticDistance), part, i};
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
        magnet_(magnetOf(world, track.part, track.magnet)),
        rounding_(kRounding *
                  (world.collider(held).radius + world.collider(track.part).radius +
                   glm::length(world.pose(held).position) + glm::length(world.pose(track.part).position))),
        reach_(most()) {
    if (!track.known) return;
    onHeld_ = transformPoint(world.pose(held), track.onHeld);
    onMagnet_ = transformPoint(world.pose(track.part), track.onMagnet);
    reach_ = glm::distance(onHeld_, onMagnet_);
  }

  /// m, world, from the magnet's point of the last tick to the part's, as they stand now.
  glm::dvec3 between() const { return onHeld_ - onMagnet_; }
  const glm::dvec3& onHeld() const { return onHeld_; }
  const glm::dvec3& onMagnet() const { return onMagnet_; }

  void run() {
    if (track_.known && !isThere()) {
      track_.known = false;
      reach_ = most();
    }
    track_.work = std::min(kWork, track_.work + kWork);
    if (track_.known) settle(onMagnet_);
    leaves_ = kLeaves;
    tries_ = kTries;
    for (int i = 0; i < kBalls && leaves_ > 0 && tries_ > 0 && hasWork(); ++i) lookAtNext();
    track_.work -= spent();
    if (!track_.known) return;
    track_.distance = reach_;
    track_.onHeld = transformPoint(inverse(world_.pose(held_)), onHeld_);
    track_.onMagnet = transformPoint(inverse(world_.pose(track_.part)), onMagnet_);
  }

 private:
  /// m, as far as a nearest place is sought.
  double most() const { return kBeyond * world_.scene().surfaces[magnet_.surface].magneticDistance; }

  /// Nodes of trees that queries have visited in this tick. Where many triangles are about as near, as in the
  /// middle of a sphere, a query visits thousands.
  int spent() const { return static_cast<int>(queryWork.nodes - before_); }
  bool hasWork() const { return spent() < track_.work; }

  /// Whether the known points are still on the faces: meshes may be exchanged, and sections cut them away.
  bool isThere() const {
    glm::dvec3 found;
    return nearestOfHeld(onHeld_, rounding_, found) && nearestOfMagnet(onMagnet_, rounding_, found);
  }

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

  /// Goes from a point of the magnet to the nearest one of the part and back, as long as they come nearer
  /// than what is known.
  void settle(glm::dvec3 onMagnet) {
    for (int i = 0; i < kRounds && hasWork(); ++i) {
      glm::dvec3 onHeld, back;
      if (!nearestOfHeld(onMagnet, reach_ + rounding_, onHeld)) return;
      const double before = glm::distance(onHeld, onMagnet);
      if (!nearestOfMagnet(onHeld, before + rounding_, back)) return;
      track_.known = true;
      reach_ = glm::distance(onHeld, back);
      onHeld_ = onHeld;
      onMagnet_ = back;
      if (!(reach_ < before * (1.0 - kSettled))) return;
      onMagnet = back;
    }
  }

  /// Reads one ball of samples in the field of the other part: goes on to its halves where a pair of points
  /// in it may be nearer.
  void lookAtNext() {
    if (track_.balls.empty()) {
      track_.searched = track_.searched || track_.throughHeld;
      track_.throughHeld = !track_.throughHeld;
      track_.balls.push_back(0);
    }
    const PartId sampled = track_.throughHeld ? held_ : track_.part,
                 other = track_.throughHeld ? track_.part : held_;
    const ContactSamples& samples = world_.model(sampled)->samples;
    const DistanceField& field = world_.model(other)->field;
    const InField motion{inverse(world_.pose(other)) * world_.pose(sampled), field.origin()};
    const std::uint32_t n = track_.balls.back();
    track_.balls.pop_back();
    if (n >= samples.nodes().size()) return;  // the mesh has been exchanged, or has no samples
    const ContactSamples::Node& ball = samples.nodes()[n];
    const DistanceField::Reading read = field.read(motion({ball.centre[0], ball.centre[1], ball.centre[2]}));
    if (atLeast(read) - static_cast<double>(ball.radius) > reach_) return;
    if (ball.second == 0) {
      tryLeaf(sampled, samples, field, motion, ball);
    } else if (track_.balls.size() + 2 <= track_.balls.capacity()) {
      track_.balls.push_back(ball.second);
      track_.balls.push_back(n + 1);
    }
  }

  /// m, to the surface.
  static double atLeast(const DistanceField::Reading& read) {
    return std::max(0.0, static_cast<double>(std::abs(read.distance) - read.error));
  }

  /// Looks for a nearer pair from that sample of a leaf which may be nearest.
  void tryLeaf(PartId sampled, const ContactSamples& samples, const DistanceField& field,
               const InField& motion, const ContactSamples::Node& leaf) {
    --leaves_;
    double least = (1.0 - kGain) * reach_;
    std::uint32_t best = leaf.end;
    for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
      const glm::vec4& sample = samples.points()[i];
      const double distance = atLeast(field.read(motion(glm::vec3(sample)))) -
                              static_cast<double>(ContactSamples::touchAbout(sample));
      if (distance < least) {
        least = distance;
        best = i;
      }
    }
    if (best == leaf.end) return;
    --tries_;
    const glm::dvec3 from =
        transformPoint(world_.pose(sampled), glm::dvec3(glm::vec3(samples.points()[best])));
    const double about = static_cast<double>(ContactSamples::touchAbout(samples.points()[best]));
    glm::dvec3 onHeld = from, onMagnet;
    if (!track_.throughHeld && !nearestOfHeld(from, reach_ + about, onHeld)) return;
    if (nearestOfMagnet(onHeld, reach_ + about, onMagnet)) settle(onMagnet);
  }

  const ContactWorld& world_;
  const PartId held_;
  Track& track_;
  const Magnet& magnet_;
  const double rounding_;  // m
  double reach_;           // m, of the pair, once it is known; only what is nearer is sought
  glm::dvec3 onHeld_{0.0}, onMagnet_{0.0};
  int leaves_ = 0, tries_ = 0;
  const std::uint64_t before_ = queryWork.nodes;
};

void HeldMagnets::keepOnly(const NearList& near) {
  const auto end = std::remove_if(tracks_.begin(), tracks_.end(), [&](const Track& track) {
    return std::none_of(near.begin(), near.end(), [&](const Near& entry) {
      return track.part == entry.part && track.magnet == entry.magnet;
    });
  });
  tracks_.shrink(static_cast<std::size_t>(end - tracks_.begin()));
  for (const Near& entry : near) {
    if (trackOf(entry.part, entry.magnet) != nullptr) continue;
    Track& track = tracks_.push_back({});
    track.part = entry.part;
    track.magnet = entry.magnet;
  }
}

MagnetPull HeldMagnets::follow(Track& track, const ContactWorld& world, std::span<const MagneticBody> bodies,
                               const Settings& settings) {
  Search search(world, held_, track);
  const double work = glm::dot(track.force, search.between() - track.between);
  search.run();
  track.share = std::min(1.0, track.share + settings.fade);
  track.force = glm::dvec3(0.0);
  const assets::Surface& surface = world.scene().surfaces[magnetOf(world, track.part, track.magnet).surface];
  if (!track.known || !(track.distance < surface.magneticDistance)) {
    track.account = track.potential = 0.0;
    track.between = search.between();
    return {};
  }
  const double share = track.share * settings.share;
  const double moves =
      mobilityAt(bodies, held_, search.onHeld()) + mobilityAt(bodies, track.part, search.onMagnet());
  const PullLaw law(surface, kHeld / (settings.dt * settings.dt * moves));
  const double potential = -share * law.depth(track.distance);
  track.account = std::max(0.0, track.account + work + potential - track.potential);
  track.potential = potential;
  track.between = search.between();
  track.force = -share * law.stiffness(track.distance) * track.between;
  const glm::dvec3 closing = velocityAt(world.pose(held_), world.twist(held_), search.onHeld()) -
                             velocityAt(world.pose(track.part), world.twist(track.part), search.onMagnet());
  const double square = settings.dt * glm::length2(closing);
  if (track.account > 0.0 && square > 0.0)
    track.force -= std::min(track.account / square, 0.5 * kHeld / (settings.dt * moves)) * closing;
  return {track.part, search.onHeld(), search.onMagnet(), track.force};
}

const HeldMagnets::Pulls& HeldMagnets::find(const ContactWorld& world, PartId held,
                                            std::span<const MagneticBody> bodies, const Settings& settings,
                                            std::uint32_t& flags) {
  if (held != held_) forget();
  held_ = held;
  keepOnly(nearest(world, held, flags));
  pulls_.clear();
  for (Track& track : tracks_) {
    const MagnetPull pull = follow(track, world, bodies, settings);
    if (pull.force != glm::dvec3(0.0)) pulls_.push_back(pull);
  }
  return pulls_;
}

}  // namespace tandem::haptics
