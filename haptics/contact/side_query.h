#pragma once

// One side of a pair: the samples of one part before the other part, the target, with all that turns them
// into rows.
//
// 1. Made for one step; the island and the overlaps that it is made from must outlive it unchanged.

#include <algorithm>
#include <cstdint>

#include <glm/mat3x3.hpp>

#include "haptics/contact/contact_island.h"
#include "haptics/contact/overlaps.h"
#include "haptics/touch/sample_touch.h"

namespace tandem::haptics {

struct SideQuery : SampledModels {
  /// The last answer of a sample is trusted while the sample has not moved further than this share of the
  /// spacing of its part's samples.
  static constexpr double kTrustedShare = 0x1p-4;

  /// `sampledSide` is 0 where the pair's first part is sampled and 1 where the other is; `reach` in m.
  SideQuery(const ContactIsland& island, const Overlaps& overlaps, std::uint16_t pairIndex,
            std::uint16_t sampledSide, double reach);

  bool ofFirst() const { return side == 0; }
  RowSource source(std::uint32_t sample) const { return {pair, side, sample}; }
  /// World direction of a normal of the target, signed such that it opens the gap for the pair's first
  /// part.
  glm::vec3 world(const glm::vec3& normal) const { return sign * (rotation * normal); }
  /// m, world axes, from the first body's centre of mass to a place relative to the origin of the target's
  /// field.
  glm::vec3 armOf(const glm::vec3& place) const { return rotation * place + shift; }
  /// The same of a point in the frame of the target.
  glm::vec3 arm(const glm::dvec3& point) const { return armOf(glm::vec3(point - to->field.origin())); }
  /// Whether sections cut away the place that `arm` points to: nothing touches there.
  bool isCut(const glm::vec3& arm) const {
    const Sections& sections = island->sections();
    return !sections.empty() && isCutAway(sections, first().centre + glm::dvec3(arm));
  }
  /// The gap (m) that a row demands of a sample with this one. Of a penetration all but one tolerance is
  /// corrected in a step, of a small one a fifth a step (a Baumgarte stabilisation).
  double corrected(double gap) const { return gap + std::clamp(-0.8 * gap, 0.0, to->field.tolerance()); }
  /// m by which the sample may be deep in the target because it was when its part began to move here.
  double allowed(const ContactSample& sample) const;
  /// The shift (m, frame of the target) by which an interference fit takes the sample back; zero without one.
  glm::dvec3 fitShift(const ContactSample& sample) const {
    InterferenceFit::Hint none;
    return fitShift(sample, none);
  }
  /// The same with the hint of the last sample, which becomes that of this one.
  glm::dvec3 fitShift(const ContactSample& sample, InterferenceFit::Hint& hint) const {
    return fit != nullptr ? fit->shift(*this, sample, sampledIsHollow, hint) : glm::dvec3(0.0);
  }

  const ContactPair& contactPair() const { return island->pair(pair); }
  const ContactBody& first() const { return island->first(contactPair()); }

  const ContactIsland* island;
  const Overlaps* overlaps;
  Pose worldFromTo;
  glm::mat3 rotation{1.0f};  // world from target
  glm::vec3 shift{
      0.0f};  // m, world axes, from the first body's centre of mass to the origin of the target's field
  float sign = 1.0f;     // -1 where a normal of the target points towards the first part's own outside
  float limit = 0.0f;    // m, reach of the step
  float smooth = 0.0f;   // m, error of the field up to which its reading is trusted
  float rough = 0.0f;    // m, error of the field above which its gradient is no direction
  float trusted = 0.0f;  // m that a sample may move before it is queried again
  const InterferenceFit* fit = nullptr;  // of the pair
  bool sampledIsHollow = false;          // the seat of the fit is in the part that is sampled
  // No row acts between the parts: one is inside the other and is brought out, or they are passing through.
  bool rowless = false, passing = false;
  std::uint16_t pair = 0, side = 0;
  PartId sampled = kNoPart, target = kNoPart;
};

}  // namespace tandem::haptics
