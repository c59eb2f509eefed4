#include "haptics/proxy/proxy_planes.h"

#include <algorithm>
#include <array>
#include <span>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"

namespace tandem::haptics {
namespace {

// 1 - cos of the angle by which a plane may turn before it counts as another constraint: 1.4e-5 rad. The
// relative force error is of the same size, and it is above the noise of a direction measured over one skin.
constexpr double kSameDirection = 1e-10;

/// The contact that covers this one on an edge or corner: the edge lies on or under the other contact's
/// plane, and the proxy rests there at full height.
const ProxyPlane* coverOf(const Proxy& proxy, double radius, int index) {
  const ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(index)];
  if (plane.surface.onFace) return nullptr;
  const double height = radius + 0.75 * plane.skin;  // lower, a sweep along the plane would hit the edge
  for (int i = 0; i < proxy.planeCount; ++i) {
    const ProxyPlane& other = proxy.planes[static_cast<std::size_t>(i)];
    const SurfacePoint& under = other.surface;
    if (i == index || !(under.distance < plane.surface.distance) || under.distance < height) continue;
    if (glm::dot(under.normal, plane.surface.point - under.point) <= 0.25 * plane.skin) return &other;
  }
  return nullptr;
}

/// Decides what a covered edge constrains. Returns false where its face goes on flat or downwards, which the
/// proxy does not feel from here; otherwise the contact becomes one with the rising face.
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
  ASSERT(proxy.planeCount >= 0 && proxy.planeCount <= kMaxPlanes);
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
      // The face that the surface walk expects ahead is kept once before it is touched.
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
  ASSERT(world.has(hit.part));
  int slot = -1;
  for (int i = 0; i < proxy.planeCount && slot < 0; ++i) {
    const SurfacePoint& known = proxy.planes[static_cast<std::size_t>(i)].surface;
    if (known.part == hit.part && known.triangle == hit.triangle) slot = i;
  }
  if (slot < 0 && proxy.planeCount < kMaxPlanes) slot = proxy.planeCount++;
  // A corner has fewer than eight planes in practice; a plane that does not press makes room.
  for (int i = 0; i < kMaxPlanes && slot < 0; ++i) {
    if (!presses(proxy.planes[static_cast<std::size_t>(i)])) slot = i;
  }
  ASSERT(slot < kMaxPlanes && proxy.planeCount <= kMaxPlanes);
  ProxyPlane& plane = proxy.planes[static_cast<std::size_t>(std::max(slot, 0))];
  plane.surface = {
      hit.part,  hit.triangle, hit.point, hit.normal, glm::dot(proxy.position - hit.point, hit.normal),
      hit.onFace};
  plane.skin = world.skin(hit.part, proxy.position);
  plane.multiplier = 0.0;
  plane.beyondEdge = false;
}

glm::dvec3 wayToGoal(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy,
                     Covered covered) {
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
  ASSERT(count <= static_cast<std::size_t>(proxy.planeCount));
  // Lengths are relative to the proxy, where they are small and keep their precision.
  const Projection found =
      projectOntoPlanes(goal - proxy.position, std::span<const HalfSpace>(planes.data(), count), tolerance);
  for (std::size_t i = 0; i < count; ++i) {
    proxy.planes[static_cast<std::size_t>(source[i])].multiplier = found.multiplier[i];
  }
  // Planes contradict each other in a gap narrower than the tool and its skins; staying is always allowed.
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

int onlyPressing(const Proxy& proxy) {
  int only = -1;
  for (int i = 0; i < proxy.planeCount; ++i) {
    if (!presses(proxy.planes[static_cast<std::size_t>(i)])) continue;
    if (only >= 0) return -1;
    only = i;
  }
  return only;
}

}  // namespace tandem::haptics
