#include "haptics/proxy.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "haptics/crease.h"
#include "haptics/friction_scale.h"
#include "haptics/surface_walk.h"

namespace tandem::haptics {
namespace {

constexpr int kMaxRounds = 24;
constexpr int kMaxFrictionRounds = 4;
constexpr double kConeError = 1e-3;  // of the friction ratio
constexpr double kMaxRoll = 0.7;  // rad a round: where two tangents of the arc meet, 6.5 % of its radius off
// By how much a step may go beyond the point of its line that is nearest to the goal: below 2, so that even
// if the surface is not curved as expected it ends nearer than it began.
constexpr double kMaxStretch = 1.5;
// A share of the first tangent of a tick. A ball's way that is shorter is the rest of it: followed face by
// face, for a tangent across several facets would end above them and leave the same rest again.
constexpr double kShort = 0.25;
// Of a ball's radius: a step that is cut because the ground turns is no shorter. Along a tangent of that length
// the ball rises by half a hundredth of its radius.
constexpr double kLeastStep = 0.1;
// Of the arc between where a roll is free and where it is stopped: to the last digit.
constexpr int kBisections = 40;
constexpr int kEdgeRounds = 4;
// Arcs of a crease: a way longer than that leads over the creases behind it too. Along the tangent it skims
// over all of them at once, and the next round comes down.
constexpr double kSkim = 8.0;
// cos 0.0026 degrees: what turns by less is one plane to the force (5e-5 of it across), more is a facet of its
// own for the rest of a way.
constexpr double kSmooth = 1.0 - 1e-9;
// Sine of the angle between a way and a face. To step back to its full height the ball goes half a skin / sine
// along its way: on flatter ways, more than 32 skins, it stays where it was stopped.
constexpr double kSteepEnough = 1.0 / 64.0;
constexpr double kWellPast = 8.0;     // skins, from an edge: what holds the proxy there is no longer near
constexpr double kNearEnough = 1e-6;  // of the depth: a force error of as little
// 1 - cos of the angle by which a plane may turn before its constraint counts as another one: 1.4e-5 rad, a
// force error of as little, yet above the noise of a direction measured over one skin.
constexpr double kSameDirection = 1e-10;

/// Measures the planes anew from where the proxy is now and drops those that it no longer touches. True if
/// one that matters has gone or turned, so that the last projection is out of date.
bool refreshPlanes(const ContactWorld& world, double radius, Proxy& proxy) {
  bool changed = false;
  int kept = 0;
  for (int i = 0; i < proxy.planeCount; ++i) {
    ProxyPlane plane = proxy.planes[static_cast<std::size_t>(i)];
    const glm::dvec3 before = plane.surface.normal;
    if (!world.touchable(plane.surface.part)) continue;
    if (presses(plane)) {
      proxy.lastPart = plane.surface.part;
      proxy.lastTriangle = plane.surface.triangle;
    }
    plane.surface = world.surfaceAt(plane.surface.part, plane.surface.triangle, proxy.position);
    plane.beyondEdge = false;
    plane.skin = world.skin(plane.surface.part, proxy.position);
    const glm::dvec3 offset = proxy.position - plane.surface.point;
    if (glm::length(offset) > radius + 2.0 * plane.skin) {
      changed = changed || presses(plane);
      // The face that the walk says lies ahead is worth a look before it is touched, once.
      if (!plane.arriving || !plane.surface.onFace) continue;
    }
    plane.arriving = false;
    changed = changed || (presses(plane) && 1.0 - glm::dot(before, plane.surface.normal) > kSameDirection);
    proxy.planes[static_cast<std::size_t>(kept++)] = plane;
  }
  proxy.planeCount = kept;
  return changed;
}

void addPlane(const ContactWorld& world, const WorldHit& hit, Proxy& proxy) {
  int slot = -1;
  for (int i = 0; i < proxy.planeCount && slot < 0; ++i) {
    const SurfacePoint& known = proxy.planes[static_cast<std::size_t>(i)].surface;
    if (known.part == hit.part && known.triangle == hit.triangle) slot = i;
  }
  if (slot < 0 && proxy.planeCount < kMaxPlanes) slot = proxy.planeCount++;
  // Eight planes at once are more than a corner has in practice; one that does not press makes room.
  for (int i = 0; i < kMaxPlanes && slot < 0; ++i) {
    if (!presses(proxy.planes[static_cast<std::size_t>(i)])) slot = i;
  }
  ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(std::max(slot, 0))];
  plane.surface = {
      hit.part,  hit.triangle, hit.point, hit.normal, glm::dot(proxy.position - hit.point, hit.normal),
      hit.onFace};
  plane.skin = world.skin(hit.part, proxy.position);
  plane.multiplier = 0.0;
  plane.beyondEdge = false;
}

/// The contact that covers this one on an edge or corner: it lies on or under the other's plane, and further
/// from the proxy, which rests there at full height.
const ProxyPlane* coverOf(const Proxy& proxy, double radius, int index) {
  const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(index)];
  if (plane.surface.onFace) return nullptr;
  const double height = radius + 0.75 * plane.skin;  // below this a sweep along the plane would meet the edge
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& other = proxy.planes[static_cast<std::size_t>(i)];
    const SurfacePoint& under = other.surface;
    if (i == index || !(under.distance < plane.surface.distance) || under.distance < height) continue;
    if (glm::dot(under.normal, plane.surface.point - under.point) <= 0.25 * plane.skin) return &other;
  }
  return nullptr;
}

/// Makes a contact on a triangle's edge or corner one with its plane; of a triangle of no area it stays what
/// it is.
void takeFacePlane(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& position,
                   SurfacePoint& at) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double length = glm::length(normal);
  if (!(length > 0.0)) return;
  const double side = glm::dot(normal, position - at.point);
  at.normal = side < 0.0 ? -normal / length : normal / length;
  at.distance = std::abs(side) / length;
}

/// Settles what a covered edge means: nothing where its face goes on flat or downwards, which is then not
/// felt from here; the face itself where that rises. False if it means nothing.
bool facesProxy(const ContactWorld& world, const ProxyPlane& cover, const glm::dvec3& position,
                SurfacePoint& at, double skin) {
  const Pose& pose = world.pose(at.part);
  const Triangle t = world.collider(at.part).tree->triangle(at.triangle);
  const glm::dvec3 a = transformPoint(pose, t.a), b = transformPoint(pose, t.b),
                   c = transformPoint(pose, t.c);
  const auto height = [&](const glm::dvec3& p) {
    return glm::dot(cover.surface.normal, p - cover.surface.point);
  };
  if (std::max({height(a), height(b), height(c)}) <= skin) return false;
  takeFacePlane(a, b, c, position, at);
  return true;
}

/// What a contact on an edge counts as whose face rises out of another contact's: that face's whole plane,
/// which is right before an inner edge, or the edge alone.
enum class Covered { asFace, asEdge };

/// The way from the proxy to the point nearest to the goal that the known planes allow. Notes the
/// multipliers, and whether a face presses beyond its edge.
glm::dvec3 wayToGoal(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy,
                     Covered covered = Covered::asFace) {
  std::array<HalfSpace, kMaxPlanes> planes;
  std::array<int, kMaxPlanes> source{};
  std::size_t count = 0;
  double tolerance = 0.0;
  for (int i = 0; i < proxy.planeCount; ++i) {
    ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    plane.multiplier = 0.0;
    const ProxyPlane* cover = proxy.planeCount > 1 ? coverOf(proxy, radius, i) : nullptr;
    if (cover != nullptr) {
      SurfacePoint face = plane.surface;
      if (!facesProxy(world, *cover, proxy.position, face, plane.skin)) continue;
      plane.beyondEdge = covered == Covered::asFace;
      if (plane.beyondEdge) plane.surface = face;
    }
    tolerance = count == 0 ? 0.125 * plane.skin : std::min(tolerance, 0.125 * plane.skin);
    source[count] = i;
    planes[count++] = {plane.surface.normal, radius + plane.skin - plane.surface.distance};
  }
  // Lengths are relative to the proxy, where they are small and keep their digits.
  const Projection found =
      projectOntoPlanes(goal - proxy.position, std::span<const HalfSpace>(planes.data(), count), tolerance);
  for (std::size_t i = 0; i < count; ++i) {
    proxy.planes[static_cast<std::size_t>(source[i])].multiplier = found.multiplier[i];
  }
  // Planes that contradict each other (a gap narrower than the tool and its skins): staying is always
  // allowed.
  return found.exact ? found.point : glm::dvec3(0.0);
}

double smallestSkin(const Proxy& proxy) {
  double skin = 0.0;
  for (int i = 0; i < proxy.planeCount; ++i) {
    const double s = proxy.planes[static_cast<std::size_t>(i)].skin;
    skin = i == 0 ? s : std::min(skin, s);
  }
  return skin;
}

bool touches(const Proxy& proxy) {
  return std::any_of(proxy.planes.begin(), proxy.planes.begin() + proxy.planeCount, presses);
}

/// The first touch on a straight way. A way back to a surface that the tool has just lost is tried against
/// the triangle touched last: nothing that is met later than that one needs a look.
bool sweepWay(const ContactWorld& world, const glm::dvec3& way, double radius, const Proxy& proxy,
              WorldHit& hit) {
  if (proxy.planeCount == 0) {
    hit.t = world.sweepOne(proxy.position, way, radius, proxy.lastPart, proxy.lastTriangle);
    if (hit.t < 1.0 && world.sweep(proxy.position, way, radius, kNoPart, hit)) return true;
    hit.t = 1.0;
  }
  return world.sweep(proxy.position, way, radius, kNoPart, hit);
}

/// Moves along a straight way until a part stops it, and where; true if none did.
bool advance(const ContactWorld& world, const glm::dvec3& way, double radius, Proxy& proxy, WorldHit& hit) {
  hit = {};
  ++proxy.sweeps;
  if (!sweepWay(world, way, radius, proxy, hit)) {
    proxy.position += way;
    return true;
  }
  // It is stopped at half a skin. Where the way met the surface steeply enough, stepping back along it to the
  // full height is short and free.
  const double length = glm::length(way), slope = -glm::dot(hit.normal, way) / length;
  const double back =
      slope > kSteepEnough ? 0.5 * world.skin(hit.part, proxy.position) / (slope * length) : 0.0;
  proxy.position += way * (hit.t > 2.0 * back ? hit.t - back : hit.t);
  refreshPlanes(world, radius, proxy);
  addPlane(world, hit, proxy);
  return false;
}

bool advance(const ContactWorld& world, const glm::dvec3& way, double radius, Proxy& proxy) {
  WorldHit hit;
  return advance(world, way, radius, proxy, hit);
}

/// Rolls the ball over the crease that it presses on alone, towards the place over it that is nearest to the
/// goal: up to the face or edge ahead, or by kMaxRoll, along two tangents of the arc. False if it is there.
bool rollOverCrease(const ContactWorld& world, const glm::dvec3& goal, double radius, const glm::dvec3& way,
                    int index, Proxy& proxy) {
  const ProxyPlane plane = proxy.planes[static_cast<std::size_t>(index)];
  const Crease crease = creaseUnder(world, plane.surface, plane.skin);
  const glm::dvec3 axis = crease.b - crease.a;
  const double square = glm::dot(axis, axis);
  const double place = square > 0.0 ? glm::dot(goal - crease.a, axis) / square : 0.0;
  const glm::dvec3 foot = crease.a + axis * std::clamp(place, 0.0, 1.0);
  const glm::dvec3 normal = plane.surface.normal;
  const glm::dvec3 out = goal - (crease.a + axis * place);
  const double reach = radius + plane.skin, length = glm::length(out);
  if (!(length > 0.0)) return false;
  const double cosine = std::clamp(glm::dot(normal, out) / length, -1.0, 1.0);
  const glm::dvec3 sideways = out / length - cosine * normal;
  const double sine = glm::length(sideways);
  // Right behind the crease: no side is nearer than the other.
  if (sine < 1e-6 && cosine < 0.0) return false;
  const glm::dvec3 tangent = sine > 0.0 ? sideways / sine : glm::dvec3(0.0);
  const double angle = std::atan2(sine, cosine);
  RollLimit limit;
  if (sine > 0.0) limit = rollLimit(world, plane.surface, plane.skin, tangent);
  const bool leaves = limit.triangle != kNoTriangle && limit.turn < std::min(angle, kMaxRoll);
  // A way that is far longer than the arc skims over it, and the creases behind it.
  if (leaves && glm::length(way) > kSkim * limit.turn * reach + 8.0 * plane.skin) return false;
  // Over a crease whose other side is not known the ball would roll too far, if the goal is under it.
  if (!leaves && angle > kMaxRoll && plane.multiplier >= 0.8 * radius) return false;
  const double turn = std::min({angle, limit.turn, kMaxRoll}), share = angle > 0.0 ? turn / angle : 1.0;
  const glm::dvec3 shift = (foot - plane.surface.point) * share;
  if (leaves) proxy.planes[static_cast<std::size_t>(index)].surface.triangle = limit.triangle;
  if (turn * reach + glm::length(shift) <= 0.01 * plane.skin) return false;
  // Of the way over the crease, and that far from it.
  const auto over = [&](double part, double distance) {
    const double t = part * turn;
    return plane.surface.point + shift * part + distance * (std::cos(t) * normal + std::sin(t) * tangent);
  };
  WorldHit stop;
  const auto rollTo = [&](double part, const glm::dvec3& end) {
    const double t = part * turn;
    const glm::dvec3 middle = over(0.5 * part, reach / std::cos(0.5 * t));
    return (reach * t * t <= plane.skin || advance(world, middle - proxy.position, radius, proxy, stop)) &&
           advance(world, end - proxy.position, radius, proxy, stop);
  };
  const Proxy before = proxy;
  glm::dvec3 end = over(1.0, reach);
  if (leaves) end += 3.0 * plane.skin * (std::cos(turn) * tangent - std::sin(turn) * normal);
  if (rollTo(1.0, end)) {
    refreshPlanes(world, radius, proxy);
    return true;
  }
  // Stopped above the arc, on a tangent of it: where the arc itself touches what was met, both hold the ball.
  const WorldHit met = stop;
  const double contact = radius + world.skin(met.part, proxy.position);
  const auto isFree = [&](double part) { return glm::length(over(part, reach) - met.point) > contact; };
  if (!isFree(0.0) || isFree(1.0)) return true;
  double free = 0.0, blocked = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (free + blocked);
    (isFree(middle) ? free : blocked) = middle;
  }
  const int sweeps = proxy.sweeps;
  proxy = before;
  proxy.sweeps = sweeps;
  if (rollTo(free, over(free, reach))) {
    addPlane(world, met, proxy);
    refreshPlanes(world, radius, proxy);
  }
  return true;
}

/// Lets a point that rests on a ridge rest on the face that its way leads onto. False if the mesh does not
/// tell.
bool stepOffRidge(const ContactWorld& world, const glm::dvec3& position, const glm::dvec3& way,
                  ProxyPlane& plane) {
  SurfacePoint at = plane.surface;
  const std::uint32_t ahead = rollLimit(world, plane.surface, plane.skin, way / glm::length(way)).triangle;
  if (ahead == kNoTriangle) return false;
  const Pose& pose = world.pose(at.part);
  const Triangle t = world.collider(at.part).tree->triangle(ahead);
  at.triangle = ahead;
  takeFacePlane(transformPoint(pose, t.a), transformPoint(pose, t.b), transformPoint(pose, t.c), position,
                at);
  // Lower over that face, its sweep would meet the ridge.
  if (at.distance < 0.75 * plane.skin) return false;
  plane.surface = at;
  return true;
}

using Walks = std::array<SurfaceWalk, kMaxPlanes>;

/// Cuts a way short where the ground under one of the pressing contacts ends, and notes on which triangles
/// the contacts that stay on it arrive. True if the way was cut.
bool keepToGround(const ContactWorld& world, double radius, const Proxy& proxy, double flat, glm::dvec3& way,
                  Walks& walks, bool& onCrease) {
  const double length = glm::length(way);
  double share = 1.0;
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    if (!presses(plane)) continue;
    SurfaceWalk& walk = walks[static_cast<std::size_t>(i)];
    walk = walkSurface(world, plane.surface, way, plane.skin, flat);
    // On a crease already: over it by a few skins for a point, by no more than it can roll for a ball.
    const double over = 3.0 * plane.skin / length;
    if (walk.sharp || walk.share < over) {
      onCrease = true;
      const double leaves = wayOver(creaseUnder(world, plane.surface, plane.skin), way);
      walk.share = leaves > 0.0 ? (3.0 * plane.skin + 0.5 * radius) / leaves : 1.0;
    } else if (walk.share < 1.0) {
      walk.share += over;
    }
    // Features far smaller than the ball are no creases of its way.
    share = std::min(share, std::max(walk.share, std::min(1.0, kLeastStep * radius / length)));
  }
  if (share >= 1.0) return false;
  way *= share;
  return true;
}

/// Puts the pressing planes onto the triangles to which the walk has led, once the proxy is there.
void arrive(const Walks& walks, Proxy& proxy) {
  for (int i = 0; i < proxy.planeCount; ++i) {
    ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    const SurfaceWalk& walk = walks[static_cast<std::size_t>(i)];
    if (!presses(plane) || walk.sharp || walk.share < 1.0) continue;
    plane.arriving =
        walk.arrival.triangle != plane.surface.triangle || walk.arrival.part != plane.surface.part;
    plane.surface.part = walk.arrival.part;
    plane.surface.triangle = walk.arrival.triangle;
  }
}

/// Puts a contact that has passed a crease onto the face behind it.
void passCrease(const Walks& walks, Proxy& proxy) {
  for (int i = 0; i < proxy.planeCount; ++i) {
    ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    const std::uint32_t beyond = walks[static_cast<std::size_t>(i)].beyond;
    if (!presses(plane) || beyond == kNoTriangle) continue;
    plane.surface.triangle = beyond;
    plane.arriving = true;
  }
}

/// The index of the plane that presses alone; -1 if none or several do.
int onlyPressing(const Proxy& proxy) {
  int only = -1;
  for (int i = 0; i < proxy.planeCount; ++i) {
    if (!presses(proxy.planes[static_cast<std::size_t>(i)])) continue;
    if (only >= 0) return -1;
    only = i;
  }
  return only;
}

/// Friction reach of the pressing planes, m: the tangential lag that the normal depth can hold.
double frictionReach(const ContactWorld& world, const Proxy& proxy, bool sliding) {
  double reach = 0.0;
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    if (!presses(plane)) continue;
    const assets::Material& m = world.material(plane.surface.part, plane.surface.triangle);
    const double coefficient = sliding ? m.dynamicFriction : std::max(m.staticFriction, m.dynamicFriction);
    if (coefficient > 0.0) reach += plane.multiplier * coefficient * frictionScale(world, plane.surface);
  }
  return reach;
}

/// How near is near enough: a share of the skin, or of the depth where facets, edges and corners stand for a
/// curve.
double closeEnough(const Proxy& proxy, double radius) {
  double depth = 0.0;
  bool curved = false;
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    if (!presses(plane)) continue;
    depth += plane.multiplier;
    curved = curved || (radius > 0.0 && !plane.surface.onFace);
  }
  return std::max(0.01 * smallestSkin(proxy), curved ? kNearEnough * depth : 0.0);
}

/// One move of the proxy towards a goal: rounds of projection, walk and sweep.
class Descent {
 public:
  Descent(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy)
      : world_(world), goal_(goal), radius_(radius), proxy_(proxy), mayRoll_(radius > 0.0) {}

  /// From planes that are up to date.
  void run() {
    for (int round = 0; round < kMaxRounds; ++round) {
      if (settled()) return;
    }
    leaveOff();
  }

  /// As run(), the first of a tick: it begins as far along the tangent as the last one turned out to go.
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
  void leaveOff() {
    // Out of rounds, somewhere on the way. What holds the proxy there must be known, or the force would drop
    // out.
    const glm::dvec3 way = wayToGoal(world_, goal_, radius_, proxy_);
    if (touches(proxy_)) return;
    advance(world_, way, radius_, proxy_);
    wayToGoal(world_, goal_, radius_, proxy_);
  }

  /// One round; true if the proxy has arrived.
  bool settled() {
    glm::dvec3 way = wayToGoal(world_, goal_, radius_, proxy_);
    if (glm::length(way) <= closeEnough(proxy_, radius_)) return !passEdge();
    if (!touches(proxy_))
      return advance(world_, way, radius_, proxy_) && !refreshPlanes(world_, radius_, proxy_);

    const int alone = onlyPressing(proxy_);
    if (alone >= 0 && !planeAt(alone).surface.onFace) {
      ProxyPlane& plane = proxy_.planes[static_cast<std::size_t>(alone)];
      if (mayRoll_ && roll(alone, way)) return false;
      if (radius_ == 0.0 && stepOffRidge(world_, proxy_.position, way, plane)) {
        way = wayToGoal(world_, goal_, radius_, proxy_);
      }
    }
    // The goal is under the crease itself, whose other side is not known: the ball creeps off it.
    if (alone >= 0 && mayRoll_ && stillOnSameCrease(planeAt(alone))) way *= kMaxStretch;
    const bool first = stretch_ > 0.0, stretched = stretch_ > 1.0;
    if (first) {
      tangent_ = way;
      way *= stretch_;
      stretch_ = 0.0;
    }
    bool onCrease = false;
    Walks walks;
    const bool cut =
        keepToGround(world_, radius_, proxy_, shortWay(way) ? kSmooth : kGroundTurn, way, walks, onCrease);
    if (onCrease && alone >= 0 && mayRoll_ && roll(alone, way)) return false;
    mayRoll_ = radius_ > 0.0;
    if (!advance(world_, way, radius_, proxy_)) return false;
    if (!cut) {
      arrive(walks, proxy_);
    } else if (alone >= 0 || radius_ == 0.0) {
      passCrease(walks, proxy_);
    }
    const bool changed = refreshPlanes(world_, radius_, proxy_);
    curved_ = curved_ || (first && !cut && proxy_.planeCount == 0);
    return !changed && !cut && !stretched;
  }

  /// Where a face that presses beyond its edge holds the proxy: tries whether the edge alone lets it pass. True
  /// if it has.
  bool passEdge() {
    const auto end = proxy_.planes.begin() + proxy_.planeCount;
    const auto isBeyond = [](const ProxyPlane& plane) { return plane.beyondEdge && presses(plane); };
    if (triedEdge_ || std::none_of(proxy_.planes.begin(), end, isBeyond)) return false;
    triedEdge_ = true;
    const Proxy before = proxy_;
    refreshPlanes(world_, radius_, proxy_);
    const double far = kWellPast * smallestSkin(proxy_);
    for (int i = 0; i < kEdgeRounds; ++i) {
      const glm::dvec3 way = wayToGoal(world_, goal_, radius_, proxy_, Covered::asEdge);
      if (glm::length(way) <= far) break;
      if (advance(world_, way, radius_, proxy_)) refreshPlanes(world_, radius_, proxy_);
      if (glm::length(proxy_.position - before.position) > far) return true;
    }
    const int sweeps = proxy_.sweeps;
    proxy_ = before;
    proxy_.sweeps = sweeps;
    return false;
  }

  /// Whether a way of the ball is the rest of a longer one: then it is followed face by face.
  bool shortWay(const glm::dvec3& way) const {
    return radius_ > 0.0 && glm::length(way) < kShort * glm::length(tangent_);
  }

  /// Whether the last step has left the ball on the corner or edge on which it was: then its arc is the exact
  /// way.
  bool stillOnSameCrease(const ProxyPlane& plane) {
    const bool same =
        !plane.surface.onFace && !lastOnFace_ &&
        glm::length(plane.surface.point - lastPoint_) < 0.25 * glm::length(proxy_.position - lastPosition_);
    lastOnFace_ = plane.surface.onFace;
    lastPoint_ = plane.surface.point;
    lastPosition_ = proxy_.position;
    return same;
  }

  /// True if the round is over: the ball has rolled on, or has met something that the next projection must
  /// know.
  bool roll(int index, const glm::dvec3& way) {
    const int sweeps = proxy_.sweeps;
    const glm::dvec3 from = proxy_.position;
    if (rollOverCrease(world_, goal_, radius_, way, index, proxy_)) {
      // Stopped at once by another plane: the projection knows it, the arc does not.
      mayRoll_ = glm::length(proxy_.position - from) > 2.0 * smallestSkin(proxy_);
      return true;
    }
    mayRoll_ = false;
    return proxy_.sweeps != sweeps;
  }

  const ProxyPlane& planeAt(int index) const { return proxy_.planes[static_cast<std::size_t>(index)]; }

  const ContactWorld& world_;
  const glm::dvec3 goal_;
  const double radius_;
  Proxy& proxy_;
  bool mayRoll_;
  bool triedEdge_ = false;
  bool lastOnFace_ = true;
  double stretch_ = 0.0;     // of the first tangent; 0 = none
  glm::dvec3 tangent_{0.0};  // m, the first one
  bool curved_ = false;      // it ended above the surface
  glm::dvec3 lastPoint_{0.0}, lastPosition_{0.0};
};

void descendAhead(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  Descent(world, goal, radius, proxy).runAhead();
}

void descend(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  Descent(world, goal, radius, proxy).run();
}

}  // namespace

void slideProxy(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  proxy.sweeps = 0;
  refreshPlanes(world, radius, proxy);
  descendAhead(world, goal, radius, proxy);
}

void moveProxy(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  proxy.sweeps = 0;
  refreshPlanes(world, radius, proxy);
  glm::dvec3 way = wayToGoal(world, goal, radius, proxy);
  if (!touches(proxy)) {
    // Friction begins where the tool lands.
    proxy.sliding = false;
    if (glm::length(way) <= 0.01 * smallestSkin(proxy)) return;
    if (advance(world, way, radius, proxy) && !refreshPlanes(world, radius, proxy)) return;
    way = wayToGoal(world, goal, radius, proxy);
  }
  const double hold = frictionReach(world, proxy, proxy.sliding);
  if (hold > 0.0 && glm::length(way) <= hold) {
    proxy.sliding = false;
    return;
  }
  for (int round = 0; round < kMaxFrictionRounds; ++round) {
    const double reach = frictionReach(world, proxy, true), lag = glm::length(way);
    if (!(reach > 0.0) || !(lag > 0.0)) {
      proxy.sliding = false;
      return round == 0 ? descendAhead(world, goal, radius, proxy) : descend(world, goal, radius, proxy);
    }
    // On a plane the cone is reached exactly; on a curved surface the depth changes on the way.
    const double error = lag / reach - 1.0;
    if (round > 0 && (std::abs(error) <= kConeError || error < -0.5)) break;
    (round == 0 ? descendAhead : descend)(world, goal - way * (reach / lag), radius, proxy);
    way = wayToGoal(world, goal, radius, proxy);
  }
  proxy.sliding = true;
}

bool pushProxy(const ContactWorld& world, PartId part, const Pose& before, double radius, Proxy& proxy) {
  if (!world.touchable(part)) return true;
  glm::dvec3 target = proxy.position;
  bool carriedByFriction = false;
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
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
  const glm::dvec3 way = target - proxy.position;
  if (!world.sweep(proxy.position, way, radius, part, obstacle)) {
    proxy.position = target;
    return true;
  }
  proxy.position += way * obstacle.t;
  return false;
}

}  // namespace tandem::haptics
