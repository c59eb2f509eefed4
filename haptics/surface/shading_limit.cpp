#include "haptics/surface/shading_limit.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tandem::haptics {
namespace {

// Change of a force in a tick, N, that shading may make beside what the hand makes. At 1 kHz it is a ramp of
// 30 N/s.
constexpr double kUnfelt = 0.03;
// The least trust in the normals at which the curvature of their surface is believed: below, the depth along
// them is that of facets, which jumps where these meet.
constexpr double kBelieved = 0.9;

glm::dvec3 withLength(const glm::dvec3& v, double most) {
  const double square = glm::dot(v, v);
  return square > most * most ? v * (most / std::sqrt(square)) : v;
}

/// The largest change since the last tick, N, of which `spring` is that of a spring over the travel.
double changeOf(const ShadedTouches& touches, double spring, const glm::dvec3& plain,
                const ShadingMemory& memory) {
  const bool stays = touches.part == memory.part && touches.region == memory.region;
  const double facets = std::max(0.0, glm::distance(plain, memory.plain) - spring);
  const double believed = stays ? glm::smoothstep(kBelieved, 1.0, touches.trust) : 1.0;
  return spring + std::max(spring * (touches.steepness - 1.0), facets) * believed + kUnfelt;
}

}  // namespace

glm::dvec3 holdShading(const ShadedTouches& touches, const glm::dvec3& device, const glm::dvec3& plain,
                       const glm::dvec3& wanted, ShadingMemory& memory) {
  glm::dvec3 felt = wanted;
  if (touches.any && !touches.other) {
    // The last tick's force, cut to the first bound, moves towards this one's, which keeps to that bound too:
    // all vectors between the two do.
    const double most = glm::length(plain) + touches.relief;
    felt = withLength(wanted, most);
    const double change = glm::distance(felt, memory.felt);
    const double spring = touches.stiffness * (glm::distance(device, memory.device) + touches.travel);
    if (memory.valid && change > spring + kUnfelt) {
      const double allowed = changeOf(touches, spring, plain, memory);
      if (change > allowed) {
        const glm::dvec3 from = withLength(memory.felt, most);
        const double left = allowed - glm::distance(from, memory.felt);
        felt = from + withLength(felt - from, std::max(0.0, left));
      }
    }
  }
  memory = {felt, plain, device, touches.part, touches.region, !touches.other};
  return felt;
}

}  // namespace tandem::haptics
