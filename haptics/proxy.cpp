#include "haptics/proxy.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

constexpr int kMaxRounds = 24;
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
    plane.surface = world.surfaceAt(plane.surface.part, plane.surface.triangle, proxy.position);
    plane.skin = world.skin(plane.surface.part, proxy.position);
    const glm::dvec3 offset = proxy.position - plane.surface.point;
    if (glm::length(offset) > radius + 2.0 * plane.skin) {
      changed = changed || presses(plane);
      continue;
    }
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
  plane.surface = {hit.part, hit.triangle, hit.point, hit.normal,
                   glm::dot(proxy.position - hit.point, hit.normal)};
  plane.skin = world.skin(hit.part, proxy.position);
  plane.multiplier = 0.0;
}

/// The way from the proxy to the point nearest to the goal that the known planes allow. Notes the
/// multipliers.
glm::dvec3 wayToGoal(const glm::dvec3& goal, double radius, Proxy& proxy) {
  std::array<HalfSpace, kMaxPlanes> planes;
  double tolerance = 0.0;
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    planes[static_cast<std::size_t>(i)] = {plane.surface.normal,
                                           radius + plane.skin - plane.surface.distance};
    tolerance = i == 0 ? 0.125 * plane.skin : std::min(tolerance, 0.125 * plane.skin);
  }
  // Lengths are relative to the proxy, where they are small and keep their digits.
  const Projection found = projectOntoPlanes(
      goal - proxy.position,
      std::span<const HalfSpace>(planes.data(), static_cast<std::size_t>(proxy.planeCount)), tolerance);
  for (int i = 0; i < proxy.planeCount; ++i) {
    proxy.planes[static_cast<std::size_t>(i)].multiplier = found.multiplier[static_cast<std::size_t>(i)];
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

/// Friction reach of the pressing planes, m: the tangential lag that the normal depth can hold.
double frictionReach(const ContactWorld& world, const Proxy& proxy, bool sliding) {
  double reach = 0.0;
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
    if (!presses(plane)) continue;
    const assets::Material& m = world.material(plane.surface.part, plane.surface.triangle);
    reach += plane.multiplier * (sliding ? m.dynamicFriction : std::max(m.staticFriction, m.dynamicFriction));
  }
  return reach;
}

}  // namespace

void slideProxy(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  refreshPlanes(world, radius, proxy);
  for (int round = 0; round < kMaxRounds; ++round) {
    const glm::dvec3 way = wayToGoal(goal, radius, proxy);
    if (glm::length(way) <= 0.01 * smallestSkin(proxy)) return;
    WorldHit hit;
    if (world.sweep(proxy.position, way, radius, kNoPart, hit)) {
      proxy.position += way * hit.t;
      refreshPlanes(world, radius, proxy);
      addPlane(world, hit, proxy);
    } else {
      proxy.position += way;
      if (!refreshPlanes(world, radius, proxy)) return;
    }
  }
}

void moveProxy(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy) {
  const Proxy anchor = proxy;
  slideProxy(world, goal, radius, proxy);
  const bool wasTouching =
      std::any_of(anchor.planes.begin(), anchor.planes.begin() + anchor.planeCount, presses);
  const double slidingReach = frictionReach(world, proxy, true);
  const double reach = anchor.sliding ? slidingReach : frictionReach(world, proxy, false);
  if (!wasTouching || !(reach > 0.0)) {
    proxy.sliding = false;
    return;
  }
  const glm::dvec3 slip = proxy.position - anchor.position;
  const double length = glm::length(slip);
  const bool slides = length > reach;
  const glm::dvec3 stop = slides ? anchor.position + slip * (1.0 - slidingReach / length) : anchor.position;
  // The same depth under the place where friction holds the proxy: on a plane this ends exactly there, on a
  // curved surface it ends on the surface.
  const glm::dvec3 depth = goal - proxy.position;
  const Proxy pressed = proxy;
  if (slides) {
    proxy = anchor;
    slideProxy(world, stop + depth, radius, proxy);
  } else {
    proxy.position = anchor.position;
    if (refreshPlanes(world, radius, proxy)) proxy = anchor;
    for (int i = 0; i < proxy.planeCount; ++i) {
      ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(i)];
      plane.multiplier = 0.0;
      for (int j = 0; j < pressed.planeCount; ++j) {
        const ProxyPlane& other = pressed.planes[static_cast<std::size_t>(j)];
        if (other.surface.part == plane.surface.part && other.surface.triangle == plane.surface.triangle) {
          plane.multiplier = other.multiplier;
        }
      }
    }
  }
  proxy.sliding = slides;
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
