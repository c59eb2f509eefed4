#include "haptics/proxy/proxy_planes.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

// 1 - cos of the angle by which a plane may rotate before it counts as another constraint: 1.4e-5 rad. The
// relative force error is of the same size, and it is above the noise of a direction measured over one skin.
constexpr double kSameDirection = 1e-10;

/// The contact that covers this one on an edge or corner: the edge lies on or under the other contact's
/// plane, and the proxy rests there at full height.
const ProxyPlane* coverOf(const Proxy& proxy, double radius, const ProxyPlane& plane) {
  if (plane.surface.onFace) return nullptr;
  const double height = radius + 0.75 * plane.skin;  // lower, a sweep along the plane would hit the edge
  for (const ProxyPlane& other : proxy.planes) {
    const SurfacePoint& under = other.surface;
    if (&other == &plane || !(under.distance < plane.surface.distance) || under.distance < height) continue;
    if (glm::dot(under.normal, plane.surface.point - under.point) <= 0.25 * plane.skin) return &other;
  }
  return nullptr;
}

/// Decides what a covered edge constrains. Returns false where its face continues flat or downwards, which
/// cannot touch the proxy here; otherwise the contact becomes one with the rising face.
bool facesProxy(const ContactWorld& world, const ProxyPlane& cover, const glm::dvec3& position,
                SurfacePoint& at, double skin) {
  const Triangle face = world.triangle(at.part, at.triangle);
  const auto height = [&](const glm::dvec3& p) {
    return glm::dot(cover.surface.normal, p - cover.surface.point);
  };
  if (std::max({height(face.a), height(face.b), height(face.c)}) <= skin) return false;
  takeFacePlane(face, position, at);
  return true;
}

/// The plane of the triangle that was hit, else a new one, else one that does not press.
ProxyPlane& slotFor(const WorldHit& hit, Proxy& proxy) {
  for (ProxyPlane& known : proxy.planes) {
    if (known.surface.part == hit.part && known.surface.triangle == hit.triangle) return known;
  }
  if (!proxy.planes.full()) return proxy.planes.push_back({});
  // A corner has fewer than eight planes in practice.
  const auto idle = std::find_if_not(proxy.planes.begin(), proxy.planes.end(), presses);
  return idle != proxy.planes.end() ? *idle : proxy.planes[0];
}

}  // namespace

void takeFacePlane(const Triangle& face, const glm::dvec3& position, SurfacePoint& at) {
  const glm::dvec3 normal = areaVector(face);
  const double length = glm::length(normal);
  if (!(length > 0.0)) return;
  const double side = glm::dot(normal, position - at.point);
  at.normal = side < 0.0 ? -normal / length : normal / length;
  at.distance = std::abs(side) / length;
}

bool refreshPlanes(const ContactWorld& world, double radius, Proxy& proxy) {
  bool changed = false;
  std::size_t left = 0;
  for (ProxyPlane plane : proxy.planes) {
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
      // The face that the surface walk expects ahead is kept once before it is touched.
      if (!plane.arriving || !plane.surface.onFace) continue;
    }
    plane.arriving = false;
    changed = changed || (presses(plane) && 1.0 - glm::dot(before, plane.surface.normal) > kSameDirection);
    proxy.planes[left++] = plane;
  }
  proxy.planes.shrink(left);
  return changed;
}

void addPlane(const ContactWorld& world, const WorldHit& hit, Proxy& proxy) {
  ASSERT(world.has(hit.part));
  ProxyPlane& plane = slotFor(hit, proxy);
  plane.surface = {
      hit.part,  hit.triangle, hit.point, hit.normal, glm::dot(proxy.position - hit.point, hit.normal),
      hit.onFace};
  plane.skin = world.skin(hit.part, proxy.position);
  plane.multiplier = 0.0;
  plane.beyondEdge = false;
}

glm::dvec3 displacementToGoal(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy,
                              Covered covered) {
  FixedVector<HalfSpace, kMaxPlanes> planes;
  FixedVector<ProxyPlane*, kMaxPlanes> sources;
  double tolerance = 0.0;
  for (ProxyPlane& plane : proxy.planes) {
    plane.multiplier = 0.0;
    const ProxyPlane* cover = proxy.planes.size() > 1 ? coverOf(proxy, radius, plane) : nullptr;
    if (cover != nullptr) {
      SurfacePoint face = plane.surface;
      if (!facesProxy(world, *cover, proxy.position, face, plane.skin)) continue;
      plane.beyondEdge = covered == Covered::asFace;
      if (plane.beyondEdge) plane.surface = face;
    }
    tolerance = planes.empty() ? 0.125 * plane.skin : std::min(tolerance, 0.125 * plane.skin);
    sources.push_back(&plane);
    planes.push_back({plane.surface.normal, radius + plane.skin - plane.surface.distance});
  }
  // Lengths are relative to the proxy, where they are small and keep their precision.
  const Projection found =
      projectOntoPlanes(goal - proxy.position, {planes.data(), planes.size()}, tolerance);
  for (std::size_t i = 0; i < sources.size(); ++i) sources[i]->multiplier = found.multiplier[i];
  // Planes contradict each other in a gap narrower than the tool and its skins; staying is always allowed.
  return found.exact ? found.point : glm::dvec3(0.0);
}

double smallestSkin(const Proxy& proxy) {
  if (proxy.planes.empty()) return 0.0;
  double skin = proxy.planes[0].skin;
  for (const ProxyPlane& plane : proxy.planes) skin = std::min(skin, plane.skin);
  return skin;
}

bool touches(const Proxy& proxy) { return std::any_of(proxy.planes.begin(), proxy.planes.end(), presses); }

ProxyPlane* onlyPressing(Proxy& proxy) {
  ProxyPlane* only = nullptr;
  for (ProxyPlane& plane : proxy.planes) {
    if (!presses(plane)) continue;
    if (only != nullptr) return nullptr;
    only = &plane;
  }
  return only;
}

}  // namespace tandem::haptics
