#pragma once

// The way of a part out of its assembly, found with the contact solver of a held part: a hand takes the part
// and draws it along straight lines, giving way across the line and about every axis, until it is out or
// stuck. Where no line leads out, the search goes on from where the part got stuck.
//
// 1. Every other part stands still. Parts that have been taken away are ignored.
// 2. Forces are those of contact, friction, springs and joints; weight is left out.
// 3. A part is out along a direction once its bounding box lies beyond, in that direction, the boxes of all
//    parts that it could meet there by kClearOf of its size. Parts further aside than kApart are not met.
// 4. The same scene gives the same result.
//
// Planning an assembly by a physical search for its disassembly follows Tian et al. 2022, "Assemble Them
// All: Physics-Based Planning for Generalizable Assembly by Disassembly" (ACM TOG 41, 6); there forces are
// drawn at random, here the axes come from the shapes. Not complete: a way that needs a turn which no contact
// brings about, such as unscrewing, is not found. Allocates.

#include <functional>
#include <vector>

#include "client/extraction/straight_pull.h"
#include "haptics/scene/contact_scene.h"

namespace tandem::client {

struct ExtractionOptions {
  double maxForce = 100.0;  // N, with which a hand draws before it gives up
  int maxPulls = 80;        // straight pulls tried for one part
  /// Receives the share of these pulls that has been tried, in the calling thread. False stops.
  std::function<bool(double)> goesOn;
};

struct Extraction {
  PartId part = kNoPart;
  bool free = false;  // the part gets out
  /// Of a free part the way out, of length 0 if nothing is beside it in that direction; otherwise the pulls
  /// that brought it furthest.
  std::vector<ExtractionLeg> way;
  double force = 0.0;  // N, the largest resistance along the way; at most maxForce
  double work = 0.0;   // J, against that resistance; what speeds the part up and its weight are left out
  /// Of a part that is not free: the parts that it pressed on wherever a pull from its place got stuck.
  std::vector<PartId> blockedBy;
  std::vector<Pose> path;  // world from part, from tick to tick of the way, thinned
};

/// Makes every part that can be moved so light that speeding it up takes a thousandth of maxForce: what is
/// felt on a way out is then contact alone, whatever the assembly weighs. Before the ContactScene is made.
void lightenParts(assets::Scene& scene, const ExtractionOptions& options);

/// Takes parts out of one scene, whose parts are light. `contact` must have its models, and outlive this.
class PartExtractor {
 public:
  PartExtractor(const haptics::ContactScene& contact, const ExtractionOptions& options);

  /// The way out of a movable part with geometry, while the parts of takeAway() are away.
  Extraction extract(PartId part) const;
  void takeAway(PartId part) { away_[part] = true; }
  bool isAway(PartId part) const { return away_[part]; }
  /// Whether a hand can take the part, and it has geometry and a model.
  bool canTake(PartId part) const;

  static constexpr double kClearOf = 0.02, kApart = 0.1;

 private:
  const haptics::ContactScene& contact_;
  ExtractionOptions options_;
  std::vector<bool> away_;
};

}  // namespace tandem::client
