#include "haptics/proxy/proxy.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/proxy/crease.h"
#include "haptics/proxy/proxy_planes.h"
#include "haptics/proxy/proxy_steps.h"
#include "haptics/proxy/surface_walk.h"
#include "haptics/scene/haptic_texture.h"

namespace tandem::haptics {
namespace {

constexpr int kMaxRounds = 24;
constexpr int kFewRounds = 8;          // after a goal that went over few triangles
constexpr double kRoundsAnEdge = 4.0;  // of the triangles' length that the goal went
constexpr double kRoundsLate = 0.5;    // more for each move that ended too early
constexpr double kFine = 0.25;         // of the depth, the length of triangles that a hand hardly tells apart
constexpr double kAtRest = 0.1;        // of the triangles' length: a hand that goes no further is at rest
constexpr int kLate = 8;               // moves in a row that ended too early, after which one takes its time
constexpr int kMaxFrictionRounds = 4;
constexpr double kConeError = 1e-3;  // of the friction ratio
// Overrelaxation of a step beyond the point of its line nearest to the goal. It is below 2, so a step ends
// nearer to the goal than it began even if the surface is not curved as expected.
constexpr double kMaxStretch = 1.5;
// Shortest step that is cut where the ground turns, as a fraction of the ball's radius. Along a tangent of
// that length the ball rises by 0.005 of its radius.
constexpr double kLeastStep = 0.1;
constexpr int kEdgeRounds = 4;
constexpr int kMaxRises = 4;          // of a point, in one move
constexpr int kFreeRidges = 2;        // steep ridges that a point leaves by long steps, in one move
constexpr double kSteepRidge = 0.98;  // cosine of a direction to the face beside it
constexpr double kHighEnough = 0.9;   // of its margin
constexpr double kWellPast = 8.0;     // margins from an edge, at which the edge no longer holds the proxy
constexpr double kNearEnough = 1e-6;  // of the depth, which is also the relative force error

using Walks = std::array<SurfaceWalk, kMaxPlanes>;

bool isKnown(const Proxy& proxy, const SurfacePoint& at) {
  return std::any_of(proxy.planes.begin(), proxy.planes.end(), [&](const ProxyPlane& plane) {
    return plane.surface.part == at.part && plane.surface.triangle == at.triangle;
  });
}

/// Ends the walk of a point between its triangle and the one at which it arrives, if that rises towards it:
/// its sweep, which leaves half a margin, would miss a rise so slight, and the next step would lead back.
void stopAtRise(const ContactWorld& world, double radius, const Proxy& proxy, const ProxyPlane& plane,
                const glm::dvec3& displacement, SurfaceWalk& walk) {
  if (!(plane.margin > plane.skin) || !plane.surface.onFace || walk.sharp || walk.share < 1.0) return;
  if (isKnown(proxy, walk.arrival)) return;
  const Triangle face = world.triangle(walk.arrival.part, walk.arrival.triangle);
  SurfacePoint ahead = walk.arrival;
  ahead.point = face.a;
  takeFacePlane(face, proxy.position, ahead);
  const double rest = radius + plane.margin, fall = -glm::dot(ahead.normal, displacement);
  if (ahead.distance < rest - plane.skin || !(ahead.distance - fall < rest - plane.skin)) return;
  const double share = std::clamp((ahead.distance - rest) / fall, 0.0, 1.0);
  const glm::dvec3 end = proxy.position + share * displacement;
  const SurfacePoint there = world.surfaceAt(ahead.part, ahead.triangle, end);
  if (glm::length(end - there.point) > radius + 2.0 * plane.margin) return;
  walk.share = share;
  walk.rises = true;
}

/// Cuts a displacement short where the surface under one of the pressing contacts ends, and notes the
/// triangles at which the contacts that stay on it arrive. Returns the share that is left, 1 if all of it.
double keepToGround(const ContactWorld& world, double radius, const Proxy& proxy, glm::dvec3& displacement,
                    Walks& walks, bool& onCrease) {
  const double length = glm::length(displacement);
  double share = 1.0;
  for (std::size_t i = 0; i < proxy.planes.size(); ++i) {
    const ProxyPlane& plane = proxy.planes[i];
    if (!presses(plane)) continue;
    SurfaceWalk& walk = walks[i];
    walk = walkSurface(world, plane.surface, displacement, {plane.skin, plane.margin});
    stopAtRise(world, radius, proxy, plane, displacement, walk);
    // On a crease already: a point crosses it by a few margins, a ball by no more than it can roll.
    const double over = 3.0 * plane.margin / length;
    if (walk.sharp || (walk.share < over && !walk.rises)) {
      onCrease = true;
      const double leaves = lengthAcross(creaseUnder(world, plane.surface, plane.skin), displacement);
      walk.share = leaves > 0.0 ? (3.0 * plane.margin + 0.5 * radius) / leaves : 1.0;
    } else if (walk.share < 1.0 && !walk.rises) {
      walk.share += over;
    }
    // Features far smaller than the ball do not count as creases.
    share = std::min(share, std::max(walk.share, std::min(1.0, kLeastStep * radius / length)));
  }
  if (share >= 1.0) return 1.0;
  displacement *= share;
  return share;
}

/// Moves the pressing planes to the triangles that the walk has reached, once the proxy is there.
void arrive(const Walks& walks, Proxy& proxy) {
  for (std::size_t i = 0; i < proxy.planes.size(); ++i) {
    ProxyPlane& plane = proxy.planes[i];
    const SurfaceWalk& walk = walks[i];
    if (!presses(plane) || walk.sharp || walk.share < 1.0) continue;
    plane.arriving =
        walk.arrival.triangle != plane.surface.triangle || walk.arrival.part != plane.surface.part;
    plane.surface.part = walk.arrival.part;
    plane.surface.triangle = walk.arrival.triangle;
  }
}

/// Moves the contacts whose crease lies within that share of the displacement to the face behind it. A
/// contact that has not come to its crease keeps its plane: without it the next projection would lead back.
void passCrease(const Walks& walks, double share, Proxy& proxy) {
  for (std::size_t i = 0; i < proxy.planes.size(); ++i) {
    ProxyPlane& plane = proxy.planes[i];
    const std::uint32_t beyond = walks[i].beyond;
    if (!presses(plane) || beyond == kNoTriangle || walks[i].share > share) continue;
    plane.surface.triangle = beyond;
    plane.arriving = true;
  }
}

/// Adds the triangles that rise before a point which has stopped there.
void addRises(const Walks& walks, Proxy& proxy) {
  const std::size_t count = proxy.planes.size();
  for (std::size_t i = 0; i < count && !proxy.planes.full(); ++i) {
    const SurfaceWalk& walk = walks[i];
    if (!presses(proxy.planes[i]) || !walk.rises) continue;
    ProxyPlane rise;
    rise.surface.part = walk.arrival.part;
    rise.surface.triangle = walk.arrival.triangle;
    if (!isKnown(proxy, walk.arrival)) proxy.planes.push_back(rise);
  }
}

/// Friction reach of the pressing planes, m: the tangential lag that their depths hold inside the
/// friction cone, sum mu_i d_i (Harwin & Melder 2002).
double frictionReach(const ContactWorld& world, const Proxy& proxy, bool sliding) {
  double reach = 0.0;
  for (const ProxyPlane& plane : proxy.planes) {
    if (!presses(plane)) continue;
    const assets::Material& m = world.material(plane.surface.part, plane.surface.triangle);
    const double coefficient = sliding ? m.dynamicFriction : std::max(m.staticFriction, m.dynamicFriction);
    if (coefficient > 0.0) reach += plane.depth * coefficient * frictionScale(world, plane.surface);
  }
  return reach;
}

/// The share of the path from where a point has landed on its margin to the goal that lies before the
/// surface: on that share friction holds nothing.
double shareAboveSurface(const Proxy& proxy, double radius) {
  for (const ProxyPlane& plane : proxy.planes) {
    if (!isFelt(plane) || !(plane.margin > plane.skin)) continue;
    const double above = std::max(0.0, plane.surface.distance - radius - plane.skin);
    return above / (above + plane.depth);
  }
  return 0.0;
}

/// Distance at which the proxy counts as arrived: a fraction of the skin, or of the depth where facets, edges
/// and corners approximate a curve.
double closeEnough(const Proxy& proxy, double radius) {
  double depth = 0.0;
  bool curved = false;
  for (const ProxyPlane& plane : proxy.planes) {
    if (!presses(plane)) continue;
    depth += plane.multiplier;
    curved = curved || (radius > 0.0 && !plane.surface.onFace);
  }
  return std::max(0.01 * smallestSkin(proxy), curved ? kNearEnough * depth : 0.0);
}

/// m, the longest edge of the triangles that press; 0 if none does.
double longestEdge(const ContactWorld& world, const Proxy& proxy) {
  double square = 0.0;
  for (const ProxyPlane& plane : proxy.planes) {
    if (!presses(plane)) continue;
    const Triangle face = world.triangle(plane.surface.part, plane.surface.triangle);
    const glm::dvec3 ab = face.b - face.a, bc = face.c - face.b, ca = face.a - face.c;
    square = std::max({square, glm::dot(ab, ab), glm::dot(bc, bc), glm::dot(ca, ca)});
  }
  return std::sqrt(square);
}

/// How many rounds of descent a move to the goal may take. On a finely and roughly meshed surface a small
/// motion of the hand may let the proxy slide from one local minimum of the distance to one far away. A point
/// then covers the rest of that way in the next ticks. A ball that rolls between spikes far thinner than
/// itself needs all its rounds.
int roundsFor(const ContactWorld& world, const glm::dvec3& goal, double radius, const Proxy& proxy) {
  if (radius > 0.0) return kMaxRounds;
  const double edge = longestEdge(world, proxy);
  if (!proxy.goal || !(edge > 0.0) || proxy.late >= kLate) return kMaxRounds;
  const double edges = glm::distance(goal, *proxy.goal) / edge;
  if (edges < kAtRest || edge > kFine * glm::distance(goal, proxy.position)) return kMaxRounds;
  return static_cast<int>(
      std::clamp<double>(kRoundsAnEdge * edges, kFewRounds + kRoundsLate * proxy.late, kMaxRounds));
}

/// One move of the proxy towards a goal, in rounds of projection, surface walk and sweep.
class Descent {
 public:
  Descent(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy)
      : world_(world), goal_(goal), radius_(radius), proxy_(proxy), mayRoll_(radius > 0.0) {}

  /// Runs from planes that are up to date.
  void run() {
    for (int round = 0; round < proxy_.rounds; ++round) {
      if (descendOnce()) return;
    }
    stopShort();
  }

  /// run() for the first move of a tick: it starts with the stretch that the last move ended with.
  void runAhead() {
    const glm::dvec3 start = proxy_.position;
    stretch_ = proxy_.stretch;
    proxy_.stretch = 1.0;
    run();
    const double square = glm::dot(tangent_, tangent_);
    if (!curved_ || !(square > 0.0)) return;
    proxy_.stretch = std::clamp(glm::dot(proxy_.position - start, tangent_) / square, 1.0, kMaxStretch);
  }

 private:
  void stopShort() {
    ++proxy_.late;
    // The rounds are used up before the proxy has arrived. The planes that press on it must still be known,
    // or the force would drop to zero.
    const glm::dvec3 displacement = displacementToGoal(world_, goal_, radius_, proxy_);
    if (touches(proxy_)) return;
    advance(world_, displacement, radius_, proxy_);
    displacementToGoal(world_, goal_, radius_, proxy_);
  }

  /// Lifts a point that was stopped below its margin straight up to it: on the way along, so low, it would be
  /// stopped by every face that lies flush with the one under it.
  void rise() {
    const bool low = std::any_of(proxy_.planes.begin(), proxy_.planes.end(), [&](const ProxyPlane& plane) {
      return plane.margin > plane.skin && presses(plane) &&
             plane.surface.distance < radius_ + kHighEnough * plane.margin;
    });
    if (!low || ++rises_ > kMaxRises) return;
    const glm::dvec3 up = displacementToGoal(world_, proxy_.position, radius_, proxy_);
    if (advance(world_, up, radius_, proxy_)) refreshPlanes(world_, radius_, proxy_);
  }

  /// Cuts the step of a point short that stands on an edge or corner where no face leads on. This may be the
  /// rim of a crack: along the tangent the point would pass the other rim and come back from there in the
  /// same way. With short steps both rims stay known. Steep ridges are left by long steps first.
  bool creep(const ProxyPlane& edge, glm::dvec3& displacement) {
    if (!(edge.margin > edge.skin)) return false;
    SurfacePoint face = edge.surface;
    takeFacePlane(world_.triangle(face.part, face.triangle), proxy_.position, face);
    if (glm::dot(face.normal, edge.surface.normal) < kSteepRidge && ++ridges_ <= kFreeRidges) return false;
    const double across = lengthAcross(creaseUnder(world_, edge.surface, edge.skin), displacement);
    if (across <= edge.margin) return false;
    displacement *= edge.margin / across;
    return true;
  }

  /// One round; true if the proxy has arrived.
  bool descendOnce() {
    rise();
    glm::dvec3 displacement = displacementToGoal(world_, goal_, radius_, proxy_);
    if (glm::length(displacement) <= closeEnough(proxy_, radius_)) return !passEdge();
    if (!touches(proxy_))
      return advance(world_, displacement, radius_, proxy_) && !refreshPlanes(world_, radius_, proxy_);

    ProxyPlane* const alone = onlyPressing(proxy_);
    bool creeps = false;
    if (alone != nullptr && !alone->surface.onFace) {
      if (mayRoll_ && roll(*alone, displacement)) return false;
      if (radius_ == 0.0 && stepOffRidge(world_, proxy_.position, displacement, *alone)) {
        displacement = displacementToGoal(world_, goal_, radius_, proxy_);
      } else {
        creeps = creep(*alone, displacement);
      }
    }
    // The goal is under a crease whose other side is unknown, so the ball creeps off it.
    if (alone != nullptr && mayRoll_ && stillOnSameCrease(*alone)) displacement *= kMaxStretch;
    const bool first = stretch_ > 0.0, stretched = stretch_ > 1.0;
    if (first) {
      tangent_ = displacement;
      displacement *= stretch_;
      stretch_ = 0.0;
    }
    bool onCrease = false;
    Walks walks;
    const double share = keepToGround(world_, radius_, proxy_, displacement, walks, onCrease);
    const bool cut = share < 1.0;
    if (onCrease && alone != nullptr && mayRoll_ && roll(*alone, displacement)) return false;
    mayRoll_ = radius_ > 0.0;
    if (!advance(world_, displacement, radius_, proxy_)) return false;
    if (!cut) {
      arrive(walks, proxy_);
    } else if (alone != nullptr || radius_ == 0.0) {
      passCrease(walks, share, proxy_);
      addRises(walks, proxy_);
    }
    const bool changed = refreshPlanes(world_, radius_, proxy_);
    curved_ = curved_ || (first && !cut && proxy_.planes.empty());
    return !changed && !cut && !creeps && !stretched;
  }

  /// Tests whether the edge alone would let the proxy pass where a face presses beyond its edge. True if the
  /// proxy has passed.
  bool passEdge() {
    const auto isBeyond = [](const ProxyPlane& plane) { return plane.beyondEdge && presses(plane); };
    if (triedEdge_ || std::none_of(proxy_.planes.begin(), proxy_.planes.end(), isBeyond)) return false;
    triedEdge_ = true;
    const Proxy before = proxy_;
    refreshPlanes(world_, radius_, proxy_);
    const double far = kWellPast * largestMargin(proxy_);
    for (int i = 0; i < kEdgeRounds; ++i) {
      const glm::dvec3 displacement = displacementToGoal(world_, goal_, radius_, proxy_, Covered::asEdge);
      if (glm::length(displacement) <= far) break;
      if (advance(world_, displacement, radius_, proxy_)) refreshPlanes(world_, radius_, proxy_);
      if (glm::length(proxy_.position - before.position) > far) return true;
    }
    const int sweeps = proxy_.sweeps;
    proxy_ = before;
    proxy_.sweeps = sweeps;
    return false;
  }

  /// Whether the last step has left the ball on the same corner or edge; its arc is then the exact path.
  bool stillOnSameCrease(const ProxyPlane& plane) {
    const bool same =
        !plane.surface.onFace && !lastOnFace_ &&
        glm::length(plane.surface.point - lastPoint_) < 0.25 * glm::length(proxy_.position - lastPosition_);
    lastOnFace_ = plane.surface.onFace;
    lastPoint_ = plane.surface.point;
    lastPosition_ = proxy_.position;
    return same;
  }

  /// True if the round is over: the ball has rolled on, or has hit something that the next projection must
  /// include.
  bool roll(ProxyPlane& plane, const glm::dvec3& displacement) {
    const int sweeps = proxy_.sweeps;
    const glm::dvec3 from = proxy_.position;
    if (rollOverCrease(world_, goal_, radius_, displacement, plane, proxy_)) {
      // A roll that another plane stops at once is not repeated: the projection accounts for that plane, the
      // arc does not.
      mayRoll_ = glm::length(proxy_.position - from) > 2.0 * largestMargin(proxy_);
      return true;
    }
    mayRoll_ = false;
    return proxy_.sweeps != sweeps;
  }

  const ContactWorld& world_;
  const glm::dvec3 goal_;
  const double radius_;
  Proxy& proxy_;
  bool mayRoll_;
  int rises_ = 0, ridges_ = 0;
  bool triedEdge_ = false;
  bool lastOnFace_ = true;
  double stretch_ = 0.0;     // of the first tangent; 0 = none
  glm::dvec3 tangent_{0.0};  // m, the first one
  bool curved_ = false;      // the first tangent step has ended above the surface
  glm::dvec3 lastPoint_{0.0}, lastPosition_{0.0};
};

void descendAhead(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  Descent(world, goal, radius, proxy).runAhead();
}

void descend(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  Descent(world, goal, radius, proxy).run();
}

/// moveProxy() from planes that are up to date.
void moveOverGround(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  glm::dvec3 displacement = displacementToGoal(world, goal, radius, proxy);
  if (!touches(proxy)) {
    // Friction restarts at each landing.
    proxy.sliding = false;
    if (glm::length(displacement) <= 0.01 * smallestSkin(proxy)) return;
    if (advance(world, displacement, radius, proxy) && !refreshPlanes(world, radius, proxy)) return;
    displacement = displacementToGoal(world, goal, radius, proxy);
    const double above = shareAboveSurface(proxy, radius);
    if (above > 0.0 && frictionReach(world, proxy, true) > 0.0) {
      descend(world, glm::mix(proxy.position, goal, above), radius, proxy);
      displacement = displacementToGoal(world, goal, radius, proxy);
    }
  }
  const double stickReach = frictionReach(world, proxy, proxy.sliding);
  if (stickReach > 0.0 && glm::length(displacement) <= stickReach) {
    proxy.sliding = false;
    return;
  }
  for (int round = 0; round < kMaxFrictionRounds; ++round) {
    const double reach = frictionReach(world, proxy, true), lag = glm::length(displacement);
    if (!(reach > 0.0) || !(lag > 0.0)) {
      proxy.sliding = false;
      return round == 0 ? descendAhead(world, goal, radius, proxy) : descend(world, goal, radius, proxy);
    }
    // One move reaches the cone exactly on a plane; on a curved surface the depth changes along the path.
    const double error = lag / reach - 1.0;
    if (round > 0 && (std::abs(error) <= kConeError || error < -0.5)) break;
    (round == 0 ? descendAhead : descend)(world, goal - displacement * (reach / lag), radius, proxy);
    displacement = displacementToGoal(world, goal, radius, proxy);
  }
  proxy.sliding = true;
}

}  // namespace

void moveProxy(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  proxy.sweeps = 0;
  refreshPlanes(world, radius, proxy);
  proxy.rounds = roundsFor(world, goal, radius, proxy);
  const int late = proxy.late;
  moveOverGround(world, goal, radius, proxy);
  proxy.late = proxy.late > late ? late + 1 : 0;
  proxy.goal = goal;
}

bool pushProxy(const ContactWorld& world, PartId part, const Pose& before, double radius, Proxy& proxy) {
  ASSERT(world.has(part));
  if (!world.touchable(part)) return true;
  glm::dvec3 target = proxy.position;
  bool carriedByFriction = false;
  for (const ProxyPlane& plane : proxy.planes) {
    if (plane.surface.part != part || !presses(plane)) continue;
    const assets::Material& m = world.material(part, plane.surface.triangle);
    carriedByFriction = carriedByFriction || std::max(m.staticFriction, m.dynamicFriction) > 0.0;
  }
  if (carriedByFriction) {
    target = transformPoint(world.pose(part), transformPoint(inverse(before), proxy.position));
  } else {
    WorldHit hit;
    if (!world.sweepAgainstMoved(part, before, proxy.position, radius, hit, target)) return true;
  }
  WorldHit obstacle;
  const glm::dvec3 displacement = target - proxy.position;
  if (!world.sweep(proxy.position, displacement, radius, part, obstacle)) {
    proxy.position = target;
    return true;
  }
  proxy.position += displacement * obstacle.t;
  return false;
}

}  // namespace tandem::haptics
