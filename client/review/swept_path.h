#pragma once

// The path of a moved part, thinned: a pose after each given distance of its furthest point, with the
// clearance to each of its neighbours there. For reviews of an extraction. Allocates.

#include <string>
#include <vector>

#include "haptics/scene/contact_scene.h"

namespace tandem::haptics {
class TickState;
}

namespace tandem::client {

class SweptPath {
 public:
  /// The clearance to one neighbour, m, between surfaces; 0 where they meet.
  struct Clearance {
    PartId part = kNoPart;
    double distance = 0.0;
  };
  struct Stop {
    double time = 0.0;  // s
    Pose worldFromPart;
    std::vector<Clearance> near;  // to parts that may collide with it and are nearer than its own diameter
  };

  /// `step`: m, the distance of the part's furthest point between two stops; 0: a fiftieth of its diameter.
  /// `contact` must outlive this object.
  SweptPath(const haptics::ContactScene& contact, PartId part, double step);

  /// Call after each tick, with its state.
  void note(double time, const haptics::TickState& state);

  const std::vector<Stop>& stops() const { return stops_; }
  /// The least clearance of all stops; part = kNoPart where nothing came near.
  Clearance least() const;
  /// Columns t,x,y,z,qw,qx,qy,qz, then clearance:NAME for every neighbour that was ever near; the cell is
  /// empty where it was not. SI, world.
  std::string csv() const;

 private:
  /// An upper bound of the distance that any point of the part moves from one pose to the other, m.
  double displacementBound(const Pose& a, const Pose& b) const;

  const haptics::ContactScene& contact_;
  PartId part_;
  double radius_ = 0.0;     // m, of the ball that holds the part, about centre_
  glm::dvec3 centre_{0.0};  // part frame
  double step_ = 0.0;
  std::vector<PartId> others_;  // parts that may collide with the part
  std::vector<Stop> stops_;
};

}  // namespace tandem::client
