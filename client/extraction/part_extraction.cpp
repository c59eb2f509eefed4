#include "client/extraction/part_extraction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "assets/base/assert.h"
#include "assets/mesh/cylinders.h"
#include "assets/scene/control.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/scene/contact_world.h"

namespace tandem::client {
namespace {

using haptics::Collider;
using haptics::ContactWorld;

constexpr double kSamePlace = 0.02;   // of the size: places that are nearer are one
constexpr double kSameAxis = 0.9994;  // cosine of two degrees
constexpr double kSlight = 0.01;      // of maxForce, below which a way takes no force
constexpr std::size_t kMaxBores = 6;  // cylinders of a mesh whose axes are tried

/// The rotation vector that leads from one orientation to the other, rad.
glm::dvec3 rotationBetween(const glm::dquat& from, const glm::dquat& to) {
  return rotationVector(glm::normalize(to * glm::conjugate(from)));
}

/// How far a box of these corners reaches along an axis.
struct Span {
  double least = std::numeric_limits<double>::max(), most = -least;
};
Span spanOf(const std::array<glm::dvec3, 8>& corners, const glm::dvec3& axis) {
  Span span;
  for (const glm::dvec3& corner : corners) {
    span.least = std::min(span.least, glm::dot(corner, axis));
    span.most = std::max(span.most, glm::dot(corner, axis));
  }
  return span;
}

class Search {
 public:
  Search(const haptics::ContactScene& contact, const ExtractionOptions& options,
         const std::vector<bool>& away, PartId part)
      : contact_(contact), options_(options), part_(part), world_(contact) {
    ASSERT(part < contact.scene().parts.size() && world_.collider(part).tree != nullptr);
    size_ = 2.0 * world_.collider(part).radius;
    const assets::Bounds& bounds = contact.scene().bounds;
    // A part that has not got out after twice the way across the scene goes round in circles.
    pull_ = {part, size_, options.maxForce, 2.0 * (size_ + glm::length(bounds.max - bounds.min)), {}, {}};
    pull_.isClear = [this](const Pose& worldFromPart, const glm::dvec3& axis) {
      return isClear(worldFromPart, axis);
    };
    for (std::size_t i = 0; i < away.size(); ++i) {
      const auto other = static_cast<PartId>(i);
      if (away[i])
        pull_.away.push_back(other);
      else if (other != part && world_.collider(other).tree != nullptr && world_.mayCollide(part, other))
        others_.push_back(cornersOf(other, world_.pose(other)));
    }
    findAxes();
  }
  Search(const Search&) = delete;
  Search& operator=(const Search&) = delete;

  Extraction run();

 private:
  std::array<glm::dvec3, 8> cornersOf(PartId part, const Pose& worldFromPart) const;
  void addAxis(const glm::dvec3& axis);
  void findAxes();
  /// Whether nothing is in the way of the part any more, if it goes on along this axis.
  bool isClear(const Pose& worldFromPart, const glm::dvec3& axis) const;
  bool isKnown(const Pose& worldFromPart) const;
  /// Less work first, where there is any to speak of; then shorter.
  bool isEasier(const Place& a, const Place& b) const;
  void block(const std::vector<PartId>& pressed);

  const haptics::ContactScene& contact_;
  const ExtractionOptions& options_;
  const PartId part_;
  ContactWorld world_;
  double size_ = 0.0;  // m, of the part
  PullSettings pull_;
  std::vector<std::array<glm::dvec3, 8>> others_;  // m, world: boxes of the parts that are in the way
  std::vector<glm::dvec3> axes_;                   // unit, world
  std::vector<Pose> known_;                        // places that were searched from
  Extraction found_;
};

std::array<glm::dvec3, 8> Search::cornersOf(PartId part, const Pose& worldFromPart) const {
  const assets::Mesh& mesh = world_.collider(part).tree->mesh();
  std::array<glm::dvec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3& x = (i & 1) != 0 ? mesh.bounds.max : mesh.bounds.min;
    const glm::dvec3& y = (i & 2) != 0 ? mesh.bounds.max : mesh.bounds.min;
    const glm::dvec3& z = (i & 4) != 0 ? mesh.bounds.max : mesh.bounds.min;
    corners[i] = transformPoint(worldFromPart, {x.x, y.y, z.z});
  }
  return corners;
}

/// Adds an axis and its opposite, unless they are there.
void Search::addAxis(const glm::dvec3& axis) {
  const double length = glm::length(axis);
  if (!(length > 0.0)) return;
  for (const double sign : {1.0, -1.0}) {
    const glm::dvec3 unit = axis * (sign / length);
    const bool known = std::any_of(axes_.begin(), axes_.end(), [&](const glm::dvec3& other) {
      return glm::dot(unit, other) > kSameAxis;
    });
    if (!known) axes_.push_back(unit);
  }
}

/// The world's axes, the part's own, and those of the bores and shafts of the part.
void Search::findAxes() {
  const Pose& worldFromPart = world_.pose(part_);
  for (int i = 0; i < 3; ++i) {
    glm::dvec3 axis(0.0);
    axis[i] = 1.0;
    addAxis(axis);
  }
  std::vector<assets::Cylinder> cylinders = assets::findCylinders(world_.collider(part_).tree->mesh());
  std::stable_sort(cylinders.begin(), cylinders.end(), [](const auto& a, const auto& b) {
    return a.radius * a.halfLength > b.radius * b.halfLength;
  });
  if (cylinders.size() > kMaxBores) cylinders.resize(kMaxBores);
  for (const assets::Cylinder& cylinder : cylinders) addAxis(transformVector(worldFromPart, cylinder.axis));
  for (int i = 0; i < 3; ++i) {
    glm::dvec3 axis(0.0);
    axis[i] = 1.0;
    addAxis(transformVector(worldFromPart, axis));
  }
}

bool Search::isClear(const Pose& worldFromPart, const glm::dvec3& axis) const {
  const glm::dvec3 aside = std::abs(axis.x) < 0.9 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 u = glm::normalize(glm::cross(axis, aside)), v = glm::cross(axis, u);
  const auto own = cornersOf(part_, worldFromPart);
  const Span along = spanOf(own, axis), alongU = spanOf(own, u), alongV = spanOf(own, v);
  const double clear = PartExtractor::kClearOf * size_;
  const double apart = PartExtractor::kApart * size_;
  const auto isBeside = [&](const Span& a, const Span& b) {
    return a.most + apart < b.least || b.most + apart < a.least;
  };
  return std::none_of(others_.begin(), others_.end(), [&](const auto& other) {
    if (isBeside(alongU, spanOf(other, u)) || isBeside(alongV, spanOf(other, v))) return false;
    return along.least < spanOf(other, axis).most + clear;
  });
}

bool Search::isEasier(const Place& a, const Place& b) const {
  const auto workOf = [&](const Place& place) {
    return place.force > kSlight * options_.maxForce ? place.work : 0.0;
  };
  if (workOf(a) != workOf(b)) return workOf(a) < workOf(b);
  return a.travelled < b.travelled;
}

bool Search::isKnown(const Pose& worldFromPart) const {
  const glm::dvec3& centre = world_.collider(part_).centre;
  return std::any_of(known_.begin(), known_.end(), [&](const Pose& other) {
    return glm::length(transformPoint(worldFromPart, centre) - transformPoint(other, centre)) +
               0.5 * size_ * glm::length(rotationBetween(worldFromPart.orientation, other.orientation)) <
           kSamePlace * size_;
  });
}

void Search::block(const std::vector<PartId>& pressed) {
  for (const PartId other : pressed)
    if (std::find(found_.blockedBy.begin(), found_.blockedBy.end(), other) == found_.blockedBy.end())
      found_.blockedBy.push_back(other);
}

Extraction Search::run() {
  found_.part = part_;
  for (const glm::dvec3& axis : axes_) {
    if (!isClear(world_.pose(part_), axis)) continue;
    found_.free = true;
    found_.way.push_back({axis, 0.0});
    return std::move(found_);
  }
  std::vector<Place> open{Place{world_.pose(part_), {}, {world_.pose(part_)}}};
  known_.push_back(world_.pose(part_));
  Place furthest = open.front();
  int pulls = 0;
  bool stopped = false;
  while (!open.empty() && pulls < options_.maxPulls && !stopped) {
    const auto next = std::max_element(open.begin(), open.end(), [](const Place& a, const Place& b) {
      return a.travelled / static_cast<double>(a.way.size() + 1) <
             b.travelled / static_cast<double>(b.way.size() + 1);
    });
    const Place from = std::move(*next);
    open.erase(next);
    const Place* best = nullptr;
    std::vector<PullEnd> ends;
    ends.reserve(axes_.size());
    for (const glm::dvec3& axis : axes_) {
      // Straight back is where it came from.
      if (!from.way.empty() && glm::dot(axis, from.way.back().axis) < -kSameAxis) continue;
      stopped = options_.goesOn && !options_.goesOn(static_cast<double>(pulls) / options_.maxPulls);
      if (stopped) break;
      ++pulls;
      ends.push_back(pullStraight(contact_, pull_, from, axis));
      const PullEnd& end = ends.back();
      if (end.free && (best == nullptr || isEasier(end.place, *best))) best = &end.place;
      if (!end.free) block(end.pressed);
    }
    if (best != nullptr) {
      found_.free = true;
      found_.blockedBy.clear();
      furthest = *best;
      break;
    }
    for (PullEnd& end : ends) {
      if (isKnown(end.place.worldFromPart)) continue;
      known_.push_back(end.place.worldFromPart);
      if (end.place.travelled > furthest.travelled) furthest = end.place;
      open.push_back(std::move(end.place));
    }
  }
  found_.way = std::move(furthest.way);
  found_.path = std::move(furthest.path);
  found_.force = furthest.force;
  found_.work = furthest.work;
  std::sort(found_.blockedBy.begin(), found_.blockedBy.end());
  return std::move(found_);
}

}  // namespace

void lightenParts(assets::Scene& scene, const ExtractionOptions& options) {
  constexpr double kShare = 1e-3, kTick = 1e-3;  // of maxForce; s
  for (assets::Part& part : scene.parts) {
    if (!part.movable || part.mesh >= scene.meshes.size()) continue;
    const assets::Bounds& bounds = scene.meshes[part.mesh].bounds;
    const double size = glm::length(bounds.max - bounds.min);
    if (!(size > 0.0)) continue;
    assets::MassProperties& own = part.massProperties;
    if (!(own.mass > 0.0)) own = {1.0, 0.5 * (bounds.min + bounds.max), glm::dmat3(0.1 * size * size)};
    const double acceleration = kPullSpeed * size / (kTick * kTick * kPullRamp);
    const double share = kShare * options.maxForce / (acceleration * own.mass);
    own.mass *= share;
    own.inertia *= share;
  }
}

PartExtractor::PartExtractor(const haptics::ContactScene& contact, const ExtractionOptions& options)
    : contact_(contact), options_(options), away_(contact.scene().parts.size(), false) {
  ASSERT(options.maxForce > 0.0 && options.maxPulls > 0);
}

bool PartExtractor::canTake(PartId part) const {
  const assets::Scene& scene = contact_.scene();
  const Collider& collider = contact_.data().colliders[part];
  return scene.parts[part].movable && collider.tree != nullptr && collider.model != nullptr &&
         assets::controlOf(scene, part) == nullptr;
}

Extraction PartExtractor::extract(PartId part) const {
  ASSERT(canTake(part) && !away_[part]);
  return Search(contact_, options_, away_, part).run();
}

}  // namespace tandem::client
