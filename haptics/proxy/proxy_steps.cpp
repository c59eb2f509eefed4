#include "haptics/proxy/proxy_steps.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/proxy/crease.h"
#include "haptics/proxy/proxy_planes.h"
#include "haptics/proxy/proxy_trace.h"

namespace tandem::haptics {
namespace {

constexpr double kMaxRoll =
    0.7;  // rad a round: where two tangents of the arc meet, 6.5 % of its radius off it
// Multiple of a crease's arc beyond which a displacement also crosses the creases behind it. Such a step
// follows the tangent over all of them at once, and the next round comes down to the surface.
constexpr double kSkim = 8.0;
// Bisection steps between the free and the blocked end of a roll, which resolve 2^-40 of its arc.
constexpr int kBisections = 40;
// Sine of the angle between a displacement and a face. To step back to its full height the ball moves half a
// margin / sine back along its displacement; on a flatter one, which needs more than 32 margins, it stays
// where it was stopped.
constexpr double kSteepEnough = 1.0 / 64.0;

/// The first hit on a straight displacement. A move back to a surface that was just lost is tested against
/// the last touched triangle first, which bounds the sweep over all others.
bool sweepAlong(const ContactWorld& world, const glm::dvec3& displacement, double radius, const Proxy& proxy,
                WorldHit& hit) {
  if (proxy.planes.empty()) {
    hit.t = world.sweepOne(proxy.position, displacement, radius, proxy.lastPart, proxy.lastTriangle);
    if (hit.t < 1.0 && world.sweep(proxy.position, displacement, radius, kNoPart, hit)) return true;
    hit.t = 1.0;
  }
  return world.sweep(proxy.position, displacement, radius, kNoPart, hit);
}

void moveTo(const glm::dvec3& position, Proxy& proxy) {
  if (proxyTrace != nullptr) proxyTrace->push_back({proxy.position, position});
  proxy.position = position;
}

/// Moves along a straight displacement until a part stops the proxy, and reports that hit; true if there was
/// none.
bool advance(const ContactWorld& world, const glm::dvec3& displacement, double radius, Proxy& proxy,
             WorldHit& hit) {
  hit = {};
  ++proxy.sweeps;
  if (!sweepAlong(world, displacement, radius, proxy, hit)) {
    moveTo(proxy.position + displacement, proxy);
    return true;
  }
  // The sweep stops at half a margin. Where the displacement meets the surface steeply enough, stepping back
  // along it to the full height is short and free.
  const double length = glm::length(displacement), slope = -glm::dot(hit.normal, displacement) / length;
  const double back =
      slope > kSteepEnough ? 0.5 * world.margin(hit.part, proxy.position, radius) / (slope * length) : 0.0;
  moveTo(proxy.position + displacement * (hit.t > 2.0 * back ? hit.t - back : hit.t), proxy);
  refreshPlanes(world, radius, proxy);
  addPlane(world, hit, radius, proxy);
  return false;
}

}  // namespace

bool advance(const ContactWorld& world, const glm::dvec3& displacement, double radius, Proxy& proxy) {
  WorldHit hit;
  return advance(world, displacement, radius, proxy, hit);
}

bool rollOverCrease(const ContactWorld& world, const glm::dvec3& goal, double radius,
                    const glm::dvec3& displacement, ProxyPlane& pressing, Proxy& proxy) {
  const ProxyPlane plane = pressing;
  const Crease crease = creaseUnder(world, plane.surface, plane.skin);
  const glm::dvec3 axis = crease.b - crease.a;
  const double square = glm::dot(axis, axis);
  const double place = square > 0.0 ? glm::dot(goal - crease.a, axis) / square : 0.0;
  const glm::dvec3 foot = crease.a + axis * std::clamp(place, 0.0, 1.0);
  const glm::dvec3 normal = plane.surface.normal;
  const glm::dvec3 out = goal - (crease.a + axis * place);
  const double reach = radius + plane.margin, length = glm::length(out);
  if (!(length > 0.0)) return false;
  const double cosine = std::clamp(glm::dot(normal, out) / length, -1.0, 1.0);
  const glm::dvec3 sideways = out / length - cosine * normal;
  const double sine = glm::length(sideways);
  // The goal is right behind the crease, where no side is nearer than the other.
  if (sine < 1e-6 && cosine < 0.0) return false;
  const glm::dvec3 tangent = sine > 0.0 ? sideways / sine : glm::dvec3(0.0);
  const double angle = std::atan2(sine, cosine);
  RollLimit limit;
  if (sine > 0.0) limit = rollLimit(world, plane.surface, plane.skin, tangent);
  const bool leaves = limit.triangle != kNoTriangle && limit.angle < std::min(angle, kMaxRoll);
  // A displacement far longer than the arc skims over it and over the creases behind it.
  if (leaves && glm::length(displacement) > kSkim * limit.angle * reach + 8.0 * plane.margin) return false;
  // If the other side of the crease is unknown and the goal is under it, the ball would roll too far.
  if (!leaves && angle > kMaxRoll && plane.multiplier >= 0.8 * radius) return false;
  const double rollAngle = std::min({angle, limit.angle, kMaxRoll}),
               share = angle > 0.0 ? rollAngle / angle : 1.0;
  const glm::dvec3 shift = (foot - plane.surface.point) * share;
  if (leaves) pressing.surface.triangle = limit.triangle;
  if (rollAngle * reach + glm::length(shift) <= 0.01 * plane.skin) return false;
  // Point at this fraction of the roll and this distance from the crease.
  const auto over = [&](double part, double distance) {
    const double t = part * rollAngle;
    return plane.surface.point + shift * part + distance * (std::cos(t) * normal + std::sin(t) * tangent);
  };
  WorldHit stop;
  const auto rollTo = [&](double part, const glm::dvec3& end) {
    const double t = part * rollAngle;
    const glm::dvec3 middle = over(0.5 * part, reach / std::cos(0.5 * t));
    return (reach * t * t <= plane.margin || advance(world, middle - proxy.position, radius, proxy, stop)) &&
           advance(world, end - proxy.position, radius, proxy, stop);
  };
  const Proxy before = proxy;
  glm::dvec3 end = over(1.0, reach);
  if (leaves) end += 3.0 * plane.margin * (std::cos(rollAngle) * tangent - std::sin(rollAngle) * normal);
  if (rollTo(1.0, end)) {
    refreshPlanes(world, radius, proxy);
    return true;
  }
  // The ball was stopped on a tangent, above the arc. Bisection finds where the arc itself touches the
  // obstacle; there both hold the ball.
  const WorldHit met = stop;
  const double contact = radius + world.margin(met.part, proxy.position, radius);
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
    addPlane(world, met, radius, proxy);
    refreshPlanes(world, radius, proxy);
  }
  return true;
}

bool stepOffRidge(const ContactWorld& world, const glm::dvec3& position, const glm::dvec3& displacement,
                  ProxyPlane& plane) {
  SurfacePoint at = plane.surface;
  const std::uint32_t ahead =
      rollLimit(world, plane.surface, plane.skin, displacement / glm::length(displacement)).triangle;
  if (ahead == kNoTriangle) return false;
  ASSERT(ahead < world.collider(at.part).tree->mesh().triangles.size());

  at.triangle = ahead;
  takeFacePlane(world.triangle(at.part, ahead), position, at);
  // From a lower position over that face, a sweep would hit the ridge.
  if (at.distance < 0.75 * plane.margin) return false;
  plane.surface = at;
  return true;
}

}  // namespace tandem::haptics
