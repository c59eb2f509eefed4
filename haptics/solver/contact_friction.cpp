#include "haptics/solver/contact_friction.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <glm/geometric.hpp>

#include "assets/base/across.h"

namespace tandem::haptics {
namespace {

constexpr int kMaxSweeps = 24;
// The sweeps end once no force changes by more than this share of the largest normal force, and no change of
// a force moves its point by more than this many metres.
constexpr double kConverged = 1e-6, kSlipConverged = 1e-9;

/// m, world: how far the point of a row slips in this tick if nothing but what has been applied already acts.
glm::dvec3 freeSlip(const StepSpace& space, const ExactRow& row, const RowRefiner& refiner) {
  const RowPair& pair = space.pair(row.source.pair);
  const StepGoal& first = space.goal(pair.first);
  glm::dvec3 slip = first.applied.at(row.arm) + first.free.at(row.arm);
  if (pair.second < 0) return slip - refiner.surfaceMotion(row);
  const StepGoal& second = space.goal(pair.second);
  const glm::dvec3 arm = row.arm + pair.offset;
  return slip - (second.applied.at(arm) + second.free.at(arm));
}

}  // namespace

void ContactFriction::recall(std::span<const FrictionForce> known) {
  ASSERT(known.size() <= forces_.capacity());
  forces_.clear();
  for (const FrictionForce& force : known) forces_.push_back(force);
}

const FrictionForce* ContactFriction::lastAt(const RowSource& source) const {
  const FrictionForce* found = nullptr;
  for (const FrictionForce& last : forces_) {
    if (last.source == source) found = &last;
  }
  return found;
}

void ContactFriction::addTo(const StepSpace& space, const ContactRows& rows, BodyVectors& sum) const {
  for (const FrictionForce& last : forces_) {
    const double size = glm::length(last.force);
    if (!(size > 0.0)) continue;
    for (int i = 0; i < rows.exactRows(); ++i) {
      const ExactRow& row = rows.exact(i);
      if (row.source != last.source) continue;
      const glm::dvec3 unit = last.force / size;
      space.direction(space.pair(row.source.pair), unit, glm::cross(row.arm, unit)).addTo(sum, size);
      break;
    }
  }
}

void ContactFriction::makeContacts(const StepSpace& space, const ActiveSet::Rows& active,
                                   const ContactRows& rows, const RowRefiner& refiner) {
  contacts_.clear();
  for (const ActiveSet::Row& normal : active) {
    const ExactRow& row = rows.exact(normal.row);
    if (row.staticFriction <= 0.0 && row.dynamicFriction <= 0.0) continue;
    FrictionContact& contact = contacts_.push_back({});
    contact.row = normal.row;
    contact.slidingLimit = row.dynamicFriction * normal.multiplier;
    contact.stickingLimit = std::max(row.staticFriction * normal.multiplier, contact.slidingLimit);
    std::tie(contact.tangent[0], contact.tangent[1]) = acrossOf(row.normal);
    const glm::dvec3 slip = freeSlip(space, row, refiner);
    const FrictionForce* const last = lastAt(row.source);
    contact.sticks = last != nullptr && last->sticks;
    const glm::dvec3 force = last != nullptr ? last->force : glm::dvec3(0.0);
    for (int k = 0; k < 2; ++k) {
      contact.direction[k] = space.direction(space.pair(row.source.pair), contact.tangent[k],
                                             glm::cross(row.arm, contact.tangent[k]));
      contact.slip[k] = glm::dot(contact.tangent[k], slip);
      contact.force[k] = glm::dot(contact.tangent[k], force);
    }
    contact.mobility =
        contact.direction[0].dot(contact.direction[0]) + contact.direction[1].dot(contact.direction[1]);
  }
}

void ContactFriction::iterate(double largest, BodyVectors& y) {
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double change = 0.0, slip = 0.0;
    for (FrictionContact& contact : contacts_) {
      double target[2];
      for (int k = 0; k < 2; ++k)
        target[k] = contact.force[k] - (contact.slip[k] + contact.direction[k].dot(y)) / contact.mobility;
      // Projection onto the disc. What slides sticks again only within the smaller one, that of sliding.
      const double length = std::hypot(target[0], target[1]);
      contact.sticks =
          length <= (contact.sticks || sweep == 0 ? contact.stickingLimit : contact.slidingLimit);
      const double scale = contact.sticks || length == 0.0 ? 1.0 : contact.slidingLimit / length;
      for (int k = 0; k < 2; ++k) {
        const double step = scale * target[k] - contact.force[k];
        contact.force[k] += step;
        contact.direction[k].addTo(y, step);
        change = std::max(change, std::abs(step));
        slip = std::max(slip, std::abs(step) * contact.mobility);
      }
    }
    if (change <= kConverged * largest && slip <= kSlipConverged) break;
  }
}

ContactFriction::Change ContactFriction::solve(const StepSpace& space, const ActiveSet::Rows& active,
                                               const ContactRows& rows, const RowRefiner& refiner,
                                               const BodyVectors& saturated, BodyVectors& part) {
  makeContacts(space, active, rows, refiner);
  BodyVectors y;
  for (std::size_t b = 0; b < space.bodyCount(); ++b) y[b] = saturated[b];
  double largest = 0.0;
  for (const ActiveSet::Row& normal : active) {
    normal.direction.addTo(y, normal.multiplier);
    largest = std::max(largest, normal.multiplier);
  }
  for (const FrictionContact& contact : contacts_) {
    for (int k = 0; k < 2; ++k) contact.direction[k].addTo(y, contact.force[k]);
  }
  iterate(largest, y);
  space.setToZero(part);
  Change change;
  FixedVector<FrictionForce, ActiveSet::kMaxRows> now;
  for (const FrictionContact& contact : contacts_) {
    const RowSource& source = rows.exact(contact.row).source;
    const glm::dvec3 force = contact.force[0] * contact.tangent[0] + contact.force[1] * contact.tangent[1];
    const FrictionForce* const last = lastAt(source);
    const double by = glm::length(force - (last != nullptr ? last->force : glm::dvec3(0.0)));
    change.force = std::max(change.force, largest > 0.0 ? by / largest : 0.0);
    change.slip = std::max(change.slip, by * contact.mobility);
    for (int k = 0; k < 2; ++k) contact.direction[k].addTo(part, contact.force[k]);
    now.push_back({source, force, contact.sticks});
  }
  forces_ = now;
  return change;
}

}  // namespace tandem::haptics
