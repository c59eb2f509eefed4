#pragma once

// The way that a part took, thinned: a pose wherever a point of it has gone a given distance, and how near it there
// came to each of its neighbours. What a review of an extraction asks for. Allocates.

#include <string>
#include <vector>

#include "haptics/scene/contact_scene.h"

namespace tandem::haptics {
class TickState;
}

namespace tandem::client {

class SweptPath {
 public:
  /// How near one neighbour was, m, between surfaces; 0 where they meet.
  struct Clearance {
    PartId part = kNoPart;
    double distance = 0.0;
  };
  struct Stop {
    double time = 0.0;  // s
    Pose worldFromPart;
    std::vector<Clearance>
        near;  // of parts that it may collide with and that are nearer than its own diameter
  };

  /// `step`: m that the furthest point of the part goes between two stops; 0: a fiftieth of its diameter.
  /// `contact` must outlive this.
  SweptPath(const haptics::ContactScene& contact, PartId part, double step);

  /// After a tick: parts are where its state left them.
  void note(double time, const haptics::TickState& state);

  const std::vector<Stop>& stops() const { return stops_; }
  /// The least clearance of all stops; part = kNoPart where nothing came near.
  Clearance least() const;
  /// t,x,y,z,qw,qx,qy,qz, then clearance:NAME of every neighbour that was ever near, empty where it was not. SI, world.
  std::string csv() const;

 private:
  /// An upper bound of what any point of the part went from one pose to the other, m.
  double wayBetween(const Pose& a, const Pose& b) const;

  const haptics::ContactScene& contact_;
  PartId part_;
  double radius_ = 0.0;     // m, of the ball that holds the part, about centre_
  glm::dvec3 centre_{0.0};  // part frame
  double step_ = 0.0;
  std::vector<PartId> others_;  // that the part may collide with
  std::vector<Stop> stops_;
};

}  // namespace tandem::client
