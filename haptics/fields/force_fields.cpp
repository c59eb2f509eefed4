#include "haptics/fields/force_fields.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "haptics/base/tick_types.h"

namespace tandem::haptics {

struct ForceFields::Sum {
  glm::dvec3 force{0.0}, sourceChange{0.0}, damping{0.0};  // N, world
  double dampingRate = 0.0;                                // N·s/m
  double curvature = 0.0;                                  // N/m
  double work = 0.0;                                       // J
  bool limited = false;
};

ForceFields::ForceFields(const assets::Scene& scene) {
  overflow_ = scene.fields.size() > assets::kMaxForceFields;
  const std::size_t count = std::min(scene.fields.size(), assets::kMaxForceFields);
  entries_.reserve(count);
  for (std::size_t i = 0; i < count; ++i) entries_.emplace_back(scene.fields[i]);
}

void ForceFields::forgetHand() {
  for (Entry& entry : entries_) entry.known = false;
}

/// Follows the path from the hand's last place on it; beyond the reach of the force any place may be the
/// next.
void ForceFields::findPlace(Entry& entry, const glm::dvec3& x) {
  const FieldPath& path = *entry.law.path();
  if (entry.known) {
    entry.at = path.follow(x, entry.at);
    const double range = entry.law.field().range;
    if (!(range > 0.0) || glm::distance(path.point(entry.at), x) < range) return;
  }
  const double before = entry.at;
  entry.at = path.nearest(x);
  if (entry.at != before) entry.known = false;
}

/// The Frobenius norm of the steepest differences to both sides along each axis: no less than the greatest
/// curvature along any direction, kinks within `over` included.
double ForceFields::curvatureOf(const Entry& entry, const FieldQuery& query, const FieldAction& here,
                                double over) {
  const glm::dvec3 force = here.stored + here.source;
  double squares = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    double steepest = 0.0;
    for (const double side : {-over, over}) {
      FieldQuery beside = query;
      beside.position[axis] += side;
      const FieldAction there = entry.law.act(beside, entry.at);
      const glm::dvec3 change = there.stored + there.source - force;
      steepest = std::max(steepest, glm::dot(change, change));
    }
    squares += steepest;
  }
  return std::sqrt(squares) / over;
}

void ForceFields::addEntry(Entry& entry, const ContactWorld& world, const DeviceSample& device, double time,
                           const FieldSettings& settings, Sum& sum) {
  const assets::ForceField& field = entry.law.field();
  const bool moves = field.part != kNoPart && world.has(field.part);
  const Pose worldFromField = moves ? world.pose(field.part) * field.partFromField : field.partFromField;
  const glm::dvec3 tip = device.worldFromDevice.position;
  const glm::dvec3 carried =
      moves ? velocityAt(world.pose(field.part), world.twist(field.part), tip) : glm::dvec3(0.0);
  const glm::dquat fieldFromWorld = glm::conjugate(worldFromField.orientation);

  const double target = moves && field.part == settings.held ? 0.0 : 1.0;
  const double step = settings.fadeTime > 0.0 ? settings.dt / settings.fadeTime : 1.0;
  entry.weight = started_ ? entry.weight + std::clamp(target - entry.weight, -step, step) : target;

  FieldQuery query;
  query.position = fieldFromWorld * (tip - worldFromField.position);
  query.velocity = fieldFromWorld * (device.twist.linear - carried);
  query.time = time;
  query.timeBefore = entry.known ? lastTime_ : time;
  if (entry.law.path() != nullptr) findPlace(entry, query.position);
  const FieldAction action = entry.law.act(query, entry.at);

  const glm::dvec3 stored = worldFromField.orientation * action.stored * entry.weight;
  const glm::dvec3 source = worldFromField.orientation * action.source * entry.weight;
  sum.force += stored + source;
  sum.sourceChange += worldFromField.orientation * action.sourceChange * entry.weight;
  sum.damping += worldFromField.orientation * action.damping * entry.weight;
  sum.dampingRate += action.dampingRate * entry.weight;
  sum.limited = sum.limited || action.limited;
  if (settings.curvatureOver > 0.0)
    sum.curvature += entry.weight * curvatureOf(entry, query, action, settings.curvatureOver);
  // The hand receives what a potential loses, however coarse the ticks; a moving field adds its own work.
  if (entry.known) sum.work += entry.weight * (entry.potential - action.potential);
  sum.work += settings.dt * (glm::dot(stored, carried) + glm::dot(source, device.twist.linear));
  entry.potential = action.potential;
  entry.known = true;
}

FieldForces ForceFields::step(const ContactWorld& world, const DeviceSample& device, double time,
                              const FieldSettings& settings) {
  ASSERT(settings.dt > 0.0);
  Sum sum;
  for (Entry& entry : entries_) addEntry(entry, world, device, time, settings, sum);
  started_ = true;
  lastTime_ = time;
  FieldForces out;
  const double share =
      sum.dampingRate > settings.dampingLimit ? settings.dampingLimit / sum.dampingRate : 1.0;
  out.damping = sum.damping * share;
  out.dampingRate = sum.dampingRate * share;
  out.curvature = sum.curvature;
  out.force = sum.force + out.damping;
  out.sourceChange = sum.sourceChange;
  out.sourcePower = sum.work / settings.dt;
  if (overflow_) out.flags |= kFlagOverflow;
  if (sum.limited) out.flags |= kFlagFieldLimited;
  return out;
}

}  // namespace tandem::haptics
