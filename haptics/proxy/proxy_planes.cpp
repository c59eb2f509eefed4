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
  const double height = radius + 0.75 * plane.margin;  // lower, a sweep along the plane would hit the edge
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
  double highest = 0.0;
  for (const glm::dvec3& corner : world.face(at.part, at.triangle))
    highest = std::max(highest, glm::dot(cover.surface.normal, corner - cover.surface.point));
  if (highest <= skin) return false;
  takeFacePlane(world.triangle(at.part, at.triangle), position, at);
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

/// The planes of the proxy that take part in a projection, and whose planes they are.
struct Constraints {
  FixedVector<HalfSpace, kMaxPlanes> planes;
  FixedVector<ProxyPlane*, kMaxPlanes> sources;
  double tolerance = 0.0;  // m

  Projection project(const glm::dvec3& goal) const {
    return projectOntoPlanes(goal, {planes.data(), planes.size()}, tolerance);
  }
};

Constraints constraintsOf(const ContactWorld& world, double radius, Proxy& proxy, Covered covered) {
  Constraints all;
  for (ProxyPlane& plane : proxy.planes) {
    plane.multiplier = plane.depth = 0.0;
    const ProxyPlane* cover = proxy.planes.size() > 1 ? coverOf(proxy, radius, plane) : nullptr;
    if (cover != nullptr) {
      SurfacePoint face = plane.surface;
      if (!facesProxy(world, *cover, proxy.position, face, plane.skin)) continue;
      plane.beyondEdge = covered == Covered::asFace;
      if (plane.beyondEdge) plane.surface = face;
    }
    all.tolerance = std::min(all.sources.empty() ? plane.skin : all.tolerance, 0.125 * plane.skin);
    all.sources.push_back(&plane);
    all.planes.push_back({plane.surface.normal, radius + plane.margin - plane.surface.distance});
  }
  return all;
}

/// Measures the depths: the multipliers, with a skin in place of the margin. `goal` is relative to the proxy.
void measureDepths(const glm::dvec3& goal, double radius, const Constraints& all) {
  Constraints felt;
  bool margins = false;
  for (std::size_t i = 0; i < all.sources.size(); ++i) {
    ProxyPlane& plane = *all.sources[i];
    plane.depth = plane.multiplier;
    if (!presses(plane)) continue;
    felt.sources.push_back(&plane);
    felt.planes.push_back(all.planes[i]);
    if (!(plane.margin > plane.skin)) continue;
    margins = true;
    HalfSpace& surface = felt.planes.back();
    surface.offset = radius + plane.skin - plane.surface.distance;
    plane.depth = std::max(0.0, plane.multiplier - (all.planes[i].offset - surface.offset));
  }
  // Planes that are not at right angles share their margins, so several are solved for anew.
  if (!margins || felt.sources.size() < 2) return;
  felt.tolerance = all.tolerance;
  const Projection found = felt.project(goal);
  if (!found.exact) return;
  for (std::size_t i = 0; i < felt.sources.size(); ++i) felt.sources[i]->depth = found.multiplier[i];
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
    plane.margin = world.margin(plane.surface.part, proxy.position, radius);
    const glm::dvec3 offset = proxy.position - plane.surface.point;
    if (glm::length(offset) > radius + 2.0 * plane.margin) {
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

void addPlane(const ContactWorld& world, const WorldHit& hit, double radius, Proxy& proxy) {
  ASSERT(world.has(hit.part));
  ProxyPlane& plane = slotFor(hit, proxy);
  plane.surface = {
      hit.part,  hit.triangle, hit.point, hit.normal, glm::dot(proxy.position - hit.point, hit.normal),
      hit.onFace};
  plane.skin = world.skin(hit.part, proxy.position);
  plane.margin = world.margin(hit.part, proxy.position, radius);
  plane.multiplier = plane.depth = 0.0;
  plane.beyondEdge = false;
}

glm::dvec3 displacementToGoal(const ContactWorld& world, const glm::dvec3& goal, double radius, Proxy& proxy,
                              Covered covered) {
  // Lengths are relative to the proxy, where they are small and keep their precision.
  const glm::dvec3 ahead = goal - proxy.position;
  Constraints all = constraintsOf(world, radius, proxy, covered);
  Projection found = all.project(ahead);
  if (!found.exact) {
    // In a gap narrower than the tool and its margins the planes contradict each other. Staying is always
    // allowed, and so is all that comes no nearer to any of them.
    for (HalfSpace& plane : all.planes) plane.offset = std::min(plane.offset, 0.0);
    found = all.project(ahead);
  }
  for (std::size_t i = 0; i < all.sources.size(); ++i) all.sources[i]->multiplier = found.multiplier[i];
  measureDepths(ahead, radius, all);
  return found.exact ? found.point : glm::dvec3(0.0);
}

glm::dvec3 feltPosition(const Proxy& proxy, double radius) {
  const glm::dvec3 back = heldByMargins(proxy);
  if (back == glm::dvec3(0.0)) return proxy.position;
  // A point that has not come up to its margin everywhere is nearer to the surface.
  double share = 1.0;
  for (const ProxyPlane& plane : proxy.planes) {
    const double nearer = glm::dot(back, plane.surface.normal);
    const double room = std::max(0.0, plane.surface.distance - radius - plane.skin);
    if (nearer * share > room) share = room / nearer;
  }
  return proxy.position - share * back;
}

double smallestSkin(const Proxy& proxy) {
  if (proxy.planes.empty()) return 0.0;
  double skin = proxy.planes[0].skin;
  for (const ProxyPlane& plane : proxy.planes) skin = std::min(skin, plane.skin);
  return skin;
}

double largestMargin(const Proxy& proxy) {
  double margin = 0.0;
  for (const ProxyPlane& plane : proxy.planes) margin = std::max(margin, plane.margin);
  return margin;
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
