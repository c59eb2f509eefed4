#include "haptics/contact/side_query.h"

#include <algorithm>

namespace tandem::haptics {

SideQuery::SideQuery(const ContactIsland& on, const Overlaps& known, std::uint16_t pairIndex,
                     std::uint16_t sampledSide, double reach)
    : island(&on), overlaps(&known), pair(pairIndex), side(sampledSide) {
  const ContactPair& of = contactPair();
  const ContactBody& body = first();
  from = ofFirst() ? body.model : of.model;
  to = ofFirst() ? of.model : body.model;
  toFromSamples = ofFirst() ? of.otherFromFirst : inverse(of.otherFromFirst);
  worldFromTo = ofFirst() ? on.otherPose(of) : body.pose;
  rotation = glm::mat3(glm::mat3_cast(worldFromTo.orientation));
  shift = glm::vec3(transformPoint(worldFromTo, to->field.origin()) - body.centre);
  sign = ofFirst() ? 1.0f : -1.0f;
  limit = static_cast<float>(reach);
  smooth = 2.0f * static_cast<float>(to->field.tolerance());
  rough = std::max(smooth, 0.12f * static_cast<float>(to->field.smallestCell()));
  trusted = static_cast<float>(kTrustedShare * from->samples.spacing());
  passing = known.passing(pair);
  rowless = passing || known.contained(pair);
  bool firstIsHollow = false;
  fit = known.fit(pair, firstIsHollow);
  sampledIsHollow = firstIsHollow == ofFirst();
  sampled = ofFirst() ? body.part : of.other;
  target = ofFirst() ? of.other : body.part;
}

double SideQuery::allowed(const ContactSample& sample) const {
  if (!overlaps->has(pair)) return 0.0;
  const glm::dvec3 at = transformPoint(toFromSamples, sample.point);
  return ofFirst() ? overlaps->allowedAt(pair, sample.point, at)
                   : overlaps->allowedAt(pair, at, sample.point);
}

}  // namespace tandem::haptics
