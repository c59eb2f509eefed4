#include "client/review/swept_path.h"

#include <algorithm>
#include <cstdio>

#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/scene/part_pairs.h"
#include "client/review/clash_check.h"
#include "client/review/contact_log.h"
#include "haptics/geometry/mesh_distance.h"
#include "haptics/scene/contact_scene_data.h"
#include "haptics/tick.h"

namespace tandem::client {

SweptPath::SweptPath(const haptics::ContactScene& contact, PartId part, double step)
    : contact_(contact), part_(part) {
  const std::vector<haptics::Collider>& colliders = contact.data().colliders;
  ASSERT(part < colliders.size());
  radius_ = colliders[part].radius;
  centre_ = colliders[part].centre;
  step_ = step > 0.0 ? step : radius_ / 25.0;
  for (PartId other = 0; other < colliders.size(); ++other) {
    const haptics::TriangleBvh* tree = colliders[other].tree;
    if (other != part && tree != nullptr && !tree->empty() &&
        assets::mayCollide(contact.scene(), part, other))
      others_.push_back(other);
  }
}

double SweptPath::displacementBound(const Pose& a, const Pose& b) const {
  const double shift = glm::length(transformPoint(a, centre_) - transformPoint(b, centre_));
  return shift + radius_ * glm::length(rotationVector(b.orientation * glm::conjugate(a.orientation)));
}

void SweptPath::note(double time, const haptics::TickState& state) {
  const Pose& pose = state.worldFromPart(part_);
  if (!stops_.empty() && !(displacementBound(stops_.back().worldFromPart, pose) >= step_)) return;
  Stop stop{time, pose, {}};
  const std::vector<haptics::Collider>& colliders = contact_.data().colliders;
  const haptics::PlacedMesh own{colliders[part_].tree, pose};
  const double reach = 2.0 * radius_;
  for (const PartId other : others_) {
    if (own.tree == nullptr) break;
    const haptics::Collider& collider = colliders[other];
    const haptics::PlacedMesh placed{collider.tree, state.worldFromPart(other)};
    const double apart =
        glm::length(transformPoint(placed.worldFromMesh, collider.centre) - transformPoint(pose, centre_));
    haptics::MeshGap gap;
    if (apart - collider.radius - radius_ <= reach && haptics::nearestPoints(own, placed, reach, gap))
      stop.near.push_back({other, gap.distance});
  }
  stops_.push_back(std::move(stop));
}

SweptPath::Clearance SweptPath::least() const {
  Clearance least;
  for (const Stop& stop : stops_) {
    for (const Clearance& c : stop.near) {
      if (least.part == kNoPart || c.distance < least.distance) least = c;
    }
  }
  return least;
}

std::string SweptPath::csv() const {
  std::vector<PartId> columns;
  for (const PartId other : others_) {
    const bool everNear = std::any_of(stops_.begin(), stops_.end(), [&](const Stop& stop) {
      return std::any_of(stop.near.begin(), stop.near.end(),
                         [&](const Clearance& c) { return c.part == other; });
    });
    if (everNear) columns.push_back(other);
  }
  std::string text = "t,x,y,z,qw,qx,qy,qz";
  for (const PartId part : columns) text += ',' + csvCell("clearance:" + contact_.scene().parts[part].name);
  text += '\n';
  char line[256];
  for (const Stop& stop : stops_) {
    const glm::dvec3& p = stop.worldFromPart.position;
    const glm::dquat& q = stop.worldFromPart.orientation;
    std::snprintf(line, sizeof line, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", stop.time, p.x, p.y, p.z, q.w,
                  q.x, q.y, q.z);
    text += line;
    auto next = stop.near.begin();  // in the order of others_, as columns are
    for (const PartId part : columns) {
      text += ',';
      if (next == stop.near.end() || next->part != part) continue;
      std::snprintf(line, sizeof line, "%.6g", next->distance);
      text += line;
      ++next;
    }
    ASSERT(next == stop.near.end());  // every clearance has a column
    text += '\n';
  }
  return text;
}

}  // namespace tandem::client
